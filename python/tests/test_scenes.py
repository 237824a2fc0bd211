"""Scenes of placed meshes: against one mesh of all baked instances, and wrong arguments."""

import copy
import pickle
import threading

import numpy as np
import pytest

import octray
from test_queries import sphere


def cube():
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners, np.array([[a, b, c] for a, b, c, _ in sides] + [[a, c, d] for a, _, c, d in sides])


def matrices(random, count, far=0.0):
    """Turned, mirrored and stretched, but not flat."""
    placed = np.tile(np.eye(4), (count, 1, 1))
    for matrix in placed:
        turned, _ = np.linalg.qr(random.normal(size=(3, 3)))
        matrix[:3, :3] = turned * random.uniform(0.2, 0.8, 3)
        matrix[:3, 3] = random.uniform(-2, 2, 3) + far
    return placed


def baked(arrays, placed, index):
    """One mesh of all instances, the instance and the triangle of each of its faces."""
    vertices, faces, instance, triangle, count = [], [], [], [], 0
    for i, (matrix, mesh) in enumerate(zip(placed, index)):
        positions, corners = arrays[mesh]
        vertices.append(positions @ matrix[:3, :3].T + matrix[:3, 3])
        faces.append(corners + count)
        instance.append(np.full(len(corners), i))
        triangle.append(np.arange(len(corners)))
        count += len(positions)
    return np.concatenate(vertices), np.concatenate(faces), np.concatenate(instance), np.concatenate(triangle)


@pytest.mark.parametrize("far", [0.0, 3e6])
def test_hits_are_those_of_the_baked_instances(far):
    random = np.random.default_rng(4)
    arrays = [sphere(8, 12), cube()]
    meshes = [octray.Mesh(*both) for both in arrays]
    index = np.arange(20) % 2
    placed = matrices(random, 20, far)
    scene = octray.Scene(meshes, placed, index)
    vertices, faces, instance, triangle = baked(arrays, placed, index)
    mesh = octray.Mesh(vertices, faces)
    origins = random.uniform(-4, 4, (3000, 3)) + far
    directions = random.uniform(-2, 2, (3000, 3)) + far - origins
    expected = mesh.closest_hit(origins, directions)
    hits = scene.closest_hit(origins, directions)
    assert (hits.instance.dtype, hits.triangle.dtype, hits.mesh.dtype) == (np.int64, np.int64, np.int64)
    # At edges and outlines rounding decides.
    same = (hits.hit == expected.hit) & (
        ~expected.hit
        | (hits.instance == instance[expected.triangle]) & (hits.triangle == triangle[expected.triangle])
    )
    assert np.count_nonzero(~same) < 10 and np.count_nonzero(expected.hit) > 1000
    both = same & expected.hit
    # Rays that graze a surface are not compared.
    facing = np.abs(np.sum(expected.normal * directions, axis=1)) / np.linalg.norm(directions, axis=1)
    both &= facing > 0.1
    assert np.allclose(hits.t[both], expected.t[both], rtol=1e-4, atol=1e-5)
    assert np.allclose(hits.position[both] - far, expected.position[both] - far, atol=1e-4)
    mirrored = np.where(np.linalg.det(placed[:, :3, :3]) < 0, -1, 1)
    normals = expected.normal[both] * mirrored[hits.instance[both], None]
    assert np.allclose(hits.normal[both], normals, atol=1e-5)
    missed = ~hits.hit
    assert np.all(hits.t[missed] == np.inf) and np.all(np.isnan(hits.position[missed]))
    assert np.all(hits.instance[missed] == -1) and np.all(hits.mesh[missed] == -1)
    assert np.array_equal(hits.mesh[hits.hit], index[hits.instance[hits.hit]])
    assert np.array_equal(scene.occluded(origins, directions), hits.hit)
    shares = np.count_nonzero(scene.occluded(origins, directions, t_max=0.5) != mesh.occluded(origins, directions, t_max=0.5))
    assert shares < 10
    ray, of_instance, of_triangle, t = scene.all_hits(origins, directions)
    assert (ray.dtype, of_instance.dtype, of_triangle.dtype, t.dtype) == (np.int64, np.int64, np.int64, np.float32)
    baked_ray, baked_triangle, baked_t = mesh.all_hits(origins, directions)
    alike = np.bincount(ray, minlength=3000) == np.bincount(baked_ray, minlength=3000)
    assert np.count_nonzero(~alike) < 20
    kept, baked_kept = alike[ray], alike[baked_ray]
    assert np.allclose(t[kept], baked_t[baked_kept], rtol=1e-3, atol=1e-4)
    first = np.unique(ray, return_index=True)[1]
    assert np.array_equal(t[first], hits.t[hits.hit])
    ray, of_instance, _, _ = scene.all_hits(origins, directions, max_hits=1)
    assert np.array_equal(ray, np.flatnonzero(hits.hit))
    bounds = scene.bounds
    assert np.all(bounds[0] <= vertices.min(axis=0) + 1e-6) and np.all(bounds[1] >= vertices.max(axis=0) - 1e-6)


