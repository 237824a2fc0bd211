//! Numbers of meshes as colours: `--color-by` and its like, and the lists of `octray info`.

use crate::program::{Folder, assert_contains, shipped_mesh};
use image::Rgb;
use serde_json::Value;
use std::fs;

mod attributes;
mod bar;

/// The first, the middle and the last colour of viridis.
const VIRIDIS: [[u8; 3]; 3] = [[68, 1, 84], [32, 145, 140], [253, 231, 37]];
const GREY: [u8; 3] = [128; 3];

/// The corners of three squares, from left to right.
fn corners() -> impl Iterator<Item = (usize, [i32; 3])> {
    (0..3).flat_map(|square| {
        let left = 2 * square as i32;
        [[left, 0, 0], [left + 1, 0, 0], [left + 1, 1, 0], [left, 1, 0]].map(|corner| (square, corner))
    })
}

/// Three squares whose vertices, or faces, have these numbers as the property `q`.
fn squares(vertices: Option<[&str; 3]>, faces: Option<[&str; 3]>) -> String {
    let property = |has: bool| if has { "property double q\n" } else { "" };
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex 12\nproperty float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\n{}element face 3\n\
         property list uchar int vertex_indices\n{}end_header\n",
        property(vertices.is_some()),
        property(faces.is_some())
    );
    for (square, [x, y, z]) in corners() {
        let value = vertices.map_or("", |values| values[square]);
        text += &format!("{x} {y} {z} 255 0 0 {value}\n");
    }
    for square in 0..3 {
        let first = 4 * square;
        let value = faces.map_or("", |values| values[square]);
        text += &format!("4 {first} {} {} {} {value}\n", first + 1, first + 2, first + 3);
    }
    text
}

/// The colours of the material in the middles of three squares.
fn shown(folder: &Folder, arguments: &str) -> [[u8; 3]; 3] {
    let line = format!(
        "{arguments} --style plain -s 50x10 --eye 2.5,0.5,9 --target 2.5,0.5,0 --up 0,1,0 --ortho 1 --aov albedo -o a.png -q"
    );
    folder.run_line(&line).succeeded();
    let picture = image::open(folder.path("a.albedo.png")).unwrap().into_rgb8();
    [5, 25, 45].map(|x| picture.get_pixel(x, 5).0)
}

fn assert_near(found: [[u8; 3]; 3], expected: [[u8; 3]; 3], what: &str) {
    let apart = found.as_flattened().iter().zip(expected.as_flattened());
    let most = apart.map(|(a, b)| a.abs_diff(*b)).max();
    assert!(most <= Some(1), "{what}: {found:?}, expected {expected:?}");
}

#[test]
fn numbers_of_vertices_and_faces_are_colours() {
    let folder = Folder::new();
    let values = Some(["-1", "1.5", "4"]);
    let others = Some(["7", "7", "8"]);
    for (name, vertices, faces) in [
        ("vertices.ply", values, None),
        ("faces.ply", None, values),
        // Those of vertices win.
        ("both.ply", values, others),
    ] {
        folder.write(name, &squares(vertices, faces));
        let line = |options: &str| format!("{name} --color-by q{options}");
        assert_near(shown(&folder, &line("")), VIRIDIS, name);
        assert_near(shown(&folder, &line(" --mode scalar")), VIRIDIS, name);
        let [first, middle, last] = VIRIDIS;
        let reversed = shown(&folder, &line(" --color-range 4,-1"));
        assert_near(reversed, [last, middle, first], name);
        // The range ends at 1.5, or begins there.
        let clamped = shown(&folder, &line(" --color-range=-6,-1"));
        assert_near(clamped, [last; 3], name);
        let clamped = shown(&folder, &line(" --color-range 1.5,100"));
        assert_near([clamped[0], clamped[1], first], [first; 3], name);
        let grey = shown(&folder, &line(" --color-map greys"));
        assert_near([grey[0], grey[2], GREY], [[255; 3], [0; 3], GREY], name);
    }
    // Without the option the file has its own colours.
    assert_near(shown(&folder, "faces.ply"), [[255, 0, 0]; 3], "red");
    for style in ["studio", "clay"] {
        let picture = |options: &str| {
            let line = format!("both.ply -s 40x20 -q -o b.ppm --style {style} {options}");
            folder.run_line(&line).succeeded();
            fs::read(folder.path("b.ppm")).unwrap()
        };
        assert!(picture("") != picture("--color-by q"), "{style}");
        assert!(
            picture("--color-by q") != picture("--color-by q --color-map turbo"),
            "{style}"
        );
    }
}

