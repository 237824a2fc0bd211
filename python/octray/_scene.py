"""Scenes: meshes that are placed any number of times."""

from __future__ import annotations

import copy
from functools import cached_property
from typing import TYPE_CHECKING, Any, Iterable, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _octray
from ._mesh import Hits, Mesh, _only_to_read, _thread_count

if TYPE_CHECKING:
    from typing_extensions import Self


class SceneHits(Hits):
    """The closest hits of k rays in a scene: as ``Hits``, and ``instance``, the index of the instance (-1 for a miss).

    ``triangle`` and ``uv`` are those of the instance's mesh.
    """

    instance: NDArray[np.int64]

    def __init__(self, scene, mesh_index, origins, directions, arrays):
        columns, self.instance = arrays
        super().__init__(scene, origins, directions, columns)
        self._mesh_index = mesh_index

    @cached_property
    def mesh(self) -> NDArray[np.int64]:
        """The index of each hit's mesh in the list that the scene was made of, shape (k,); -1 for a miss."""
        mesh = np.full(len(self), -1)
        mesh[self.hit] = self._mesh_index[self.instance[self.hit]]
        return mesh

    @cached_property
    def _surface(self):
        scene, origins, directions = self._ray
        return scene.surface(origins, directions, self.instance, self.triangle, self.t)


