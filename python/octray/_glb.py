"""Scenes of trimesh as GLB files in memory, by its exporter, which is given only what a picture shows."""

from __future__ import annotations

import io
import itertools
import json
import struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _arrays, _camera
from ._looks import Look, linear, looks_of

_BYTE, _SHORT = 5121, 5123
# Of a float32.
_LARGEST = float(np.finfo(np.float32).max)
ALPHA = "left out: alpha of the colours of vertices or faces"


class Glb(NamedTuple):
    """A GLB file, warnings, and the order of the faces of a mesh, if it is another than that of the mesh."""

    file: io.BytesIO
    notes: list[str]
    faces: NDArray[np.int64] | None


class _Part(NamedTuple):
    """A mesh, point cloud or path of trimesh, and which faces these are, if it shows some of a mesh."""

    geometry: Any
    faces: NDArray[np.int64] | None = None


def glb(subject) -> Glb:
    """Return a scene, mesh, point cloud or path as a GLB file.

    Colours look as in trimesh, which writes those of vertices, faces and simple materials as if glTF had them in sRGB.
    """
    from trimesh import Scene
    from trimesh.exchange.gltf import export_glb

    notes: list[str] = []
    is_scene = hasattr(subject, "graph")
    shown = Scene()
    places = _places(subject) if is_scene else [("mesh", np.eye(4))]
    geometries = subject.geometry if is_scene else {"mesh": subject}
    if is_scene and subject.has_camera:
        _add_camera(subject, shown)
    looks: dict[Any, Look] = {}
    pieces: list[tuple[str, str, Any]] = []
    order, used = None, {name for name, _ in places}
    names: dict[Any, str] = {}
    for name in (name for name in geometries if name in used):
        parts = _parts(f"geometry {name!r}" if is_scene else "mesh", geometries[name], looks, notes)
        if not parts:
            continue
        names[name] = str(len(names))
        shown.geometry[names[name]] = parts[0].geometry
        pieces += ((names[name], f"{names[name]}.{i}", part.geometry) for i, part in enumerate(parts[1:], 1))
        if not is_scene and parts[0].faces is not None:
            order = np.concatenate([part.faces for part in parts])
    if not names:
        why = "".join(f"; {note}" for note in notes)
        raise ValueError(f"mesh: {_arrays.shown(subject)} has nothing to render{why}")
    # After all others, so that they can be taken away.
    shown.geometry.update({piece: geometry for _, piece, geometry in pieces})
    for i, (name, matrix) in enumerate(places):
        if name in names:
            shown.graph.update(frame_to=f"node {i}", matrix=matrix, geometry=names[name])
    owners = {piece: owner for owner, piece, _ in pieces}

    def correct(exported):
        meshes = {mesh["name"]: mesh for mesh in exported.get("meshes", ())}
        for name, mesh in meshes.items():
            look = getattr(getattr(shown.geometry[name], "visual", None), "material", None)
            if isinstance(look, Look):
                look.correct(exported["materials"][mesh["primitives"][0]["material"]])
        for piece, owner in owners.items():
            meshes[owner]["primitives"] += meshes[piece]["primitives"]
        if meshes:
            exported["meshes"] = [mesh for name, mesh in meshes.items() if name not in owners]

    content = export_glb(shown, include_normals=False, tree_postprocessor=correct)
    file = io.BytesIO(_with_linear_colors(content))
    # In messages.
    file.name = "mesh"  # type: ignore[attr-defined]
    return Glb(file, list(dict.fromkeys(notes)), order)


def _places(scene) -> list[tuple[Any, NDArray[np.float64]]]:
    """Return the names of geometries and where they are, relative to the scene's base frame."""
    graph, frames = scene.graph, _Frames(scene.graph)
    nodes = ((node, graph.transforms.node_data[node].get("geometry")) for node in graph.nodes_geometry)
    return [(name, frames.placed(node)) for node, name in nodes if name in scene.geometry]


