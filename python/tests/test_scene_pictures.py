"""Pictures of scenes of placed meshes: against those of one mesh of all baked instances, and wrong arguments."""

import numpy as np
import pytest

import octray
from test_queries import sphere
from test_scenes import baked, cube, matrices

SIZE = (64, 48)


def placed_meshes(far=0.0):
    """A scene without an order, its meshes, and what it would be as one mesh."""
    random = np.random.default_rng(3)
    arrays = [sphere(12, 16), cube(), (np.eye(3), [[0, 1, 2]])]
    index = np.array([1, 0, 0, 1, 0, 1, 1])
    placed = matrices(random, 7, far)
    scene = octray.Scene([octray.Mesh(*both) for both in arrays], placed, index)
    vertices, faces, instance, triangle = baked(arrays, placed, index)
    # Mirrored instances change their winding, as a picture sees it.
    mirrored = np.linalg.det(placed[:, :3, :3])[instance] < 0
    faces[mirrored] = faces[mirrored][:, ::-1]
    return scene, index, octray.Mesh(vertices, faces), instance, triangle


def nearly(found, expected, most=0.003):
    """Whether pictures are equal but for a few pixels: instances and baked triangles round differently, which shows at edges."""
    different = np.abs(found.astype(float) - expected) > (2 if found.dtype == np.uint8 else 1e-3)
    assert different.reshape(*found.shape[:2], -1).any(axis=2).mean() <= most


@pytest.mark.parametrize("far", [0.0, 3e6])
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"style": "clay", "ground": True, "samples": 4},
        {"style": "plain", "camera": {"from": "top", "ortho": "fit"}},
        {"camera": {"eye": (7, -6, 4), "target": (0, 0, 0), "fov": 40}, "style": "plain"},
        {"up_axis": "-y", "background": "transparent", "samples": "auto:8"},
        {"dtype": np.float32, "lit_from": (0, 0, 1), "shadows": False},
    ],
)
def test_pictures_are_nearly_those_of_the_baked_mesh(options, far):
    scene, _, mesh, instance, triangle = placed_meshes(far)
    camera = options.get("camera")
    if camera and "eye" in camera:
        options = {**options, "camera": {**camera, **{name: np.add(camera[name], far) for name in ("eye", "target")}}}
    aov = ("depth", "normal", "albedo", "id", "instance", "mask")
    found, expected = (octray.render(source, SIZE, aov=aov, **options) for source in (scene, mesh))
    assert list(found) == list(expected)
    for name in ("color", "normal", "albedo", "mask"):
        assert (found[name].shape, found[name].dtype) == (expected[name].shape, expected[name].dtype)
        nearly(found[name], expected[name])
    # The ground is outside of instances.
    assert np.unique(found["instance"]).max() <= 8 and (1 in found["instance"]) == options.get("ground", False)
    both = (found["id"] != 2**32 - 1) & (expected["id"] < len(instance))
    assert np.count_nonzero(both) > 300
    ids = expected["id"][both]
    same = (found["instance"][both] == instance[ids] + 2) & (found["id"][both] == triangle[ids])
    assert np.count_nonzero(~same) < 0.003 * len(ids)
    assert np.allclose(found["depth"][both][same], expected["depth"][both][same], rtol=1e-4)


@pytest.mark.parametrize("far", [0.0, 4e5])
@pytest.mark.parametrize("camera", [None, {"from": "top", "ortho": "fit"}, {"eye": (7, -6, 4), "target": (0, 0, 0)}])
def test_camera_rays_hit_what_pictures_show(camera, far):
    scene, index, *_ = placed_meshes(far)
    if camera and "eye" in camera:
        camera = {name: np.add(value, far) for name, value in camera.items()}
    picture = octray.render(scene, SIZE, camera, 1, ("id", "instance", "depth", "mask"))
    hits = scene.closest_hit(*octray.camera_rays(camera, SIZE, scene))
    # The last bit of a ray may differ.
    shown = picture["instance"].ravel().astype(np.int64) - 2
    same = (shown == np.where(hits.hit, hits.instance, -2)) & (picture["id"].ravel() == hits.triangle.astype(np.uint32))
    assert np.count_nonzero(~same) < 10 and np.count_nonzero(hits.hit) > 200
    assert np.allclose(picture["depth"].ravel()[same], hits.t[same], rtol=1e-5)
    assert np.array_equal(np.unique(index[shown[shown >= 0]]), [0, 1])


def test_map_coordinates_are_sharp():
    """A millimetre of difference at five million metres is seen."""
    bolt, board = octray.Mesh(cube()[0] * 1e-3, cube()[1]), octray.Mesh(cube()[0] * [0.1, 0.1, 1e-3], cube()[1])
    pictures = []
    for middle in (np.zeros(3), np.array([432_100.125, 5_812_345.75, 214.5])):
        placed = np.tile(np.eye(4), (401, 1, 1))
        x, y = np.mgrid[-10:10, -10:10].reshape(2, -1)
        placed[:400, :3, 3] = np.stack([x * 5e-3, y * 5e-3, np.full(400, 2e-3)], axis=1)
        placed[:, :3, 3] += middle
        scene = octray.Scene([bolt, board], placed, [0] * 400 + [1])
        camera = {"eye": middle + (0.05, -0.2, 0.3), "target": middle, "fov": 40}
        pictures.append(octray.render(scene, (256, 192), camera, 4, ("instance", "depth")))
    near, far = pictures
    assert len(np.unique(near["instance"])) > 300
    assert np.count_nonzero(near["instance"] != far["instance"]) < 0.003 * near["instance"].size
    nearly(far["color"], near["color"])
    same = (near["instance"] == far["instance"]) & (near["instance"] > 1)
    assert np.abs(near["depth"][same] - far["depth"][same]).max() < 1e-5


