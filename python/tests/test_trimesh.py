"""The adapter for trimesh."""

import pickle

import numpy as np
import pytest

import octray


def adapter():
    """trimesh, and the class under test."""
    trimesh = pytest.importorskip("trimesh")
    import octray.trimesh

    return trimesh, octray.trimesh.RayMeshIntersector


def test_trimesh():
    trimesh = pytest.importorskip("trimesh")
    import octray.trimesh

    mesh = trimesh.creation.icosphere(subdivisions=3)
    rays = octray.trimesh.RayMeshIntersector(mesh)
    origins = np.random.default_rng(8).uniform(-2, 2, (200, 3))
    directions = np.random.default_rng(9).normal(size=(200, 3))
    locations, index_ray, index_tri = rays.intersects_location(origins, directions)
    assert locations.shape == (len(index_ray), 3) and index_tri.dtype == np.int64
    planes = np.einsum("ij,ij->i", locations - mesh.triangles[index_tri][:, 0], mesh.face_normals[index_tri])
    assert np.abs(planes).max() < 1e-6
    first = rays.intersects_first(origins, directions)
    assert np.array_equal(first != -1, rays.intersects_any(origins, directions))
    radius = np.linalg.norm(origins, axis=1)
    inside = rays.contains_points(origins)
    assert inside[radius < 0.98].all() and not inside[radius > 1].any()
    assert pickle.loads(pickle.dumps(rays)).intersects_first(origins, directions).tolist() == first.tolist()
    with pytest.raises(ValueError, match="mesh of trimesh"):
        octray.trimesh.RayMeshIntersector(octray.Mesh(mesh.vertices, mesh.faces))
    mesh.apply_scale(2)
    assert np.allclose(np.abs(rays.intersects_location([[0, 0, 0]], [[0, 0, 1]])[0]).max(), 2, atol=0.05)


