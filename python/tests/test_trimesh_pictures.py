"""Pictures of trimesh's meshes, point clouds and scenes."""

import linecache

import numpy as np
import pytest

import octray

trimesh = pytest.importorskip("trimesh")
import octray.trimesh  # noqa: E402


def shown(subject, **options):
    options = {"size": (48, 32), "samples": 4, "camera": {"from": "front", "fov": 30}, **options}
    return octray.trimesh.render(subject, **options)


@pytest.mark.parametrize("kind", ["vertex", "face"])
def test_pictures_of_meshes_are_those_of_their_arrays(kind):
    mesh = trimesh.creation.box((1, 2, 3))
    size = len(mesh.vertices if kind == "vertex" else mesh.faces)
    colors = np.random.default_rng(1).integers(0, 256, (size, 4), dtype=np.uint8)
    colors[:, 3] = 255
    setattr(mesh.visual, f"{kind}_colors", colors)
    found = shown(mesh, aov="id")
    own = octray.Mesh(mesh.vertices, mesh.faces)
    expected = octray.render(own, (48, 32), {"from": "front", "fov": 30}, 4, "id", **{f"{kind}_colors": colors})
    assert np.array_equal(found["color"], expected["color"]) and np.array_equal(found["id"], expected["id"])
    # In a scene it goes through a file, with its colours, and z is up.
    scene = shown(trimesh.Scene([mesh]), aov=("depth", "albedo"))
    assert np.abs(scene["color"].astype(int) - expected["color"]).max() <= 2
    assert len(mesh.vertices) == 8, "the scene's mesh stays as it is"
    colors[0, 3] = 7
    setattr(mesh.visual, f"{kind}_colors", colors)
    for subject in (mesh, trimesh.Scene([mesh])):
        with pytest.warns(UserWarning, match="left out: alpha") as caught:
            again = octray.trimesh.render(subject, size=(48, 32), samples=4, camera={"from": "front", "fov": 30})
        assert [warning.filename for warning in caught] == [__file__]
        assert "octray.trimesh.render(subject" in linecache.getline(__file__, caught[0].lineno)
        assert np.abs(again["color"].astype(int) - expected["color"]).max() <= 2


def test_pictures_of_plain_meshes():
    mesh = trimesh.creation.cone(1, 3)
    expected = octray.render(octray.Mesh(mesh.vertices, mesh.faces), (48, 32), {"from": "front", "fov": 30}, 4)["color"]
    assert np.array_equal(shown(mesh)["color"], expected)
    # What trimesh has computed changes no picture.
    assert len(mesh.vertex_normals) and np.array_equal(shown(mesh)["color"], expected)
    assert np.abs(shown(trimesh.Scene([mesh]))["color"].astype(int) - expected).max() <= 2
    assert not np.array_equal(shown(mesh, smooth_angle=50)["color"], expected)
    assert np.array_equal(shown(trimesh.primitives.Box())["color"], shown(trimesh.primitives.Box().to_mesh())["color"])


def test_pictures_of_scenes_have_instances():
    scene = trimesh.Scene()
    box = trimesh.creation.box()
    scene.add_geometry(box, geom_name="box")
    for at in ([2, 0, 0], [0, 0, 3]):
        scene.add_geometry(box, geom_name="box", transform=trimesh.transformations.translation_matrix(at))
    picture = shown(scene, aov=("depth", "mask"), camera={"eye": (0, -20, 0), "target": (0, 0, 0), "ortho": 8})
    rows, columns = np.nonzero(picture["mask"])
    # From z = 3.5 down to -0.5, and from x = -0.5 to 2.5; the picture is 12 wide and 8 high.
    assert (rows.min(), rows.max()) == (2, 17) and (columns.min(), columns.max()) == (22, 33)
    assert np.allclose(picture["depth"][rows, columns], 19.5)


def test_pictures_of_points_and_materials():
    points = np.random.default_rng(1).normal(size=(300, 3))
    red = shown(trimesh.PointCloud(points, colors=[255, 0, 0, 255]), aov="albedo", point_size=0.3)
    hit = red["albedo"][..., 0] > 0.5
    assert hit.any() and red["albedo"][hit].max(axis=0).tolist() == [1, 0, 0]
    cloud = trimesh.PointCloud(points)
    assert shown(cloud, aov="mask")["mask"].any() and shown(trimesh.Scene([cloud]), aov="mask")["mask"].any()
    with pytest.warns(UserWarning, match="left out: alpha"):
        shown(trimesh.PointCloud(points, colors=[255, 0, 0, 9]))
    path = trimesh.load_path(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 1]]))
    assert shown(path, aov="mask")["mask"].any()
    with pytest.warns(UserWarning, match="points"):
        mixed = shown(trimesh.Scene([trimesh.creation.box(), cloud]), aov="mask")
    assert mixed["mask"].any()
    image = pytest.importorskip("PIL.Image").fromarray(np.full((4, 4, 3), [0, 128, 0], dtype=np.uint8))
    box = trimesh.creation.box()
    linear = ((128 / 255 + 0.055) / 1.055) ** 2.4
    for material in (
        trimesh.visual.material.SimpleMaterial(diffuse=[0, 128, 0, 255]),
        trimesh.visual.material.SimpleMaterial(image=image),
        trimesh.visual.material.PBRMaterial(baseColorTexture=image, metallicFactor=0.0),
    ):
        box.visual = trimesh.visual.TextureVisuals(uv=np.zeros((8, 2)), material=material)
        albedo = shown(box, aov="albedo")["albedo"]
        assert np.allclose(albedo.max(axis=(0, 1)), [0, linear, 0], atol=1e-3), material


def test_pictures_refuse():
    for subject in (octray.Mesh(np.eye(3), [[0, 1, 2]]), 3, "a.ply", None, np.eye(3)):
        with pytest.raises(ValueError, match="mesh: expected a mesh, point cloud or scene of trimesh"):
            octray.trimesh.render(subject)
    for subject in (trimesh.Scene(), trimesh.Trimesh()):
        with pytest.raises(ValueError, match="nothing to render"):
            octray.trimesh.render(subject)
    for name in ("vertex_colors", "source", "colour"):
        with pytest.raises(ValueError, match=f"options: expected names among size, .*, found '{name}'"):
            octray.trimesh.render(trimesh.creation.box(), **{name: 1})
    with pytest.raises(ValueError, match="samples"):
        octray.trimesh.render(trimesh.creation.box(), samples=0)
