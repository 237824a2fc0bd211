"""Checks of arguments: converts each to a contiguous array of the right type, or raises ``ValueError``."""

from __future__ import annotations

import operator
import sys

import numpy as np


def _numbers(name: str, value, what: str) -> np.ndarray:
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
    array = _numbers(name, value, what)
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
    array = _numbers("faces", value, what)
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


def ends(name: str, value, count: int) -> float | np.ndarray:
    """Return the ends of rays: a number, or a contiguous ``float32`` array with one per ray.

    They are rounded outwards, so that a ``float32`` ``t`` compares with the result as with the value.
    """
    what = f"a number or an array of shape ({count},)"
    array = _numbers(name, _narrow(value), what)
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


def count(name: str, value, *, least: int, most: int = sys.maxsize) -> int:
    """Return a count, clamped to ``most``."""
    try:
        number = operator.index(value)
    except TypeError:
        number = int(value) if isinstance(value, (float, np.floating)) and float(value).is_integer() else least - 1
    if isinstance(value, bool) or number < least:
        raise ValueError(f"{name}: expected a whole number of at least {least}, found {shown(value)}")
    return min(number, most)
