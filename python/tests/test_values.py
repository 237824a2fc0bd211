"""Numbers as colours from Python: the program's bytes, and wrong values."""

import pathlib

import numpy as np
import pytest

import octray

SCENES = pathlib.Path(__file__).parents[2] / "scenes"
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [9, 9, 9]], float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def ply(path, of_vertices=None, of_faces=None):
    """Write a text PLY file whose vertices or faces have a property `q`."""

    def lines(rows, values):
        ends = [""] * len(rows) if values is None else [repr(float(value)) for value in values]
        return "".join(f"{' '.join(map(str, row))} {end}\n" for row, end in zip(rows, ends, strict=True))

    def q(values):
        return "" if values is None else "property double q\n"

    path.write_text(
        f"ply\nformat ascii 1.0\ncomment up z\nelement vertex {len(CORNERS)}\n"
        f"property float x\nproperty float y\nproperty float z\n{q(of_vertices)}"
        f"element face {len(FACES)}\nproperty list uchar int vertex_indices\n{q(of_faces)}end_header\n"
        + lines(CORNERS, of_vertices)
        + lines([[3, *face] for face in FACES], of_faces)
    )


@pytest.mark.parametrize("style", ["studio", "clay", "plain"])
@pytest.mark.parametrize(
    ("owner", "values"),
    [
        ("of_vertices", [0.5, np.nan, 2, 1e300, 7]),
        ("of_vertices", [1, 2, 3, 4, 100]),
        ("of_faces", [4, 1, 2, np.inf]),
    ],
)
def test_values_make_the_bytes_of_a_ply_file(tmp_path, style, owner, values):
    path = tmp_path / "a.ply"
    ply(path, **{owner: values})
    mesh = octray.Mesh(CORNERS, FACES)
    for options in ({}, {"color_map": "turbo"}, {"color_range": (3, 1.5)}):
        expected = octray.render(path, (48, 32), style=style, aov="albedo", color_by="q", **options)
        found = octray.render(mesh, (48, 32), style=style, aov="albedo", values=values, **options)
        assert np.array_equal(found["color"], expected["color"])
        assert np.array_equal(found["albedo"], expected["albedo"])


def test_coordinates_are_those_of_the_mesh():
    far = octray.Mesh(CORNERS[:4] + [500000, 4000000, 7], FACES)
    near = octray.Mesh(CORNERS[:4], FACES)
    by = {"size": (48, 32), "style": "plain", "color_by": "x"}
    expected = octray.render(near, **by, color_range=(-1, 3))["color"]
    assert np.array_equal(octray.render(far, **by, color_range=(499999, 500003))["color"], expected)
    assert not np.array_equal(octray.render(near, **by)["color"], expected)


def test_colors_are_those_of_the_map():
    mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    cases = [([3, 3, 3], None, [32, 145, 140]), ([0, 0, 0], (0, 1), [68, 1, 84]), (np.float32([np.nan]), None, [128] * 3)]
    for values, ends, color in cases:
        options = {"values": values, "color_range": ends}
        picture = octray.render(mesh, (8, 8), {"from": "top"}, 1, "albedo", "plain", **options)
        np.testing.assert_allclose(picture["albedo"][4, 4] * 255, color, atol=0.01)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"values": [1, 2, 3]}, r"values: expected numbers of shape \(5,\) for vertices or \(4,\) for faces, found shape \(3,\)"),
        ({"values": np.ones((5, 1))}, "values: expected numbers"),
        ({"values": ["a"] * 5}, "values: expected numbers"),
        ({"values": 3.0}, "values: expected numbers"),
        ({"values": [True] * 5}, "values: expected numbers"),
        ({"values": [1] * 5, "color_by": "z"}, "color_by: expected values or color_by, found more than one"),
        ({"values": [1] * 5, "vertex_colors": np.ones((5, 3))}, "values: expected vertex_colors or values"),
        ({"color_by": "q"}, "color_by: expected x, y or z for a Mesh"),
        ({"color_by": 1}, "color_by: expected a name"),
        ({"color_map": "turbo"}, "color_map: needs values or color_by"),
        ({"color_range": (0, 1)}, "color_range: needs values or color_by"),
        ({"color_by": "z", "color_map": "hot"}, "color_map: expected viridis, magma"),
        ({"color_by": "z", "color_map": 1}, "color_map: expected a name"),
        ({"color_by": "z", "color_range": (1, 1)}, "color_range: expected two different finite numbers"),
        ({"color_by": "z", "color_range": (1, np.nan)}, "color_range: expected two different finite numbers"),
        ({"color_by": "z", "color_range": 1}, "color_range: expected two different finite numbers"),
        ({"color_by": "z", "color_range": "01"}, "color_range: expected two different finite numbers"),
    ],
)
def test_wrong_values(options, message):
    with pytest.raises(ValueError, match=message):
        octray.render(octray.Mesh(CORNERS, FACES), (4, 4), **options)


def test_wrong_names(tmp_path):
    ply(tmp_path / "a.ply", of_faces=[1, 2, 3, 4])
    with pytest.raises(ValueError, match="no scalar property `w`: the file has `q` of faces; x, y and z"):
        octray.render(tmp_path / "a.ply", (4, 4), color_by="w")
    with pytest.raises(ValueError, match="values: expected None for a file"):
        octray.render(tmp_path / "a.ply", (4, 4), values=[1, 2, 3, 4])
    with pytest.raises(ValueError, match="color_by applies to meshes only"):
        octray.render(SCENES / "reflections.scn", (4, 4), color_by="z")


def test_values_of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    from octray.trimesh import render

    mesh = trimesh.Trimesh(CORNERS[:4], FACES, face_colors=[255, 0, 0, 255], process=False)
    values = [1, 2, 3, 5]
    expected = octray.render(octray.Mesh(CORNERS[:4], FACES), (16, 16), values=values)["color"]
    assert np.array_equal(render(mesh, size=(16, 16), values=values)["color"], expected)
    textured = trimesh.Trimesh(CORNERS[:4], FACES, process=False)
    textured.visual = trimesh.visual.TextureVisuals(uv=np.zeros((4, 2)))
    assert np.array_equal(render(textured, size=(16, 16), values=values)["color"], expected)
