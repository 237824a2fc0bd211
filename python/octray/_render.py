"""Pictures as arrays, and the rays of their cameras."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _octray
from ._mesh import Mesh

_AOVS = ("depth", "normal", "albedo", "id")
_CAMERA = ("from", "eye", "target", "up", "fov", "ortho", "aperture", "focus")
_SIDES = {"front": (0, 0), "right": (90, 0), "back": (180, 0), "left": (-90, 0), "top": (0, 90), "bottom": (0, -90)}
_LARGEST = 65_535
_MOST_SAMPLES = 1 << 20
_FARTHEST = 1e9


def render(
    source: str | bytes | os.PathLike[str] | Mesh,
    size: Sequence[SupportsIndex] | NDArray[np.integer[Any]] = (512, 512),
    camera: str | SupportsIndex | Mapping[str, Any] | None = None,
    samples: SupportsIndex | str = "usual",
    aov: str | Sequence[str] = (),
    style: str | None = None,
) -> dict[str, NDArray[Any]]:
    """Render a scene (``.scn``), a mesh file or a :class:`Mesh`, like the program ``octray``.

    Parameters
    ----------
    source
        A path, or a mesh, whose z axis points up.
    size
        Width and height, pixels.
    camera
        A camera of the file by name, a classic viewpoint from 1 to 6, or a dictionary with any of ``eye``, ``target``,
        ``up`` (three numbers each), ``fov`` (degrees, vertical) or ``ortho`` (the height of an orthographic view, scene
        units), ``aperture`` (the diameter of a lens, scene units) and ``focus`` (the distance in focus, scene units).
        Instead of ``eye``, ``from`` frames a mesh from its ``"front"``, ``"right"``, ``"back"``, ``"left"``, ``"top"`` or
        ``"bottom"``, or from an azimuth and an elevation in degrees. By default the scene's first camera, or one that
        frames the mesh.
    samples
        Samples per pixel: a number; ``"auto"`` or ``"auto:N"``, which take up to 16 or N, fewer in pixels that look like
        their neighbours; or ``"usual"``, which is 1, or ``"auto"`` for meshes in the studio and clay styles.
    aov
        More arrays, by name: ``"depth"``, ``"normal"``, ``"albedo"``, ``"id"``, each of one ray through the pixel's
        centre.
    style
        How a mesh is lit: ``"studio"``, the default, soft light with ambient occlusion; ``"clay"``, the same with one
        colour for all of it; ``"plain"``, two point lights. A scene has its own light.

    Returns
    -------
    dict
        ``"color"``: shape (height, width, 3), ``uint8``, in sRGB, or linear for scenes and plain meshes; ``"depth"``:
        (height, width) ``float32``, scene units, infinite for a miss; ``"normal"``, ``"albedo"``: (height, width, 3)
        ``float32``; ``"id"``: (height, width) ``uint32``, the index of the primitive, 2^32 - 1 for a miss.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If an argument is invalid, or the file is faulty: then with line and column.
    """
    names = (aov,) if isinstance(aov, str) else _items(aov)
    if names is None or not all(isinstance(name, str) and name in _AOVS for name in names):
        raise ValueError(f"aov: expected names among {', '.join(_AOVS)}, found {aov!r}")
    width, height = _size(size)
    number = _samples(samples)
    if style is not None and not isinstance(style, str):
        raise ValueError(f"style: expected plain, studio or clay, found {style!r}")
    start, target, up, lens = _camera(camera)
    subject: _octray.Mesh | str
    if isinstance(source, Mesh):
        subject = source._mesh
        if source._mesh.counts[1] == 0:
            raise ValueError(f"source: {source!r} has no triangles to render")
    elif isinstance(source, (str, bytes, os.PathLike)):
        subject = os.fsdecode(source)
        # A file of that name: to the program it is standard input.
        subject = "./-" if subject == "-" else subject
    else:
        raise ValueError(f"source: expected a path or a Mesh, found {source!r}")
    arrays, notes = _octray.render(subject, (width, height), start, target, up, lens, style, number, bool(names))
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return {name: arrays[name] for name in ("color", *names)}


def camera_rays(
    camera: SupportsIndex | Mapping[str, Any] | None,
    size: Sequence[SupportsIndex] | NDArray[np.integer[Any]],
    mesh: Mesh | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """Return the rays of a camera through the centres of a picture's pixels, as the queries of :class:`Mesh` take them.

    They are the rays of ``render(mesh, size, camera)`` with one sample per pixel, without a lens. They take 12 bytes per
    pixel, 36 if ``ortho`` is given.

    Parameters
    ----------
    camera
        As for :func:`render`: a classic viewpoint from 1 to 6, or a dictionary. None frames the mesh, as the studio style
        does.
    size
        Width and height, pixels.
    mesh
        The mesh to look at. Needed unless the dictionary has ``eye`` and ``target``, or the camera is a viewpoint.

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
    width, height = _size(size)
    if mesh is not None and not isinstance(mesh, Mesh):
        raise ValueError(f"mesh: expected a Mesh, found {mesh!r}")
    if isinstance(camera, str):
        raise ValueError(
            f"camera: expected a viewpoint from 1 to 6 or a dictionary, found {_arrays.shown(camera)}: "
            "cameras of files have no rays here"
        )
    start, target, up, lens = _camera(camera)
    if mesh is None:
        if not isinstance(start, int) and (start is None or len(start) != 3 or target is None):
            raise ValueError("mesh: needed for a camera without eye and target, because it looks at the mesh")
    elif mesh._mesh.counts[1] == 0:
        raise ValueError(f"mesh: {mesh!r} has no triangles to look at")
    return _octray.camera_rays(None if mesh is None else mesh._mesh, (width, height), start, target, up, lens)


