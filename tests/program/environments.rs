//! Environment maps of meshes: `--environment`.

use crate::program::{Folder, shipped_mesh};
use std::fs;

const SQUARE: &str = "v -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nf 1 2 3 4\n";

/// A folder with a square that faces up, and a sky whose upper half is bright.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    let sky = image::GrayImage::from_fn(4, 4, |_, y| image::Luma([if y < 2 { 240 } else { 10 }]));
    sky.save(folder.path("sky.png")).expect("it is written");
    folder
}

/// Its up axis is that of the mesh, and its brightness does not matter.
#[test]
fn the_sky_is_above() {
    let folder = folder();
    let middle = |options: &str| {
        let line =
            format!("square.obj --size 9x9 --eye 0,4,0 --up 0,0,1 --samples 64 -q -o made.png {options}");
        folder.run_line(&line).succeeded();
        image::open(folder.path("made.png")).expect("a picture").to_rgb8()[(4, 4)][0]
    };
    let [above, below] = ["y", "-y"].map(|axis| middle(&format!("--environment sky.png --up-axis {axis}")));
    assert!(above > below + 20, "{above} {below}");
    image::open(folder.path("sky.png"))
        .unwrap()
        .brighten(-200)
        .save(folder.path("dark.png"))
        .unwrap();
    let dark = middle("--environment dark.png");
    assert!(above.abs_diff(dark) < 20, "{above} {dark}");
}

/// TIFF files hold the same light as OpenEXR files.
#[test]
fn skies_of_floats() {
    let folder = folder();
    let sky = image::Rgb32FImage::from_fn(4, 4, |x, y| image::Rgb([y as f32 * 3.5, 0.25, x as f32]));
    let made = ["exr", "tiff"].map(|extension| {
        let name = format!("floats.{extension}");
        sky.save(folder.path(&name)).expect("it is written");
        folder
            .run_line(&format!(
                "square.obj --size 9x9 -q -o made.png --environment {name}"
            ))
            .succeeded();
        fs::read(folder.path("made.png")).expect("a picture")
    });
    assert_eq!(made[0], made[1]);
}

/// Palettes are read, and what is not read is said.
#[test]
fn references_and_skies_of_tiff() {
    let folder = folder();
    let short = |tag: u16, value: u16| [tag, 3, 1, 0, value, 0].map(u16::to_le_bytes).concat();
    let long = |tag: u16, kind: u16, count: u32, value: u32| {
        let [tag, kind] = [tag, kind].map(u16::to_le_bytes);
        let [count, value] = [count, value].map(u32::to_le_bytes);
        [&tag[..], &kind, &count, &value].concat()
    };
    let tiff = |interpretation, bits, samples: &[u8]| {
        let map = [300_u16, 0xa00, 0xf000].map(|most| (0..256).map(move |i| most.wrapping_mul(i)));
        let map: Vec<u8> = map.into_iter().flatten().flat_map(u16::to_le_bytes).collect();
        let start = 8 + 2 + 9 * 12 + 4;
        let entries = [
            short(256, 2),
            short(257, 1),
            short(258, bits),
            short(259, 1),
            short(262, interpretation),
            long(273, 4, 1, start + map.len() as u32),
            short(278, 1),
            long(279, 4, 1, samples.len() as u32),
            long(320, 3, 768, start),
        ];
        let head = [&b"II*\0\x08\0\0\0\x09\0"[..], &entries.concat(), &[0; 4]].concat();
        [head, map, samples.to_vec()].concat()
    };
    fs::write(folder.path("palette.tif"), tiff(3, 8, &[1, 255])).expect("it is written");
    let shown = |i: u16| [300, 0xa00, 0xf000_u16].map(|most| (most.wrapping_mul(i) >> 8) as u8);
    let colors = [shown(1), shown(255)].concat();
    let colors = image::RgbImage::from_raw(2, 1, colors).expect("two pixels");
    colors.save(folder.path("palette.png")).expect("it is written");
    let made = ["png", "tif"].map(|extension| {
        let options = format!("-q -o made.png --environment palette.{extension}");
        folder
            .run_line(&format!("square.obj --size 9x9 {options}"))
            .succeeded();
        fs::read(folder.path("made.png")).expect("a picture")
    });
    assert_eq!(made[0], made[1]);
    let compare = |name: &str| folder.run_line(&format!("square.obj --size 2x1 -o a.png --compare {name}"));
    let [tiff_said, png_said] = ["palette.tif", "palette.png"].map(|name| compare(name).stderr);
    assert_eq!(tiff_said.replace(".tif", ".png"), png_said);
    fs::write(folder.path("grey.tif"), tiff(1, 32, &[0; 8])).expect("it is written");
    let words = "this is a TIFF with grey of 32-bit integers, expected grey, RGB";
    compare("grey.tif").failed(1, words);
    folder
        .run_line("square.obj --environment grey.tif")
        .failed(1, words);
}

#[test]
fn wrong_environments() {
    let folder = folder();
    for (options, code, words) in [
        ("--environment no.hdr", 1, "no.hdr: file not found"),
        (
            "--environment square.obj",
            1,
            "square.obj: unknown kind of picture",
        ),
        (
            "--environment sky.png --style plain",
            2,
            "needs --style studio or clay",
        ),
        ("--environment sky.png --lit-from 1,0,0", 2, "cannot be used with"),
        (
            "--environment sky.png -o sky.png",
            2,
            "would replace a file of square.obj",
        ),
    ] {
        let arguments: Vec<_> = ["square.obj"].into_iter().chain(options.split(' ')).collect();
        folder.fails(&arguments, code, words);
    }
    assert!(image::open(folder.path("sky.png")).is_ok_and(|sky| sky.width() == 4));
}

/// An HDR file.
#[test]
fn shipped_sky() {
    let folder = Folder::new();
    fs::copy(shipped_mesh("../skies/evening.hdr"), folder.path("sky.hdr")).unwrap();
    let mesh = shipped_mesh("vase.obj");
    let arguments = [
        &*mesh,
        "--environment",
        "sky.hdr",
        "--size",
        "32x32",
        "-q",
        "-o",
        "vase.png",
    ];
    folder.run(&arguments).succeeded();
}

#[test]
fn info_shows_rotation_and_intensity() {
    let folder = folder();
    folder.write("sky.scn", "environment sky.png rotate -30.5 intensity 2\n");
    let text = folder.run(&["info", "sky.scn"]);
    let words = "picture of 4x4 pixels, rotate -30.5, intensity 2, lights the scene";
    assert!(text.succeeded().text().contains(words));
    let json = folder.run(&["info", "sky.scn", "--json", "-"]);
    let json: serde_json::Value = serde_json::from_str(json.succeeded().text()).expect("JSON");
    let background = &json["background"];
    assert_eq!(
        (&background["rotate"], &background["intensity"]),
        (&(-30.5).into(), &2.0.into())
    );
}