def test_defaults_and_shapes():
    ball, box = octray.Mesh(*sphere(6, 8)), octray.Mesh(*cube())
    alone = octray.Scene([box, ball])
    assert len(alone) == 2 and np.array_equal(alone.mesh_index, [0, 1])
    assert np.array_equal(alone.transforms, np.tile(np.eye(4), (2, 1, 1)))
    assert np.array_equal(alone.bounds, [[-1, -1, -1], [1, 1, 1]])
    assert "2 instances of 2 meshes" in repr(alone)
    moved = np.tile(np.eye(4), (5, 1, 1))
    moved[:, 0, 3] = np.arange(5) * 10
    for placed in (moved, moved[:, :3], moved.tolist(), np.asfortranarray(moved), moved.astype(np.float32)):
        scene = octray.Scene([box], placed)
        assert len(scene) == 5 and np.array_equal(scene.mesh_index, np.zeros(5))
        assert np.array_equal(scene.transforms, moved)
        hits = scene.closest_hit(moved[:, :3, 3] + [0.1, 0.2, 5], [0, 0, -1])
        assert np.array_equal(hits.instance, np.arange(5)) and np.allclose(hits.t, 4)
        assert "5 of 5" in repr(hits) and repr(hits).startswith("<octray.SceneHits")
    scene = octray.Scene([box, ball], moved, np.array([1, 0, 1, 0, 1], dtype=np.uint8), threads=2)
    assert np.array_equal(scene.closest_hit(moved[:, :3, 3] + [0, 0, 5], [0.01, 0.01, -1]).mesh, [1, 0, 1, 0, 1])
    assert [str(mesh) for mesh in scene.meshes] == [str(box), str(ball)]
    for nothing in (octray.Scene([]), octray.Scene([box], []), octray.Scene([octray.Mesh([], [])])):
        assert nothing.bounds is None and not nothing.occluded([0, 0, 5], [0, 0, -1]).any()
        hits = nothing.closest_hit([0, 0, 5], [[0, 0, -1], [np.nan, 0, 0]])
        assert not hits.hit.any() and np.all(hits.mesh == -1) and np.all(np.isnan(hits.normal))
        assert [len(column) for column in nothing.all_hits([0, 0, 5], [0, 0, -1])] == [0] * 4
    # Empty meshes keep their places.
    scene = octray.Scene([octray.Mesh([], []), box, ball], moved[[0, 0, 2, 3]], [0, 1, 0, 2])
    assert np.array_equal(scene.closest_hit([[0, 0, 5], [30, 0, 5]], [0.01, 0.01, -1]).instance, [1, 3])