class _Frames:
    """The nodes of a scene's graph. trimesh's own transforms take a matrix with NaN for none."""

    def __init__(self, graph: Any):
        self._forest, self._base = graph.transforms, graph.base_frame
        self._edges, self._parents = self._forest.edge_data, self._forest.parents
        self._known: dict[Any, Any] = {self._base: np.eye(4)}

    def placed(self, node) -> NDArray[np.float64]:
        """Return the transform of a node, relative to the base frame."""
        steps: list[tuple[Any, Any]] = []
        at = node
        while at not in self._known:
            if at not in self._parents or len(steps) > len(self._parents):
                return self._aside(node)
            steps.append((self._parents[at], at))
            at = self._parents[at]
        for parent, child in reversed(steps):
            matrix, above = self._matrix((parent, child)), self._known[parent]
            # Products change the sign of 0.
            self._known[child] = matrix if parent == self._base else above @ matrix
        return self._known[node]

    def _aside(self, node) -> NDArray[np.float64]:
        """Return the transform of a node that is not below the base frame."""
        try:
            path = self._forest.shortest_path(self._base, node)
            steps = [(pair, pair in self._edges) for pair in itertools.pairwise(path)]
        except (KeyError, ValueError) as error:
            raise ValueError(f"graph: node {node!r} is not connected to the base frame {self._base!r}") from error
        placed: Any = np.eye(4)
        for pair, is_down in steps:
            matrix = self._matrix(pair if is_down else pair[::-1])
            try:
                placed = placed @ (matrix if is_down else np.linalg.inv(matrix))
            except np.linalg.LinAlgError as error:
                raise ValueError(f"graph: transform of node {pair[0]!r} has no inverse, but leads to {node!r}") from error
        return placed

    def _matrix(self, edge: tuple[Any, Any]) -> NDArray[np.float64]:
        matrix = np.asarray(self._edges[edge].get("matrix", np.eye(4)), dtype=np.float64)
        finite(f"graph: transform of node {edge[1]!r}", matrix, _LARGEST)
        return matrix


def _add_camera(scene, shown) -> None:
    """Add the scene's camera, unless it makes no view: pictures need not use it."""
    camera = scene.camera
    try:
        matrix = _Frames(scene.graph).placed(camera.name)
    except ValueError:
        return
    if np.all(np.isfinite(camera.fov)) and np.isfinite(camera.z_near):
        shown.camera = camera
        shown.graph.update(frame_to=camera.name, matrix=matrix)


def _parts(label: str, geometry, looks: dict[Any, Look], notes: list[str]) -> list[_Part]:
    """Return what a picture shows of a geometry: nothing if it is empty, several parts if it has several materials."""
    from trimesh import PointCloud

    if hasattr(geometry, "entities"):
        if len(geometry.entities) == 0:
            return []
        used = np.concatenate([np.ravel(entity.points) for entity in geometry.entities]).astype(np.int64)
        finite(f"{label}: vertices", np.asarray(geometry.vertices)[used], _camera.FARTHEST)
        path = geometry.copy()
        path.vertex_attributes = {}
        return [_Part(path)]
    if hasattr(geometry, "faces") and hasattr(geometry, "visual"):
        return _meshes(label, geometry, looks, notes)
    if not hasattr(geometry, "colors"):
        notes.append(f"left out: {label}: a {type(geometry).__name__} is no mesh, point cloud or path")
        return []
    points, colors = np.asarray(geometry.vertices, dtype=np.float64), geometry.colors
    if len(points) == 0:
        return []
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"{label}: vertices: expected shape (n, 3), found {points.shape}")
    finite(f"{label}: vertices", points, _camera.FARTHEST)
    if np.ndim(colors) != 2 or len(colors) != len(points):
        colors = None
    elif opaque(colors)[1]:
        notes.append(ALPHA)
    return [_Part(PointCloud(points, colors=colors))]


def _meshes(label: str, mesh, looks: dict[Any, Look], notes: list[str]) -> list[_Part]:
    """Return a mesh without what a picture does not show, one for each of its materials."""
    from trimesh import Trimesh
    from trimesh.visual import TextureVisuals

    vertices, faces, is_used = arrays_of(label, mesh)
    visual = mesh.visual
    if len(faces) == 0:
        return []
    if visual.kind in ("vertex", "face"):
        colors = getattr(visual, f"{visual.kind}_colors")
        notes += [ALPHA] * opaque(colors)[1]
        if visual.kind == "face":
            # trimesh would write the means of neighbouring faces.
            vertices, colors = vertices[faces].reshape(-1, 3), np.repeat(colors, 3, axis=0)
            faces = np.arange(3 * len(faces)).reshape(-1, 3)
        return [_Part(Trimesh(vertices, faces, vertex_colors=colors, process=False))]
    parts = []
    for look, which in looks_of(label, visual, len(faces), looks, notes):
        own, corners = np.arange(len(vertices)), faces
        if which is not None:
            own, corners = np.unique(faces[which], return_inverse=True)
        part = Trimesh(vertices[own], corners.reshape(-1, 3), process=False)
        if look is not None:
            uv = _uv(label, visual, is_used, notes) if look.has_textures else None
            part.visual = TextureVisuals(uv=None if uv is None else uv[own], material=look)
            colors = _colors(label, visual, len(vertices), notes)
            if colors is not None:
                part.visual.vertex_attributes["color"] = colors[own]
        parts.append(_Part(part, which))
    return parts


