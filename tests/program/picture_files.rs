//! The files that `--aov`, `--srgb` and `--background` write. (`--crop`: `crops.rs`.)

use crate::program::Folder;
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};
use image::DynamicImage;

/// A square that faces the views of a mesh.
const FLAT: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n\
    -1 0 -1 255 128 0\n1 0 -1 255 128 0\n1 0 1 255 128 0\n-1 0 1 255 128 0\n4 0 1 2 3\n";

fn render(folder: &Folder, name: &str, options: &str) -> DynamicImage {
    let arguments = format!("a.scn --size 60x40 -o {name} {options}");
    folder.run_line(&arguments).succeeded();
    open(folder, name)
}

fn open(folder: &Folder, name: &str) -> DynamicImage {
    image::open(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn layers_have_files_of_their_own() {
    let folder = Folder::new();
    render(&folder, "b.qoi", "--aov normal,heat,heat");
    assert_eq!(folder.names(), ["a.scn", "b.heat.qoi", "b.normal.qoi", "b.qoi"]);
    let stats = folder.run(&["a.scn", "--aov", "depth,heat", "--json=-"]);
    let stats: serde_json::Value = serde_json::from_str(stats.text()).unwrap();
    let aov = &stats["aov"];
    assert!(aov["depth"]["white"].as_f64().unwrap() < aov["depth"]["black"].as_f64().unwrap());
    assert!(aov["heat"]["total"]["most"].as_u64().unwrap() > 1);
    assert_eq!(aov["heat"]["legend"][0]["color"], "#440154");
    let text = folder.run(&["a.scn", "--aov", "heat", "--stats"]).stderr;
    assert!(text.contains("heat legend 1 #440154, 4 #"), "{text}");
    assert!(!folder.run(&["a.scn", "--stats"]).stderr.contains("heat"));
}

/// Threads compress many blocks in any order.
#[test]
fn exr_files_are_deterministic() {
    let folder = Folder::new();
    for options in ["", "--background transparent", "--aov depth,id"] {
        let files = ["a.exr", "b.exr", "c.exr"].map(|name| {
            let arguments = format!("a.scn --size 700x500 -o {name} {options}");
            folder.run_line(&arguments).succeeded();
            std::fs::read(folder.path(name)).unwrap()
        });
        assert!(files[0] == files[1] && files[0] == files[2], "{options}");
    }
}

#[test]
fn exr_files_hold_layers() {
    let folder = Folder::new();
    render(&folder, "plain.exr", "");
    let layered = render(&folder, "b.exr", "--aov depth,normal,albedo,id,heat");
    assert_eq!(folder.names(), ["a.scn", "b.exr", "plain.exr"]);
    assert_eq!(layered.to_rgb32f(), open(&folder, "plain.exr").to_rgb32f());
    let file = read_first_flat_layer_from_file(folder.path("b.exr")).unwrap();
    let names: Vec<String> = file
        .layer_data
        .channel_data
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    let expected = "B G R albedo.B albedo.G albedo.R depth.Z heat.nodes heat.primitives id.primitive \
                    normal.X normal.Y normal.Z";
    assert_eq!(names.join(" "), expected);
    for channel in &file.layer_data.channel_data.list {
        let whole = matches!(channel.sample_data, FlatSamples::U32(_));
        let name = channel.name.to_string();
        assert_eq!(
            whole,
            name.starts_with("id") || name.starts_with("heat"),
            "{name}"
        );
    }
    let transparent = render(&folder, "c.exr", "--aov depth --background transparent");
    assert_eq!(transparent.to_rgba32f().get_pixel(0, 0).0, [0.0; 4]);
}

#[test]
fn srgb_encodes_linear_values() {
    let folder = Folder::new();
    let linear = render(&folder, "a.exr", "").to_rgb32f();
    let plain = render(&folder, "a.png", "").to_rgb8();
    assert_eq!(render(&folder, "b.png", "--linear").to_rgb8(), plain);
    let srgb = render(&folder, "c.png", "--srgb").to_rgb8();
    assert_ne!(srgb, plain);
    for (&c, &byte) in linear.iter().zip(srgb.iter()) {
        let c = f64::from(c.clamp(0.0, 1.0));
        let curve = if c <= 0.003_130_8 {
            12.92 * c
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        };
        assert!((f64::from(byte) - 255.0 * curve).abs() < 0.51, "{c}: {byte}");
    }
}

/// A scene is linear by default and a mesh is not, whichever comes first.
#[test]
fn albedo_is_encoded_as_its_picture() {
    let folder = Folder::new();
    folder.write(
        "flat.scn",
        "camera eye 0 -1 0 target 0 0 0\nmaterial matte cd 0.5 0.25 1\nplane 0 0 0 normal 0 1 0\n",
    );
    folder.write("b.ply", FLAT);
    let albedo = |name: &str| open(&folder, name).to_rgb8().get_pixel(4, 4).0;
    for inputs in ["flat.scn b.ply", "b.ply flat.scn"] {
        let options = "--size 9x9 --force --quiet --aov albedo";
        folder
            .run_line(&format!("{inputs} -o {{stem}}.ppm {options}"))
            .succeeded();
        assert_eq!(albedo("flat.albedo.ppm"), [127, 63, 255], "{inputs}");
        assert_eq!(albedo("b.albedo.ppm"), [255, 128, 0], "{inputs}");
    }
    folder
        .run_line("flat.scn -o c.png --size 9x9 --quiet --aov albedo --srgb")
        .succeeded();
    assert_eq!(albedo("c.albedo.png"), [188, 137, 255]);
    folder
        .run_line("b.ply -o d.png --size 9x9 --quiet --aov albedo --linear")
        .succeeded();
    assert_eq!(albedo("d.albedo.png"), [255, 55, 0]);
}

/// The horizon is in the picture.
#[test]
fn depth_shows_infinite_planes() {
    let folder = Folder::new();
    folder.write(
        "ground.scn",
        "camera eye 0 0 2 target 0 1 2 fov 60\nmaterial matte\nplane 0 0 0 normal 0 0 1\n",
    );
    let run = "ground.scn -o g.png --size 20x301 --quiet --aov depth,mask";
    folder.run_line(run).succeeded();
    let [depth, mask] = ["g.depth.png", "g.mask.png"].map(|name| open(&folder, name).to_luma8());
    assert!(
        depth
            .pixels()
            .zip(mask.pixels())
            .all(|(depth, mask)| (depth.0[0] > 0) == (mask.0[0] > 0))
    );
    assert!(depth.get_pixel(10, 160).0[0] < depth.get_pixel(10, 200).0[0]);
    assert!(depth.get_pixel(10, 300).0[0] > 150);
    folder
        .run_line(&format!("{run} --force --crop 3,140,9,190"))
        .succeeded();
    let crop = open(&folder, "g.depth.png").to_luma8();
    assert_eq!(crop.get_pixel(2, 40), depth.get_pixel(5, 180));
}

#[test]
fn transparent_pictures_have_alpha() {
    let folder = Folder::new();
    for name in ["a.png", "a.qoi", "a.tiff", "a.exr"] {
        let picture = render(&folder, name, "--background transparent --samples 4 --view 2");
        assert!(picture.color().has_alpha(), "{name}");
        let picture = picture.to_rgba8();
        let alphas: std::collections::BTreeSet<u8> = picture.pixels().map(|p| p.0[3]).collect();
        assert!(
            alphas.contains(&0) && alphas.contains(&255) && alphas.len() == 5,
            "{name}: {alphas:?}"
        );
    }
    assert!(!render(&folder, "b.png", "--background scene").color().has_alpha());
    let run = folder.run(&["a.scn", "-o", "-", "--background", "transparent", "--size", "5x3"]);
    assert!(
        image::load_from_memory(&run.succeeded().stdout)
            .unwrap()
            .color()
            .has_alpha()
    );
}

#[test]
fn impossible_combinations_are_refused() {
    let folder = Folder::new();
    for (arguments, words) in [
        ("--crop 0,0,513,5", "expected at most 0,0,512,512"),
        ("--crop 0,0,5", "x0,y0,x1,y1"),
        ("--crop 5,5,5,9", "x0 below x1"),
        ("--pattern random", "grid, stratified, sobol"),
        ("--filter gauss", "box, tent, blackman-harris"),
        ("--aov depths", "depth, normal, albedo, id, heat"),
        ("-o - --aov depth", "-o a.png"),
        ("--srgb --linear", "--linear"),
        ("-o a.exr --srgb", "leave out --srgb"),
        ("-o a.ppm --background transparent", "expected .png"),
        ("-o a.jpg --background transparent", "expected .png"),
        ("-o a.bmp --background transparent", "expected .png"),
        ("--background blackish", "scene, transparent"),
    ] {
        let arguments: Vec<_> = std::iter::once("a.scn").chain(arguments.split(' ')).collect();
        folder.fails(&arguments, 2, words);
    }
    std::fs::create_dir(folder.path("a.depth.png")).unwrap();
    folder.fails(&["a.scn", "--aov", "depth"], 1, "it is a directory");
}