#[test]
fn numbers_may_be_anything() {
    let folder = Folder::new();
    let [first, middle, last] = VIRIDIS;
    for (values, expected) in [
        (["nan", "0", "1"], [GREY, first, last]),
        (["-inf", "inf", "NaN"], [GREY; 3]),
        (["3", "3", "3"], [middle; 3]),
        (["-1e308", "0", "1e308"], [first, middle, last]),
        (["1e300", "1e-300", "1e400"], [last, first, GREY]),
        // Seconds since 1970 with milliseconds.
        (
            ["1700000000.001", "1700000000.003", "1700000000.005"],
            [first, middle, last],
        ),
    ] {
        for (what, text) in [
            ("vertices", squares(Some(values), None)),
            ("faces", squares(None, Some(values))),
            // Not one record per line.
            (
                "slow",
                squares(Some(values), None).replace(" 255 0 0 ", " 255 0 0\n"),
            ),
        ] {
            folder.write("a.ply", &text);
            let found = shown(&folder, "a.ply --color-by q");
            assert_near(found, expected, &format!("{what} {values:?}"));
        }
    }
}

/// Vertices of binary files, in both byte orders; names that are no words.
#[test]
fn binary_files_and_odd_names() {
    let folder = Folder::new();
    for order in ["little", "big"] {
        for (kind, value) in [("double", -1.0_f64), ("short", -300.0), ("uchar", 3.0)] {
            let mut bytes = format!(
                "ply\nformat binary_{order}_endian 1.0\nelement vertex 12\nproperty float x\nproperty float y\n\
                 property {kind} \u{e9}-1\nproperty float z\nelement face 3\n\
                 property list uchar int vertex_indices\nend_header\n"
            )
            .into_bytes();
            let mut put = |number: &[u8]| {
                let mut number = number.to_vec();
                if order == "little" {
                    number.reverse();
                }
                bytes.extend(number);
            };
            for (square, [x, y, z]) in corners() {
                let value = value + 50.0 * square as f64;
                put(&(x as f32).to_be_bytes());
                put(&(y as f32).to_be_bytes());
                match kind {
                    "double" => put(&value.to_be_bytes()),
                    "short" => put(&(value as i16).to_be_bytes()),
                    _ => put(&[value as u8]),
                }
                put(&(z as f32).to_be_bytes());
            }
            for first in [0, 4, 8] {
                put(&[4]);
                (first..first + 4).for_each(|i: i32| put(&i.to_be_bytes()));
            }
            fs::write(folder.path("a.ply"), bytes).unwrap();
            assert_near(shown(&folder, "a.ply --color-by \u{e9}-1"), VIRIDIS, kind);
        }
    }
}

/// A colour between those of two vertices is their mean, as that of vertex colours.
#[test]
fn colours_are_interpolated() {
    let folder = Folder::new();
    let square = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  property float q\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                  0 0 0 0\n5 0 0 1\n5 1 0 1\n0 1 0 0\n4 0 1 2 3\n";
    folder.write("a.ply", square);
    let [first, _, last] = VIRIDIS;
    let found = shown(&folder, "a.ply --color-by q")[1];
    let share = 25.5 / 50.0;
    for i in 0..3 {
        let expected = f32::from(first[i]) + share * (f32::from(last[i]) - f32::from(first[i]));
        assert!((f32::from(found[i]) - expected).abs() <= 1.0, "{found:?}");
    }
    // Linear light is that of the colours as bytes of sRGB.
    folder.write("b.ply", &squares(Some(["0", "1", "2"]), None));
    let line = "b.ply --color-by q -s 50x10 --eye 2.5,0.5,9 --target 2.5,0.5,0 --up 0,1,0 --ortho 1 --aov albedo -o b.exr";
    folder.run_line(line).succeeded();
    let layers = exr::prelude::read_first_flat_layer_from_file(folder.path("b.exr")).unwrap();
    let mut channels = layers.layer_data.channel_data.list.iter();
    let green = channels
        .find(|channel| channel.name.to_string() == "albedo.G")
        .unwrap();
    let found = green.sample_data.value_by_flat_index(5 * 50 + 45).to_f32();
    assert!((found - 0.7991).abs() < 1e-3, "{found}");
}