def test_moved_instances():
    box = octray.Mesh(*cube())
    random = np.random.default_rng(5)
    first, second = matrices(random, 30), matrices(random, 30)
    scene = octray.Scene([box], first)
    origins, directions = random.uniform(-3, 3, (500, 3)), random.normal(size=(500, 3))
    before = scene.closest_hit(origins, directions)
    twin = copy.copy(scene)
    scene.move(second)
    after, new = scene.closest_hit(origins, directions), octray.Scene([box], second).closest_hit(origins, directions)
    assert np.array_equal(after.t, new.t) and np.array_equal(after.instance, new.instance)
    assert np.array_equal(scene.transforms, second) and np.array_equal(twin.transforms, first)
    assert np.array_equal(twin.closest_hit(origins, directions).t, before.t)
    # Hits belong to the scene as it was.
    where = before.hit
    ahead = (origins + before.t[:, None] * directions)[where]
    assert np.allclose(before.position[where], ahead, atol=1e-4)
    wrong = second.copy()
    wrong[7, :3, :3] = 0
    for bad, why in ((wrong, "instance 7 flattens"), (second[1:], "expected 30")):
        with pytest.raises(ValueError, match=why):
            scene.move(bad)
        assert np.array_equal(scene.closest_hit(origins, directions).t, after.t)
    # A mesh that moves later moves no scene.
    box.refit(np.asarray(box.vertices) * 3)
    assert np.array_equal(scene.closest_hit(origins, directions).t, after.t)
    assert np.array_equal(scene.meshes[0].bounds, [[-1, -1, -1], [1, 1, 1]])
    scene.meshes[0].refit(np.asarray(box.vertices))
    assert np.array_equal(pickle.loads(pickle.dumps(scene)).closest_hit(origins, directions).t, after.t)


def test_copies_and_pickles():
    class Named(octray.Scene):
        pass

    random = np.random.default_rng(6)
    scene = octray.Scene([octray.Mesh(*sphere(6, 8)), octray.Mesh(*cube())], matrices(random, 12), np.arange(12) % 2, threads=2)
    origins, directions = random.uniform(-3, 3, (300, 3)), random.normal(size=(300, 3))
    hits = scene.closest_hit(origins, directions)
    for other in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        again = other.closest_hit(origins, directions)
        assert np.array_equal(again.t, hits.t) and np.array_equal(again.instance, hits.instance)
        assert np.array_equal(other.transforms, scene.transforms) and other._scene.threads == 2
        assert not other.mesh_index.flags.writeable
    kept = pickle.loads(pickle.dumps(hits))
    assert np.array_equal(kept.position, hits.position, equal_nan=True) and np.array_equal(kept.mesh, hits.mesh)
    named = Named([octray.Mesh(*cube())])
    named.label = ["a"]
    for other in (copy.copy(named), copy.deepcopy(named)):
        assert type(other) is Named and other.label == ["a"]
    named.itself = named
    assert (other := copy.deepcopy(named)).itself is other
    with pytest.raises(ValueError):
        scene.mesh_index[0] = 1
    with pytest.raises(ValueError):
        scene.transforms[0] = 1


def test_many_threads_trace_and_move():
    random = np.random.default_rng(7)
    box = octray.Mesh(*cube())
    places = [matrices(random, 20) for _ in range(2)]
    origins, directions = random.uniform(-3, 3, (2000, 3)), random.normal(size=(2000, 3))
    expected = [octray.Scene([box], place).closest_hit(origins, directions).t for place in places]
    scene, wrong = octray.Scene([box], places[0]), []

    def trace():
        for _ in range(20):
            t = scene.closest_hit(origins, directions).t
            wrong.extend([] if any(np.array_equal(t, one) for one in expected) else [t])

    threads = [threading.Thread(target=trace) for _ in range(3)]
    for thread in threads:
        thread.start()
    for i in range(40):
        scene.move(places[i % 2])
    for thread in threads:
        thread.join()
    assert not wrong


def sheared(random, count, far=0.0):
    """Turned, mirrored, stretched by very different factors and sheared."""
    placed = matrices(random, count, far)
    for i, matrix in enumerate(placed):
        shear = np.eye(3) + np.triu(random.uniform(-2, 2, (3, 3)), 1)
        factors = [[1, 1, 1], [1, -0.01, 1], [0.01, 1, 0.02], [-1, -1, -1]][i % 4]
        matrix[:3, :3] = matrix[:3, :3] @ shear * factors
    return placed


