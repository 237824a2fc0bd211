"""Colours, options and sources of pictures from Python: the program's bytes, and wrong values."""

import base64
import io
import json
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import octray

SCENES = pathlib.Path(__file__).parents[2] / "scenes"


def ply(path, corners, faces, of_vertices=None, of_faces=None):
    """Write a binary PLY file with float positions."""

    def records(fields, colors):
        array = np.zeros(len(fields[0][2]), dtype=[field[:2] for field in fields] + colored(colors))
        for name, _, values in fields:
            array[name] = values
        if colors is not None:
            array["color"] = colors
        return array.tobytes()

    def colored(colors):
        return [] if colors is None else [("color", colors.dtype, 3)]

    def properties(colors):
        kind = {None: None, np.uint8: "uchar", np.float32: "float"}[None if colors is None else colors.dtype.type]
        return "".join(f"property {kind} {name}\n" for name in ("red", "green", "blue") if kind)

    path.write_bytes(
        f"ply\nformat binary_little_endian 1.0\ncomment up z\nelement vertex {len(corners)}\n"
        f"property float x\nproperty float y\nproperty float z\n{properties(of_vertices)}"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\n{properties(of_faces)}end_header\n".encode()
        + records([("at", "3<f4", corners)], of_vertices)
        + records([("count", "u1", np.full(len(faces), 3)), ("corners", "3<i4", faces)], of_faces)
    )


@pytest.mark.parametrize("style", ["studio", "clay", "plain"])
@pytest.mark.parametrize("kind", ["vertex", "face"])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_colors_make_the_bytes_of_a_ply_file(tmp_path, style, kind, dtype):
    loaded = octray.Mesh.from_file(SCENES / "meshes" / "vase.obj")
    # Some vertices that no face uses.
    corners = np.vstack([[[99, 0, 0]], loaded.vertices[:40], [[0, 99, 0]], loaded.vertices[40:]])
    faces = loaded.faces + 1 + (loaded.faces >= 40)
    count = len(corners) if kind == "vertex" else len(faces)
    colors = np.random.default_rng(1).random((count, 3)).astype(np.float32)
    colors = (colors * 255).astype(np.uint8) if dtype == np.uint8 else colors
    ply(tmp_path / "a.ply", corners, faces, **{f"of_{'vertices' if kind == 'vertex' else 'faces'}": colors})
    expected = octray.render(tmp_path / "a.ply", (64, 48), style=style, aov="albedo")
    mesh = octray.Mesh(corners, faces)
    found = octray.render(mesh, (64, 48), style=style, aov="albedo", **{f"{kind}_colors": colors})
    assert np.array_equal(found["color"], expected["color"])
    assert np.array_equal(found["albedo"], expected["albedo"])
    opaque = np.hstack([colors, np.full((count, 1), 255 if dtype == np.uint8 else 1, dtype)])
    again = octray.render(mesh, (64, 48), style=style, **{f"{kind}_colors": opaque})
    assert np.array_equal(again["color"], expected["color"])
    plain = octray.render(mesh, (64, 48), style=style)
    assert np.array_equal(plain["color"], expected["color"]) == (style == "clay")


def test_too_many_colors_of_faces_are_rounded():
    side = np.linspace(0, 1, 515)
    corners = np.stack(np.meshgrid(side, side, [0]), axis=-1).reshape(-1, 3)
    corner = (np.arange(514)[:, None] * 515 + np.arange(514)).ravel()
    faces = np.vstack([corner[:, None] + [0, 1, 516], corner[:, None] + [0, 516, 515]])
    colors = np.random.default_rng(1).random((len(faces), 3))
    with pytest.warns(UserWarning, match="mesh: 4104 faces have a rounded colour: there are too many colours"):
        octray.render(octray.Mesh(corners, faces), (8, 8), samples=1, face_colors=colors)


