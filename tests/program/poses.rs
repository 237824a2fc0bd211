//! Cameras of NeRF data sets.

use crate::program::Folder;
use std::fs;

const SMALL: &str = "--size=40x30";

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The pictures of a turntable again, from the poses that it saved.
#[test]
fn saved_poses_make_the_same_pictures() {
    let folder = Folder::new();
    fs::create_dir(folder.path("train")).expect("a folder");
    let turn = [
        "a.scn",
        SMALL,
        "--turntable=4",
        "-o",
        "train/r_#.png",
        "--save-poses=transforms.json",
    ];
    folder.run(&turn).succeeded();
    let text = String::from_utf8(read(&folder, "transforms.json")).expect("text");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(
        (&json["w"], &json["h"], &json["frames"][2]["file_path"]),
        (&40.into(), &30.into(), &"train/r_3.png".into())
    );
    folder
        .run(&["a.scn", SMALL, "--poses=transforms.json", "-o", "{pose}.png"])
        .succeeded();
    for i in 1..=4 {
        let [first, again] = [format!("train/r_{i}.png"), format!("r_{i}.png")]
            .map(|name| image::open(folder.path(&name)).expect("a picture").into_rgb8());
        // Directions may differ in their last bits.
        let same = first.pixels().zip(again.pixels()).filter(|(a, b)| a == b).count();
        assert!(same >= 40 * 30 * 99 / 100, "{i}: {same}");
    }
    // Some of them, by number; a film.
    folder
        .run(&[
            "a.scn",
            SMALL,
            "--poses=transforms.json",
            "--frames=2-3",
            "-o",
            "p#.png",
        ])
        .succeeded();
    assert_eq!(read(&folder, "p2.png"), read(&folder, "r_2.png"));
    assert!(!folder.names().contains(&"p1.png".to_owned()));
    folder
        .run(&["a.scn", SMALL, "--poses=transforms.json", "-o", "p.gif"])
        .succeeded();
    // Without -o, by number.
    folder
        .run(&["a.scn", SMALL, "--poses=transforms.json"])
        .succeeded();
    assert_eq!(read(&folder, "a-0004.png"), read(&folder, "r_4.png"));
}

