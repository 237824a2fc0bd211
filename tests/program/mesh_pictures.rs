//! Meshes on the command line: golden pictures of each format (see `tests/library/golden.rs`), and framing.

use crate::{
    crops::SWING,
    images::{assert_all, compare_golden},
    program::{Folder, assert_contains, shipped_mesh},
};
use image::RgbImage;

/// The share of pixels that may differ: without fused multiply-add, edges round differently.
const SHARE: f64 = 0.001;

/// Renders a shipped mesh.
fn picture(folder: &Folder, mesh: &str, options: &[&str]) -> RgbImage {
    let mesh = shipped_mesh(mesh);
    let arguments = [&["render", &mesh, "-o", "a.png", "--quiet"], options].concat();
    folder.run(&arguments).succeeded();
    image::open(folder.path("a.png")).expect("a picture").into_rgb8()
}

#[test]
fn golden_pictures_of_every_format() {
    let folder = Folder::new();
    let size = ["--size", "160x120", "--samples", "4"];
    assert_all(
        [
            ("obj", "vase.obj", &[][..]),
            (
                "obj-smooth-ground",
                "vase.obj",
                &["--ground", "--smooth-angle", "40"],
            ),
            ("stl-binary", "gear.stl", &["--ground"]),
            ("stl-ascii", "house.stl", &["--ground"]),
            ("ply", "tetrahedron.ply", &[]),
            ("points", "helix.ply", &["--ground", "--point-size", "0.1"]),
            ("gltf", "mobile.gltf", &["--ground"]),
            ("gltf-camera", "mobile.gltf", &["--camera", "front"]),
            ("up-axis", "house.stl", &["--up-axis", "y"]),
            ("studio", "helix.ply", &["--ground", "--style", "studio"]),
            ("clay", "mobile.gltf", &["--style", "clay"]),
            ("3mf", "stairs.3mf", &[]),
            (
                "textures",
                "garden.obj",
                &[
                    "--style",
                    "studio",
                    "--eye",
                    "1.2,2.1,5.2",
                    "--target",
                    "0,0.75,0",
                ],
            ),
        ]
        .map(|(name, mesh, options)| {
            let plain = if options.contains(&"--style") {
                &[][..]
            } else {
                &["--style", "plain"]
            };
            let actual = picture(&folder, mesh, &[&size[..], plain, options].concat());
            compare_golden(&format!("mesh-{name}"), &actual, SHARE)
        }),
    );
}

/// A style only changes the defaults of options: the sRGB curve, the filter and the number of samples.
#[test]
fn styles_give_way_to_options() {
    let folder = Folder::new();
    let studio = |options: &str| {
        let words: Vec<&str> = options.split_whitespace().collect();
        let style = ["--style", "studio", "--size", "60x40"];
        picture(&folder, "vase.obj", &[&style[..], &words].concat())
    };
    let whole = studio("");
    assert!(whole == studio("--samples auto --filter tent --srgb"));
    assert!(whole == studio("--samples auto:16 --pattern sobol"));
    assert!(studio("--pattern grid") == studio("--samples 16"));
    for option in [
        "--samples 4",
        "--samples 16",
        "--samples auto:9",
        "--filter box",
        "--linear",
    ] {
        assert!(whole != studio(option), "{option}");
    }
    assert!(whole == studio("--threads 1 --mode scalar"));
    let size = ["--size", "60x40"];
    assert!(whole == picture(&folder, "vase.obj", &size));
    let plain = |options: &[&str]| {
        picture(
            &folder,
            "vase.obj",
            &[&size[..], &["--style", "plain"], options].concat(),
        )
    };
    assert!(plain(&[]) == plain(&["--samples", "1", "--filter", "box", "--linear"]));
    // Linear light is what an EXR holds.
    let mesh = shipped_mesh("vase.obj");
    let exr = [
        "render", &mesh, "--style", "studio", "--size", "9x9", "-o", "a.exr",
    ];
    folder.run(&exr).succeeded();
    folder.write("a.scn", "light 1 2 3 1\nmaterial 1\nsphere 0 0 0 1\n");
    let words = "--style applies to meshes only";
    folder.fails(&["a.scn", "--style", "clay"], 2, words);
    // A scene keeps its pixels, also beside a mesh.
    folder.run(&["a.scn", "-s", "9x9", "-o", "alone.png"]).succeeded();
    let both = ["render", "a.scn", &mesh, "-s", "9x9", "-o", "both-{stem}.png"];
    folder.run(&both).succeeded();
    let pixels = |name: &str| image::open(folder.path(name)).expect("a picture").into_rgb8();
    assert!(pixels("alone.png") == pixels("both-a.png"));
    assert!(picture(&folder, "vase.obj", &["-s", "9x9"]) == pixels("both-vase.png"));
}

