"""Pictures from Python: those of the program, and wrong arguments."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest

import octray

SCENES = pathlib.Path(__file__).parents[2] / "scenes"


def test_a_scene_has_the_bytes_of_the_program(tmp_path):
    scene = SCENES / "reflections.scn"
    picture = octray.render(scene, size=(64, 48), samples=4, aov=("depth", "id"))
    assert list(picture) == ["color", "depth", "id"]
    assert picture["color"].shape == (48, 64, 3) and picture["color"].dtype == np.uint8
    assert picture["depth"].shape == picture["id"].shape == (48, 64)
    assert np.array_equal(np.isinf(picture["depth"]), picture["id"] == 2**32 - 1)
    program = pathlib.Path(sys.executable).with_name("octray")
    file = tmp_path / "picture.ppm"
    subprocess.run([program, scene, "-s", "64x48", "--samples", "4", "-o", file], check=True)
    assert file.read_bytes().endswith(picture["color"].tobytes())


@pytest.mark.parametrize(
    ("options", "arguments"),
    [
        ({}, []),
        ({"style": "studio", "samples": "auto:8"}, ["--samples", "auto:8"]),
        ({"style": "clay", "samples": 4}, ["--style", "clay", "--samples", "4"]),
        ({"style": "plain"}, ["--style", "plain"]),
    ],
)
def test_a_mesh_has_the_bytes_of_the_program(tmp_path, options, arguments):
    mesh = SCENES / "meshes" / "vase.obj"
    picture = octray.render(mesh, size=(64, 48), **options)
    program = pathlib.Path(sys.executable).with_name("octray")
    file = tmp_path / "picture.ppm"
    subprocess.run([program, mesh, "-s", "64x48", *arguments, "-o", file], check=True)
    assert file.read_bytes().endswith(picture["color"].tobytes())


def test_a_mesh_is_framed():
    mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    picture = octray.render(mesh, size=(40, 30), aov=["normal", "albedo", "depth"])
    seen = np.isfinite(picture["depth"])
    assert 0.1 < seen.mean() < 0.9
    assert np.allclose(np.linalg.norm(picture["normal"][seen], axis=1), 1, atol=1e-5)
    for side in ("top", (0, 90)):
        below = octray.render(mesh, (9, 9), {"from": side}, aov="normal")["normal"]
        assert below[below.any(axis=-1), 2].min() > 0.5
    middle = np.array([4e5, 5e6, 0])
    moved = octray.Mesh(np.eye(3) + middle, [[0, 1, 2]])
    camera = {"eye": middle + 3, "target": middle, "up": (0, 0, 1), "fov": 30}
    assert np.isfinite(octray.render(moved, (32, 32), camera, aov="depth")["depth"]).any()


def test_cameras():
    scene = SCENES / "reflections.scn"
    first = octray.render(scene, (32, 32))["color"]
    assert np.array_equal(first, octray.render(scene, (32, 32), camera=1)["color"])
    assert not np.array_equal(first, octray.render(str(scene).encode(), (32, 32), camera=np.int64(2))["color"])
    across = octray.render(SCENES / "evening.scn", (32, 32), camera="across the water")["color"]
    assert across.std() > 0


def test_parallel_rays_and_lenses():
    scene = SCENES / "reflections.scn"

    def depth(**camera):
        return octray.render(scene, (32, 32), camera, samples=4, aov="depth")

    wide, narrow = depth(ortho=8), depth(ortho=2)
    assert not np.array_equal(wide["depth"], narrow["depth"])
    sharp, soft = depth(aperture=0), depth(aperture=0.5, focus=1)
    assert np.array_equal(sharp["color"], depth()["color"])
    assert not np.array_equal(sharp["color"], soft["color"])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"size": (0, 3)}, "size"),
        ({"size": 3}, "size"),
        ({"size": (10**6, 1)}, "size"),
        ({"samples": 0}, "samples"),
        ({"samples": 10**12}, "samples: expected at most 1048576, found 1000000000000"),
        ({"samples": 2**70}, "found 1180591620717411303424"),
        ({"samples": 10**9999}, "found a larger one"),
        ({"samples": "1048577"}, "samples: expected at most 1048576, found '1048577'"),
        ({"samples": "auto:99999999"}, "at most 1048576, found 'auto:99999999'"),
        ({"samples": "auto:" + "9" * 9999}, "samples"),
        ({"size": (2**70, 1)}, "at most 65535 pixels a side, found .1180591620717411303424, 1"),
        ({"samples": None}, "samples"),
        ({"samples": "many"}, "samples"),
        ({"samples": "auto:0"}, "samples"),
        ({"style": "glossy"}, "style"),
        ({"style": 1}, "style"),
        ({"style": "studio"}, "meshes"),
        ({"size": (None, 5)}, "size"),
        ({"size": (1, 2, 3)}, "size"),
        ({"aov": None}, "aov"),
        ({"aov": [[]]}, "aov"),
        ({"camera": True}, "viewpoint"),
        ({"camera": {"fov": [30]}}, "a number"),
        ({"camera": {"fov": 10**400}}, "a number"),
        ({"camera": {"fov": "wide"}}, "a number"),
        ({"aov": ["heat"]}, "aov"),
        ({"camera": 7}, "viewpoint"),
        ({"camera": "nobody"}, "no camera"),
        ({"camera": {"eye": (0, 0)}}, "three numbers"),
        ({"camera": {"fov": 40, "ortho": 2}}, "fov or ortho"),
        ({"camera": {"from": "above"}}, "front, right, back"),
        ({"camera": {"from": (0, 91)}}, "-90 to 90"),
        ({"camera": {"from": "top", "eye": (0, 0, 1)}}, "from or eye"),
        ({"camera": {"from": "top"}}, "meshes only"),
        ({"camera": {"ortho": -1}}, "height"),
        ({"camera": {"aperture": -1}}, "aperture"),
        ({"camera": {"focus": 0}}, "focus"),
        ({"camera": {"focus": 1}}, "aperture"),
        ({"camera": {"eye": (0, 0, 1), "target": (0, 0, 0), "up": (0, 0, 1)}}, "\"up\": "),
        ({"camera": {"eyes": (0, 0, 0)}}, "keys"),
        ({"camera": {"eye": (2e9, 0, 0)}}, "at most 1e"),
        ({"camera": {"target": (0, -1e300, 0)}}, "at most 1e"),
        ({"camera": {"eye": (1, 0, 0), "target": (1, 0, 0)}}, "camera|target|view"),
        ({"camera": 1.5}, "camera"),
        ({"camera": {"ortho": "fill"}}, 'a number, or "fit"'),
        ({"camera": {"ortho": "fit", "fov": 3}}, "fov or ortho"),
        ({"camera": {"ortho": "fit"}}, '"ortho": "fit" applies to meshes only'),
        ({"camera": {"ortho": "fit", "eye": (1, 2, 3)}}, 'give a side as "from"'),
        ({"background": "green"}, "background: expected scene, transparent, white, black, or a colour"),
        ({"background": 0}, "background"),
        ({"dtype": "float64"}, "dtype: expected uint8 or float32"),
        ({"dtype": None}, "dtype"),
        ({"dtype": "pixels"}, "dtype"),
        ({"dtype": "float32", "srgb": True}, "srgb"),
        ({"srgb": 1}, "srgb: expected True or False"),
        ({"max_depth": 0}, "max_depth: expected a whole number"),
        ({"max_depth": 1001}, "max_depth: expected a whole number from 1 to 1000, found 1001"),
        ({"max_depth": None}, "max_depth"),
        ({"edges": 0}, "edges: expected True, False, or a width in pixels above 0 and at most 100, found 0"),
        ({"edges": 100.1}, "edges: expected"),
        ({"edges": np.nan}, "edges: expected"),
        ({"edges": "1"}, "edges: expected"),
        ({"edges": None}, "edges: expected"),
        ({"shadows": "no"}, "shadows: expected True or False"),
        ({"frame": 0}, "frame"),
        ({"frame": 1.5}, "frame"),
        ({"frame": 2}, "frame: expected at most 1,"),
        ({"ground": True}, "ground applies to meshes only"),
        ({"ground": 1}, "ground: expected True or False"),
        ({"up_axis": "z"}, "up_axis applies to meshes only"),
        ({"up_axis": "w"}, "up_axis: expected x, y, z, -x, -y or -z, found 'w'"),
        ({"up_axis": ["x"]}, "up_axis"),
        ({"smooth_angle": 30}, "smooth_angle applies to meshes only"),
        ({"smooth_angle": 181}, "smooth_angle: expected degrees from 0 to 180, found 181"),
        ({"smooth_angle": np.nan}, "smooth_angle: expected"),
        ({"smooth_angle": "30"}, "smooth_angle: expected"),
        ({"smooth_angle": True}, "smooth_angle: expected"),
        ({"smooth_angle": [30]}, "smooth_angle: expected"),
        ({"point_size": 0}, "point_size: expected"),
        ({"point_size": 1e-60}, "point_size: expected"),
        ({"point_size": 10**400}, "point_size: expected"),
        ({"point_size": 1}, "point_size applies"),
        ({"lit_from": (1, 2)}, "lit_from: expected"),
        ({"lit_from": (0, 0, 0)}, "lit_from: expected a direction"),
        ({"lit_from": (0, 0, np.nan)}, "lit_from: expected"),
        ({"lit_from": (0, 0, 1)}, "lit_from applies"),
        ({"lit_from": (0, 0, 1), "environment": "a.hdr"}, "lit_from: expected environment or lit_from"),
        ({"environment": 3}, "environment: expected a path"),
        ({"environment": "a.hdr"}, "environment applies"),
        ({"environment_rotate": 3}, "environment_rotate: needs an environment"),
        ({"environment_rotate": np.inf}, "environment_rotate: expected degrees"),
        ({"animation": 1}, "animation applies"),
        ({"animation": 0}, "animation: expected"),
        ({"animation": 1.5}, "animation: expected"),
        ({"animation_time": -1}, "animation_time: expected seconds"),
        ({"animation_time": "1"}, "animation_time: expected seconds"),
    ],
)
def test_wrong_options(options, message):
    with pytest.raises(ValueError, match=message) as caught:
        octray.render(SCENES / "reflections.scn", **options)
    # The program's options are not those of Python.
    assert "--" not in str(caught.value)


def test_vertices_that_no_face_uses_do_not_change_the_framing():
    corners, faces = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 0.5]]), [[0, 2, 1], [0, 1, 3]]
    expected = octray.render(octray.Mesh(corners, faces), (40, 30), aov="id")
    more = np.vstack([[[1000, 0, 0]], corners[:2], [[0, -500, 3]], corners[2:]])
    found = octray.render(octray.Mesh(more, [[1, 4, 2], [1, 2, 5]]), (40, 30), aov="id")
    assert np.array_equal(found["id"], expected["id"]) and np.isin([0, 1], found["id"]).all()
    assert np.array_equal(found["color"], expected["color"])


def test_triangles_without_area_are_told():
    with pytest.warns(UserWarning, match="1 without area"):
        octray.render(octray.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]), (4, 4))


def test_small_meshes_are_framed():
    corners, faces = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, 0.5]]), [[0, 2, 1], [0, 1, 3]]
    seen = [(octray.render(octray.Mesh(corners * size, faces), (40, 30), aov="id")["id"] < 2).sum() for size in (1, 1e-10)]
    assert abs(seen[0] - seen[1]) < 10


def test_a_path_is_no_standard_input(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for path in ("-", b"-", pathlib.Path("-")):
        with pytest.raises(FileNotFoundError, match="-: file not found"):
            octray.render(path)
    (tmp_path / "-").write_bytes((SCENES / "meshes" / "vase.obj").read_bytes())
    with pytest.raises(ValueError, match="-: unknown file type"):
        octray.render("-")


def test_wrong_files(tmp_path):
    with pytest.raises(FileNotFoundError, match="missing"):
        octray.render(tmp_path / "missing.scn")
    with pytest.raises(ValueError, match="source"):
        octray.render(5)
    faulty = tmp_path / "faulty.scn"
    faulty.write_text("sphere 0 0 0\n")
    with pytest.raises(ValueError, match="faulty.scn:1"):
        octray.render(faulty)
    with pytest.raises(ValueError, match="no triangles"):
        octray.render(octray.Mesh([], []), (8, 8))


EYES = [
    {"eye": (1, -3, 2)},
    {"eye": (1, -3, 2), "target": (0, 0, 0.4), "up": (0, 1, 1), "fov": 25},
    {"eye": (1, -3, 2), "target": (0, 0, 0.4), "ortho": 2.5},
    {"from": "top"},
    {"from": (20, 40), "ortho": 1.5},
    {"from": "front", "aperture": 0.1, "focus": 2},
    {"fov": 50},
    None,
    1,
]


@pytest.mark.parametrize("camera", EYES)
@pytest.mark.parametrize("middle", [(0, 0, 0), (4096, 0, -8192), (4e5, 5e6, 100)])
def test_camera_rays_hit_what_pictures_show(camera, middle):
    loaded = octray.Mesh.from_file(SCENES / "meshes" / "vase.obj")
    mesh = octray.Mesh(loaded.vertices + middle, loaded.faces)
    if isinstance(camera, dict):
        moved = {name: camera[name] + np.array(middle) for name in ("eye", "target") if name in camera}
        camera = {**camera, **moved}
    picture = octray.render(mesh, (64, 48), camera, samples=1, aov=("id", "depth"))
    origins, directions = octray.camera_rays(camera, (64, 48), mesh)
    assert origins.dtype == np.float64 and directions.dtype == np.float32
    assert directions.shape == (48 * 64, 3)
    assert origins.shape == (directions.shape if isinstance(camera, dict) and "ortho" in camera else (1, 3))
    hits = mesh.closest_hit(origins, directions)
    shown = picture["id"].ravel().astype(np.int64)
    shown[shown == 2**32 - 1] = -1
    assert np.array_equal(hits.triangle, shown)
    assert camera == 1 or hits.hit.sum() > 100
    assert np.allclose(hits.t, picture["depth"].ravel(), rtol=1e-5)


def test_camera_rays_without_a_mesh():
    mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    for camera in (3, {"eye": (1, 2, 3), "target": (0, 0, 0)}, {"eye": (1, 2, 3), "target": (0, 0, 0), "ortho": 2}):
        for one, other in zip(octray.camera_rays(camera, (7, 5)), octray.camera_rays(camera, (7, 5), mesh)):
            assert np.abs(one - other).max() < 1e-6
    origins, directions = octray.camera_rays({"eye": (1e6, 2, 3.1), "target": (1e6, 0, 3.1)}, (1, 1))
    assert origins.tolist() == [[1e6, 2, 3.1]] and np.allclose(directions, [[0, -1, 0]])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((None, (8, 8)), "mesh: needed"),
        (({"from": "top"}, (8, 8)), "mesh: needed"),
        (({"eye": (1, 2, 3)}, (8, 8)), "mesh: needed"),
        (({"target": (1, 2, 3)}, (8, 8)), "mesh: needed"),
        (("a camera", (8, 8)), "camera: expected a viewpoint"),
        ((7, (8, 8)), "camera: expected"),
        (({"eye": (1, 2, 3), "target": (1, 2, 3)}, (8, 8)), "same point"),
        (({"eye": (1, 2, np.nan), "target": (1, 2, 3)}, (8, 8)), "camera: eye"),
        (({"eye": (1, 2, 3), "target": (1, 2, 4)}, (8, 8)), "up vector"),
        (({"eye": (1, 2, 3), "target": (0, 0, 0), "focus": 2}, (8, 8)), "needs a lens"),
        ((1, (8,)), "size: expected a width"),
        ((1, (0, 8)), "size: expected a whole number"),
        ((1, (8, 65_536)), "size: expected at most"),
        ((1, (8, 8), "bunny.ply"), "mesh: expected a Mesh"),
        ((None, (8, 8), octray.Mesh(np.zeros((0, 3)), np.zeros((0, 3), int))), "no triangles"),
    ],
)
def test_camera_rays_refuse(arguments, message):
    with pytest.raises(ValueError, match=message):
        octray.camera_rays(*arguments)


def test_camera_rays_far_from_zero_need_no_mesh():
    middle = np.array([4e5, 5e6, 100.0])
    mesh = octray.Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) + middle, [[0, 1, 2], [0, 1, 3]])
    camera = {"eye": middle + (1, -3, 2), "target": middle, "ortho": 2}
    for size in [(5, 4), (1, 1)]:
        for found, expected in zip(
            octray.camera_rays(camera, size), octray.camera_rays(camera, size, mesh), strict=True
        ):
            assert np.abs(found - expected).max() < 1e-6
    # A viewpoint is where it is, whatever the mesh.
    for found, expected in zip(octray.camera_rays(3, (5, 4)), octray.camera_rays(3, (5, 4), mesh), strict=True):
        assert np.abs(found - expected).max() < 1e-6
