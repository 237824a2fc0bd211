"""Pictures as arrays."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _octray
from ._mesh import Mesh

_AOVS = ("depth", "normal", "albedo", "id")
_CAMERA = ("eye", "target", "up", "fov")
_LARGEST = 65_535


def render(
    source: str | os.PathLike[str] | Mesh,
    size: tuple[int, int] = (512, 512),
    camera: str | int | Mapping[str, Any] | None = None,
    samples: int = 1,
    aov: Sequence[str] = (),
) -> dict[str, NDArray[Any]]:
    """Render a scene (``.scn``), a mesh file or a :class:`Mesh`, as the program ``octray`` does.

    Parameters
    ----------
    source
        A path, or a mesh, whose z axis points up.
    size
        Width and height, pixels.
    camera
        A camera of the file by name, a classic viewpoint from 1 to 6, or a dictionary with any of ``eye``, ``target``,
        ``up`` (three numbers each) and ``fov`` (degrees, vertical). By default the scene's first camera, or one that
        frames the mesh.
    samples
        Samples for each pixel.
    aov
        More arrays, by name: ``"depth"``, ``"normal"``, ``"albedo"``, ``"id"``, each of one ray through the pixel's
        centre.

    Returns
    -------
    dict
        ``"color"``: shape (height, width, 3), ``uint8``, linear; ``"depth"``: (height, width) ``float32``, infinite where
        nothing is; ``"normal"``, ``"albedo"``: (height, width, 3) ``float32``; ``"id"``: (height, width) ``uint32``, the
        triangle, 2^32 - 1 where nothing is.

    Raises
    ------
    ValueError
        If an argument is wrong, or the file is faulty: with its line and column.
    """
    if isinstance(aov, str):
        aov = (aov,)
    for name in aov:
        if name not in _AOVS:
            raise ValueError(f"aov: expected names among {', '.join(_AOVS)}, found {name!r}")
    try:
        width, height = (_arrays.count("size", part, least=1) for part in size)
    except TypeError as error:
        raise ValueError(f"size: expected a width and a height, found {size!r}") from error
    if max(width, height) > _LARGEST:
        raise ValueError(f"size: expected at most {_LARGEST} pixels a side, found {width} and {height}")
    samples = _arrays.count("samples", samples, least=1)
    if samples > 1 << 20:
        raise ValueError(f"samples: expected at most {1 << 20}, found {samples}")
    start, target, up, fov = camera, None, None, None
    if isinstance(camera, Mapping):
        for name in camera:
            if name not in _CAMERA:
                raise ValueError(f"camera: expected keys among {', '.join(_CAMERA)}, found {name!r}")
        start, target, up = (_vector(name, camera.get(name)) for name in _CAMERA[:3])
        fov = camera.get("fov")
        fov = None if fov is None else float(fov)
    elif camera is not None and not isinstance(camera, (str, int)):
        raise ValueError(f"camera: expected a name, a number or a dictionary, found {camera!r}")
    if isinstance(camera, int) and not 1 <= camera <= 6:
        raise ValueError(f"camera: expected a viewpoint from 1 to 6, found {camera}")
    source = source._mesh if isinstance(source, Mesh) else os.fspath(source)
    arrays, notes = _octray.render(source, (width, height), start, target, up, fov, samples, bool(aov))
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return {name: arrays[name] for name in ("color", *aov)}


def _vector(name, value):
    if value is None:
        return None
    vector = np.asarray(value)
    if vector.shape != (3,) or vector.dtype.kind not in "fiu" or not np.all(np.isfinite(vector)):
        raise ValueError(f"camera: {name} is {value!r}, expected three numbers")
    return [float(part) for part in vector]