/// Coordinates of any format, in the file's own units, wherever they are.
#[test]
fn coordinates_are_colours() {
    let folder = Folder::new();
    let mut text = String::new();
    for (_, [x, y, z]) in corners() {
        text += &format!(
            "v {} {} {z}\n",
            500_000.125 + f64::from(x),
            4_000_000.5 + f64::from(y)
        );
    }
    folder.write("a.obj", &format!("{text}f 1 2 3 4\nf 5 6 7 8\nf 9 10 11 12\n"));
    folder
        .run_line("a.obj --color-by x -s 8x8 -q --json a.json")
        .succeeded();
    let json: Value = serde_json::from_str(&fs::read_to_string(folder.path("a.json")).unwrap()).unwrap();
    let legend = serde_json::json!({
        "name": "x", "of": "vertices", "map": "viridis", "low": 500_000.125, "high": 500_005.125
    });
    assert_eq!(json["color_by"], legend);
    for mesh in ["vase.obj", "gear.stl", "stairs.3mf", "mobile.gltf", "helix.ply"] {
        let picture = |options: &str| {
            let mesh = shipped_mesh(mesh);
            let line = [&["render", &mesh, "-s", "40x30", "-q", "-o", "a.ppm"][..]].concat();
            let words: Vec<&str> = line.into_iter().chain(options.split_whitespace()).collect();
            folder.run(&words).succeeded();
            fs::read(folder.path("a.ppm")).unwrap()
        };
        let by_z = picture("--color-by z");
        assert!(by_z != picture(""), "{mesh}");
        assert!(by_z == picture("--color-by z --color-map viridis"), "{mesh}");
        assert!(by_z != picture("--color-by x"), "{mesh}");
    }
}

#[test]
fn points_have_colours() {
    let folder = Folder::new();
    let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                property float scalar_Intensity\nend_header\n0.5 0.5 0 -4\n2.5 0.5 0 -2\n4.5 0.5 0 0\n";
    folder.write("a.ply", text);
    let line = "a.ply --color-by scalar_Intensity --point-size 0.8";
    assert_near(shown(&folder, line), VIRIDIS, "points");
    let lines = text.replace(
        "end_header",
        "element edge 2\nproperty int vertex1\nproperty int vertex2\nend_header",
    );
    folder.write("a.ply", &format!("{lines}0 1\n1 2\n"));
    assert_near(shown(&folder, line), VIRIDIS, "lines");
}

#[test]
fn info_lists_numbers() {
    let folder = Folder::new();
    let text = squares(Some(["-1", "nan", "4.1"]), Some(["inf", "inf", "nan"]));
    folder.write("a.ply", &text.replacen("double q", "double radius", 1));
    let info = folder.run_line("info a.ply");
    assert_contains(
        info.succeeded().text(),
        &[
            "\nscalar             \"radius\" of vertices, -1 to 4.1\nscalar             \"q\" of faces, no finite number\n",
        ],
    );
    let json: Value = serde_json::from_str(folder.run_line("info a.ply --json=-").text()).unwrap();
    assert_eq!(
        json["scalars"],
        serde_json::json!([
            {"name": "radius", "of": "vertices", "low": -1.0, "high": 4.1},
            {"name": "q", "of": "faces", "low": null, "high": null}
        ])
    );
    let piped = folder.shell("\"$0\" info - < a.ply");
    assert_contains(piped.succeeded().text(), &["\"radius\" of vertices, -1 to 4.1"]);
    let bare = folder.run_line("info a.scn --json=-");
    assert!(bare.text().contains("\"scalars\":[]"), "{bare:?}");
    let stats = folder.run_line("a.ply -s 8x8 --color-by radius --color-map reds --stats");
    assert_contains(
        &stats.stderr,
        &["colours     \"radius\" of vertices, -1 to 4.1, reds\n"],
    );
}

