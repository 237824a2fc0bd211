"""Meshes and hits."""

from __future__ import annotations

import copy
import os
import warnings
from functools import cached_property
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _octray

if TYPE_CHECKING:
    from typing_extensions import Self

_MOST_THREADS = 4096


class Hits:
    """The closest hits of k rays.

    ``t`` is the distance of each hit in units of the direction's length (``inf`` for a miss); ``triangle`` the index of
    the triangle (-1 for a miss); ``uv`` the barycentric weights of its second and third corner; ``hit`` whether the ray
    hits.
    """

    t: NDArray[np.float32]
    triangle: NDArray[np.int64]
    uv: NDArray[np.float32]
    hit: NDArray[np.bool_]

    def __init__(self, mesh, origins, directions, arrays):
        self._ray = (mesh, origins, directions)
        self.t, self.triangle, self.uv, self.hit = arrays

    def __len__(self) -> int:
        return len(self.t)

    def __repr__(self) -> str:
        return f"<octray.{type(self).__name__}: {int(self.hit.sum())} of {len(self)} rays hit>"

    @cached_property
    def _surface(self):
        mesh, origins, directions = self._ray
        return mesh.surface(origins, directions, None, self.triangle, self.t, True)

    @property
    def position(self) -> NDArray[np.float64]:
        """The hit points, shape (k, 3), ``float64``; NaN for a miss.

        Computed on first access, from the mesh as it was when the rays were traced and the original arrays of rays: do
        not change those before.
        """
        return self._surface[0]

    def __getstate__(self):
        return {**self.__dict__, "_surface": self._surface, "_ray": None}

    @property
    def normal(self) -> NDArray[np.float64]:
        """Unit normals of the triangles that are hit, by their winding, shape (k, 3), ``float64``; NaN for a miss.

        Computed like ``position``.
        """
        return self._surface[1]


