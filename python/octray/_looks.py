"""Materials of trimesh as its exporter to glTF takes them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _arrays

_TEXTURES = ("baseColorTexture", "emissiveTexture", "normalTexture", "occlusionTexture", "metallicRoughnessTexture")
_NUMBERS = ("alphaCutoff", "metallicFactor", "roughnessFactor")
# What PNG files hold.
_MODES = ("1", "L", "LA", "I;16", "P", "RGB", "RGBA")
_CONVERTED = {"I": "I;16", "La": "LA", "PA": "RGBA", "RGBa": "RGBA"}


class Look:
    """A material for trimesh's exporter.

    trimesh takes materials with equal hashes for the same, such as those of two colours that are diffuse as well as
    ambient; a look has its identity instead.
    """

    def __init__(self, label: str, material, notes: list[str]):
        self._is_simple = hasattr(material, "diffuse")
        self._diffuse = np.asarray(material.diffuse) / 255 if self._is_simple else np.ones(4)
        self._pbr = _simple(label, material) if self._is_simple else _physical(label, material)
        for name in _TEXTURES:
            image = getattr(self._pbr, name)
            if image is not None and not hasattr(image, "getbands"):
                notes.append(f"left out: {name} of {label}: expected a picture of PIL, found a {type(image).__name__}")
                image = None
            elif image is not None and 0 in image.size:
                notes.append(f"left out: {name} of {label}: it has no pixels")
                image = None
            setattr(self._pbr, name, image if image is None else _writable(image))
        image = self._pbr.baseColorTexture
        if self._is_simple and (self._diffuse[3] < 1 or image is not None and _is_translucent(image)):
            self._pbr.alphaMode = "BLEND"

    @property
    def has_textures(self) -> bool:
        """Whether it uses texture coordinates."""
        return any(getattr(self._pbr, name) is not None for name in _TEXTURES)

    def to_pbr(self) -> SimpleNamespace:
        """Return the attributes that the exporter reads."""
        return self._pbr

    def copy(self) -> Look:
        return self

    def correct(self, exported) -> None:
        """Correct a material of the file: a simple one is not metal, and its colour, which a texture hides, is in sRGB."""
        if not self._is_simple:
            return
        factors = exported.setdefault("pbrMetallicRoughness", {})
        factors["metallicFactor"] = 0.0
        color = [1.0] * 3
        if "baseColorTexture" not in factors:
            color = linear(self._diffuse[:3]).tolist()
        factors["baseColorFactor"] = [*color, float(self._diffuse[3])]


def looks_of(
    label: str, visual, count: int, known: dict[Any, Look], notes: list[str]
) -> list[tuple[Look | None, NDArray[np.int64] | None]]:
    """Return the looks of a mesh of ``count`` faces, and which faces have each; None for all of them.

    ``known`` has those of other meshes, so that equal materials become one.
    """
    material: Any = getattr(visual, "material", None)
    if not hasattr(material, "materials"):
        return [(_look(label, material, known, notes), None)]
    materials = list(material.materials)
    if len(materials) == 1:
        return [(_look(label, materials[0], known, notes), None)]
    which = np.asarray(getattr(visual, "face_materials", None))
    is_index = which.dtype.kind in "iu" and which.shape == (count,)
    if not is_index or np.any((which < 0) | (which >= len(materials))):
        notes.append(
            f"left out: materials of {label}: expected face_materials with an index of {len(materials)} materials for each "
            f"of {count} faces"
        )
        return [(None, None)]
    faces = ((materials[i], np.flatnonzero(which == i)) for i in np.unique(which))
    return [(_look(label, own, known, notes), some) for own, some in faces]


def _look(label: str, material, known: dict[Any, Look], notes: list[str]) -> Look | None:
    if material is None:
        return None
    names = ("diffuse", "glossiness", "baseColorFactor", "emissiveFactor", "alphaMode", "doubleSided", *_NUMBERS)
    try:
        own = hash(material)
    except (TypeError, ValueError, OverflowError):
        # trimesh converts numbers that may be NaN.
        own = id(material)
    # trimesh's hash is of the bytes of numbers and pixels, not of what they are.
    images = (getattr(material, name, None) for name in ("image", *_TEXTURES))
    shapes = [(getattr(image, "size", None), getattr(image, "mode", None)) for image in images]
    key = (own, repr(shapes), *(repr(getattr(material, name, None)) for name in names))
    if key not in known:
        known[key] = Look(label, material, notes)
    return known[key]


def _simple(label: str, material) -> SimpleNamespace:
    """Return what a simple material is as a physical one."""
    glossiness = _number(label, "glossiness", getattr(material, "glossiness", 1.0))
    look = SimpleNamespace(**dict.fromkeys((*_TEXTURES, *_NUMBERS, "name", "emissiveFactor", "alphaMode", "doubleSided")))
    look.baseColorTexture, look.baseColorFactor = getattr(material, "image", None), material.diffuse
    # As trimesh has it.
    look.roughnessFactor = (2 / (max(glossiness, 0.0) + 2)) ** 0.25
    return look


def _physical(label: str, material) -> SimpleNamespace:
    """Return a physical material's attributes."""
    if hasattr(material, "to_pbr"):
        material = material.to_pbr()
    names = ("baseColorFactor", "emissiveFactor", "alphaMode", "doubleSided", *_TEXTURES, *_NUMBERS)
    look = SimpleNamespace(name=None, **{name: getattr(material, name, None) for name in names})
    for name in _NUMBERS:
        value = getattr(look, name)
        setattr(look, name, None if value is None else _number(label, name, value))
    if look.emissiveFactor is not None:
        for value in np.ravel(look.emissiveFactor):
            _number(label, "emissiveFactor", float(value))
    return look


def _number(label: str, name: str, value) -> float:
    return _arrays.number(f"{label}: {name} of its material", value, "a finite number")


def _writable(image):
    """Return a picture that trimesh can write as PNG or JPEG."""
    if "transparency" in image.info and image.mode in ("1", "L", "P", "RGB"):
        return image.convert("RGBA")
    if image.mode not in _MODES:
        return image.convert(_CONVERTED.get(image.mode, "RGB"))
    # What was a JPEG file may have got an alpha since.
    return image.copy() if image.format == "JPEG" and image.mode not in ("L", "RGB") else image


def _is_translucent(image) -> bool:
    return "A" in image.getbands() and image.getchannel("A").getextrema()[0] < 255


def linear(colors: np.ndarray) -> np.ndarray:
    """Return linear values of sRGB, both from 0 to 1."""
    return np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