#[test]
fn info_lists_cameras() {
    let info = Folder::new().run(&["info", &shipped_mesh("mobile.gltf")]);
    assert!(info.succeeded().text().contains("camera"), "{info:?}");
    assert!(info.text().contains("\"front\" eye"), "{info:?}");
}

/// The first and last column and row that show more than the background.
fn extent(picture: &RgbImage) -> [u32; 4] {
    let background = *picture.get_pixel(0, 0);
    let shown = picture
        .enumerate_pixels()
        .filter(|(.., pixel)| **pixel != background);
    shown.fold(
        [u32::MAX, 0, u32::MAX, 0],
        |[left, right, top, bottom], (x, y, _)| [left.min(x), right.max(x), top.min(y), bottom.max(y)],
    )
}

#[test]
fn meshes_are_framed() {
    let folder = Folder::new();
    for mesh in ["vase.obj", "gear.stl", "house.stl", "mobile.gltf", "cube.ply"] {
        for (size, fov) in [("200x200", "45"), ("320x100", "20"), ("90x240", "100")] {
            let picture = picture(&folder, mesh, &["--size", size, "--fov", fov]);
            let [left, right, top, bottom] = extent(&picture);
            let (width, height) = picture.dimensions();
            let margins = [left, width - 1 - right, top, height - 1 - bottom];
            // Some margin on all sides, little on two opposite ones.
            assert!(
                margins.iter().all(|&margin| margin > 0),
                "{mesh} {size}: {margins:?}"
            );
            let across = margins[0].max(margins[1]) as f32 / width as f32;
            let down = margins[2].max(margins[3]) as f32 / height as f32;
            assert!(across.min(down) < 0.06, "{mesh} {size}: {margins:?}");
        }
    }
}

#[test]
fn modes_and_threads_make_the_same_picture() {
    let folder = Folder::new();
    let options = ["--size", "64x48", "--ground", "--smooth-angle", "60"];
    for mesh in ["vase.obj", "gear.stl", "mobile.gltf"] {
        let expected = picture(&folder, mesh, &options);
        for more in [["--mode", "scalar"], ["--threads", "1"]] {
            let actual = picture(&folder, mesh, &[&options[..], &more].concat());
            assert!(actual == expected, "{mesh} {more:?}");
        }
    }
}

#[test]
fn meshes_that_cannot_be_lit() {
    let folder = Folder::new();
    folder.write("far.obj", "v 0 0 0\nv 9e8 0 0\nv 0 9e8 0\nf 1 2 3\n");
    let words = "error: far.obj: the mesh reaches 6.4e8 from its middle, so that its lights, 100 times as far away, would \
                 be beyond 1e9; scale it down";
    folder.fails(&["far.obj", "-s", "8x8"], 1, words);
    folder.fails(&["far.obj", "-s", "8x8", "--style", "plain"], 1, words);
    folder.run(&["info", "far.obj"]).succeeded();
}

#[test]
fn clay_reads_no_images() {
    let folder = Folder::new();
    folder.write("a.mtl", "newmtl a\nmap_Kd a.png\n");
    folder.write("a.png", "no picture");
    let text = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
    folder.write("a.obj", text);
    let said = |style: &str| {
        let run = folder.run(&["a.obj", "-s", "8x8", "--style", style, "-o", "out.png"]);
        assert_eq!(run.code, Some(0), "{run:?}");
        run.stderr
    };
    assert!(said("studio").contains("texture a.png is not shown"));
    assert!(!said("clay").contains("a.png is not shown"));
}