@pytest.mark.parametrize(
    ("colors", "message"),
    [
        ([[1, 2, 3]] * 4, "expected uint8, or floats from 0 to 1, of shape .4, 3., found an array of int64"),
        (np.zeros((4, 3), np.uint16), "found an array of uint16"),
        (np.zeros((4, 3), bool), "found an array of bool"),
        (np.zeros((4, 3), complex), "found an array of complex128"),
        ("red", "found an array of"),
        ([[0.1] * 3] * 3, "found shape .3, 3."),
        ([0.1] * 12, "found shape .12,."),
        (np.zeros((4, 2)), "found shape"),
        (np.zeros((0, 3)), "found shape"),
        ([[0.1] * 3, [0.2] * 2] * 2, "rows of different lengths"),
        ([[0.1, 0.2, np.nan]] * 4, "found others, such as nan"),
        ([[0.1, 0.2, 1.01]] * 4, "found others, such as 1.01"),
        ([[0.1, 0.2, -1e-30]] * 4, "found others"),
        ([[0.1, 0.2, np.inf]] * 4, "found others"),
        ([[0.1, 0.2, 0.3, 0.9]] * 4, "alpha is not rendered: expected 1 in"),
        (np.full((4, 4), 254, np.uint8), "alpha is not rendered: expected 255 in"),
        (np.ma.masked_equal(np.eye(4, 3), 1), "masked"),
    ],
)
@pytest.mark.parametrize("name", ["vertex_colors", "face_colors"])
def test_wrong_colors(name, colors, message):
    mesh = octray.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    with pytest.raises(ValueError, match=f"{name}: .*{message}"):
        octray.render(mesh, (4, 4), **{name: colors})


def test_colors_that_do_not_fit():
    mesh = octray.Mesh(np.eye(3), [[0, 1, 2]])
    with pytest.raises(ValueError, match="found both"):
        octray.render(mesh, vertex_colors=np.eye(3), face_colors=np.eye(3)[:1])
    for source in (SCENES / "reflections.scn", SCENES / "meshes" / "vase.obj", io.BytesIO()):
        with pytest.raises(ValueError, match="vertex_colors: expected None for a file"):
            octray.render(source, vertex_colors=np.eye(3))


MESH = SCENES / "meshes" / "vase.obj"


@pytest.mark.parametrize(
    ("source", "options", "arguments"),
    [
        (MESH, {"ground": True, "samples": 1}, ["--ground", "--samples", "1"]),
        (MESH, {"up_axis": "-x", "samples": 1}, ["--up-axis=-x", "--samples", "1"]),
        (SCENES / "meshes" / "gear.stl", {"smooth_angle": 40, "samples": 1}, ["--smooth-angle", "40", "--samples", "1"]),
        (MESH, {"lit_from": (1, 0, 0.5), "samples": 1}, ["--lit-from", "1,0,0.5", "--samples", "1"]),
        (MESH, {"srgb": False, "samples": 1}, ["--linear", "--samples", "1"]),
        (MESH, {"camera": {"ortho": "fit", "from": "top"}}, ["--ortho", "fit", "--from", "top"]),
        (SCENES / "meshes" / "helix.ply", {"point_size": 0.05}, ["--point-size", "0.05"]),
        (SCENES / "glass.scn", {"max_depth": 9}, ["--max-depth", "9"]),
        (SCENES / "glass.scn", {"srgb": True}, ["--srgb"]),
        (MESH, {"edges": True}, ["--edges"]),
        (SCENES / "gears.scn", {"edges": np.float32(2.5)}, ["--edges=2.5"]),
        (SCENES / "glass.scn", {"shadows": False, "max_depth": 1}, ["--no-shadows", "--max-depth", "1"]),
    ],
)
def test_options_are_those_of_the_program(tmp_path, source, options, arguments):
    picture = octray.render(source, (48, 32), **options)
    program = pathlib.Path(sys.executable).with_name("octray")
    file = tmp_path / "picture.ppm"
    subprocess.run([program, source, "-s", "48x32", *arguments, "-o", file], check=True)
    assert file.read_bytes().endswith(picture["color"].tobytes())


def test_transparent_pictures_and_floats():
    image = pytest.importorskip("PIL.Image")
    for source, samples in ((MESH, 4), (SCENES / "reflections.scn", 4)):
        picture = octray.render(source, (48, 32), samples=samples, background="transparent", aov="mask")
        assert picture["color"].shape == (32, 48, 4) and picture["color"].dtype == np.uint8
        assert picture["mask"].dtype == bool and 0 < picture["mask"].mean() <= 1
        program = pathlib.Path(sys.executable).with_name("octray")
        arguments = ["-s", "48x32", "--samples", str(samples), "--background", "transparent", "-o", "-"]
        done = subprocess.run([program, source, *arguments], check=True, capture_output=True)
        assert np.array_equal(np.asarray(image.open(io.BytesIO(done.stdout))), picture["color"])
    floats = octray.render(MESH, (48, 32), samples=4, dtype="float32")["color"]
    linear = octray.render(MESH, (48, 32), samples=4, srgb=False)["color"]
    assert floats.dtype == np.float32 and floats.shape == (32, 48, 3)
    assert np.abs(np.clip(floats * 255, 0, 255) - linear).max() <= 1
    four = octray.render(MESH, (48, 32), samples=4, dtype=np.float32, background="transparent")["color"]
    assert four.shape == (32, 48, 4) and four[..., 3].min() == 0


