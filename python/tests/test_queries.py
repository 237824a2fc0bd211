"""Queries from Python: against one triangle after the other, and wrong arguments."""

import copy
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest

import octray


def sphere(rings=24, segments=36):
    """A closed mesh: a ball of radius 1."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.linspace(0, 2 * np.pi, segments, endpoint=False)
    ring = [[np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)] for a in theta for b in phi]
    vertices = np.array([[0, 0, 1], *ring, [0, 0, -1]])
    last, faces = len(vertices) - 1, []

    def at(i, j):
        return 1 + i * segments + j % segments

    for j in range(segments):
        faces += [[0, at(0, j), at(0, j + 1)], [last, at(rings - 2, j + 1), at(rings - 2, j)]]
        for i in range(rings - 2):
            faces += [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    return vertices, np.array(faces)


def brute(vertices, faces, origin, direction):
    """All t at which a ray meets the mesh, in float64."""
    a, b, c = (vertices[faces[:, i]] - origin for i in range(3))
    normal = np.cross(b - a, c - a)
    with np.errstate(all="ignore"):
        t = np.sum(normal * a, axis=1) / (normal @ direction)
        sides = [np.cross(p, q) @ direction for p, q in ((a, b), (b, c), (c, a))]
    inside = np.all(np.array(sides) > 0, axis=0) | np.all(np.array(sides) < 0, axis=0)
    found = inside & (t > 0)
    order = np.argsort(t[found])
    return t[found][order], np.flatnonzero(found)[order]


@pytest.fixture(scope="module")
def ball():
    vertices, faces = sphere()
    return octray.Mesh(vertices, faces), vertices, faces


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_hits_are_those_of_all_triangles(ball, dtype):
    mesh, vertices, faces = ball
    random = np.random.default_rng(1)
    origins = random.uniform(-2, 2, (400, 3)).astype(dtype)
    directions = random.normal(size=(400, 3)).astype(dtype) * 3
    hits = mesh.closest_hit(origins, directions)
    ray, triangle, t = mesh.all_hits(origins, directions)
    blocked = mesh.occluded(origins, directions)
    assert (hits.t.dtype, hits.triangle.dtype, hits.uv.shape) == (np.float32, np.int64, (400, 2))
    assert (ray.dtype, triangle.dtype, t.dtype) == (np.int64, np.int64, np.float32)
    for i in range(400):
        expected_t, expected = brute(vertices, faces, origins[i].astype(float), directions[i].astype(float))
        assert np.array_equal(triangle[ray == i], expected)
        assert np.allclose(t[ray == i], expected_t, rtol=1e-4)
        assert blocked[i] == hits.hit[i] == bool(len(expected))
        if len(expected):
            assert hits.triangle[i] == expected[0]
    where = hits.hit
    assert np.all(hits.t[~where] == np.inf) and np.all(hits.triangle[~where] == -1)
    assert np.allclose(hits.position[where], (origins + hits.t[:, None] * directions)[where], atol=1e-5)
    assert np.all(np.isnan(hits.position[~where])) and np.all(np.isnan(hits.normal[~where]))
    assert np.allclose(np.linalg.norm(hits.normal[where], axis=1), 1)
    corners = vertices[faces[hits.triangle[where]]]
    u, v = hits.uv[where].T[:, :, None]
    assert np.allclose(corners[:, 0] * (1 - u - v) + corners[:, 1] * u + corners[:, 2] * v, hits.position[where], atol=1e-5)


def test_one_origin_serves_for_all(ball):
    mesh = ball[0]
    directions = np.random.default_rng(2).normal(size=(1000, 3))
    one = mesh.closest_hit([0.0, 0.1, 0.2], directions)
    each = mesh.closest_hit(np.tile([0.0, 0.1, 0.2], (1000, 1)), directions)
    assert np.array_equal(one.t, each.t) and one.hit.all()
    assert np.array_equal(one.position, each.position)
    up = mesh.occluded(np.random.default_rng(3).uniform(-1, 1, (50, 3)) * 0.5, [0, 0, 1])
    assert up.shape == (50,) and up.all()


def test_ends_and_limits(ball):
    mesh = ball[0]
    origin, direction = [[-3.0, 0.01, 0.02]], [[2.0, 0.0, 0.0]]
    _, _, t = mesh.all_hits(origin, direction)
    assert len(t) == 2 and np.allclose(t, [1, 2], atol=0.02)
    assert mesh.closest_hit(origin, direction, t_min=1.5).t == t[1]
    assert mesh.closest_hit(origin, direction, t_min=t[0]).t == t[1]
    assert not mesh.occluded(origin, direction, t_min=t[0], t_max=t[1])
    assert mesh.occluded(origin, direction, t_min=[0.5], t_max=np.nextafter(t[:1], np.float32(9)))
    assert len(mesh.all_hits(origin, direction, max_hits=1)[0]) == 1
    assert len(mesh.all_hits(origin, direction, max_hits=0)[0]) == 0


def test_rays_that_are_none_miss(ball):
    mesh = ball[0]
    origins = np.zeros((5, 3))
    directions = np.array([[1, 0, 0], [np.nan, 0, 0], [0, 0, 0], [np.inf, 0, 0], [0, 1, 0]], dtype=float)
    assert mesh.closest_hit(origins, directions).hit.tolist() == [True, False, False, False, True]
    origins[0, 1] = np.nan
    assert mesh.occluded(origins, directions).tolist() == [False, False, False, False, True]


def test_crossings_of_a_closed_mesh_are_even(ball):
    mesh, vertices, _ = ball
    origins = np.full((len(vertices), 3), 4.0)
    ray, _, _ = mesh.all_hits(origins, vertices - origins, crossings=True)
    assert np.all(np.bincount(ray, minlength=len(vertices)) % 2 == 0)


def test_points(ball):
    mesh, vertices, faces = ball
    points = np.random.default_rng(4).uniform(-1.5, 1.5, (3000, 3))
    inside = mesh.contains(points)
    radius = np.linalg.norm(points, axis=1)
    assert np.all(inside[radius < 0.98]) and not np.any(inside[radius > 1])
    point, distance, triangle = mesh.closest_point(points)
    assert np.allclose(np.linalg.norm(points - point, axis=1), distance)
    assert np.all(distance <= np.abs(radius - 1) + 0.02) and triangle.min() >= 0
    signed = mesh.signed_distance(points)
    assert np.array_equal(signed > 0, inside) and np.array_equal(np.abs(signed), distance)
    nothing = mesh.closest_point([[np.nan, 0, 0]])
    assert np.isnan(nothing[0]).all() and np.isnan(nothing[1]).all() and nothing[2][0] == -1
    # An empty mesh, and triangles without area.
    assert octray.Mesh([], []).closest_point(points)[2].max() == -1
    flat = octray.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 9, 0]], [[0, 1, 2], [0, 2, 3]])
    assert flat.closest_point([[1, -1, 0]])[2].tolist() == [1]


def test_an_open_mesh_has_no_inside():
    vertices, faces = sphere()
    with pytest.raises(ValueError, match="not closed"):
        octray.Mesh(vertices, faces[1:]).contains([[0, 0, 0]])


def test_map_coordinates_with_millimetres():
    vertices, faces = sphere()
    middle = np.array([4e5, 5.6e6, 120.0])
    mesh = octray.Mesh(vertices * 1e-3 + middle, faces)
    hits = mesh.closest_hit(middle, vertices)
    assert hits.hit.all()
    assert np.abs(hits.position - middle - vertices * 1e-3).max() < 1e-6
    assert np.allclose(mesh.bounds, [middle - 1e-3, middle + 1e-3], atol=1e-5)


def test_refit(ball):
    vertices, faces = sphere()
    mesh = octray.Mesh(vertices, faces)
    mesh.refit(vertices * [1, 1, 3])
    assert np.allclose(mesh.closest_hit([[0, 0, 0]], [[0.001, 0.002, 1]]).t, 3, atol=0.01)
    with pytest.raises(ValueError, match="expected"):
        mesh.refit(vertices[1:])


def test_a_mesh_tells_what_it_is_made_of():
    vertices, faces = np.array([[5e6, 0, 0], [5e6 + 1, 0, 0], [5e6, 1, 0.5]]), [[0, 1, 2]]
    mesh = octray.Mesh(vertices, faces)
    assert np.array_equal(mesh.vertices, vertices) and np.array_equal(mesh.faces, faces)
    assert octray.Mesh([], []).vertices.shape == octray.Mesh([], []).faces.shape == (0, 3)
    with pytest.raises(AttributeError):
        mesh.vertices = vertices
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0] = 1


def test_copies_and_pickles(ball):
    _, vertices, faces = ball
    mesh = octray.Mesh(vertices + [4e5, 5e6, 0.3], faces, threads=1)
    points = np.random.default_rng(5).uniform(-2, 2, (200, 3)) + [4e5, 5e6, 0.3]
    hits = mesh.closest_hit(points, points[::-1] - points)
    for other in (copy.copy(mesh), copy.deepcopy(mesh), pickle.loads(pickle.dumps(mesh))):
        assert np.array_equal(other.closest_hit(points, points[::-1] - points).t, hits.t)
        assert np.array_equal(other.vertices, mesh.vertices)
        assert np.array_equal(other.signed_distance(points), mesh.signed_distance(points))
        other.refit(vertices)
        assert other.bounds[1, 1] == 1 and mesh.bounds[1, 1] > 5e6
    beyond_single = octray.Mesh(vertices * [0, 1, 1] + [1e39, 0, 0], faces)
    assert pickle.loads(pickle.dumps(beyond_single)).bounds.tolist() == beyond_single.bounds.tolist()
    away = pickle.loads(pickle.dumps(hits))
    assert np.array_equal(away.position, hits.position, equal_nan=True)
    assert np.array_equal(copy.deepcopy(away).t, hits.t)


def test_hits_are_those_of_the_mesh_as_it_was():
    mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    hits = mesh.closest_hit([0.2, 0.2, 5], [0, 0, -1])
    mesh.refit([[0, 0, 1], [1, 0, 1], [0, 1, 1]])
    assert hits.position.tolist() == [[0.2, 0.2, 0]]


def test_a_mesh_from_a_file(tmp_path):
    scenes = pathlib.Path(__file__).parents[2] / "scenes"
    mesh = octray.Mesh.from_file(scenes / "meshes/gear.stl", threads=1)
    assert mesh.contains([0, 0, 100]).tolist() == [False]
    with pytest.raises(FileNotFoundError, match="missing.obj"):
        octray.Mesh.from_file(tmp_path / "missing.obj")
    with pytest.raises(ValueError, match="no triangles, only 240"):
        octray.Mesh.from_file(scenes / "meshes/helix.ply")
    with pytest.raises(ValueError, match="expected a mesh"):
        octray.Mesh.from_file(scenes / "reflections.scn")
    with pytest.raises(ValueError, match="path"):
        octray.Mesh.from_file(5)
    (tmp_path / "faulty.off").write_text("OFF\n1 1 0\n0 0 0\n3 0 1 2\n")
    with pytest.raises(ValueError, match="faulty.off:4"):
        octray.Mesh.from_file(tmp_path / "faulty.off")
    (tmp_path / "bare.obj").write_text("mtllib no.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.warns(UserWarning, match="no.mtl"):
        octray.Mesh.from_file(os.fsencode(tmp_path / "bare.obj"))


def test_files_in_map_coordinates(tmp_path):
    corners = [[500000.001, 4000000, 9], [500001.001, 4000000, 9], [500000.001, 4000001, 9.5]]
    lines = [f"v {x} {y} {z}\n" for x, y, z in corners]
    (tmp_path / "map.obj").write_text("".join(lines) + "f 1 2 3\n")
    mesh = octray.Mesh.from_file(tmp_path / "map.obj")
    assert np.abs(mesh.vertices - corners).max() < 1e-6


def test_arrays_that_are_not_contiguous(ball):
    vertices, faces = sphere()
    wide = np.zeros((len(vertices), 6))
    wide[:, ::2] = vertices
    mesh = octray.Mesh(wide[:, ::2], np.asfortranarray(faces.astype(np.uint8 if len(vertices) < 256 else np.uint16)))
    directions = np.random.default_rng(5).normal(size=(100, 3))
    expected = ball[0].closest_hit(np.zeros((100, 3)), directions).t
    assert np.array_equal(mesh.closest_hit(np.zeros((200, 3))[::2], directions[::-1][::-1]).t, expected)


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0, 0]], [[0, 0, 0]], r"shape \(1, 2\)"),
        ([[0, 0, 0]], [[0, 0, 1]], "vertex index 1, but there are only 1"),
        ([[0, 0, 0]], [[0, 0, -1]], "vertex index -1"),
        ([[0, 0, 0]], [[0.0, 0.0, 0.0]], "integers"),
        ([[0, 0, np.nan]], [], "vertex 0 has the coordinate NaN"),
        ([["a", "b", "c"]], [], "numbers"),
        ([[0, 0, 1j]], [], "numbers"),
        ([[0, 0, 0], [1, 2]], [], "different lengths"),
        (None, [], "numbers"),
        ([[1e300, 0, 0], [0, 0, 0]], [], "1e9"),
    ],
)
def test_wrong_meshes(vertices, faces, message):
    with pytest.raises(ValueError, match=message):
        octray.Mesh(vertices, faces)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[0, 0, 0]] * 2, [[1, 0, 0]] * 3), "as many of each"),
        (([0, 0], [[1, 0, 0]]), "shape"),
        (([[0, 0, 0]], [[[1, 0, 0]]]), "shape"),
        (([[0, 0, 0]], [["x", "y", "z"]]), "numbers"),
    ],
)
def test_wrong_rays(ball, arguments, message):
    for query in (ball[0].closest_hit, ball[0].occluded, ball[0].all_hits):
        with pytest.raises(ValueError, match=message):
            query(*arguments)


def test_wrong_options(ball):
    mesh, ray = ball[0], ([[0, 0, 0]], [[1, 0, 0]])
    for options in ({"t_min": -1}, {"t_min": np.nan}, {"t_max": [1, 2]}, {"t_max": "far"}):
        with pytest.raises(ValueError, match="t_m"):
            mesh.closest_hit(*ray, **options)
    for limit in (-1, 1.5, "all", True):
        with pytest.raises(ValueError, match="max_hits"):
            mesh.all_hits(*ray, max_hits=limit)
    for threads in (0, -3, 10**9, 2.5):
        with pytest.raises(ValueError, match="threads"):
            octray.Mesh(*sphere(), threads=threads)


def test_ends_are_those_of_exact_numbers():
    mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    ray = ([[0.25, 0.25, 3.0]], [[0, 0, -2]])
    assert mesh.closest_hit(*ray).t == 1.5
    for nearer, farther in ((1.5 - 1e-9, 1.5 + 1e-9), ([1.5 - 1e-9], np.array([1.5 + 1e-9]))):
        assert mesh.occluded(*ray, t_min=nearer) and mesh.occluded(*ray, t_max=farther)
        assert not mesh.occluded(*ray, t_min=farther) and not mesh.occluded(*ray, t_max=nearer)
    assert not mesh.occluded(*ray, t_min=1.5) and not mesh.occluded(*ray, t_max=1.5)
    assert mesh.occluded(*ray, t_max=1e300) and not mesh.occluded(*ray, t_min=1e300)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert mesh.occluded(*ray, t_max=np.array([5.0]))


def test_ends_above_all_numbers(ball):
    mesh, ray = ball[0], ([[-3.0, 0.01, 0.02]] * 2, [[2.0, 0.0, 0.0]] * 2)
    for far in (10**30, 10**400, [10**30, 10**400], (10**30, 5.0)):
        assert mesh.occluded(*ray, t_max=far).all() and not mesh.occluded(*ray, t_min=far).any()
    with pytest.raises(ValueError, match="at least 0"):
        mesh.occluded(*ray, t_min=-(10**400))
    with pytest.raises(ValueError, match="t_max"):
        mesh.occluded(*ray, t_max=[True, 10**30])


def test_masked_items_are_refused(ball):
    mesh, vertices, faces = ball
    masked = np.ma.masked_array(vertices[:3], mask=np.eye(3, dtype=bool))
    for ask in (mesh.closest_point, mesh.refit, mesh.contains, lambda points: mesh.occluded(points, points)):
        with pytest.raises(ValueError, match="3 masked items"):
            ask(masked)
    with pytest.raises(ValueError, match="faces.*1 masked items"):
        octray.Mesh(vertices, np.ma.masked_equal(faces[:1], faces[0, 1]))
    with pytest.raises(ValueError, match="t_max.*masked"):
        mesh.occluded(vertices[:2], vertices[:2], t_max=np.ma.masked_array([1.0, 2.0], mask=[True, False]))
    # Without masked items it is an array like any other.
    assert len(mesh.closest_point(np.ma.masked_array(vertices[:3]))[1]) == 3


def test_limits_above_all_numbers(ball):
    mesh = ball[0]
    origins, directions = np.full((3, 3), 3.0), -np.ones((3, 3))
    for limit in (2**64, 10**30, np.int64(7), 7.0):
        assert len(mesh.all_hits(origins, directions, max_hits=limit)[0]) >= 3


def test_arrays_that_are_not_aligned():
    points = np.arange(30, dtype=np.float32).reshape(-1, 3) ** 2 % 7
    askew = np.frombuffer(b"\0" + points.tobytes(), "f4", offset=1).reshape(-1, 3)
    swapped = points.astype(">f8")
    mesh = octray.Mesh(askew, [[0, 1, 5]])
    expected = mesh.closest_point(points)[1]
    for array in (askew, swapped):
        assert np.array_equal(mesh.closest_point(array)[1], expected)
    assert np.array_equal(octray.Mesh(swapped, np.array([[0, 1, 5]], dtype=">i2")).bounds, mesh.bounds)


def test_meshes_are_moved_one_after_the_other():
    vertices = np.random.default_rng(10).uniform(-1, 1, (150_000, 3))
    mesh = octray.Mesh(vertices, np.arange(150_000).reshape(-1, 3), threads=2)
    threads = [threading.Thread(target=lambda: [mesh.refit(vertices) for _ in range(4)], daemon=True) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60)
        assert not thread.is_alive(), "two moves wait for each other"


def test_a_mesh_that_is_moved_away_is_a_new_one():
    vertices, faces = sphere()
    mesh = octray.Mesh(vertices, faces)
    for moved in (vertices * 0.01 + 1e6, vertices + 1e10):
        mesh.refit(moved)
        assert np.array_equal(mesh.bounds, octray.Mesh(moved, faces).bounds)
        assert mesh.contains(moved.mean(axis=0)).all()


def test_nothing():
    mesh = octray.Mesh([], [])
    assert not mesh.closest_hit([[0, 0, 0]], [[1, 0, 0]]).hit.any() and mesh.bounds is None
    ball = octray.Mesh(*sphere())
    assert len(ball.closest_hit(np.zeros((0, 3)), np.zeros((0, 3)))) == 0
    assert [len(part) for part in ball.all_hits([], [])] == [0, 0, 0]
    assert ball.contains([]).shape == (0,)


def test_threads_ask_at_once(ball):
    mesh, vertices, faces = ball
    directions = np.random.default_rng(6).normal(size=(50_000, 3))
    expected = mesh.closest_hit([0, 0, 0], directions).t
    moving, failures = octray.Mesh(vertices, faces, threads=2), []

    def ask():
        for _ in range(5):
            t = moving.closest_hit([0, 0, 0], directions).t
            doubled = np.allclose(t, expected * 2, rtol=1e-5)
            if not np.array_equal(t, expected) and not doubled:
                failures.append(t)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for factor in (2, 1, 2, 1):
        moving.refit(vertices * factor)
    for thread in threads:
        thread.join()
    assert not failures


def test_a_forked_process_has_threads_of_its_own(ball):
    if not hasattr(os, "fork"):
        pytest.skip("this system does not fork")
    mesh = ball[0]
    directions = np.random.default_rng(7).normal(size=(30_000, 3))
    mesh.closest_hit([0, 0, 0], directions)
    child = os.fork()
    if child == 0:
        os._exit(0 if mesh.closest_hit([0, 0, 0], directions).hit.all() else 1)
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            assert status == 0
            return
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    pytest.fail("the child hangs")


def test_ctrl_c_ends_long_calls(tmp_path):
    code = (
        "import numpy as np, octray, os, signal, threading, time\n"
        "n = np.random.default_rng(0).uniform(-1, 1, (300_000, 3))\n"
        "mesh = octray.Mesh(n, np.arange(300_000).reshape(-1, 3), threads=1)\n"
        "d = np.random.default_rng(1).normal(size=(400_000, 3))\n"
        # Where SIGINT is ignored, as behind a shell's &, Python does not catch it by itself.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "start = time.monotonic()\n"
        "try:\n"
        "    while True: mesh.all_hits(d * 0.1, d)\n"
        "except KeyboardInterrupt:\n"
        "    print('ended')\n"
    )
    # Elsewhere than in python/, where octray/ is the package's source.
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.stdout == "ended\n", done


def test_ctrl_c_ends_calls_with_few_points(tmp_path):
    code = (
        "import numpy as np, octray, os, signal, threading, time\n"
        # From the middle of a ball all triangles are equally near.
        "corners = np.random.default_rng(0).normal(size=(200_000, 1, 3))\n"
        "corners = corners + np.random.default_rng(1).normal(size=(200_000, 3, 3)) * 3e-4\n"
        "corners /= np.linalg.norm(corners, axis=2, keepdims=True)\n"
        "mesh = octray.Mesh(corners.reshape(-1, 3), np.arange(600_000).reshape(-1, 3), threads=1)\n"
        "def seconds(points):\n"
        "    start = time.monotonic()\n"
        "    try: mesh.closest_point(np.zeros((points, 3)))\n"
        "    except KeyboardInterrupt: print('interrupted')\n"
        "    return time.monotonic() - start\n"
        "little = seconds(25)\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "threading.Timer(little, lambda: os.kill(os.getpid(), signal.SIGINT)).start()\n"
        "print(seconds(2500) < 30 * little)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.stdout == "interrupted\nTrue\n", done


@pytest.mark.skipif(sys.platform != "linux", reason="address space is limited as on Linux")
def test_memory_that_runs_out_is_an_error(tmp_path):
    code = (
        "import numpy as np, octray, resource\n"
        "mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], threads=1)\n"
        "mesh.closest_hit([0, 0, 1], [[0, 0, -1]])\n"
        "rays = np.full((4_000_000, 3), [0, 0, 1], np.float32)\n"
        "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        "calls = (mesh.closest_point, mesh.closest_hit, mesh.all_hits, mesh.occluded)\n"
        "resource.setrlimit(resource.RLIMIT_AS, (used + 30_000_000, -1))\n"
        "for call in calls:\n"
        "    try: call(rays) if call == mesh.closest_point else call([0.1, 0.1, -1], rays)\n"
        "    except MemoryError as error: print(call.__name__)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert done.returncode == 0 and done.stdout.split() == ["closest_point", "closest_hit", "all_hits"], done


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers")
def test_a_refit_in_a_signal_handler_does_not_wait_for_itself(tmp_path):
    code = (
        "import faulthandler, numpy as np, octray, signal\n"
        "faulthandler.dump_traceback_later(50, exit=True)\n"
        "vertices = np.random.default_rng(0).uniform(-1, 1, (600_000, 3))\n"
        "mesh = octray.Mesh(vertices, np.arange(600_000).reshape(-1, 3), threads=1)\n"
        "def handler(*_):\n"
        "    try: mesh.refit(vertices)\n"
        "    except RuntimeError as error: caught.append(error)\n"
        "    signal.setitimer(signal.ITIMER_REAL, 0.001)\n"
        "caught = []\n"
        "signal.signal(signal.SIGALRM, handler)\n"
        "signal.setitimer(signal.ITIMER_REAL, 0.001)\n"
        "while not caught: mesh.refit(vertices * 2)\n"
        "signal.setitimer(signal.ITIMER_REAL, 0)\n"
        "mesh.refit(vertices * 3)\n"
        "print(caught[0])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, cwd=tmp_path)
    assert "already moving" in done.stdout and done.returncode == 0, done
