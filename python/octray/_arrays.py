"""Checks of arguments: converts each to a contiguous array of the right type, or raises ``ValueError``."""

from __future__ import annotations

import operator
import sys

import numpy as np


def numbers(name: str, value, what: str) -> np.ndarray:
    """Return an array of real numbers."""
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name}: expected {what}, found rows of different lengths") from error
    if array.size == 0 and array.dtype.kind == "f":
        return array
    if value is None:
        raise ValueError(f"{name}: expected {what}, found None")
    refuse_masked(name, value, what)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name}: expected {what}, found an array of {array.dtype}")
    return array


def refuse_masked(name: str, value, what: str) -> None:
    """Raise ``ValueError`` if items are masked: numpy would pass on what is under the mask."""
    if np.ma.is_masked(value):
        count = np.ma.count_masked(value)
        raise ValueError(f"{name}: expected {what}, found a masked array with {count} masked items")


def shown(value) -> str:
    """Return a value for an error message."""
    try:
        text = repr(value)
    except ValueError:
        # Python writes no integers of more than some thousand digits.
        return "a larger one"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _require(array: np.ndarray, dtype) -> np.ndarray:
    """Return an array for the native code: contiguous, aligned and in the machine's byte order."""
    return np.require(array, dtype, ["C", "A"])


def vectors(name: str, value, *, one: bool = False) -> np.ndarray:
    """Return vectors, one per row, as contiguous ``float32`` or ``float64``."""
    what = "an array of numbers of shape (n, 3)"
    array = numbers(name, value, what)
    if array.ndim == 1 and array.shape == (3,) and one:
        array = array.reshape(1, 3)
    if array.size == 0 and array.ndim == 1:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"{name}: expected {what}, found shape {array.shape}")
    if array.dtype == np.float32:
        return _require(array, np.float32)
    return _require(array, np.float64)


def faces(value) -> np.ndarray:
    """Return triangles, three vertex indices per row, as contiguous ``int64``."""
    what = "an array of integers of shape (m, 3)"
    array = numbers("faces", value, what)
    if array.size == 0 and array.ndim <= 2:
        return np.zeros((0, 3), dtype=np.int64)
    if array.dtype.kind not in "iu":
        raise ValueError(f"faces: expected {what}, found an array of {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces: expected {what}, found shape {array.shape}")
    if array.dtype == np.uint64 and array.size and array.max() > np.iinfo(np.int64).max:
        raise ValueError("faces: a vertex index is above 2^63")
    return _require(array, np.int64)


def rays(origins, directions) -> tuple[np.ndarray, np.ndarray]:
    """Return origins and directions; a single one of either is used for all of the other."""
    origins = vectors("origins", origins, one=True)
    directions = vectors("directions", directions, one=True)
    if len(directions) == 1 and len(origins) != 1:
        directions = np.ascontiguousarray(np.broadcast_to(directions, origins.shape))
    if len(origins) not in (1, len(directions)):
        raise ValueError(
            f"origins and directions: expected as many of each, or one, "
            f"found {len(origins)} and {len(directions)}"
        )
    return origins, directions


def asked_rays(
    origins, directions, t_min, t_max
) -> tuple[np.ndarray, np.ndarray, float | np.ndarray, float | np.ndarray]:
    """Return origins, directions and the ends of rays."""
    arrays = rays(origins, directions)
    count = len(arrays[1])
    return *arrays, ends("t_min", t_min, count), ends("t_max", t_max, count)


def indices(name: str, value, count: int) -> np.ndarray:
    """Return an array of ``count`` integers."""
    what = f"integers of shape ({count},)"
    array = numbers(name, value, what)
    if array.size == 0 and array.ndim == 1:
        array = array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise ValueError(f"{name}: expected {what}, found an array of {array.dtype}")
    if array.shape != (count,):
        raise ValueError(f"{name}: expected {what}, found shape {array.shape}")
    if array.dtype == np.uint64:
        array = np.minimum(array, np.uint64(2**63 - 1))
    return array.astype(np.int64)


def transforms(value) -> np.ndarray:
    """Return affine matrices as contiguous ``float64``, the 12 numbers of the upper three rows per row."""
    what = "matrices of shape (k, 4, 4) or (k, 3, 4)"
    array = numbers("transforms", value, what)
    if array.size == 0 and array.ndim == 1:
        array = array.reshape(0, 3, 4)
    if array.ndim != 3 or array.shape[1:] not in ((4, 4), (3, 4)):
        raise ValueError(f"transforms: expected {what}, found shape {array.shape}")
    if array.shape[1] == 4:
        wrong = np.flatnonzero((array[:, 3] != [0, 0, 0, 1]).any(axis=1))
        if len(wrong):
            i = wrong[0]
            raise ValueError(f"transforms: the last row of matrix {i} is {array[i, 3]}, expected [0 0 0 1]")
    return _require(array[:, :3].reshape(-1, 12), np.float64)


