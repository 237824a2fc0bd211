"""Pictures of trimesh's scenes with materials, and with what a picture cannot show."""

import io
import warnings

import numpy as np
import pytest

import octray

trimesh = pytest.importorskip("trimesh")
image = pytest.importorskip("PIL.Image")
import octray.trimesh  # noqa: E402
from trimesh.visual import TextureVisuals  # noqa: E402
from trimesh.visual.material import MultiMaterial, PBRMaterial, SimpleMaterial  # noqa: E402

NO_ID = 2**32 - 1


def shown(subject, **options):
    """A picture, without warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return octray.trimesh.render(subject, **{"size": (48, 32), "samples": 1, **options})


def square(material, x=0.0):
    """A square that looks to the front."""
    corners = [[x, 0, 0], [x + 1, 0, 0], [x + 1, 0, 1], [x, 0, 1]]
    mesh = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    mesh.visual = TextureVisuals(uv=[[0, 0], [1, 0], [1, 1], [0, 1]], material=material)
    return mesh


def plain(subject, **options):
    camera = {"from": "front", "ortho": "fit"}
    return shown(subject, camera=camera, style="plain", srgb=False, background="transparent", **options)["color"]


def spoiled(mesh, attribute, where, value=np.nan):
    numbers = np.array(getattr(mesh, attribute))
    numbers[where] = value
    setattr(mesh, attribute, numbers)
    return mesh


@pytest.mark.parametrize(
    "values",
    [
        np.zeros(8, dtype=bool),
        np.array(list("abcdefgh")),
        np.array([None] * 8),
        np.arange(8),
        np.zeros((8, 7)),
        np.full(8, np.nan),
    ],
)
def test_attributes_of_vertices_are_left_out(values):
    box = trimesh.creation.box()
    expected = shown(trimesh.Scene([box]))["color"]
    box.vertex_attributes["own"] = values
    assert np.array_equal(shown(trimesh.Scene([box]))["color"], expected)
    path = trimesh.load_path(np.eye(3))
    expected = shown(path)["color"]
    path.vertex_attributes = {"own": values[:3]}
    assert np.array_equal(shown(path)["color"], expected)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e300])
def test_numbers_that_are_not_finite(value):
    box = spoiled(trimesh.creation.box(), "vertices", 3, value)
    cloud = spoiled(trimesh.PointCloud(np.eye(3)), "vertices", 1, value)
    path = spoiled(trimesh.load_path(np.eye(3)), "vertices", 1, value)
    for subject in (box, cloud, path):
        with pytest.raises(ValueError, match="^mesh: vertices: expected finite numbers .*, found (nan|inf|1e.300)"):
            shown(subject)
        with pytest.raises(ValueError, match="^geometry 'thing': vertices: expected finite numbers"):
            shown(trimesh.Scene({"thing": subject}))
    picture = SimpleMaterial(image=image.new("RGB", (4, 4)))
    with pytest.raises(ValueError, match="^geometry 'thing': uv: expected finite numbers"):
        shown(trimesh.Scene({"thing": spoiled_uv(square(picture), value)}))
    scene = trimesh.Scene()
    matrix = np.eye(4)
    matrix[0, 3] = value
    scene.graph.update(frame_to="a", matrix=matrix)
    scene.graph.update(frame_from="a", frame_to="b", matrix=np.eye(4))
    scene.add_geometry(trimesh.creation.box(), node_name="c", parent_node_name="b")
    with pytest.raises(ValueError, match="^graph: transform of node 'a': expected finite numbers"):
        shown(scene)
    with pytest.raises(ValueError, match="^mesh: metallicFactor of its material: expected a finite number"):
        shown(square(PBRMaterial(metallicFactor=np.nan)))


def spoiled_uv(mesh, value):
    mesh.visual.uv[0] = value
    return mesh


def test_numbers_that_are_not_shown_may_be_anything():
    box = trimesh.creation.box()
    expected = shown(trimesh.Scene([box]))["color"]
    stray = trimesh.Trimesh(np.vstack([box.vertices, [[np.nan, np.inf, 1e300]]]), box.faces, process=False)
    scene = trimesh.Scene([stray])
    matrix = np.full((4, 4), np.nan)
    scene.graph.update(frame_to="nothing", matrix=matrix)
    scene.camera_transform = matrix
    for subject in (stray, scene):
        assert np.abs(shown(subject)["color"].astype(int) - expected).max() <= 2
    without = plain(square(SimpleMaterial(diffuse=[255, 0, 0, 255])))
    assert np.array_equal(plain(spoiled_uv(square(SimpleMaterial(diffuse=[255, 0, 0, 255])), np.nan)), without)


def test_empty_parts():
    box, empty = trimesh.creation.box(), trimesh.PointCloud(np.zeros((0, 3)))
    expected = shown(trimesh.Scene([box]))["color"]
    assert np.array_equal(shown(trimesh.Scene([empty, trimesh.Trimesh(), box, trimesh.path.Path3D()]))["color"], expected)
    textured = trimesh.Trimesh()
    textured.visual = TextureVisuals()
    for subject in (empty, trimesh.Scene([empty]), textured, trimesh.path.Path3D(), trimesh.Trimesh(np.eye(3))):
        with pytest.raises(ValueError, match="^mesh: .* has nothing to render$"):
            shown(subject)


def test_materials_of_faces():
    box, which = trimesh.creation.box(), np.arange(12) % 3
    expected = octray.render(octray.Mesh(box.vertices, box.faces), (48, 32), samples=1, aov="id")["id"]
    materials = [
        SimpleMaterial(diffuse=[255, 0, 0, 255]),
        SimpleMaterial(diffuse=[0, 0, 255, 255]),
        PBRMaterial(baseColorFactor=[0, 255, 0, 255], metallicFactor=0.0),
    ]
    box.visual = TextureVisuals(material=MultiMaterial(materials), face_materials=which)
    for subject in (box, trimesh.Scene([box])):
        picture = shown(subject, aov=("id", "albedo", "instance"))
        hit = expected != NO_ID
        colors = np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]])[which[expected[hit]]]
        assert np.array_equal(picture["albedo"][hit], colors) and picture["instance"].max() == 1
        assert subject is not box or np.array_equal(picture["id"], expected)
    for wrong in (None, which[:5], which + 1, which - 1, which * 1.0):
        box.visual.face_materials = wrong
        with pytest.warns(UserWarning, match="left out: materials of mesh: expected face_materials"):
            octray.trimesh.render(box, size=(8, 8), samples=1)


def test_materials_with_equal_hashes_keep_their_colours():
    colors = [[255, 0, 0, 255], [0, 0, 255, 255]]
    squares = [square(SimpleMaterial(diffuse=color, ambient=color), x) for x, color in enumerate(colors)]
    left, right = plain(trimesh.Scene(squares), size=(64, 32))[16, [10, 54]]
    assert left[0] > 200 > 20 > left[2] and right[2] > 200 > 20 > right[0]


def test_alpha_of_simple_materials_is_opacity():
    for alpha in (255, 128, 0):
        assert plain(square(SimpleMaterial(diffuse=[255, 0, 0, alpha])))[16, 24, 3] == alpha
    half = image.new("RGBA", (8, 8), (0, 255, 0, 255))
    half.paste((0, 255, 0, 0), (4, 0, 8, 8))
    picture = plain(square(SimpleMaterial(image=half)))
    assert picture[16, 19, 3] == 255 and picture[16, 28, 3] == 0
    # Without an alpha mode a physical material is opaque, as in glTF.
    for mode, alpha in ((None, 255), ("BLEND", 128)):
        material = PBRMaterial(baseColorFactor=[255, 0, 0, 128], alphaMode=mode)
        assert plain(square(material))[16, 24, 3] == alpha


@pytest.mark.parametrize("mode", ["CMYK", "YCbCr", "HSV", "LAB", "F", "I", "RGBa", "La", "1", "P"])
def test_pictures_of_any_mode(mode):
    shown(square(SimpleMaterial(image=image.new(mode, (4, 4)))))


def test_pictures_of_jpeg_files_and_others():
    def jpeg(mode):
        file = io.BytesIO()
        image.new(mode, (8, 8)).save(file, "JPEG")
        return image.open(file)

    changed = jpeg("RGB")
    changed.putalpha(255)
    for texture in (jpeg("CMYK"), changed):
        shown(square(SimpleMaterial(image=texture)))
    for texture, why in ((np.zeros((4, 4, 3)), "expected a picture of PIL"), (image.new("RGB", (0, 0)), "no pixels")):
        with pytest.warns(UserWarning, match=f"left out: baseColorTexture of mesh: .*{why}"):
            octray.trimesh.render(square(SimpleMaterial(image=texture)), size=(8, 8))


def test_base_frames():
    scene = trimesh.Scene()
    move = trimesh.transformations.translation_matrix
    scene.add_geometry(trimesh.creation.box(), node_name="box", transform=move([0, 0, 3]))
    scene.graph.update(frame_to="other", matrix=move([0, 0, 5]))
    camera = {"eye": (0, -20, 0), "target": (0, 0, 0), "ortho": 8}
    for frame, rows in (("world", [2, 5]), ("other", [22, 25]), ("box", [14, 17])):
        scene.graph.base_frame = frame
        mask = shown(scene, camera=camera, aov="mask")["mask"]
        assert np.nonzero(mask)[0][[0, -1]].tolist() == rows
    scene.graph.base_frame = "none"
    with pytest.raises(ValueError, match="graph: node 'box' is not connected to the base frame 'none'"):
        shown(scene)
