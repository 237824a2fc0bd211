"""octray as the engine of trimesh's ray queries, and pictures of trimesh's meshes, point clouds and scenes.

>>> import octray.trimesh
>>> mesh.ray = octray.trimesh.RayMeshIntersector(mesh)  # doctest: +SKIP
>>> picture = octray.trimesh.render(mesh)["color"]  # doctest: +SKIP
"""

from __future__ import annotations

from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays
from ._mesh import Mesh
from ._shown import render

__all__ = ["RayMeshIntersector", "render"]


class RayMeshIntersector:
    """The methods of ``trimesh.ray.ray_pyembree.RayMeshIntersector``, with the same shapes and types.

    Where a ray passes through an edge or a vertex, one triangle is reported, as by trimesh's engines: of those that share
    the edge or vertex the one with the lowest index, or with ``every_triangle`` all that the ray touches. Where surfaces
    touch, or one folds back, there may be two.
    ``intersects_first`` reports any of them: the one whose rounded distance is the least. ``max_hits`` counts what is
    reported. Hits are sorted by ray, the nearest first. A ray that starts exactly on a triangle hits it. ``scale_to_box``
    has no effect: coordinates are never scaled.
    """

    def __init__(self, geometry: Any, scale_to_box: bool = True, every_triangle: bool = False):
        # Its class, because trimesh's primitives make their engine before they have vertices.
        if isinstance(geometry, Mesh) or not all(hasattr(type(geometry), name) for name in ("vertices", "faces")):
            raise ValueError(f"geometry: expected a mesh of trimesh, found {geometry!r}")
        self.mesh = geometry
        self.every_triangle = _arrays.flag("every_triangle", every_triangle)
        self._scale_to_box = scale_to_box
        self._built: tuple[int, Mesh] | None = None

    @property
    def _scene(self) -> Mesh:
        """The mesh with its current vertices."""
        key = hash(self.mesh)
        if self._built is None or self._built[0] != key:
            mesh = Mesh(self.mesh.vertices.view(np.ndarray), self.mesh.faces.view(np.ndarray))
            self._built = (key, mesh)
        return self._built[1]

    def intersects_location(
        self, ray_origins: ArrayLike, ray_directions: ArrayLike, multiple_hits: bool = True
    ) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Return where rays hit: ``locations`` (m, 3), ``index_ray`` (m,), ``index_tri`` (m,)."""
        index_tri, index_ray, locations = self.intersects_id(
            ray_origins, ray_directions, multiple_hits=multiple_hits, return_locations=True
        )
        return locations, index_ray, index_tri

    def intersects_id(
        self,
        ray_origins: ArrayLike,
        ray_directions: ArrayLike,
        multiple_hits: bool = True,
        max_hits: SupportsIndex = 100,
        return_locations: bool = False,
    ) -> tuple[Any, ...]:
        """Return the triangles that rays hit: ``index_tri`` (m,), ``index_ray`` (m,), and with ``return_locations``
        ``locations`` (m, 3)."""
        origins, directions = _checked(ray_origins, ray_directions)
        scene = self._scene
        limit = _arrays.count("max_hits", max_hits, least=0)
        is_single = not _arrays.flag("multiple_hits", multiple_hits)
        limit = min(limit, 1) if is_single else limit
        # The nearest of all that the ray touches may be any of those at an edge, by rounding.
        once = is_single or not self.every_triangle
        index_ray, index_tri, t = scene._mesh.all_hits(origins, directions, 0.0, np.inf, limit, False, True, once)
        if not _arrays.flag("return_locations", return_locations):
            return index_tri, index_ray
        locations, _ = scene._mesh.surface(origins, directions, index_ray, index_tri, t, False)
        return index_tri, index_ray, locations

    def intersects_first(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> NDArray[np.int32]:
        """Return the first triangle that each ray hits, -1 for none: (n,). Rays are rounded to ``float32``, and of triangles
        at the same distance then it is the one with the lowest index."""
        return self._scene._mesh.first(*_checked(ray_origins, ray_directions))

    def intersects_any(self, ray_origins: ArrayLike, ray_directions: ArrayLike) -> NDArray[np.bool_]:
        """Return whether each ray hits anything: (n,)."""
        return self._scene._mesh.any(*_checked(ray_origins, ray_directions))

    def contains_points(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether each point is inside: (n,). For a mesh that is not closed, uses trimesh's algorithm."""
        at = _doubles("points", points)
        if at.ndim != 2 or at.shape[1] != 3:
            raise ValueError(f"points: expected shape (n, 3), found {at.shape}")
        if self.mesh.is_watertight:
            return self._scene.contains(at)
        from trimesh.ray.ray_util import contains_points

        return contains_points(_Crossings(self.mesh, self._scene), at)

    def __getstate__(self):
        return {**self.__dict__, "_built": None}

    def __deepcopy__(self, *_: Any) -> RayMeshIntersector:
        return self.__copy__()

    def __copy__(self, *_: Any) -> RayMeshIntersector:
        return RayMeshIntersector(self.mesh, self._scale_to_box, self.every_triangle)


class _Crossings:
    """The interface that trimesh's algorithm for open meshes needs: which rays cross the mesh, and how often."""

    def __init__(self, mesh, scene):
        self.mesh = mesh
        self._scene = scene

    def intersects_location(self, ray_origins, ray_directions, multiple_hits: bool = True):
        ray, triangle, t = self._scene.all_hits(ray_origins, ray_directions, crossings=True)
        return t, ray, triangle


def _doubles(name: str, value: ArrayLike) -> NDArray[np.float64]:
    return np.ascontiguousarray(_arrays.numbers(name, value, "an array of numbers of shape (n, 3)"), dtype=np.float64)


def _checked(ray_origins, ray_directions):
    origins, directions = _doubles("ray_origins", ray_origins), _doubles("ray_directions", ray_directions)
    if origins.shape != directions.shape:
        raise ValueError("Ray origin and direction don't match!")
    if origins.ndim != 2 or origins.shape[1] != 3:
        raise ValueError(f"rays: expected shape (n, 3), found {origins.shape}")
    return origins, directions
