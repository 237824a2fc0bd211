//! Contact sheets, and calls that continue after a broken scene.

use crate::program::Folder;
use image::{Rgb, RgbImage};

const SMALL: &str = "--size=40x30";

fn open(folder: &Folder, name: &str) -> RgbImage {
    image::open(folder.path(name)).expect("a picture").into_rgb8()
}

/// Where the picture of a place begins: cells have 8 pixels around them and a name of 16 rows.
fn corner(column: u32, row: u32) -> [u32; 2] {
    [8 + column * 48, 8 + row * 54]
}

fn holds(sheet: &RgbImage, [left, top]: [u32; 2], picture: &RgbImage) -> bool {
    picture
        .enumerate_pixels()
        .all(|(x, y, pixel)| sheet.get_pixel(left + x, top + y) == pixel)
}

#[test]
fn a_sheet_holds_all_pictures() {
    let folder = Folder::new();
    folder.write("ball.scn", "light 9 -4 10 0.7\nmaterial 1\nsphere 0 0 0.3 0.5\n");
    folder
        .run(&["a.scn", "ball.scn", SMALL, "-o", "{stem}.png"])
        .succeeded();
    let run = folder.run(&["a.scn", "ball.scn", "a.scn", SMALL, "--sheet=2"]);
    run.succeeded();
    let sheet = open(&folder, "sheet.png");
    assert_eq!(sheet.dimensions(), (2 * 48 + 8, 2 * 54 + 8));
    let (a, ball) = (open(&folder, "a.png"), open(&folder, "ball.png"));
    for (place, picture) in [(corner(0, 0), &a), (corner(1, 0), &ball), (corner(0, 1), &a)] {
        assert!(holds(&sheet, place, picture), "{place:?}");
    }
    // Names below, and paper elsewhere.
    let [left, top] = corner(1, 0);
    let is_dark = |y: u32| (left..left + 40).any(|x| sheet.get_pixel(x, y).0[0] < 128);
    assert!((top + 30..top + 46).any(is_dark));
    assert_eq!(*sheet.get_pixel(3, 3), Rgb([255; 3]));
    // Frames of a turntable, too.
    folder
        .run(&["a.scn", SMALL, "--turntable=3", "--sheet=3", "-o", "t.jpg"])
        .succeeded();
    assert_eq!(open(&folder, "t.jpg").dimensions(), (3 * 48 + 8, 54 + 8));
}

#[test]
fn broken_scenes_are_skipped() {
    let folder = Folder::new();
    folder.write("b.scn", "light 9\n");
    folder.write("c.scn", "mesh no.ply\n");
    let all = ["b.scn", "a.scn", "c.scn", "no.scn", SMALL, "--keep-going"];
    let run = folder.run(&[&all[..], &["-o", "{stem}.png"]].concat());
    assert_eq!(run.code, Some(1), "{run:?}");
    let text = &run.stderr;
    for expected in [
        "skipped: b.scn:1:8: ",
        "skipped: c.scn:1:6: ",
        "no.ply",
        "skipped: no.scn: file not found",
        "3 scenes were skipped",
    ] {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert_eq!(folder.names(), ["a.png", "a.scn", "b.scn", "c.scn"]);
    // On a sheet their places are empty.
    let run = folder.run(&["b.scn", "a.scn", SMALL, "--keep-going", "--sheet=2"]);
    assert_eq!(run.code, Some(1), "{run:?}");
    let sheet = open(&folder, "sheet.png");
    assert!(holds(&sheet, corner(1, 0), &open(&folder, "a.png")));
    assert_eq!(*sheet.get_pixel(20, 20), Rgb([255; 3]));
    // Without it, the first fault ends the call.
    let run = folder.run(&["b.scn", "a.scn", SMALL, "--sheet=2", "-o", "s.png"]);
    assert!(run.code == Some(1) && run.stderr.contains("b.scn:1:8"), "{run:?}");
    assert!(!folder.names().contains(&"s.png".to_owned()));
}

#[test]
fn what_sheets_cannot_be_is_refused() {
    let folder = Folder::new();
    for (options, expected) in [
        ("--sheet 0", "0"),
        ("--sheet 2 -o {stem}.png", "leave out {stem}"),
        ("--sheet 2 -o a-#.png", "leave out {stem}, {folder}, {pose} and #"),
        ("--sheet 2 -o a.exr", "8 bits"),
        (
            "--sheet 2 -o a.gif --turntable 3",
            "a sheet is one picture, not an animation",
        ),
        ("--sheet 2 --aov depth", "AOVs"),
        ("--sheet 2 --background transparent", "transparent"),
        ("--sheet 2 --compare a.png", "compared"),
    ] {
        let mut arguments = vec!["a.scn"];
        arguments.extend(options.split(' '));
        folder.fails(&arguments, 2, expected);
    }
    folder.fails(
        &[
            "a.scn",
            "--size=4000x4000",
            "--turntable=400",
            "--sheet=20",
            "--max-memory=2G",
        ],
        1,
        "memory",
    );
    assert_eq!(folder.names(), ["a.scn"]);
}
