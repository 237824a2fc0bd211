from collections.abc import Mapping, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = ["Mesh", "Scene", "__version__", "camera_rays", "isa", "load", "of_parts", "parts", "program", "render"]

__version__: str

def isa() -> str: ...
def program(arguments: Sequence[str]) -> int: ...

_Vectors = NDArray[np.float32] | NDArray[np.float64]
_Ends = float | NDArray[np.float32]

@final
class Mesh:
    def __new__(cls, vertices: _Vectors, faces: NDArray[np.int64], threads: int | None) -> Mesh: ...
    @property
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None: ...
    @property
    def counts(self) -> tuple[int, int]: ...
    def closest_hit(
        self, origins: _Vectors, directions: _Vectors, t_min: _Ends, t_max: _Ends
    ) -> tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.float32], NDArray[np.bool_]]: ...
    def first(self, origins: _Vectors, directions: _Vectors) -> NDArray[np.int32]: ...
    def occluded(
        self, origins: _Vectors, directions: _Vectors, t_min: _Ends, t_max: _Ends
    ) -> NDArray[np.bool_]: ...
    def any(self, origins: _Vectors, directions: _Vectors) -> NDArray[np.bool_]: ...
    def all_hits(
        self,
        origins: _Vectors,
        directions: _Vectors,
        t_min: _Ends,
        t_max: _Ends,
        max_hits: int | None,
        crossings: bool,
        starts: bool,
        once: bool,
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]: ...
    def surface(
        self,
        origins: _Vectors,
        directions: _Vectors,
        ray: NDArray[np.int64] | None,
        triangle: NDArray[np.int64],
        t: NDArray[np.float32],
        with_normals: bool,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    # Triangles without area are ignored; in an empty mesh NaN, NaN and -1.
    def closest_point(
        self, points: _Vectors
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]: ...
    def signed_distance(self, points: _Vectors) -> NDArray[np.float64]: ...
    def contains(self, points: _Vectors) -> NDArray[np.bool_]: ...
    def refit(self, vertices: _Vectors) -> None: ...
    def copy(self) -> Mesh: ...

@final
class Scene:
    # Of matrices the upper three rows, 12 numbers per instance.
    def __new__(
        cls,
        meshes: Sequence[Mesh],
        matrices: NDArray[np.float64],
        indices: NDArray[np.int64],
        threads: int | None,
    ) -> Scene: ...
    @property
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None: ...
    @property
    def matrices(self) -> NDArray[np.float64]: ...
    @property
    def threads(self) -> int | None: ...
    def closest_hit(
        self, origins: _Vectors, directions: _Vectors, t_min: _Ends, t_max: _Ends
    ) -> tuple[
        tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.float32], NDArray[np.bool_]], NDArray[np.int64]
    ]: ...
    def occluded(
        self, origins: _Vectors, directions: _Vectors, t_min: _Ends, t_max: _Ends
    ) -> NDArray[np.bool_]: ...
    def all_hits(
        self,
        origins: _Vectors,
        directions: _Vectors,
        t_min: _Ends,
        t_max: _Ends,
        max_hits: int | None,
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]: ...
    def surface(
        self,
        origins: _Vectors,
        directions: _Vectors,
        instance: NDArray[np.int64],
        triangle: NDArray[np.int64],
        t: NDArray[np.float32],
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    # In an empty scene NaN, NaN, -1 and -1.
    def closest_point(
        self, points: _Vectors
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]: ...
    def move(self, matrices: NDArray[np.float64]) -> None: ...
    def copy(self) -> Scene: ...

_Parts = tuple[NDArray[np.float32], list[float], NDArray[np.uint32], int | None]

def load(path: str, threads: int | None) -> tuple[Mesh, list[str]]: ...
def parts(mesh: Mesh) -> _Parts: ...
def of_parts(
    vertices: NDArray[np.float32],
    middle: Sequence[float],
    triangles: NDArray[np.uint32],
    threads: int | None,
) -> Mesh: ...

# A scene, its meshes, and the mesh of each instance.
_Solid = Mesh | tuple[Scene, Sequence[Mesh], NDArray[np.int64]]

# Cameras and options are dictionaries with the items of `Camera` in src/camera.rs and `Options` in src/picture.rs.
def render(
    source: _Solid | str | tuple[bytes, str], size: tuple[int, int], camera: Mapping[str, Any], options: Mapping[str, Any]
) -> tuple[dict[str, NDArray[Any]], list[str]]: ...
def camera_rays(
    mesh: _Solid | None, size: tuple[int, int], camera: Mapping[str, Any], style: str | None, up_axis: str | None
) -> tuple[NDArray[np.float64], NDArray[np.float32]]: ...
