"""Pictures of trimesh's meshes, point clouds and scenes: those with more than colours by way of a GLB file in memory."""

from __future__ import annotations

import inspect
import io
import json
import struct
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _arrays
from ._mesh import Mesh
from ._render import render as _render
from ._render import rendered

_DEFAULTS = {
    name: parameter.default
    for name, parameter in inspect.signature(_render).parameters.items()
    if name not in ("source", "vertex_colors", "face_colors")
}
_BYTE, _SHORT = 5121, 5123


def render(mesh: Any, /, **options: Any) -> dict[str, NDArray[Any]]:
    """Render a ``Trimesh``, a ``PointCloud`` or a ``Scene`` of trimesh with its colours, textures and instances.

    The z axis points up, and nothing is turned: the camera's ``eye`` and ``target`` are in trimesh's coordinates.
    Faces are flat unless ``smooth_angle`` is given: trimesh's ``vertex_normals`` are not used.
    Colours of vertices and faces are in sRGB. Their alpha is left out, with a warning.

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
        If there is nothing to render, or an argument is invalid.
    """
    for name in options:
        if name not in _DEFAULTS:
            raise ValueError(f"options: expected names among {', '.join(_DEFAULTS)}, found {name!r}")
    if options.get("up_axis") is None:
        options["up_axis"] = "z"
    colors: dict[str, Any] = dict.fromkeys(("vertex_colors", "face_colors"))
    source: Mesh | io.BytesIO
    is_translucent = False
    if _is(mesh, "vertices", "faces") and not hasattr(mesh.visual, "material"):
        source = Mesh(mesh.vertices.view(np.ndarray), mesh.faces.view(np.ndarray))
        if mesh.visual.kind in ("vertex", "face"):
            name = f"{mesh.visual.kind}_colors"
            colors[name], is_translucent = _opaque(getattr(mesh.visual, name))
    elif _is(mesh, "vertices", "faces") or _is(mesh, "vertices", "colors"):
        source, is_translucent = _glb(mesh.scene())
    elif _is(mesh, "geometry", "graph"):
        source, is_translucent = _glb(mesh)
    else:
        raise ValueError(f"mesh: expected a mesh, point cloud or scene of trimesh, found {_arrays.shown(mesh)}")
    if is_translucent:
        warnings.warn("left out: alpha of the colours of vertices or faces", stacklevel=2)
    return rendered(3, source=source, **{**_DEFAULTS, **colors, **options})


def _is(mesh, *names: str) -> bool:
    # Not by its values, because trimesh's primitives compute their vertices when they are asked for.
    own = getattr(mesh, "__dict__", ())
    return not isinstance(mesh, Mesh) and all(hasattr(type(mesh), name) or name in own for name in names)


def _opaque(colors) -> tuple[np.ndarray, bool]:
    """Return colours without alpha, and whether that is left out."""
    colors = np.asarray(colors)
    return colors[:, :3], bool(colors.shape[1] == 4 and np.any(colors[:, 3] != 255))


def _glb(scene) -> tuple[io.BytesIO, bool]:
    """Return a scene as a GLB file, and whether the alpha of colours is left out.

    Colours look as in trimesh, which writes those of vertices, faces and simple materials as if glTF had them in sRGB.
    """
    from trimesh import Scene, Trimesh
    from trimesh.exchange.gltf import export_glb

    shown = Scene(graph=scene.graph, camera=scene.camera if scene.has_camera else None)
    is_translucent = False
    for name, part in scene.geometry.items():
        kind = part.visual.kind if _is(part, "faces") else "cloud"
        if kind in ("vertex", "face"):
            is_translucent |= _opaque(getattr(part.visual, f"{kind}_colors"))[1]
        elif kind == "cloud" and np.ndim(part.colors) == 2:
            is_translucent |= _opaque(part.colors)[1]
        if kind == "face":
            # trimesh would write the means of neighbouring faces.
            corners, count = part.vertices[part.faces].reshape(-1, 3), len(part.faces)
            faces, colors = np.arange(3 * count).reshape(-1, 3), np.repeat(part.visual.face_colors, 3, axis=0)
            part = Trimesh(corners, faces, vertex_colors=colors, process=False)
        shown.geometry[name] = part

    def correct(exported):
        for mesh in exported.get("meshes", ()):
            material = getattr(getattr(shown.geometry.get(mesh["name"]), "visual", None), "material", None)
            if not hasattr(material, "diffuse"):
                continue
            # A simple material, which is not metal.
            numbers = {primitive["material"] for primitive in mesh["primitives"] if "material" in primitive}
            for number in numbers:
                factors = exported["materials"][number].setdefault("pbrMetallicRoughness", {})
                factors["metallicFactor"] = 0.0
                color = np.asarray(material.diffuse) / 255
                is_shown = "baseColorTexture" not in factors
                factors["baseColorFactor"] = [*_linear(color[:3]).tolist(), float(color[3])] if is_shown else [1.0] * 4

    content = export_glb(shown, include_normals=False, tree_postprocessor=correct)
    return io.BytesIO(_with_linear_colors(content)), is_translucent


def _with_linear_colors(content: bytes) -> bytes:
    """Return a GLB file whose colours of vertices, sRGB in bytes, are linear and opaque in 16 bits."""
    (length,) = struct.unpack_from("<I", content, 12)
    tree = json.loads(content[20 : 20 + length])
    binary = content[28 + length :]
    parts, end = [binary], len(binary)
    primitives = [primitive for mesh in tree.get("meshes", ()) for primitive in mesh["primitives"]]
    for number in sorted({p["attributes"]["COLOR_0"] for p in primitives if "COLOR_0" in p["attributes"]}):
        accessor = tree["accessors"][number]
        if accessor["componentType"] != _BYTE:
            continue
        channels, count = int(accessor["type"][-1]), accessor["count"]
        start = tree["bufferViews"][accessor["bufferView"]].get("byteOffset", 0) + accessor.get("byteOffset", 0)
        colors = np.frombuffer(binary, np.uint8, channels * count, start).reshape(count, channels)
        linear = np.full((count, 4), 65535, dtype="<u2")
        linear[:, :3] = np.round(_linear(colors[:, :3] / 255) * 65535)
        tree["accessors"][number] = {
            "componentType": _SHORT,
            "normalized": True,
            "type": "VEC4",
            "count": count,
            "bufferView": len(tree["bufferViews"]),
        }
        tree["bufferViews"].append({"buffer": 0, "byteOffset": end, "byteLength": linear.nbytes})
        parts.append(linear.tobytes())
        end += linear.nbytes
        tree["buffers"][0]["byteLength"] = end
    header = json.dumps(tree).encode()
    header += b" " * (-len(header) % 4)
    chunks = struct.pack("<I4s", len(header), b"JSON") + header
    chunks += struct.pack("<I4s", end, b"BIN\0") + b"".join(parts)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _linear(colors: np.ndarray) -> np.ndarray:
    """Return linear values of sRGB, both from 0 to 1."""
    return np.where(colors <= 0.04045, colors / 12.92, ((colors + 0.055) / 1.055) ** 2.4)