def distances(points, corners):
    """The distance of each point from each triangle: from its edges, or its plane where it is in front of it."""
    points, (a, b, c) = points[:, None], np.moveaxis(corners, 1, 0)

    def edge(a, b):
        along = b - a
        part = np.clip(np.sum((points - a) * along, axis=2) / np.sum(along * along, axis=1), 0, 1)
        return np.linalg.norm(points - a - part[..., None] * along, axis=2)

    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    sides = [np.sum(np.cross(end - start, points - start) * normals, axis=2) for start, end in ((a, b), (b, c), (c, a))]
    is_in_front = np.min(sides, axis=0) >= 0
    plane = np.abs(np.sum((points - a) * normals, axis=2))
    return np.where(is_in_front, plane, np.min([edge(a, b), edge(b, c), edge(c, a)], axis=0))


@pytest.mark.parametrize(("size", "far"), [(1.0, 0.0), (1e-7, 0.0), (1e6, 0.0), (1.0, 3e6), (1e3, -4e8)])
def test_closest_points_are_those_of_all_placed_triangles(size, far):
    random = np.random.default_rng(8)
    arrays = [sphere(6, 8), cube()]
    index = np.arange(24) % 2
    placed = sheared(random, 24)
    placed[:, :3] *= size
    placed[:, :3, 3] += far
    scene = octray.Scene([octray.Mesh(*both) for both in arrays], placed, index)
    vertices, faces, instance, triangle = baked(arrays, placed, index)
    # Flat at the poles of the sphere.
    areas = np.linalg.norm(np.cross(*(vertices[faces[:, i]] - vertices[faces[:, 0]] for i in (1, 2))), axis=1)
    wide = areas > 1e-6 * size**2
    corners = vertices[faces]
    points = np.concatenate(
        [
            random.uniform(-2, 2, (300, 3)) * size + far,
            random.uniform(-1e3, 1e3, (100, 3)) * size + far,
            corners[random.integers(len(faces), size=100)].mean(axis=1),
        ]
    )
    point, distance, of_instance, of_triangle = scene.closest_point(points)
    assert (point.dtype, distance.dtype, of_instance.dtype, of_triangle.dtype) == (float, float, np.int64, np.int64)
    all_distances = distances(points, corners[wide])
    # Matrices are rounded to float32, which shows more the more they stretch.
    tolerance = 2e-5 * size
    assert np.allclose(distance, all_distances.min(axis=1), rtol=1e-6, atol=tolerance)
    assert np.allclose(np.linalg.norm(point - points, axis=1), distance, rtol=1e-6, atol=2e-7 * size + 1e-15 * abs(far))
    first = np.searchsorted(instance, np.arange(24))
    own = corners[first[of_instance] + of_triangle]
    on_own = [distances(p[None], one[None])[0, 0] for p, one in zip(points, own)]
    assert np.allclose(on_own, distance, rtol=1e-6, atol=tolerance)


def test_closest_points_where_there_is_nothing():
    box = octray.Mesh(*cube())
    for nothing in (octray.Scene([]), octray.Scene([box], []), octray.Scene([octray.Mesh([], [])])):
        found = nothing.closest_point(np.zeros((2, 3)))
        assert found[0].shape == (2, 3) and np.isnan(found[0]).all() and np.isnan(found[1]).all()
        assert found[2].tolist() == found[3].tolist() == [-1, -1]
    moved = np.tile(np.eye(4), (3, 1, 1))
    moved[:, 0, 3] = [4, -4, 4]
    scene = octray.Scene([box], moved)
    point, distance, instance, triangle = scene.closest_point([[0, 0.1, 0.2], [np.nan, 0, 0], [1e39, 0, 0], [-1, 0, 0]])
    assert instance.tolist() == [0, -1, -1, 1] and np.allclose(distance, [3, np.nan, np.nan, 2], equal_nan=True)
    assert np.allclose(point[0], [3, 0.1, 0.2], atol=1e-12) and triangle[1] == -1 and np.isnan(point[1:3]).all()
    assert [len(column) for column in scene.closest_point(np.zeros((0, 3)))] == [0] * 4
    one = scene.closest_point([0, 0.1, 0.2])
    assert one[2].tolist() == [0]
    scene.move(moved[[1, 0, 2]])
    assert scene.closest_point([0, 0.1, 0.2])[2].tolist() == [0] and scene.closest_point([3, 0, 0])[2].tolist() == [1]
    for wrong in ([1, 2], "points", None, np.zeros((2, 2)), np.ma.masked_equal(np.eye(3), 1)):
        with pytest.raises(ValueError, match="points"):
            scene.closest_point(wrong)