def test_background_colours():
    shown = octray.render(MESH, (48, 32), samples=4, aov="mask", background="336699")
    usual = octray.render(MESH, (48, 32), samples=4, aov="mask", background="transparent")["color"]
    assert shown["color"].shape == (32, 48, 3)
    assert np.all(shown["color"][usual[..., 3] == 0] == (0x33, 0x66, 0x99))
    assert np.all(shown["color"][usual[..., 3] == 255] == usual[usual[..., 3] == 255][:, :3])
    for wrong in ("purple", "", 5, None, (1, 2, 3)):
        with pytest.raises(ValueError, match="background: expected scene, transparent"):
            octray.render(MESH, (8, 8), background=wrong)


def moving_gltf(path):
    """Write a glTF file with a triangle that turns by 120 degrees in a second."""
    arrays = [
        np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0]], "<f4"),
        np.array([0, 1], "<f4"),
        np.array([[0, 0, 0, 1], [0, 0, 0.75**0.5, 0.5]], "<f4"),
    ]
    content = b"".join(array.tobytes() for array in arrays)
    starts = np.cumsum([0, *(array.nbytes for array in arrays)]).tolist()
    kinds = ["VEC3", "SCALAR", "VEC4"]
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [3, 0, 0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [
            {
                "name": "turn",
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}],
                "samplers": [{"input": 1, "output": 2}],
            }
        ],
        "accessors": [
            {"bufferView": i, "componentType": 5126, "count": len(array), "type": kind}
            | {"min": array.min(axis=0).reshape(-1).tolist(), "max": array.max(axis=0).reshape(-1).tolist()}
            for i, (array, kind) in enumerate(zip(arrays, kinds))
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": array.nbytes} for start, array in zip(starts, arrays)
        ],
        "buffers": [
            {
                "byteLength": len(content),
                "uri": "data:application/octet-stream;base64," + base64.b64encode(content).decode(),
            }
        ],
    }
    path.write_text(json.dumps(tree))
    return path


def test_frames_environments_and_animations(tmp_path):
    gears = SCENES / "gears.scn"
    first, last = (octray.render(gears, (48, 32), frame=frame)["color"] for frame in (1, 12))
    assert np.array_equal(first, octray.render(gears, (48, 32))["color"]) and not np.array_equal(first, last)
    program = pathlib.Path(sys.executable).with_name("octray")
    subprocess.run([program, gears, "-s", "48x32", "--frames", "12", "-o", tmp_path / "#.ppm"], check=True)
    (file,) = tmp_path.glob("*.ppm")
    assert file.read_bytes().endswith(last.tobytes())
    with pytest.raises(ValueError, match="frame: expected at most [0-9]+, the last frame of the scene, found 99999"):
        octray.render(gears, (8, 8), frame=99999)
    with pytest.raises(ValueError, match="frame: meshes have no frames, only scenes with keyframes"):
        octray.render(MESH, (8, 8), frame=1)
    mobile = moving_gltf(tmp_path / "mobile.gltf")
    poses = [octray.render(mobile, (48, 32), samples=1, **pose) for pose in ({"animation": 1}, {"animation_time": 0.5})]
    poses = [pose["color"] for pose in poses]
    assert not np.array_equal(*poses)
    again = octray.render(io.BytesIO(mobile.read_bytes()), (48, 32), samples=1, animation="turn", animation_time=0.5)
    assert np.array_equal(again["color"], poses[1])
    arguments = ["--animation-time", "0.5", "--samples", "1", "-o", tmp_path / "pose.ppm"]
    subprocess.run([program, mobile, "-s", "48x32", *arguments], check=True)
    assert (tmp_path / "pose.ppm").read_bytes().endswith(poses[1].tobytes())
    with pytest.raises(ValueError, match="animation"):
        octray.render(mobile, (8, 8), animation="walk")
    with pytest.raises(ValueError, match="no animation in the file"):
        octray.render(MESH, (8, 8), animation=1)
    for name in ("animation", "animation_time"):
        with pytest.raises(ValueError, match=f"{name}: a Mesh has no animations"):
            octray.render(octray.Mesh(np.eye(3), [[0, 1, 2]]), (8, 8), **{name: 1})
    sky = SCENES / "skies" / "evening.hdr"
    lit = octray.render(MESH, (48, 32), samples=16, environment=sky, environment_rotate=30)["color"]
    arguments = ["--environment", sky, "--environment-rotate", "30", "--samples", "16", "-o", tmp_path / "lit.ppm"]
    subprocess.run([program, MESH, "-s", "48x32", *arguments], check=True)
    assert (tmp_path / "lit.ppm").read_bytes().endswith(lit.tobytes())
    with pytest.raises(FileNotFoundError, match="none.hdr"):
        octray.render(MESH, (8, 8), environment="none.hdr")
    with pytest.raises(ValueError, match="environment needs style studio or clay"):
        octray.render(MESH, (8, 8), environment=sky, style="plain")