/// Names of poses are no patterns, and an animation holds all of them.
#[test]
fn names_of_poses() {
    let folder = Folder::new();
    let matrix = r#""transform_matrix":[[1,0,0,0],[0,0,-1,-4],[0,1,0,0],[0,0,0,1]]"#;
    let frames = ["a#b.png", "{stem}.png", "c.png"]
        .map(|name| format!(r#"{{"file_path":"{name}",{matrix}}}"#))
        .join(",");
    // As an editor of Windows writes it.
    folder.write(
        "t.json",
        &format!("\u{feff}{{\"camera_angle_x\":0.8,\"frames\":[{frames}]}}"),
    );
    let call = "a.scn --size 8x6 --poses t.json";
    folder.run_line(&format!("{call} -o h_{{pose}}.png")).succeeded();
    assert_eq!(
        folder.names(),
        ["a.scn", "h_a#b.png", "h_c.png", "h_{stem}.png", "t.json"]
    );
    let run = folder.run_line(&format!(
        "{call} -o again.png --frames 1 --compare h_{{pose}}.png"
    ));
    assert!(run.stderr.contains("again.png agrees with h_a#b.png"), "{run:?}");
    for (options, words) in [
        ("-o {pose}.gif", "leave out {pose}"),
        (
            "-o {pose}.png --sheet 2",
            "leave out {stem}, {folder}, {pose} and #",
        ),
    ] {
        let line = format!("{call} {options}");
        folder.fails(&line.split(' ').collect::<Vec<_>>(), 2, words);
    }
}

/// The paths in the file lead from its own folder to the pictures, whatever way they were named.
#[test]
fn saved_paths_start_at_the_file_of_poses() {
    let folder = Folder::new();
    for inner in ["out", "poses", "out/deep"] {
        fs::create_dir(folder.path(inner)).expect("a folder");
    }
    let absolute = |name: &str| folder.path(name).to_str().expect("UTF-8").to_owned();
    for (output, poses, expected) in [
        ("out/a#.png", "out/t.json", "a1.png"),
        ("out/a#.png", "t.json", "out/a1.png"),
        ("out/a#.png", "./out/t.json", "a1.png"),
        ("out/a#.png", &absolute("out/t.json"), "a1.png"),
        (&absolute("out/a#.png"), "t.json", "out/a1.png"),
        (&absolute("out/a#.png"), "out/t.json", "a1.png"),
        ("out/a#.png", "poses/t.json", "../out/a1.png"),
        ("./out/a#.png", "out/t.json", "a1.png"),
        ("a#.png", "out/t.json", "../a1.png"),
        ("a#.png", "out/deep/t.json", "../../a1.png"),
        ("out/../a#.png", "out/t.json", "../a1.png"),
    ] {
        folder
            .run(&[
                "a.scn",
                "--size=8x6",
                "--turntable=1",
                "--aov=mask",
                "-o",
                output,
                "--save-poses",
                poses,
            ])
            .succeeded();
        let text = String::from_utf8(read(&folder, poses)).expect("text");
        let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let frame = &json["frames"][0];
        assert_eq!(frame["file_path"], expected, "{output} {poses}");
        for key in ["file_path", "mask_path"] {
            let path = frame[key].as_str().expect("a path");
            let file = folder.path(poses).parent().expect("a folder").join(path);
            assert!(file.is_file(), "{output} {poses}: {path}");
        }
        fs::remove_file(folder.path(poses)).expect("written above");
    }
    // A file of poses outside of the working directory.
    let other = Folder::new();
    let poses = other.path("t.json");
    let poses = poses.to_str().expect("UTF-8");
    folder
        .run(&[
            "a.scn",
            "--size=8x6",
            "--turntable=1",
            "-o",
            "b#.png",
            "--save-poses",
            poses,
        ])
        .succeeded();
    let text = fs::read_to_string(poses).expect("text");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let path = json["frames"][0]["file_path"].as_str().expect("a path");
    assert!(path.starts_with("../") && other.path(path).is_file(), "{path}");
}

/// A data set of a made-up sphere of views, with what programs read beside the colours.
#[test]
fn a_sphere_of_views_is_a_data_set() {
    let folder = Folder::new();
    folder.write(
        "b.scn",
        "light 0 0 90 1\ncamera eye 0 -5 0 target 0 0 0\nsphere 0 0 0 1\ninstance m.obj\ninstance m.obj translate -4 0 0\n",
    );
    folder.write("m.obj", "v 2 -1 -1\nv 2 1 -1\nv 2 0 1\nf 1 2 3\n");
    let call = "b.scn --size 40x30 --sphere 5 --aov mask,z,instance --save-poses t.json";
    folder.run_line(&format!("{call} -o r_#.png")).succeeded();
    let text = String::from_utf8(read(&folder, "t.json")).expect("text");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["integer_depth_scale"], 0.001);
    let mut instances = [0; 4];
    for i in 0..5 {
        let frame = &json["frames"][i];
        let open = |key: &str| {
            let name = frame[key].as_str().unwrap_or_else(|| panic!("{frame}: no {key}"));
            image::open(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
        };
        assert_eq!(frame["depth_path"], frame["depth_file_path"]);
        let name = format!("r_{}.instance.png", i + 1);
        let instance = image::open(folder.path(&name)).expect("a picture");
        let (mask, z) = (open("mask_path"), open("depth_file_path"));
        let (Some(mask), Some(z), Some(instance)) = (mask.as_luma8(), z.as_luma16(), instance.as_luma16())
        else {
            panic!("grey pictures, of 8, 16 and 16 bits");
        };
        for ((mask, z), instance) in mask.pixels().zip(z.pixels()).zip(instance.pixels()) {
            assert!([0, 255].contains(&mask.0[0]));
            assert_eq!(mask.0[0] == 0, instance.0[0] == 0);
            assert_eq!(mask.0[0] == 0, z.0[0] == 0);
            instances[usize::from(instance.0[0])] += 1;
        }
        // Around the axis, a sphere's depth along the view is its distance. The middle is between four pixels.
        let eye: f64 = (0..3)
            .map(|row| {
                frame["transform_matrix"][row][3]
                    .as_f64()
                    .expect("a number")
                    .powi(2)
            })
            .sum();
        assert!((eye.sqrt() - 5.0).abs() < 1e-9, "{frame}");
        if instance.get_pixel(20, 15).0[0] == 1 {
            assert!((4000..4020).contains(&z.get_pixel(20, 15).0[0]), "{frame}");
        }
    }
    assert!(instances.iter().all(|&count| count > 0), "{instances:?}");
    folder.fails(
        &["a.scn", "--aov=z", "-o", "a.qoi"],
        2,
        "--aov z: QOI does not hold its numbers",
    );
    folder.fails(&["a.scn", "--sphere=3", "--turntable=3"], 2, "--turntable");
}

/// A zoom has no single focal length: each frame has its own.
#[test]
fn a_zoom_has_intrinsics_for_each_frame() {
    let folder = Folder::new();
    let zoom = "light 0 0 9 1\nsphere 0 0 0 1\ncamera eye 0 -9 0 target 0 0 0 fov 30\n  at 1 fov 30\n  at 2 fov 50\n";
    folder.write("zoom.scn", zoom);
    let line = format!("zoom.scn --save-poses=t.json --frames=1-2 -o z#.png {SMALL}");
    folder.run_line(&line).succeeded();
    let json = json(&folder, "t.json");
    assert!(json["fl_x"].is_null() && json["w"].is_null(), "{json}");
    for (i, fov) in [30.0_f64, 50.0].into_iter().enumerate() {
        let frame = &json["frames"][i];
        let fl_y = frame["fl_y"].as_f64().expect("a number");
        assert!(
            (fl_y - 15.0 / (fov / 2.0).to_radians().tan()).abs() < 1e-9,
            "{frame}"
        );
        assert_eq!((&frame["w"], &frame["h"]), (&40.into(), &30.into()));
    }
    let line = format!("zoom.scn --poses=t.json -o again-#.png {SMALL}");
    folder.run_line(&line).succeeded();
    assert_eq!(read(&folder, "again-1.png"), read(&folder, "z1.png"));
}

/// Points, small spheres around them, and how a camera at (0, -5, 0) that looks along y sees them, by the pinhole model of
/// COLMAP and Nerfstudio: pixel centres are at half numbers.
const POINTS: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [0.6, 1.0, -0.5],
    [-0.7, 0.5, 0.4],
    [0.4, -0.5, 0.45],
];

/// Focal lengths and principal point of a lens that is neither centred nor has square pixels, in a picture of 320x240.
const STRANGE: [f64; 4] = [420.0, 350.0, 190.0, 101.5];

/// The files of [`POINTS`] and [`STRANGE`].
fn strange_folder() -> Folder {
    let folder = Folder::new();
    let spheres = POINTS
        .map(|[x, y, z]| format!("sphere {x} {y} {z} 0.02\n"))
        .concat();
    let scene = "camera eye 0 -5 0 target 0 0 0\nbackground 0 0 0\nambient 1\nmaterial matte cd 1 1 1\n";
    folder.write("p.scn", &format!("{scene}{spheres}"));
    let lens = STRANGE.map(|number| number.to_string()).join(" ");
    fs::create_dir(folder.path("sparse")).expect("a folder");
    folder.write("sparse/cameras.txt", &format!("1 PINHOLE 320 240 {lens}\n"));
    // A turn by 90 degrees about x: y of the scene is z of the camera, and z is up.
    let half = 0.5_f64.sqrt();
    folder.write(
        "sparse/images.txt",
        &format!("1 {half} {half} 0 0 0 0 5 1 c.png\n\n"),
    );
    folder
}

fn json(folder: &Folder, name: &str) -> serde_json::Value {
    serde_json::from_slice(&read(folder, name)).expect("JSON")
}

/// The centre of what is bright within some pixels of a point.
pub fn spot(picture: &image::RgbImage, [x, y]: [f64; 2]) -> [f64; 2] {
    let mut sums = [0.0; 3];
    for (i, j, pixel) in picture.enumerate_pixels() {
        let at = [f64::from(i) + 0.5, f64::from(j) + 0.5];
        if (at[0] - x).abs() < 6.0 && (at[1] - y).abs() < 6.0 {
            let weight = f64::from(pixel.0[0]);
            for (sum, value) in sums.iter_mut().zip([at[0], at[1], 1.0]) {
                *sum += weight * value;
            }
        }
    }
    [sums[0] / sums[2], sums[1] / sums[2]]
}

#[test]
fn off_centre_and_stretched_cameras_project_exactly() {
    let folder = strange_folder();
    // The size is that of the file, at first.
    for (options, scale) in [("", 1.0), ("--size 640x480", 2.0)] {
        let line = format!(
            "p.scn --poses sparse -o {{pose}}.png --samples 64 --aov z --save-poses t.json {options}"
        );
        folder.run_line(&line).succeeded();
        let picture = image::open(folder.path("c.png")).expect("a picture").into_rgb8();
        let depth = image::open(folder.path("c.z.png")).expect("a picture");
        let size = (picture.width(), picture.height());
        assert_eq!(size, ((320.0 * scale) as u32, (240.0 * scale) as u32));
        let [fl_x, fl_y, cx, cy] = STRANGE.map(|number| number * scale);
        for [x, y, z] in POINTS {
            let expected = [fl_x * x / (y + 5.0) + cx, fl_y * -z / (y + 5.0) + cy];
            let found = spot(&picture, expected);
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            assert!(off < 0.05, "{x} {y} {z}: {expected:?} {found:?}");
            let steps = depth.as_luma16().expect("16 bits");
            let steps = steps.get_pixel(expected[0] as u32, expected[1] as u32).0[0];
            let z = f64::from(steps) * 0.001;
            assert!((z - (y + 5.0 - 0.02)).abs() < 0.01, "{x} {y}: {z}");
        }
        let saved = json(&folder, "t.json");
        for (key, expected) in [("fl_x", fl_x), ("fl_y", fl_y), ("cx", cx), ("cy", cy)] {
            let found = saved[key].as_f64().expect("a number");
            assert!((found - expected).abs() < 1e-9, "{key}: {found}");
        }
    }
    folder
        .run_line("p.scn --poses t.json -o again.png --samples 64")
        .succeeded();
    assert_eq!(read(&folder, "again.png"), read(&folder, "c.png"));
}

/// Crops put together and every mode have the pixels of the whole.
#[test]
fn off_centre_and_stretched_cameras_have_the_same_pixels_everywhere() {
    let folder = strange_folder();
    folder.write(
        "sparse/t.scn",
        "light 3 -6 5 0.6\nambient 0.1\nmaterial matte cd 0.7 0.6 0.5\nsphere 0 0 0 0.7\nplane 0 0 -0.6 normal 0 0 1\n",
    );
    let scene = "sparse/t.scn --poses sparse --samples 4 --filter tent";
    folder.run_line(&format!("{scene} -o whole.png")).succeeded();
    folder
        .run_line(&format!("{scene} --mode scalar -o scalar.png"))
        .succeeded();
    assert_eq!(read(&folder, "scalar.png"), read(&folder, "whole.png"));
    for (name, crop) in [
        ("a", "0,0,117,240"),
        ("b", "117,0,320,131"),
        ("c", "117,131,320,240"),
    ] {
        folder
            .run_line(&format!("{scene} --crop {crop} -o {name}.png"))
            .succeeded();
    }
    folder
        .run_line("merge a.png b.png c.png -o merged.png")
        .succeeded();
    assert_eq!(read(&folder, "merged.png"), read(&folder, "whole.png"));
}

/// A call that succeeds with one warning.
fn warned(folder: &Folder, line: &str, words: &str) {
    let run = folder.run_line(line);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.stderr.contains(words), "expected {words:?}: {run:?}");
    assert_eq!(run.stderr.matches("warning:").count(), 1, "{run:?}");
}

