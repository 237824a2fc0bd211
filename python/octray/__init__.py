"""Ray queries on triangle meshes: fast, watertight, and the same results on every machine.

>>> import numpy as np
>>> import octray
>>> mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
>>> hits = mesh.closest_hit([0.25, 0.25, 3.0], [[0, 0, -2], [1, 0, 0]])
>>> hits.t
array([1.5, inf], dtype=float32)
>>> hits.triangle
array([ 0, -1])
"""

from ._mesh import Hits, Mesh
from ._octray import __version__, isa
from ._render import render

__all__ = ["Hits", "Mesh", "__version__", "isa", "render"]