def test_aovs():
    picture = octray.render(SCENES / "forest.scn", (48, 32), aov=("mask", "z", "depth", "instance", "id"))
    assert np.array_equal(picture["mask"], np.isfinite(picture["z"]))
    assert np.array_equal(picture["mask"], picture["instance"] > 0) and picture["instance"].max() > 1
    hit = picture["mask"]
    assert (picture["z"][hit] <= picture["depth"][hit]).all() and picture["z"].dtype == np.float32
    assert picture["id"].dtype == picture["instance"].dtype == np.uint32
    assert list(octray.render(MESH, (4, 4), aov=["mask", "mask"])) == ["color", "mask"]


@pytest.mark.parametrize("name", ["pine.ply", "gear.stl", "helix.ply", "stairs.3mf"])
def test_binary_files(name):
    path = SCENES / "meshes" / name
    expected = octray.render(path, (32, 24), samples=1)["color"]
    content = io.BytesIO(path.read_bytes())
    assert np.array_equal(octray.render(content, (32, 24), samples=1)["color"], expected)
    with path.open("rb") as file:
        assert np.array_equal(octray.render(file, (32, 24), samples=1)["color"], expected)


def test_files_that_open_files_name(monkeypatch):
    # They are looked for beside the file, or in the current folder if it has no name.
    for folder, path in ((SCENES / "meshes", MESH), (SCENES, SCENES / "reflections.scn")):
        expected = octray.render(path, (32, 24), samples=1)["color"]
        with path.open("rb") as file:
            assert np.array_equal(octray.render(file, (32, 24), samples=1)["color"], expected)
        monkeypatch.chdir(folder)
        assert np.array_equal(octray.render(io.BytesIO(path.read_bytes()), (32, 24), samples=1)["color"], expected)
        monkeypatch.undo()


def test_faults_in_binary_files():
    for wrong in (io.StringIO("v 0 0 0"), io.TextIOWrapper(io.BytesIO(b"v 0 0 0"))):
        with pytest.raises(ValueError, match="opened in binary mode, found one whose read returns str"):
            octray.render(wrong)
    with pytest.raises(ValueError, match="source: the input is empty"):
        octray.render(io.BytesIO())
    with pytest.raises(ValueError, match="source:1"):
        octray.render(io.BytesIO(b"sphere 0 0 0\n"))
    with pytest.raises(ValueError, match="source: "):
        octray.render(io.BytesIO(b"glTF" + bytes(20)))


def test_up_axis_of_a_mesh():
    corners, faces = [[0, 0, 0], [1, 0, 0], [0, 2, 0], [0.1, 0.3, 0.5]], [[0, 2, 1], [0, 1, 3]]
    mesh = octray.Mesh(corners, faces)
    usual = octray.render(mesh, (32, 32), aov="id")["id"]
    assert np.array_equal(usual, octray.render(mesh, (32, 32), up_axis="z", aov="id")["id"])
    for axis in ("y", "-z"):
        turned = octray.render(mesh, (32, 32), up_axis=axis, aov="id")["id"].ravel()
        assert not np.array_equal(usual.ravel(), turned)
        hits = mesh.closest_hit(*octray.camera_rays(None, (32, 32), mesh, up_axis=axis))
        assert np.array_equal(np.where(hits.triangle < 0, 2**32 - 1, hits.triangle), turned)
    plain = octray.render(mesh, (32, 32), style="plain", aov="id")["id"].ravel()
    hits = mesh.closest_hit(*octray.camera_rays(None, (32, 32), mesh, style="plain"))
    assert np.array_equal(np.where(hits.triangle < 0, 2**32 - 1, hits.triangle), plain)