def ends(name: str, value, count: int) -> float | np.ndarray:
    """Return the ends of rays: a number, or a contiguous ``float32`` array with one per ray.

    They are rounded outwards, so that a ``float32`` ``t`` compares with the result as with the value.
    """
    what = f"a number or an array of shape ({count},)"
    array = numbers(name, _narrow(value), what)
    if array.ndim != 0 and array.shape != (count,):
        raise ValueError(f"{name}: expected {what}, found shape {array.shape}")
    if array.ndim == 0 and np.isnan(array):
        raise ValueError(f"{name}: expected a number, found nan")
    if name == "t_min" and np.any(array < 0):
        raise ValueError("t_min: expected numbers of at least 0")
    if array.dtype != np.float32:
        exact = array.astype(np.float64)
        with np.errstate(over="ignore"):
            array = exact.astype(np.float32)
        if name == "t_min":
            array = np.where(array > exact, np.nextafter(array, np.float32(-np.inf)), array)
        else:
            array = np.where(array < exact, np.nextafter(array, np.float32(np.inf)), array)
    return float(array) if array.ndim == 0 else _require(array, np.float32)


def _narrow(value):
    """Return ``float64`` for integers of more than 64 bits, for which numpy has no type, and anything else as it is."""

    def double(number: int) -> float:
        try:
            return float(number)
        except OverflowError:
            return np.inf if number > 0 else -np.inf

    items = [value] if isinstance(value, int) else value
    if not isinstance(items, (list, tuple)) or not all(type(item) in (int, float) for item in items):
        return value
    doubles = [double(item) for item in items]
    return doubles[0] if isinstance(value, int) else doubles


def count_up_to(name: str, value, most: int) -> int:
    """Return a count from 1 to ``most``."""
    number = count(name, value, least=1)
    if number > most:
        raise ValueError(f"{name}: expected a whole number from 1 to {most}, found {shown(value)}")
    return number


def items(value):
    """Return the items of a sequence, or None if it is none."""
    try:
        return tuple(value)
    except TypeError:
        return None


def flag(name: str, value) -> bool:
    """Return a truth value."""
    if not isinstance(value, (bool, np.bool_)):
        raise ValueError(f"{name}: expected True or False, found {shown(value)}")
    return bool(value)


def one_of(name: str, value, names: tuple[str, ...]) -> str | None:
    """Return one of some names, or None."""
    if value is not None and not (isinstance(value, str) and value in names):
        raise ValueError(f"{name}: expected {', '.join(names[:-1])} or {names[-1]}, found {shown(value)}")
    return value


def is_number(value) -> bool:
    """Return whether a value is one number: no text and no truth value, which numpy would convert."""
    return np.ndim(value) == 0 and not isinstance(value, (str, bytes, bool, np.bool_)) and getattr(value, "dtype", "") != bool


def number(name: str, value, what: str, least: float = -sys.float_info.max, most: float = sys.float_info.max) -> float:
    """Return a finite number."""
    refuse_masked(name, value, what)
    try:
        if not is_number(value):
            raise TypeError
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = np.nan
    if not least <= found <= most:
        raise ValueError(f"{name}: expected {what}, found {shown(value)}")
    return found


def colors(name: str, value, count: int) -> np.ndarray:
    """Return colours from 0 to 1, one per row, as contiguous ``float32``."""
    what = f"uint8, or floats from 0 to 1, of shape ({count}, 3)"
    array = numbers(name, value, what)
    if array.dtype != np.uint8 and array.dtype.kind != "f":
        raise ValueError(f"{name}: expected {what}, found an array of {array.dtype}")
    if array.shape not in ((count, 3), (count, 4)):
        raise ValueError(f"{name}: expected {what}, found shape {array.shape}")
    full = 255 if array.dtype == np.uint8 else 1
    # False for NaN as well.
    if array.dtype.kind == "f" and not np.all((array >= 0) & (array <= 1)):
        raise ValueError(f"{name}: expected {what}, found others, such as {array[~((array >= 0) & (array <= 1))][0]}")
    if array.shape[1] == 4 and np.any(array[:, 3] != full):
        raise ValueError(f"{name}: alpha is not rendered: expected {full} in all of the fourth column")
    return _require(array[:, :3].astype(np.float32) / np.float32(full), np.float32)


def values(name: str, value, vertices: int, faces: int) -> np.ndarray:
    """Return one number for each vertex or for each face as contiguous ``float64``."""
    what = f"numbers of shape ({vertices},) for vertices or ({faces},) for faces"
    array = numbers(name, value, what)
    if array.shape not in ((vertices,), (faces,)):
        raise ValueError(f"{name}: expected {what}, found shape {array.shape}")
    return _require(array.astype(np.float64), np.float64)


def count(name: str, value, *, least: int, most: int = sys.maxsize) -> int:
    """Return a count, clamped to ``most``."""
    try:
        number = operator.index(value)
    except TypeError:
        number = int(value) if isinstance(value, (float, np.floating)) and float(value).is_integer() else least - 1
    if isinstance(value, bool) or number < least:
        raise ValueError(f"{name}: expected a whole number of at least {least}, found {shown(value)}")
    return min(number, most)