def _size(size) -> tuple[int, int]:
    """Return width and height."""
    sides = _items(size)
    if sides is None or len(sides) != 2:
        raise ValueError(f"size: expected a width and a height, found {size!r}")
    width, height = (_arrays.count("size", side, least=1) for side in sides)
    if max(width, height) > _LARGEST:
        raise ValueError(f"size: expected at most {_LARGEST} pixels a side, found {_arrays.shown(sides)}")
    return width, height


def _samples(samples: SupportsIndex | str) -> str | None:
    """Return the samples as the program takes them, or None for the usual ones."""
    if isinstance(samples, str):
        number = samples.removeprefix("auto:")
        # What is no number, or one longer than Python reads, the program refuses.
        is_number = number.isascii() and number.isdigit() and len(number) < 1000
        most = int(number) if is_number else 0
    else:
        most = _arrays.count("samples", samples, least=1)
    if most > _MOST_SAMPLES:
        raise ValueError(f"samples: expected at most {_MOST_SAMPLES}, found {_arrays.shown(samples)}")
    if isinstance(samples, str):
        return None if samples == "usual" else samples
    return str(most)


def _items(value):
    """Return the items of a sequence, or None if it is none."""
    try:
        return tuple(value)
    except TypeError:
        return None


def _camera(camera):
    """Return the camera's start, target, up vector, and [field of view, height, aperture, focus]."""
    if camera is None or isinstance(camera, str):
        return camera, None, None, [None] * 4
    if isinstance(camera, Mapping):
        for name in camera:
            if name not in _CAMERA:
                raise ValueError(f"camera: expected keys among {', '.join(_CAMERA)}, found {name!r}")
        side = camera.get("from")
        side = _vector("from", _SIDES.get(side, side) if isinstance(side, str) else side, 2)
        eye, target, up = (_vector(name, camera.get(name), 3) for name in _CAMERA[1:4])
        for name, point in (("eye", eye), ("target", target)):
            if point is not None and max(map(abs, point)) > _FARTHEST:
                raise ValueError(f"camera: {name} is {camera[name]!r}, expected numbers of at most {_FARTHEST:g}")
        lens = [_vector(name, camera.get(name), 1) for name in _CAMERA[4:]]
        for one, other, found in (("fov", "ortho", lens[:2]), ("from", "eye", (side, eye))):
            if None not in found:
                raise ValueError(f"camera: expected {one} or {other}, found both")
        return side or eye, target, up, [number and number[0] for number in lens]
    try:
        number = _arrays.count("camera", camera, least=1)
    except ValueError:
        number = 0
    if not 1 <= number <= 6:
        raise ValueError(
            f"camera: expected a name, a viewpoint from 1 to 6 or a dictionary, found {camera!r}"
        )
    return number, None, None, [None] * 4


def _vector(name, value, count):
    """Return ``count`` finite numbers."""
    if value is None:
        return None
    _arrays.refuse_masked(f"camera: {name}", value, "numbers")
    try:
        vector = np.asarray(value, dtype=np.float64).ravel()
    except (TypeError, ValueError, OverflowError):
        vector = np.zeros(0)
    if np.ndim(value) != (count != 1) or vector.shape != (count,) or not np.all(np.isfinite(vector)):
        what = {1: "a number", 2: f"{', '.join(_SIDES)}, or two angles", 3: "three numbers"}[count]
        raise ValueError(f"camera: {name} is {value!r}, expected {what}")
    return vector.tolist()