def test_trimesh_tells_one_triangle_at_an_edge():
    trimesh = pytest.importorskip("trimesh")
    import octray.trimesh

    cylinder = trimesh.creation.cylinder(radius=1.0, height=4.0, sections=32)
    side = np.linspace(-0.6, 0.6, 16)
    origins = np.array([[x, y, -5.0] for x in side for y in side])
    directions = np.tile([[0.0, 0.0, 1.0]], (len(origins), 1))
    _, ray = octray.trimesh.RayMeshIntersector(cylinder).intersects_id(origins, directions)
    assert (np.bincount(ray) == 2).all()
    every = octray.trimesh.RayMeshIntersector(cylinder, every_triangle=True)
    assert np.bincount(every.intersects_id(origins, directions)[1]).max() == 4
    # Through a corner of a box from inside, along an edge, and in the plane of a face.
    box = octray.trimesh.RayMeshIntersector(trimesh.creation.box())
    corners = box.mesh.vertices
    assert (np.bincount(box.intersects_id(np.zeros_like(corners), corners)[1]) == 1).all()
    flat = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 3, 0], [0, 3, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    locations, _, _ = octray.trimesh.RayMeshIntersector(flat).intersects_location([[-5, 1, 0]], [[1, 0, 0]])
    assert locations.shape == (0, 3)


def test_trimesh_keeps_both_sides_of_thin_sheets():
    trimesh, rays_of = adapter()
    sheet = trimesh.creation.box(extents=(1, 1, 0.01))
    for _ in range(6):
        sheet = sheet.subdivide()
    rays = rays_of(sheet)
    origins = np.random.default_rng(0).normal(size=(2000, 3)) * [1e3, 1e3, 0] + [0, 0, 1e4]
    at = np.random.default_rng(1).uniform(-0.45, 0.45, (2000, 3)) * [1, 1, 0]
    assert (np.bincount(rays.intersects_id(origins, at - origins)[1], minlength=2000) == 2).all()
    # Also at vertices, where the ray touches up to six triangles on each side.
    at = np.random.default_rng(2).integers(-30, 31, (2000, 3)) / 64 * [1, 1, 0]
    for height in (1e4, 1.0):
        origins = at + [0, 0, height]
        triangle, ray = rays.intersects_id(origins, at - origins)
        assert (np.bincount(ray, minlength=2000) == 2).all()
    # Each is the lowest of those that are touched.
    every = rays_of(sheet, every_triangle=True)
    touched, of_ray = every.intersects_id(origins, at - origins)
    is_top = sheet.face_normals[touched][:, 2] > 0
    lowest = np.full(2000, len(sheet.faces))
    np.minimum.at(lowest, of_ray[is_top], touched[is_top])
    assert np.array_equal(triangle[::2], lowest) and len(touched) > 8000


def test_trimesh_counts_hits_after_duplicates():
    trimesh, rays_of = adapter()
    box = rays_of(trimesh.creation.box())
    triangles, ray, places = box.intersects_id([[0, 0, 5]], [[0, 0, -1]], max_hits=2, return_locations=True)
    assert ray.tolist() == [0, 0] and places[:, 2].tolist() == [0.5, -0.5]
    ball = trimesh.creation.icosphere()
    for vertex in ball.vertices[:12]:
        for limit in (0, 1, 2, 7):
            found = rays_of(ball).intersects_id([vertex * 3], [-vertex], max_hits=limit)[0]
            assert len(found) == min(limit, 2)
    # The same as without a limit, cut off: rays through vertices, edges and insides.
    random = np.random.default_rng(4)
    origins = random.integers(-4, 5, (500, 3)) / 2.0
    directions = random.integers(-4, 5, (500, 3)) / 8 + 1e-9 * (random.random((500, 3)) < 0.1)
    engine = rays_of(trimesh.creation.box().subdivide().subdivide())
    triangles, ray = engine.intersects_id(origins, directions)
    order = np.arange(len(ray)) - np.searchsorted(ray, ray)
    for limit in (1, 2, 3):
        some, of_ray = engine.intersects_id(origins, directions, max_hits=limit)
        assert np.array_equal(some, triangles[order < limit]) and np.array_equal(of_ray, ray[order < limit])


def test_trimesh_tells_one_triangle_where_surfaces_meet():
    trimesh, rays_of = adapter()
    down = [[0.0, 0.0, -1.0]]

    def found(mesh, at):
        return len(rays_of(mesh).intersects_id([[*at, 5.0]], down)[0])

    # A T-junction: two triangles above an edge, one below.
    junction = [[0, 0, 0], [2, 0, 0], [1, -1, 0], [1, 0, 0], [1, 1, 0]]
    assert found(trimesh.Trimesh(junction, [[0, 2, 1], [0, 3, 4], [3, 1, 4]], process=False), (1, 0)) == 1
    # The edge of an open sheet, and a ridge that the ray only touches.
    assert found(trimesh.Trimesh(junction, [[0, 1, 4]], process=False), (1, 0)) == 1
    tent = [[-1, 0, 0], [-1, 1, 0], [0, 0, 1], [0, 1, 1], [-2, 0, -3], [-2, 1, -3]]
    ridge = trimesh.Trimesh(tent, [[0, 2, 3], [0, 3, 1], [4, 3, 2], [4, 5, 3]], process=False)
    assert found(ridge, (0, 0.5)) == 1
    # One box on another: the face between them is there twice, at its diagonal too.
    boxes = trimesh.creation.box() + trimesh.creation.box().apply_translation([0, 0, 1])
    assert found(boxes, (0, 0)) == found(boxes, (0.25, 0.1)) == 4
    # Each triangle twice.
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]] * 2, process=False)
    assert found(square, (0.5, 0.5)) == found(square, (0.75, 0.25)) == 2


def test_trimesh_hits_are_those_of_float64_rays():
    trimesh = pytest.importorskip("trimesh")
    import octray.trimesh

    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
    random = np.random.default_rng(3)
    at = np.repeat(random.uniform(0.1, 0.9, (500, 1)), 3, axis=1) * [1, 1, 0]
    above = random.random(500) < 0.5
    at[:, 1] += np.where(above, 1e-12, -1e-12)
    origins = random.uniform(-1, 2, (500, 3)) + [0, 0, 3]
    triangle, ray = octray.trimesh.RayMeshIntersector(square).intersects_id(origins, at - origins)
    assert (ray == np.arange(500)).all() and (triangle == above).all()


def test_trimesh_makes_its_primitives_with_it(monkeypatch):
    trimesh = pytest.importorskip("trimesh")
    import octray.trimesh

    # As trimesh does: before the mesh has vertices.
    engine = type("ray_pyembree", (), {"RayMeshIntersector": octray.trimesh.RayMeshIntersector})
    monkeypatch.setattr(trimesh.ray, "has_embree", True)
    monkeypatch.setattr(trimesh.ray, "ray_pyembree", engine, raising=False)
    for mesh in (trimesh.primitives.Sphere(), trimesh.primitives.Box(), trimesh.Trimesh()):
        assert isinstance(mesh.ray, octray.trimesh.RayMeshIntersector)
    assert trimesh.primitives.Box().ray.contains_points([[0, 0, 0]]).all()