def test_colours_of_each_mesh():
    ball, box = octray.Mesh(*sphere(8, 12)), octray.Mesh(*cube())
    places = np.tile(np.eye(4), (4, 1, 1))
    places[:, 0, 3] = np.arange(4) * 4
    scene = octray.Scene([ball, box, ball], places, [0, 1, 2, 1])
    red = np.tile([1.0, 0, 0], (len(ball.vertices), 1))
    sides = np.tile(np.uint8([0, 255, 0]), (12, 1))
    picture = octray.render(scene, (128, 32), {"from": "front"}, 1, ("albedo", "instance"), vertex_colors=[red, None, None],
                            face_colors=(None, sides, None))  # fmt: skip
    neutral = octray.render(ball, (32, 32), None, 1, "albedo")["albedo"].max(axis=(0, 1))
    for instance, color in enumerate([(1, 0, 0), (0, 1, 0), neutral, (0, 1, 0)]):
        shown = picture["albedo"][picture["instance"] == instance + 2]
        assert len(shown) > 50 and np.allclose(shown, color, atol=1e-6)
    # A mesh alone looks as its scene.
    for colors in ({}, {"vertex_colors": red}, {"face_colors": np.random.default_rng(1).uniform(size=(len(ball.faces), 3))}):
        each = {name: [array] for name, array in colors.items()}
        for style in ("studio", "clay", "plain"):
            found = octray.render(octray.Scene([ball]), SIZE, style=style, **each)["color"]
            nearly(found, octray.render(ball, SIZE, style=style, **colors)["color"])
    smooth = octray.render(octray.Scene([ball]), SIZE, smooth_angle=60)["color"]
    nearly(smooth, octray.render(ball, SIZE, smooth_angle=60)["color"])


def test_empty_meshes_and_meshes_that_are_not_placed():
    nothing, box = octray.Mesh([], []), octray.Mesh(*cube())
    huge = octray.Mesh(cube()[0] * 1e3, cube()[1])
    places = np.tile(np.eye(4), (3, 1, 1))
    scene = octray.Scene([nothing, huge, box], places, [0, 0, 2])
    picture = octray.render(scene, SIZE, aov=("id", "instance"), face_colors=[np.zeros((0, 3)), None, np.ones((12, 3))])
    assert np.unique(picture["instance"]).tolist() == [0, 4]
    nearly(picture["id"], octray.render(box, SIZE, aov="id")["id"])
    # What moves later is elsewhere.
    scene.move(places @ np.diag([2.0, 2, 2, 1]))
    camera = {"eye": (9, 9, 9), "target": (0, 0, 0)}
    larger, smaller = (octray.render(source, SIZE, camera, aov="mask")["mask"].sum() for source in (scene, box))
    assert larger > 2 * smaller


def test_what_a_scene_cannot_have():
    box = octray.Mesh(*cube())
    scene = octray.Scene([box, octray.Mesh(*sphere(6, 8))])
    for empty in (octray.Scene([]), octray.Scene([box], []), octray.Scene([octray.Mesh([], [])])):
        with pytest.raises(ValueError, match="source: .*no triangles to render"):
            octray.render(empty)
        with pytest.raises(ValueError, match="mesh: .*no triangles to look at"):
            octray.camera_rays(None, SIZE, empty)
    black = np.zeros((12, 3))
    for options, why in (
        ({"animation": 1}, "animation: a Scene has no animations"),
        ({"frame": 2}, "frame: meshes have no frames"),
        ({"camera": "front"}, "no camera `front`"),
        ({"vertex_colors": black}, "vertex_colors: expected a list with an array or None for each of 2 meshes, found 12"),
        ({"face_colors": [black]}, "face_colors: expected a list .*found 1"),
        ({"face_colors": 3}, "face_colors: expected a list .*found 3"),
        ({"face_colors": "ab"}, "face_colors: expected a list"),
        ({"values": [black[:, 0]]}, "values: expected None for a Scene, whose meshes take vertex_colors or face_colors"),
        ({"color_by": "z"}, "color_by: expected None for a Scene"),
        ({"face_colors": [black[1:], None]}, r"face_colors of mesh 0: .*shape \(12, 3\), found shape \(11, 3\)"),
        ({"vertex_colors": [None, black]}, "vertex_colors of mesh 1: "),
        ({"vertex_colors": [np.zeros((8, 3)), None], "face_colors": [black, None]}, "face_colors of mesh 0: .*found both"),
        ({"camera": {"eye": (1, 2, 3), "target": (1, 2, 3)}}, "same point"),
    ):
        with pytest.raises(ValueError, match=why):
            octray.render(scene, (8, 8), **options)
    with pytest.raises(ValueError, match="a path, a binary file, a Mesh or a Scene"):
        octray.render(3)
    with pytest.raises(ValueError, match="expected a Mesh or a Scene"):
        octray.camera_rays(None, SIZE, "mesh")


def test_a_warning_names_triangles_without_area():
    flat = octray.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]])
    with pytest.warns(UserWarning, match="scene: .*1 without area"):
        octray.render(octray.Scene([flat]), (4, 4))


def test_a_million_instances_are_shown():
    places = np.tile(np.eye(4), (1_000_000, 1, 1))
    places[:, :2, 3] = np.stack(np.divmod(np.arange(1_000_000), 1000), axis=1) * 3
    scene = octray.Scene([octray.Mesh(*cube())], places)
    picture = octray.render(scene, SIZE, {"from": "top", "ortho": "fit"}, style="plain", aov="instance")
    assert len(np.unique(picture["instance"])) > 500
