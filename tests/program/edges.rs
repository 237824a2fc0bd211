//! `--edges` on the command line, in the config file, and in series of pictures.

use crate::program::{Folder, shipped_mesh};
use std::fs;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
const SIZE: &str = "--size=24x16";

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The bytes of a picture of `a.obj` with some options.
fn triangle(folder: &Folder, options: &str) -> Vec<u8> {
    folder.write("a.obj", TRIANGLE);
    folder
        .run_line(&format!("a.obj -o a.ppm {SIZE} {options}"))
        .succeeded();
    read(folder, "a.ppm")
}

#[test]
fn a_width_may_follow_and_a_color_needs_edges() {
    let folder = Folder::new();
    let [without, one, two] = ["", "--edges", "--edges=2"].map(|options| triangle(&folder, options));
    assert!(without != one && one != two);
    assert!(one == triangle(&folder, "--edges 1") && two == triangle(&folder, "--edges 2.0"));
    assert!(two != triangle(&folder, "--edges=2 --edge-color=ff0000"));
    // A word that is no number is a file.
    folder
        .run_line(&format!("-o b.ppm {SIZE} --edges a.obj"))
        .succeeded();
    assert!(one == read(&folder, "b.ppm"));
    for (options, words) in [
        ("--edges 0", "expected a number of pixels above 0 and at most 100"),
        ("--edges=nan", "expected a number of pixels"),
        ("--edges=-1", "expected a number of pixels"),
        ("--edges=100.1", "expected a number of pixels"),
        ("--edges=", "--edges"),
        ("--edge-color red --edges", "six hexadecimal digits"),
        ("--edge-color ff0000", "--edges"),
    ] {
        let line = format!("a.obj {options}");
        folder.fails(&line.split(' ').collect::<Vec<_>>(), 2, words);
    }
}

/// In the config file, an option with an optional value is also a switch.
#[test]
fn edges_are_a_default() {
    let folder = Folder::new();
    for (defaults, options) in [
        (
            "edges = true\nedge-color = 'ff0000'",
            "--edges --edge-color=ff0000",
        ),
        ("edges = 2.5", "--edges 2.5"),
        ("edges = '2.5'", "--edges 2.5"),
        ("edges = false\nedge-color = 'ff0000'", ""),
    ] {
        folder.write("edges.toml", defaults);
        let made = triangle(&folder, "--config=edges.toml");
        assert!(made == triangle(&folder, options), "{defaults}");
    }
    // An option of the command line may need one of the file.
    folder.write("edges.toml", "edges = 2");
    let made = triangle(&folder, "--config=edges.toml --edge-color=ff0000");
    assert!(made == triangle(&folder, "--edges=2 --edge-color=ff0000"));
    folder.write("none.toml", "ground = false");
    for config in ["--config=none.toml", "--no-config"] {
        folder.fails(&["a.obj", config, "--edge-color=ff0000"], 2, "--edges");
    }
    folder.write("edges.toml", "edges = 'wide'");
    let run = folder.run(&["a.obj", "--config=edges.toml"]);
    assert!(
        run.code == Some(1) && run.stderr.contains("edges.toml:1:9: invalid value"),
        "{run:?}"
    );
}

/// The bytes of a colour's edges are those of the colour, with the sRGB curve and without.
#[test]
fn edges_have_their_color() {
    let folder = Folder::new();
    for transfer in ["--srgb", "--linear"] {
        let options =
            format!("--samples=1 --edges=3 --edge-color=0180fe {transfer} --eye .5,0,.5 --target .5,0,0");
        let bytes = triangle(&folder, &options);
        let pixels = bytes[bytes.len() - 24 * 16 * 3..].chunks(3);
        assert!(pixels.clone().any(|pixel| pixel == [1, 0x80, 0xfe]), "{transfer}");
    }
}

/// Octray's own triangles have none: of the ground and of lines.
#[test]
fn grounds_and_lines_have_no_edges() {
    let folder = Folder::new();
    folder.write("lines.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2 3\n");
    folder.write(
        "lines.scn",
        "light 3 -2 5 0.7\ncamera eye 3 -3 2 target 0 0 0\nmesh lines.obj\ninstance lines.obj scale 2\n",
    );
    let below = format!(
        "{} --ground --eye 0,0.4,9 --target 0,-4,0 --fov 5",
        shipped_mesh("cube.ply")
    );
    for input in ["lines.obj", "lines.scn", &below] {
        let [without, with] = ["", "--edges=5"].map(|options| {
            folder
                .run_line(&format!("{input} -o made.ppm --force {SIZE} {options}"))
                .succeeded();
            read(&folder, "made.ppm")
        });
        assert!(without == with, "{input}");
    }
}

/// Every picture of a series has them, and a job's tasks, too.
#[test]
fn edges_in_series() {
    let folder = Folder::new();
    let cube = shipped_mesh("cube.ply");
    for (options, name) in [
        ("--turntable 3 --frames 2-2 -o turn-#.png", "turn-2.png"),
        ("--sheet 1 -o sheet.png", "sheet.png"),
    ] {
        let [without, with] = ["", "--edges=2"].map(|edges| {
            folder
                .run_line(&format!("{cube} {SIZE} {options} {edges}"))
                .succeeded();
            read(&folder, name)
        });
        assert!(without != with, "{options}");
    }
    folder
        .run_line(&format!("job {cube} --for parallel --into job --edges {SIZE}"))
        .succeeded();
    let tasks = folder.path("job").read_dir().unwrap();
    let texts = tasks.filter_map(|file| fs::read_to_string(file.unwrap().path()).ok());
    assert!(texts.into_iter().any(|text| text.contains("--edges=1")));
}