def test_trimesh_rays_that_start_on_the_surface_hit_it():
    trimesh = pytest.importorskip("trimesh")
    import octray.trimesh

    box = trimesh.creation.box().subdivide().subdivide()
    rays = octray.trimesh.RayMeshIntersector(box)
    top, down = [[0.0, 0.0, 0.5]], [[0.0, 0.0, -1.0]]
    _, _, locations = rays.intersects_id(top, down, return_locations=True)
    assert locations.tolist() == [[0, 0, 0.5], [0, 0, -0.5]]
    assert rays.intersects_id(top, down, max_hits=1)[0] == rays.intersects_first(top, down)
    # Many, from triangles, edges and vertices, outwards: the surface is all that they hit.
    weights = np.repeat([[4, 2, 2], [4, 4, 0], [8, 0, 0]], len(box.faces), axis=0) / 8
    origins = np.einsum("ij,ijk->ik", weights, np.tile(box.triangles, (3, 1, 1)))
    outwards = np.tile(box.face_normals, (3, 1)) + [0.01, 0.02, 0.03]
    first = rays.intersects_first(origins, outwards)
    assert np.array_equal(np.einsum("ij,ij->i", box.triangles[first][:, 0] - origins, box.face_normals[first]), first * 0.0)
    assert rays.intersects_any(origins, outwards).all()
    _, index_ray, locations = rays.intersects_id(origins, outwards, return_locations=True)
    assert np.array_equal(np.unique(index_ray), np.arange(len(origins)))
    # From a vertex a ray may leave through another face.
    assert np.allclose(locations[np.unique(index_ray, return_index=True)[1]], origins)
    for direction in ([np.nan, 0, 1], [0, 0, 0]):
        assert rays.intersects_id(top, [direction])[0].size == 0
    assert not rays.intersects_any(np.array(top) + [0, 0, 1e-6], -np.array(down)).any()


def test_trimesh_tells_the_lowest_triangle_of_a_single_hit():
    trimesh, rays_of = adapter()
    random = np.random.default_rng(5)
    # Two triangles on both sides of an edge, and a ray through its middle.
    for _ in range(300):
        corners = random.integers(-3, 4, (4, 3)).astype(float)
        direction = random.integers(-3, 4, 3) + [0.0, 0.0, 0.125]
        origin = (corners[0] + corners[1]) / 2 - direction
        pair = trimesh.Trimesh(corners, [[0, 1, 2], [1, 0, 3]], process=False)
        touched, _ = rays_of(pair, every_triangle=True).intersects_id([origin], [direction])
        for engine in (rays_of(pair), rays_of(pair, every_triangle=True)):
            single, _ = engine.intersects_id([origin], [direction], multiple_hits=False)
            assert single.tolist() == sorted(touched)[:1]


def test_trimesh_rays_in_the_plane_they_start_on_miss_it():
    trimesh, rays_of = adapter()
    rays = rays_of(trimesh.Trimesh([[0, 0, 0], [4, -4, 0], [4, 0, -4]], [[0, 1, 2]], process=False))
    for direction in ([1, -1, 0], [1, 1, -2], [1, 2, -3], [3, -1, -2], [-2e9, -4e9, 6e9]):
        assert not rays.intersects_any([[2, -1, -1]], [direction]).any()
        assert rays.intersects_id([[2, -1, -1]], [direction])[0].size == 0
    # Not parallel, though its rounding is.
    triangle, _, locations = rays.intersects_id([[2, -1, -1]], [[1, -0.999999999, 0]], return_locations=True)
    assert triangle.tolist() == [0] and locations.tolist() == [[2, -1, -1]]


def test_trimesh_flags_are_true_or_false():
    trimesh, rays_of = adapter()
    box, ray = trimesh.creation.box(), ([[0, 0, 5]], [[0, 0, -1]])
    with pytest.raises(ValueError, match="every_triangle: expected True or False, found 'no'"):
        rays_of(box, every_triangle="no")
    for flag in ("multiple_hits", "return_locations"):
        with pytest.raises(ValueError, match=f"{flag}: expected True or False, found 2"):
            rays_of(box).intersects_id(*ray, **{flag: 2})
    with pytest.raises(ValueError, match="multiple_hits"):
        rays_of(box).intersects_location(*ray, multiple_hits=None)
    with pytest.raises(ValueError, match="crossings: expected True or False, found 'false'"):
        octray.Mesh(box.vertices, box.faces).all_hits(*ray, crossings="false")