def arrays_of(label: str, mesh) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.bool_]]:
    """Return the vertices and faces of a mesh, and which vertices a face uses: others may have any numbers."""
    vertices, faces = np.asarray(mesh.vertices, dtype=np.float64), np.asarray(mesh.faces, dtype=np.int64)
    vertices, faces = vertices.view(np.ndarray), faces.view(np.ndarray)
    is_used = np.zeros(len(vertices), dtype=bool)
    if len(faces) == 0:
        return vertices, faces, is_used
    if faces.min() < 0 or faces.max() >= len(vertices):
        found = faces.min() if faces.min() < 0 else faces.max()
        raise ValueError(f"{label}: faces: expected indices of {len(vertices)} vertices, found {found}")
    is_used[faces] = True
    vertices = _without_strays(vertices, is_used, _camera.FARTHEST)
    finite(f"{label}: vertices", vertices, _camera.FARTHEST)
    return vertices, faces, is_used


def _without_strays(numbers, is_used, most: float):
    """Return an array with 0 in rows that are not used, but out of range."""
    is_stray = ~is_used & ~np.all(np.abs(numbers) <= most, axis=1)
    return np.where(is_stray[:, None], 0.0, numbers) if is_stray.any() else numbers


def _uv(label: str, visual, is_used, notes: list[str]) -> NDArray[np.float64] | None:
    """Return the texture coordinates of a mesh with textures."""
    uv = getattr(visual, "uv", None)
    if uv is None or len(uv) == 0:
        return None
    uv = np.array(uv, dtype=np.float64)
    if uv.ndim != 2 or uv.shape[1] < 2 or len(uv) != len(is_used):
        notes.append(f"left out: uv of {label}: expected shape ({len(is_used)}, 2), found {uv.shape}")
        return None
    uv = _without_strays(uv[:, :2], is_used, _LARGEST)
    finite(f"{label}: uv", uv, _LARGEST)
    return uv


def _colors(label: str, visual, count: int, notes: list[str]) -> NDArray[np.uint8] | None:
    """Return the colours of the vertices of a mesh with a material, which are multiplied."""
    from trimesh.visual.color import to_rgba

    colors = getattr(visual, "vertex_attributes", {}).get("color")
    if colors is None or len(colors) == 0:
        return None
    if np.shape(colors) not in ((count, 3), (count, 4)):
        notes.append(f"left out: colours of {label}: expected shape ({count}, 4), found {np.shape(colors)}")
        return None
    rgba = to_rgba(np.asarray(colors))
    notes += [ALPHA] * opaque(rgba)[1]
    return rgba


def finite(what: str, numbers, most: float) -> None:
    """Raise ``ValueError`` if a number is not finite, or above ``most``."""
    # False for NaN as well.
    is_fine = np.abs(numbers) <= most
    if not np.all(is_fine):
        raise ValueError(f"{what}: expected finite numbers of at most {most:.3g}, found {np.asarray(numbers)[~is_fine][0]}")


def opaque(colors) -> tuple[np.ndarray, bool]:
    """Return colours without alpha, and whether that is left out."""
    colors = np.asarray(colors)
    return colors[:, :3], bool(colors.shape[1] == 4 and np.any(colors[:, 3] != 255))


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
        values = np.full((count, 4), 65535, dtype="<u2")
        values[:, :3] = np.round(linear(colors[:, :3] / 255) * 65535)
        tree["accessors"][number] = {
            "componentType": _SHORT,
            "normalized": True,
            "type": "VEC4",
            "count": count,
            "bufferView": len(tree["bufferViews"]),
        }
        tree["bufferViews"].append({"buffer": 0, "byteOffset": end, "byteLength": values.nbytes})
        parts.append(values.tobytes())
        end += values.nbytes
        tree["buffers"][0]["byteLength"] = end
    header = json.dumps(tree).encode()
    header += b" " * (-len(header) % 4)
    chunks = struct.pack("<I4s", len(header), b"JSON") + header
    chunks += struct.pack("<I4s", end, b"BIN\0") + b"".join(parts)
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