/// Without --size the file's size counts, if it is one.
#[test]
fn pictures_have_the_size_of_the_file() {
    let folder = Folder::new();
    let matrix = r#""transform_matrix":[[1,0,0,0],[0,0,-1,-4],[0,1,0,0]]"#;
    let file = |first: &str, second: &str| {
        format!(r#"{{"camera_angle_x":0.8,"frames":[{{{first}{matrix}}},{{{second}{matrix}}}]}}"#)
    };
    let size = |name: &str| image::image_dimensions(folder.path(name)).expect("a picture");
    let (small, other) = (r#""w":40,"h":30,"#, r#""w":30,"h":30,"#);
    folder.write("one.json", &file(small, small));
    folder.run_line("a.scn --poses one.json -o one#.png").succeeded();
    assert_eq!(size("one1.png"), (40, 30));
    warned(
        &folder,
        "a.scn --poses one.json -o one#.png --size 32x32",
        "pictures of 40x30, another shape than 32x32",
    );
    assert_eq!(size("one2.png"), (32, 32));
    folder.write("two.json", &file(small, other));
    warned(
        &folder,
        "a.scn --poses two.json -o two#.png",
        "pictures of 40x30 and 30x30, but all are rendered with 512x512: give --size",
    );
    assert_eq!(size("two1.png"), (512, 512));
    folder.write(
        "huge.json",
        &file(r#""w":4000000,"h":4000000,"#, r#""w":4000000,"h":4000000,"#),
    );
    folder
        .run_line("a.scn --poses huge.json -o huge#.png")
        .failed(1, "4000000");
}

/// Depth that 16 bits of thousandths do not hold.
#[test]
fn depth_has_a_step() {
    let folder = Folder::new();
    folder.write(
        "far.scn",
        "light 0 0 900 1\ncamera eye 0 -500 0 target 0 0 0\nsphere 0 0 0 100\n",
    );
    let call = "far.scn --size 41x41 --turntable 2 --aov z,mask --save-poses t.json -o r#.png";
    let depth = |name: &str| {
        let picture = image::open(folder.path(name)).expect("a picture");
        picture.as_luma16().expect("16 bits").get_pixel(20, 20).0[0]
    };
    let warning = "pixels of r1.z.png are farther than 65.535 units and have depth 0: use a larger --z-step, or an .exr";
    warned(&folder, call, warning);
    assert_eq!((depth("r1.z.png"), depth("r2.z.png")), (0, 0));
    assert_eq!(json(&folder, "t.json")["integer_depth_scale"], 0.001);
    folder.run_line(&format!("{call} --z-step 0.01")).succeeded();
    assert_eq!((depth("r1.z.png"), depth("r2.z.png")), (40000, 40000));
    assert_eq!(json(&folder, "t.json")["integer_depth_scale"], 0.01);
    // Tasks of a job have the same step, and EXR pictures no limit.
    folder
        .run_line("job far.scn --size 41x41 --aov z --z-step 0.01 -o p.png --for parallel --into job")
        .succeeded();
    let commands = String::from_utf8(read(&folder, "job/commands.txt")).expect("text");
    assert!(commands.contains("--z-step=0.01"), "{commands}");
    folder
        .run_line("far.scn --size 41x41 --aov z -o r.exr")
        .succeeded();
    for step in ["0", "-1", "nan", "inf", "1e-320", "x"] {
        folder.fails(
            &["far.scn", "--aov=z", &format!("--z-step={step}")],
            2,
            "--z-step",
        );
    }
}

/// Components of normals are rounded to the nearest byte.
#[test]
fn normals_are_rounded() {
    let folder = Folder::new();
    folder.write(
        "n.scn",
        "light 0 0 9 1\ncamera eye 0 0 5 target 0 0 0 up 0 1 0\ntriangle -9 -9 0  9 -9 0  0 9 0\n",
    );
    folder
        .run_line("n.scn --size 9x9 --aov normal -o n.png")
        .succeeded();
    let normals = image::open(folder.path("n.normal.png"))
        .expect("a picture")
        .into_rgb8();
    assert_eq!(normals.get_pixel(4, 4).0, [128, 128, 255]);
}

#[test]
fn broken_poses_are_refused() {
    let folder = Folder::new();
    folder.write("bad.json", "{\n  \"frames\": [1]\n}");
    folder.write("empty.json", "{\"frames\": []}");
    folder.fails(&["a.scn", "--poses=bad.json"], 1, "bad.json:2:");
    folder.fails(&["a.scn", "--poses=empty.json"], 1, "0 frames");
    folder.fails(&["a.scn", "--poses=no.json"], 1, "no.json");
    folder.fails(&["a.scn", "--poses=."], 1, "this is a directory");
    #[cfg(unix)]
    folder.fails(&["a.scn", "--poses=/dev/zero"], 1, "a pipe or a device");
    folder.fails(&["a.scn", "--poses=bad.json", "--turntable=3"], 2, "--turntable");
    folder.fails(&["a.scn", "--poses=bad.json", "--fov=30"], 2, "--fov");
    folder.fails(&["a.scn", "--save-poses=no/t.json"], 1, "does not exist");
    folder.fails(
        &["a.scn", "a.scn", "-o", "{stem}.png", "--save-poses=t.json"],
        2,
        "",
    );
    let each = "--save-poses needs a file for each picture";
    for (options, code, words) in [
        ("--crop=0,0,3,3 -o b.png", 2, "--crop"),
        ("--sheet=2 --turntable=2", 2, "--sheet"),
        ("--turntable=2 -o b.gif", 2, each),
        ("-o -", 2, each),
        ("--json=./t.json -o b.png", 2, "both the poses and the JSON"),
    ] {
        let line = format!("a.scn --save-poses=t.json {SMALL} {options}");
        folder.fails(&line.split(' ').collect::<Vec<_>>(), code, words);
    }
    folder.fails(
        &["a.scn", "--ortho=2", "--save-poses=t.json", SMALL],
        2,
        "orthographic",
    );
}
