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
    assert!(
        path.starts_with("../") && other.path(path).is_file(),
        "{path}"
    );
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
        ("--skip-existing -o b.png", 2, "--skip-existing"),
        ("--turntable=2 -o b.gif", 2, each),
        ("-o -", 2, each),
        ("--json=./t.json -o b.png", 2, "both the poses and the JSON"),
    ] {
        let line = format!("a.scn --save-poses=t.json {SMALL} {options}");
        folder.fails(&line.split(' ').collect::<Vec<_>>(), code, words);
    }
    // A zoom has no single focal length.
    let zoom = "light 0 0 9 1\nsphere 0 0 0 1\ncamera eye 0 -9 0 target 0 0 0 fov 30\n  at 1 fov 30\n  at 2 fov 50\n";
    folder.write("zoom.scn", zoom);
    let zoom = folder.run_line(&format!(
        "zoom.scn --save-poses=t.json --frames=1-2 -o z#.png {SMALL}"
    ));
    zoom.failed(1, "different fields of view");
    assert!(!folder.path("t.json").exists());
    folder.fails(
        &["a.scn", "--ortho=2", "--save-poses=t.json", SMALL],
        1,
        "orthographic",
    );
}
