"""Pictures of trimesh's meshes, point clouds and scenes: those with more than colours by way of a GLB file in memory."""

from __future__ import annotations

import inspect
import io
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _arrays
from ._glb import ALPHA, arrays_of, glb, opaque
from ._mesh import Mesh
from ._render import render as _render
from ._render import rendered

_DEFAULTS = {
    name: parameter.default
    for name, parameter in inspect.signature(_render).parameters.items()
    if name not in ("source", "vertex_colors", "face_colors")
}


def render(mesh: Any, /, **options: Any) -> dict[str, NDArray[Any]]:
    """Render a ``Trimesh``, a ``PointCloud`` or a ``Scene`` of trimesh with its colours, textures and instances.

    The z axis points up, and nothing is turned: the camera's ``eye`` and ``target`` are in trimesh's coordinates.
    Faces are flat unless ``smooth_angle`` is given: trimesh's ``vertex_normals`` are not used.
    Colours of vertices and faces are in sRGB. Their alpha is left out, with a warning. That of a ``SimpleMaterial``, and
    of its image, is its opacity; a ``PBRMaterial`` has its ``alphaMode``. A ``MultiMaterial`` needs ``face_materials``.

    Parameters
    ----------
    mesh
        A mesh, point cloud or scene of trimesh.
    options
        Those of :func:`octray.render`, but for ``vertex_colors`` and ``face_colors``.

    Returns
    -------
    dict
        As :func:`octray.render`. The ``"id"`` of a ``Trimesh`` is the index of its face.

    Raises
    ------
    ValueError
        If there is nothing to render, a number that is shown is not finite, or an argument is invalid.
    """
    for name in options:
        if name not in _DEFAULTS:
            raise ValueError(f"options: expected names among {', '.join(_DEFAULTS)}, found {name!r}")
    if options.get("up_axis") is None:
        options["up_axis"] = "z"
    colors: dict[str, Any] = dict.fromkeys(("vertex_colors", "face_colors"))
    source: Mesh | io.BytesIO
    notes: list[str] = []
    order = None
    is_valued = any(options.get(name) is not None for name in ("values", "color_by"))
    if _is(mesh, "vertices", "faces") and (is_valued or not hasattr(mesh.visual, "material")):
        vertices, faces, _ = arrays_of("mesh", mesh)
        source = Mesh(vertices, faces)
        if source._mesh.counts[1] == 0:
            raise ValueError(f"mesh: {_arrays.shown(mesh)} has nothing to render")
        if not is_valued and mesh.visual.kind in ("vertex", "face"):
            name = f"{mesh.visual.kind}_colors"
            colors[name], is_translucent = opaque(getattr(mesh.visual, name))
            notes += [ALPHA] * is_translucent
    elif any(_is(mesh, *names) for names in (("vertices", "faces"), ("vertices", "colors"), ("geometry", "graph"))):
        source, notes, order = glb(mesh)
    else:
        raise ValueError(f"mesh: expected a mesh, point cloud or scene of trimesh, found {_arrays.shown(mesh)}")
    for note in notes:
        warnings.warn(note, stacklevel=2)
    picture = rendered(3, source=source, **{**_DEFAULTS, **colors, **options})
    if order is not None and "id" in picture:
        ids = picture["id"]
        is_face = ids < len(order)
        ids[is_face] = order[ids[is_face]]
    return picture


def _is(mesh, *names: str) -> bool:
    # Not by its values, because trimesh's primitives compute their vertices when they are asked for.
    own = getattr(mesh, "__dict__", ())
    return not isinstance(mesh, Mesh) and all(hasattr(type(mesh), name) or name in own for name in names)
