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

try:
    from ._octray import __version__, isa
except ModuleNotFoundError as _error:
    if _error.name != f"{__name__}._octray":
        raise
    raise ImportError(
        f"{__path__[0]} has no compiled module: install the package with pip; if this is a clone of its source, "
        "run Python in another folder than python/",
        name=_error.name,
    ) from _error

from ._camera import camera_rays
from ._mesh import Hits, Mesh
from ._render import render
from ._scene import Scene, SceneHits

__all__ = ["Hits", "Mesh", "Scene", "SceneHits", "__version__", "camera_rays", "isa", "render"]