def wrongs():
    eye = np.eye(4)
    tilted, nan, flat, far = (np.stack([eye, eye]) for _ in range(4))
    tilted[1, 3, 0] = 1e-9
    nan[1, 0, 0] = np.nan
    flat[1, 2] = [1, 0, 0, 0]
    far[1, 0, 3] = 1e12
    yield (eye,), "shape"
    yield (np.zeros((2, 4, 3)),), "shape"
    yield (np.zeros((2, 3)),), "shape"
    yield ([[1, 2], [3]],), "different lengths"
    yield (["a", "b"],), "array of"
    yield (np.ma.masked_equal(np.stack([eye, eye]), 1),), "masked"
    yield (tilted,), "last row of matrix 1"
    yield (nan,), "instance 1 has a number that is not finite"
    yield (flat,), "instance 1 flattens"
    yield (far,), "instance 1 has the coordinate 1.*e12"
    yield (np.stack([eye] * 3),), "3 transforms and 2 meshes"
    yield (np.stack([eye] * 2), [0]), "shape"
    yield (np.stack([eye] * 2), [0.0, 1.0]), "array of float64"
    yield (np.stack([eye] * 2), [True, False]), "array of bool"
    yield (np.stack([eye] * 2), [0, 2]), "instance 1 is of mesh 2, but there are only 2"
    yield (np.stack([eye] * 2), [-1, 0]), "instance 0 is of mesh -1"
    yield (np.stack([eye] * 2), np.array([0, 2**64 - 1], dtype=np.uint64)), "instance 1 is of mesh"
    yield (None, [0, 1]), "together"


@pytest.mark.parametrize(("arguments", "why"), list(wrongs()))
def test_wrong_arguments(arguments, why):
    meshes = [octray.Mesh(*cube()), octray.Mesh(*cube())]
    with pytest.raises(ValueError, match=why):
        octray.Scene(meshes, *arguments)


def test_wrong_meshes_and_rays():
    box = octray.Mesh(*cube())
    for meshes in (box, None, 3, [box, None], [cube()], "mesh", [octray.Scene([box])]):
        with pytest.raises(ValueError, match="octray.Mesh"):
            octray.Scene(meshes)
    for threads in (0, -1, 1.5, True, 10_000):
        with pytest.raises(ValueError, match="threads"):
            octray.Scene([box], threads=threads)
    scene = octray.Scene([box])
    for call in (scene.closest_hit, scene.occluded, scene.all_hits):
        with pytest.raises(ValueError, match="origins and directions"):
            call(np.zeros((2, 3)), np.zeros((3, 3)))
        with pytest.raises(ValueError, match="t_min"):
            call([0, 0, 5], [0, 0, -1], t_min=-1)
    with pytest.raises(ValueError, match="max_hits"):
        scene.all_hits([0, 0, 5], [0, 0, -1], max_hits=-1)


def test_a_scene_of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    made = trimesh.Scene()
    box, ball = trimesh.creation.box(), trimesh.creation.icosphere(subdivisions=2, radius=0.5)
    made.add_geometry(ball, node_name="node 0", geom_name="ball")
    made.add_geometry(box, node_name="node 1", geom_name="box")
    for i in range(4):
        placed = trimesh.transformations.translation_matrix([3 * i, 0, 0])
        made.graph.update(f"node {i}", matrix=placed, geometry="box" if i % 2 else "ball")
    names, nodes = list(made.geometry), list(made.graph.nodes_geometry)
    placed = [made.graph[node] for node in nodes]
    meshes = [octray.Mesh(made.geometry[name].vertices, made.geometry[name].faces) for name in names]
    scene = octray.Scene(meshes, [matrix for matrix, _ in placed], [names.index(name) for _, name in placed])
    hits = scene.closest_hit([[3 * i, 0, 5] for i in range(4)], [0.001, 0.002, -1])
    assert [nodes[i] for i in hits.instance] == [f"node {i}" for i in range(4)]
    assert [names[i] for i in hits.mesh] == ["ball", "box", "ball", "box"]