/// A strip of 1000 triangles, placed 1100 times by one node.
fn write_many(folder: &Folder, name: &str) {
    const CORNERS: usize = 1002;
    const PLACES: usize = 1100;
    let mut numbers = Vec::new();
    for i in 0..CORNERS {
        let (sin, cos) = (i as f32 * 0.05).sin_cos();
        numbers.extend([cos, i as f32 * 0.002, sin + (i % 2) as f32 * 0.3]);
    }
    for i in 0..PLACES {
        numbers.extend([(i % 34) as f32 * 3.0, (i % 7) as f32, (i / 34) as f32 * 3.0]);
    }
    let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
    std::fs::write(folder.path("many.bin"), &bytes).expect("it is written");
    folder.write(name, &format!(
        r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["EXT_mesh_gpu_instancing"],"nodes":[{{"mesh":0,"extensions":
{{"EXT_mesh_gpu_instancing":{{"attributes":{{"TRANSLATION":1}}}}}}}}],"buffers":[{{"byteLength":{0},"uri":"many.bin"}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":5}}]}}],"bufferViews":[{{"buffer":0,"byteLength":{0}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{CORNERS},"type":"VEC3"}},
{{"bufferView":0,"byteOffset":{1},"componentType":5126,"count":{PLACES},"type":"VEC3"}}]}}"#,
        bytes.len(),
        CORNERS * 12
    ));
}

/// A mesh that would take much memory in all its places is stored once, from a pipe, too.
#[test]
fn shared_meshes_of_a_gltf_file() {
    let folder = Folder::new();
    write_many(&folder, "many.gltf");
    let info = folder.run(&["info", "many.gltf"]);
    assert_contains(info.succeeded().text(), &["1 000 (", "1 100 of 1 meshes"]);
    let render = |way: &str| {
        let line = format!("render {way} -o a.png --size 40x30 --ground --quiet --max-memory 60M --force");
        folder.run_line(&line).succeeded();
        std::fs::read(folder.path("a.png")).expect("a picture")
    };
    let first = render("many.gltf");
    assert!(first == render("many.gltf --mode scalar --threads 1"));
    folder
        .shell("\"$0\" render - -o b.png --size 40x30 --ground --quiet < many.gltf")
        .succeeded();
    assert!(std::fs::read(folder.path("b.png")).expect("a picture") == first);
    // In a scene it takes the memory of all its places.
    folder.write("a.scn", "light 9 9 9 1\nmesh many.gltf\n");
    let refused = folder.run(&["info", "a.scn", "--max-memory", "60M"]);
    assert_eq!(refused.code, Some(1));
    assert!(refused.stderr.contains("memory limit"), "{}", refused.stderr);
}

/// Cameras that make no picture are noted, and keep their number.
#[test]
fn cameras_without_a_picture() {
    let folder = Folder::new();
    let lens = |yfov: f64| format!(r#"{{"type":"perspective","perspective":{{"yfov":{yfov},"znear":0.1}}}}"#);
    let cameras = format!(
        r#""cameras":[{},{}],"nodes":[{{"camera":0}},{{"camera":1}},"#,
        lens(3.2),
        lens(0.5)
    );
    let json = SWING.replacen(r#""nodes":["#, &cameras, 1);
    folder.write("a.gltf", &json);
    let info = folder.run(&["info", "a.gltf"]);
    let info = String::from_utf8(info.succeeded().stdout.clone()).expect("text");
    assert_contains(
        &info,
        &[
            "a.gltf: camera 1 makes no picture: the field of view is 183.3",
            "fov 28.6",
        ],
    );
    folder.fails(
        &["a.gltf", "--camera=1", "-s=9"],
        2,
        "camera `1`: the field of view is 183.3",
    );
    folder.fails(
        &["a.gltf", "--camera=5", "-s=9"],
        2,
        "expected 1 (unnamed), 2 (unnamed)",
    );
    folder.run(&["a.gltf", "--camera=2", "-s=9"]);
    assert!(folder.path("a.png").exists());
}