class Scene:
    """Meshes that are placed any number of times, for queries, which any number of threads may make at once, and pictures.

    Each mesh is stored once, as it is now: to move the vertices of a ``Mesh`` later does not change the scene.

    Parameters
    ----------
    meshes
        Instances of ``Mesh``.
    transforms
        An affine matrix for each instance, from the space of its mesh to that of the scene, shape (k, 4, 4) or (k, 3, 4).
        They may mirror, stretch and shear, but not flatten. Without them, each mesh is placed once, where it is.
    mesh_index
        The mesh of each instance, an index into ``meshes``, shape (k,). May be missing if there is one mesh, or a transform
        for each.
    threads
        Number of threads; by default ``OCTRAY_THREADS``, or the number of cores.

    Raises
    ------
    ValueError
        If an array has the wrong shape or type, a mesh is not there, a matrix is not finite or has no inverse, or an instance
        is too far away.
    """

    def __init__(
        self,
        meshes: Iterable[Mesh],
        transforms: ArrayLike | None = None,
        mesh_index: ArrayLike | None = None,
        *,
        threads: SupportsIndex | None = None,
    ):
        items = _arrays.items(meshes)
        if items is None or isinstance(meshes, Mesh):
            raise ValueError(f"meshes: expected a list of octray.Mesh, found {_arrays.shown(meshes)}")
        for i, mesh in enumerate(items):
            if not isinstance(mesh, Mesh):
                raise ValueError(f"meshes: expected a list of octray.Mesh, item {i} is {_arrays.shown(mesh)}")
        if transforms is None:
            if mesh_index is not None:
                raise ValueError("mesh_index: expected together with transforms")
            transforms = np.broadcast_to(np.eye(4), (len(items), 4, 4))
        matrices = _arrays.transforms(transforms)
        index = _mesh_index(mesh_index, len(matrices), len(items))
        self._meshes = tuple(copy.copy(mesh) for mesh in items)
        self._mesh_index = index
        native = [mesh._mesh for mesh in self._meshes]
        self._scene = _octray.Scene(native, matrices, index, _thread_count(threads))

    def __repr__(self) -> str:
        return f"<octray.Scene: {len(self)} instances of {len(self._meshes)} meshes>"

    def __len__(self) -> int:
        """Return the number of instances."""
        return len(self._mesh_index)

    @property
    def meshes(self) -> tuple[Mesh, ...]:
        """Copies of the meshes, as they were when the scene was made."""
        return tuple(copy.copy(mesh) for mesh in self._meshes)

    @property
    def mesh_index(self) -> NDArray[np.int64]:
        """The mesh of each instance, shape (k,): a read-only array."""
        return self._mesh_index

    @property
    def transforms(self) -> NDArray[np.float64]:
        """The matrix of each instance, shape (k, 4, 4): a new read-only array each time. See ``move``."""
        transforms = np.zeros((len(self), 4, 4))
        transforms[:, :3] = self._scene.matrices.reshape(-1, 3, 4)
        transforms[:, 3, 3] = 1
        return _only_to_read(transforms)

    @property
    def bounds(self) -> NDArray[np.float64] | None:
        """The lower and the upper corner of the box around the placed boxes of all meshes, shape (2, 3); None if there is nothing.

        If instances are turned, it may be larger than the box around their triangles.
        """
        bounds = self._scene.bounds
        return None if bounds is None else np.array(bounds)

    def closest_hit(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> SceneHits:
        """Find the closest hit of each ray with ``t_min < t < t_max``: as ``Mesh.closest_hit``, in the space of the scene.

        Of equally near hits the one in the first instance counts, and in that of the lowest triangle. A normal is that of the
        mesh, turned: what is outside of a mesh stays outside, of mirrored instances too.
        """
        arguments = _arrays.asked_rays(origins, directions, t_min, t_max)
        scene = self._scene.copy()
        return SceneHits(scene, self._mesh_index, *arguments[:2], scene.closest_hit(*arguments))

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> NDArray[np.bool_]:
        """Return whether each ray hits anything with ``t_min < t < t_max``: shape (k,), ``bool``."""
        return self._scene.occluded(*_arrays.asked_rays(origins, directions, t_min, t_max))

    def all_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        max_hits: SupportsIndex | None = None,
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
        """Find all hits of each ray with ``t_min < t < t_max``.

        Returns ``ray``, ``instance``, ``triangle`` (``int64``) and ``t`` (``float32``): flat arrays, sorted by ray, then t, then
        instance, then triangle. ``max_hits`` keeps the nearest hits of each ray.
        """
        limit = None if max_hits is None else _arrays.count("max_hits", max_hits, least=0)
        return self._scene.all_hits(*_arrays.asked_rays(origins, directions, t_min, t_max), limit)

    def closest_point(
        self, points: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """Find the closest point of all instances to each of k points, in the space of the scene.

        Returns ``point`` (shape (k, 3), ``float64``), ``distance`` (``float64``), ``instance`` and ``triangle`` (``int64``; of
        equally near ones the first instance, and in that the lowest triangle). A point with a NaN, or beyond the range of
        ``float32``, gets NaN, NaN, -1 and -1, as does every point if the scene is empty. Triangles without area are ignored.
        """
        return self._scene.closest_point(_arrays.vectors("points", points, one=True))

    def move(self, transforms: ArrayLike) -> None:
        """Move all instances: a matrix for each, as for a new scene, whose results this one then has.

        Only the BVH over the instances is rebuilt.
        """
        matrices = _arrays.transforms(transforms)
        if len(matrices) != len(self):
            raise ValueError(f"transforms: expected {len(self)}, as there are instances, found {len(matrices)}")
        self._scene.move(matrices)

    def __copy__(self) -> Self:
        """A scene that is moved on its own. They share what is not moved."""
        return self.__deepcopy__(None)

    def __deepcopy__(self, memo: dict[int, Any] | None) -> Self:
        scene = type(self).__new__(type(self))
        if memo is not None:
            memo[id(self)] = scene
        for name, value in self.__dict__.items():
            if name == "_scene":
                value = value.copy()
            elif memo is not None and name not in ("_meshes", "_mesh_index"):
                value = copy.deepcopy(value, memo)
            setattr(scene, name, value)
        return scene

    def __getstate__(self):
        return {**self.__dict__, "_scene": (self._scene.matrices, self._scene.threads)}

    def __setstate__(self, state):
        self.__dict__.update(state)
        matrices, threads = state["_scene"]
        _only_to_read(self._mesh_index)
        native = [mesh._mesh for mesh in self._meshes]
        self._scene = _octray.Scene(native, matrices, self._mesh_index, threads)


def _mesh_index(value: ArrayLike | None, instances: int, meshes: int) -> np.ndarray:
    """Return the mesh of each instance as a read-only ``int64`` array of its own."""
    if value is None:
        if instances != meshes and meshes != 1:
            raise ValueError(
                f"mesh_index: expected the mesh of each instance, because there are {instances} transforms "
                f"and {meshes} meshes"
            )
        index = np.arange(instances) if instances == meshes else np.zeros(instances)
    else:
        index = _arrays.indices("mesh_index", value, instances)
        wrong = np.flatnonzero((index < 0) | (index >= meshes))
        if len(wrong):
            i = wrong[0]
            raise ValueError(f"mesh_index: instance {i} is of mesh {index[i]}, but there are only {meshes} meshes")
    return _only_to_read(np.array(index, dtype=np.int64))