class Mesh:
    """A triangle mesh for queries, which any number of threads may make at once.

    Parameters
    ----------
    vertices
        Positions, shape (n, 3), ``float32`` or ``float64``. They are stored in ``float32``, relative to the mesh's
        centre on each axis on which it is far from 0.
    faces
        Three vertex indices each, shape (m, 3), integers.
    threads
        Number of threads; by default ``OCTRAY_THREADS``, or the number of cores.

    Raises
    ------
    ValueError
        If an array has the wrong shape or type, a coordinate is not finite, or an index has no vertex.
    """

    def __init__(self, vertices: ArrayLike, faces: ArrayLike, *, threads: SupportsIndex | None = None):
        number = _thread_count(threads)
        self._mesh = _octray.Mesh(_arrays.vectors("vertices", vertices), _arrays.faces(faces), number)

    @classmethod
    def from_file(cls, path: str | bytes | os.PathLike[str], *, threads: SupportsIndex | None = None) -> Self:
        """Load a mesh file: ``.ply``, ``.obj``, ``.off``, ``.stl``, ``.gltf``, ``.glb``, ``.3mf``, ``.vtk``,
        ``.vtp`` or ``.vtu``.

        Vertices are in the file's own coordinates, whichever axis points up. Warnings name what is missing or ignored.

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        ValueError
            If the file is faulty, with line and column, or has no triangles.
        """
        if not isinstance(path, (str, bytes, os.PathLike)):
            raise ValueError(f"path: expected a path, found {path!r}")
        mesh = cls.__new__(cls)
        mesh._mesh, notes = _octray.load(os.fsdecode(path), _thread_count(threads))
        for note in notes:
            warnings.warn(note, stacklevel=2)
        return mesh

    def __repr__(self) -> str:
        vertices, triangles = self._mesh.counts
        return f"<octray.Mesh: {vertices} vertices, {triangles} triangles>"

    @property
    def vertices(self) -> NDArray[np.float64]:
        """The stored vertices, shape (n, 3): a new read-only array each time. See ``refit``."""
        vertices, middle, _, _ = _octray.parts(self._mesh)
        return _only_to_read(vertices + np.array(middle))

    @property
    def faces(self) -> NDArray[np.int64]:
        """The triangles, three vertex indices each, shape (m, 3): a new read-only array each time."""
        return _only_to_read(_octray.parts(self._mesh)[2].astype(np.int64))

    @property
    def bounds(self) -> NDArray[np.float64] | None:
        """The lower and the upper corner of the box around the mesh, shape (2, 3); None if it is empty."""
        bounds = self._mesh.bounds
        return None if bounds is None else np.array(bounds)

    def closest_hit(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> Hits:
        """Find the closest hit of each ray with ``t_min < t < t_max``.

        Of equally near triangles the one with the lowest index is hit. A ray with a NaN misses.

        Parameters
        ----------
        origins, directions
            Shape (k, 3), or one for all: rays with a shared origin are traced fastest. Directions may have any length
            but 0.
        t_min, t_max
            A number, or one for each ray.
        """
        arguments = _arrays.asked_rays(origins, directions, t_min, t_max)
        mesh = self._mesh.copy()
        return Hits(mesh, *arguments[:2], mesh.closest_hit(*arguments))

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
    ) -> NDArray[np.bool_]:
        """Return whether each ray hits anything with ``t_min < t < t_max``: shape (k,), ``bool``."""
        return self._mesh.occluded(*_arrays.asked_rays(origins, directions, t_min, t_max))

    def all_hits(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        *,
        t_min: ArrayLike = 0.0,
        t_max: ArrayLike = np.inf,
        max_hits: SupportsIndex | None = None,
        crossings: bool = False,
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float32]]:
        """Find all hits of each ray with ``t_min < t < t_max``.

        Returns ``ray``, ``triangle`` (``int64``) and ``t`` (``float32``): flat arrays, sorted by ray, then t, then
        triangle. At an edge or a vertex all triangles that the ray touches are hit; with ``crossings`` only those that it
        crosses, so that their number is even for a ray from outside a closed mesh. ``max_hits`` keeps the nearest hits of
        each ray.
        """
        limit = None if max_hits is None else _arrays.count("max_hits", max_hits, least=0)
        arguments = _arrays.asked_rays(origins, directions, t_min, t_max)
        return self._mesh.all_hits(*arguments, limit, _arrays.flag("crossings", crossings), False, False)

    def closest_point(
        self, points: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
        """Find the closest point of the mesh to each of k points.

        Returns ``point`` (shape (k, 3), ``float64``), ``distance`` (``float64``) and ``triangle`` (``int64``; of equally
        near triangles the lowest). A point with a NaN, or beyond the range of ``float32``, gets NaN, NaN and -1, as does
        every point if the mesh is empty. Triangles without area are ignored.
        """
        return self._mesh.closest_point(_arrays.vectors("points", points, one=True))

    def signed_distance(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the distance of each point from the mesh: positive inside, negative outside.

        NaN for a point with a NaN, or beyond the range of ``float32``; minus infinity if the mesh is empty.

        Raises
        ------
        ValueError
            If the mesh is not closed.
        """
        return self._mesh.signed_distance(_arrays.vectors("points", points, one=True))

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return whether each point is inside the mesh: whether rays from it cross the mesh an odd number of times.

        Raises
        ------
        ValueError
            If the mesh is not closed: if an edge belongs to an odd number of triangles.
        """
        return self._mesh.contains(_arrays.vectors("points", points, one=True))

    def refit(self, vertices: ArrayLike) -> None:
        """Move the vertices, whose number must not change, mostly without a new BVH.

        Results are those of a new mesh."""
        moved = _arrays.vectors("vertices", vertices)
        count = self._mesh.counts[0]
        if len(moved) != count:
            raise ValueError(f"vertices: expected {count}, as the mesh has, found {len(moved)}")
        self._mesh.refit(moved)

    def __copy__(self) -> Self:
        """A mesh that is moved on its own. They share what is not moved."""
        return self.__deepcopy__(None)

    def __deepcopy__(self, memo: dict[int, Any] | None) -> Self:
        mesh = type(self).__new__(type(self))
        if memo is not None:
            memo[id(self)] = mesh
        for name, value in self.__dict__.items():
            if name == "_mesh":
                value = value.copy()
            elif memo is not None:
                value = copy.deepcopy(value, memo)
            setattr(mesh, name, value)
        return mesh

    def __getstate__(self):
        return {**self.__dict__, "_mesh": _octray.parts(self._mesh)}

    def __setstate__(self, state):
        self.__dict__.update(state, _mesh=_octray.of_parts(*state["_mesh"]))


def _thread_count(threads: SupportsIndex | None) -> int | None:
    return None if threads is None else _arrays.count_up_to("threads", threads, _MOST_THREADS)


def _only_to_read(array: np.ndarray) -> np.ndarray:
    """Return an array that refuses what would change nothing of the mesh."""
    array.flags.writeable = False
    return array
