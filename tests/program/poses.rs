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
    folder.fails(
        &["a.scn", "--ortho=2", "--save-poses=t.json", SMALL],
        1,
        "orthographic",
    );
}