#[test]
fn numbers_that_are_not_there() {
    let folder = Folder::new();
    let text = squares(Some(["1", "2", "3"]), Some(["1", "2", "3"]));
    let text = text.replacen("double q", "double a\u{1b}[1m\u{e9}", 1);
    folder.write("a.ply", &text);
    folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let list = text.replace("property double q\n", "property list uchar float q\n");
    folder.write("c.ply", &list.replace(" 1\n4", " 1 1\n4"));
    let words = "a.ply: no scalar property `nx`: the file has `a\\u{1b}[1m\u{e9}` of vertices and `q` of faces; x, y and z are the \
                 coordinates";
    for (file, options, code, words) in [
        ("a.ply", "--color-by nx", 2, words),
        (
            "b.obj",
            "--color-by q",
            2,
            "no scalar property `q`: the file has none; x, y and z",
        ),
        (
            "c.ply",
            "--color-by q",
            2,
            "`q` of faces is a list, expected one number for each",
        ),
        ("a.scn", "--color-by z", 2, "--color-by applies to meshes only"),
        ("b.obj", "--color-map turbo", 2, "--color-by"),
        ("b.obj", "--color-range 0,1", 2, "--color-by"),
        ("b.obj", "--color-by z --color-map hot", 2, "viridis"),
        (
            "b.obj",
            "--color-by z --color-range 1,1",
            2,
            "two different numbers LOW,HIGH",
        ),
        (
            "b.obj",
            "--color-by z --color-range nan,1",
            2,
            "two finite numbers LOW,HIGH",
        ),
        (
            "b.obj",
            "--color-by z --color-range 1",
            2,
            "two finite numbers LOW,HIGH",
        ),
        (
            "b.obj",
            "--color-by z --color-range 1 2",
            2,
            "write --color-range 1,2",
        ),
        ("b.obj", "--cmap turbo", 2, "--color-map MAP"),
    ] {
        let arguments: Vec<&str> = [file].into_iter().chain(options.split(' ')).collect();
        folder.fails(&arguments, code, words);
    }
    folder.write("big.ply", &squares(Some(["1", "2", "3"]), None));
    let cut = squares(Some(["1", "2", "x"]), None);
    folder.write("word.ply", &cut);
    let run = folder.run_line("word.ply --color-by q");
    assert_contains(
        &run.stderr,
        &["error: word.ply:22:15: `q` of vertex 9 of 12 is `x`, expected a number\n"],
    );
    let piped = folder.shell("\"$0\" - --color-by q -s 8x8 -o p.png < big.ply");
    piped.succeeded();
    let scene = folder.shell("\"$0\" - --color-by q -s 8x8 -o p.png < a.scn");
    scene.failed(2, "--color-by applies to meshes only");
    // A default of the config file applies to meshes only.
    folder.write(
        "o.toml",
        "color-by = \"z\"\ncolor-map = \"turbo\"\ncolor-range = [0, 2]\n",
    );
    for input in ["a.scn", "b.obj"] {
        folder
            .run(&[input, "--config", "o.toml", "-s", "8x8", "-q"])
            .succeeded();
    }
}

/// Frames of an animation have one range.
#[test]
fn frames_have_one_legend() {
    let folder = Folder::new();
    folder.write("swing.gltf", crate::crops::SWING);
    let run = folder.run_line("swing.gltf --color-by y -s 16x16 --fps 2 --frames 1-3 -o f#.png -q --json=-");
    let lines = run.succeeded().text().lines();
    let legends: Vec<Value> = lines
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["color_by"].clone())
        .collect();
    assert!(
        legends.len() > 1 && legends.iter().all(|legend| *legend == legends[0]),
        "{legends:?}"
    );
    assert!(
        legends[0]["low"].as_f64() < legends[0]["high"].as_f64(),
        "{legends:?}"
    );
    let pixel = |name: &str| {
        *image::open(folder.path(name))
            .unwrap()
            .into_rgb8()
            .get_pixel(8, 8)
    };
    assert_ne!(pixel("f1.png"), Rgb([0; 3]));
}
