"""Cameras, and the rays of their pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _octray
from ._mesh import Mesh
from ._scene import Scene

STYLES = ("plain", "studio", "clay")
AXES = ("x", "y", "z", "-x", "-y", "-z")
# The largest coordinate.
FARTHEST = 1e9
_KEYS = ("from", "eye", "target", "up", "fov", "ortho", "aperture", "focus")
_SIDES = {"front": (0, 0), "right": (90, 0), "back": (180, 0), "left": (-90, 0), "top": (0, 90), "bottom": (0, -90)}
_LARGEST = 65_535


def camera_rays(
    camera: SupportsIndex | Mapping[str, Any] | None,
    size: Sequence[SupportsIndex] | NDArray[np.integer[Any]],
    mesh: Mesh | Scene | None = None,
    *,
    style: str | None = None,
    up_axis: str | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Return the rays of a camera through the centres of a picture's pixels, as the queries of :class:`Mesh` and
    :class:`Scene` take them.

    They are the rays of ``render(mesh, size, camera)`` with one sample per pixel, without a lens, to rounding: the last
    bit may differ, and with it which triangle is hit exactly at an edge. They take 12 bytes per pixel, 36 if ``ortho`` is
    given. Ctrl-C ends long calls.

    Parameters
    ----------
    camera
        As for :func:`render`: a classic viewpoint from 1 to 6, or a dictionary. None frames the mesh, as the studio style
        does.
    size
        Width and height, pixels.
    mesh
        The mesh or scene of meshes to look at. Needed unless the dictionary has ``eye`` and ``target``, or the camera is a viewpoint.
    style, up_axis
        Those of the picture, if it has any: they change how the mesh is framed, and the axis the default ``up``.

    Returns
    -------
    origins
        The eye, shape (1, 3), ``float64``; with ``ortho`` one origin for each ray, shape (height * width, 3).
    directions
        Unit vectors, shape (height * width, 3), ``float32``: row by row from the top left.

    Raises
    ------
    ValueError
        If an argument is invalid, or the mesh is missing.
    """
    width, height = size_of(size)
    if mesh is not None and not isinstance(mesh, (Mesh, Scene)):
        raise ValueError(f"mesh: expected a Mesh or a Scene, found {_arrays.shown(mesh)}")
    if isinstance(camera, str):
        raise ValueError(
            f"camera: expected a viewpoint from 1 to 6 or a dictionary, found {_arrays.shown(camera)}: "
            "cameras of files have no rays here"
        )
    style, up_axis = _arrays.one_of("style", style, STYLES), _arrays.one_of("up_axis", up_axis, AXES)
    view = checked(camera)
    start = view["start"]
    if mesh is None:
        if not isinstance(start, int) and (start is None or len(start) != 3 or view["target"] is None):
            raise ValueError("mesh: needed for a camera without eye and target, because it looks at the mesh")
    native = None if mesh is None else solid("mesh", mesh, "look at")
    return _octray.camera_rays(native, (width, height), view, style, up_axis)


def solid(name: str, source: Mesh | Scene, purpose: str) -> Any:
    """Return a mesh, or a scene with its meshes and the mesh of each instance, for the native code."""
    native: Any
    if isinstance(source, Mesh):
        native, has_triangles = source._mesh, source._mesh.counts[1] > 0
    else:
        meshes = [mesh._mesh for mesh in source._meshes]
        counts = np.array([mesh.counts[1] for mesh in meshes], dtype=np.int64)
        has_triangles = counts[source._mesh_index].any()
        native = (source._scene, meshes, source._mesh_index)
    if not has_triangles:
        raise ValueError(f"{name}: {source!r} has no triangles to {purpose}")
    return native


def size_of(size) -> tuple[int, int]:
    """Return width and height."""
    sides = _arrays.items(size)
    if sides is None or len(sides) != 2:
        raise ValueError(f"size: expected a width and a height, found {_arrays.shown(size)}")
    width, height = (_arrays.count("size", side, least=1) for side in sides)
    if max(width, height) > _LARGEST:
        raise ValueError(f"size: expected at most {_LARGEST} pixels a side, found {_arrays.shown(sides)}")
    return width, height


def checked(camera) -> dict[str, Any]:
    """Return the camera for the native code: where it starts, and what changes that."""
    view: dict[str, Any] = dict.fromkeys(("start", "target", "up", "fov", "ortho", "aperture", "focus"))
    view["fits"] = False
    if camera is None or isinstance(camera, str):
        return {**view, "start": camera}
    if isinstance(camera, Mapping):
        return {**view, **_of_mapping(camera)}
    try:
        number = _arrays.count("camera", camera, least=1)
    except ValueError:
        number = 0
    if not 1 <= number <= 6:
        raise ValueError(
            f"camera: expected a name, a viewpoint from 1 to 6 or a dictionary, found {_arrays.shown(camera)}"
        )
    return {**view, "start": number}


def _of_mapping(camera) -> dict[str, Any]:
    for name in camera:
        if name not in _KEYS:
            raise ValueError(f"camera: expected keys among {', '.join(_KEYS)}, found {_arrays.shown(name)}")
    side = camera.get("from")
    side = _vector("from", _SIDES.get(side, side) if isinstance(side, str) else side, 2)
    eye, target, up = (_vector(name, camera.get(name), 3) for name in _KEYS[1:4])
    for name, point in (("eye", eye), ("target", target)):
        if point is not None and max(map(abs, point)) > FARTHEST:
            found = _arrays.shown(camera[name])
            raise ValueError(f"camera: {name} is {found}, expected numbers of at most {FARTHEST:g}")
    fits = isinstance(camera.get("ortho"), str) and camera["ortho"] == "fit"
    lens = {name: _vector(name, None if fits and name == "ortho" else camera.get(name), 1) for name in _KEYS[4:]}
    ortho = fits or lens["ortho"]
    for one, other, both in (
        ("fov", "ortho", lens["fov"] is not None and bool(ortho)),
        ("from", "eye", side is not None and eye is not None),
    ):
        if both:
            raise ValueError(f"camera: expected {one} or {other}, found both")
    numbers = {name: number and number[0] for name, number in lens.items()}
    return {"start": side or eye, "target": target, "up": up, "fits": fits, **numbers}


def _vector(name, value, count):
    """Return ``count`` finite numbers."""
    if value is None:
        return None
    _arrays.refuse_masked(f"camera: {name}", value, "numbers")
    try:
        items = (value,) if count == 1 else tuple(value) if np.ndim(value) == 1 else ()
        vector = np.asarray([float(item) for item in items if _arrays.is_number(item)])
    except (TypeError, ValueError, OverflowError):
        items, vector = (), np.zeros(0)
    if not len(vector) == len(items) == count or not np.all(np.isfinite(vector)):
        what = {1: "a number", 2: f"{', '.join(_SIDES)}, or two angles", 3: "three numbers"}[count]
        what = 'a number, or "fit"' if name == "ortho" else what
        raise ValueError(f"camera: {name} is {_arrays.shown(value)}, expected {what}")
    return vector.tolist()
