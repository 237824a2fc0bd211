//! `--save-poses` of data sets that several calls make.

use crate::program::Folder;
use std::fs;

const CALL: &str = "a.scn --size=12x9 --sphere=5 --aov=mask,z -o r_#.png --save-poses t.json";

fn read(folder: &Folder, name: &str) -> String {
    fs::read_to_string(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The file that one call writes for all pictures. Removes it and the pictures.
fn whole(folder: &Folder, call: &str) -> String {
    folder.run_line(call).succeeded();
    let text = read(folder, "t.json");
    for name in folder.names() {
        if name == "t.json" || name.starts_with("r_") {
            fs::remove_file(folder.path(&name)).expect("a file");
        }
    }
    text
}

/// Each part of the frames lists all pictures, and so does a call that skips some or all of them.
#[test]
fn parts_write_the_file_of_the_whole() {
    let folder = Folder::new();
    let expected = whole(&folder, CALL);
    assert_eq!(expected.matches("mask_path").count(), 5);
    for options in ["--frames=2-3", "--frames=5", "--skip-existing", "--skip-existing"] {
        folder.run_line(&format!("{CALL} {options}")).succeeded();
        assert_eq!(read(&folder, "t.json"), expected, "{options}");
        fs::remove_file(folder.path("t.json")).expect("a file");
    }
    // Pictures that this call does not render are not replaced either.
    for file in ["r_1.png", "r_1.mask.png"] {
        let call = CALL.replace("t.json", file);
        let call = format!("{call} --skip-existing");
        folder.fails(
            &call.split(' ').collect::<Vec<_>>(),
            2,
            "both a picture and the poses",
        );
    }
    folder.fails(
        &[
            "a.scn",
            "--turntable=2",
            "-o=r.gif",
            "--skip-existing",
            "--save-poses=t.json",
        ],
        2,
        "needs a file for each picture",
    );
}

/// Cameras of frames that are not rendered are those at their time.
#[test]
fn parts_of_an_animation() {
    let folder = Folder::new();
    folder.write(
        "a.scn",
        "light 0 0 9 1\nsphere 0 0 0 1\ncamera eye 0 -9 0 target 0 0 0\n  at 1 fov 30\n  at 3 fov 50\n",
    );
    let call = "a.scn --size=12x9 -o r_#.png --save-poses t.json";
    let expected = whole(&folder, call);
    assert_eq!(expected.matches("fl_y").count(), 3);
    folder.run_line(&format!("{call} --frames=2")).succeeded();
    assert_eq!(read(&folder, "t.json"), expected);
    // Poses of a file, too.
    fs::rename(folder.path("t.json"), folder.path("all.json")).expect("a file");
    let call = "a.scn --size=12x9 --poses all.json -o r_{pose}.png --save-poses t.json";
    let expected = whole(&folder, call);
    folder.run_line(&format!("{call} --frames=3")).succeeded();
    assert_eq!(read(&folder, "t.json"), expected);
}

/// A job writes the file itself, with frames and with tiles.
#[test]
fn jobs_save_poses() {
    let folder = Folder::new();
    let expected = whole(&folder, CALL);
    for options in [
        "--chunk 2 --into frames",
        "--tiles 2x1 --into tiles",
        "--frames 2-3 --into some",
    ] {
        let line = format!("job {CALL} --for parallel {options}");
        folder.run_line(&line).succeeded();
        assert_eq!(read(&folder, "t.json"), expected, "{options}");
        let (_, into) = options.rsplit_once(' ').expect("a folder");
        assert!(!read(&folder, &format!("{into}/commands.txt")).contains("save-poses"));
    }
    // All or nothing.
    let line = "job a.scn --ortho=2 -o p.png --save-poses p.json --for parallel --into flat";
    folder.fails(&line.split(' ').collect::<Vec<_>>(), 2, "orthographic");
    let line = "job a.scn -s 8 -o p.png --save-poses a.scn --for parallel --into own";
    folder.fails(&line.split(' ').collect::<Vec<_>>(), 2, "a.scn");
}
