//! `octray merge`: merged tiles are the whole picture's file, byte for byte.

use crate::program::{Folder, shipped_mesh};
use std::fs;

/// Width and height of the whole picture, and where it is cut.
const SIZE: &str = "--size=61x43";
const COLUMNS: [u32; 4] = [0, 1, 30, 61];
const ROWS: [u32; 3] = [0, 19, 43];

/// Renders the tiles of `a.scn`, or of another input, and returns their names without extension.
fn render_tiles(folder: &Folder, input: &str, format: &str, options: &str) -> Vec<String> {
    let mut names = Vec::new();
    for y in ROWS.windows(2) {
        for x in COLUMNS.windows(2) {
            let name = format!("tile-{}-{}", x[0], y[0]);
            let crop = format!("--crop={},{},{},{}", x[0], y[0], x[1], y[1]);
            render(
                folder,
                input,
                &format!("{name}.{format}"),
                &format!("{crop} {options}"),
            );
            names.push(name);
        }
    }
    names
}

fn render(folder: &Folder, input: &str, output: &str, options: &str) {
    let mut arguments = vec!["render", input, "-o", output, SIZE, "--quiet"];
    arguments.extend(options.split_whitespace());
    folder.run(&arguments).succeeded();
}

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn tiles_are_the_whole_file_in_every_format() {
    let vase = shipped_mesh("vase.obj");
    for (input, format, options, aovs) in [
        ("a.scn", "png", "", &[][..]),
        (
            "a.scn",
            "png",
            "--aov depth,normal,albedo,id,heat,mask,z,instance --samples 4",
            &["depth", "normal", "albedo", "id", "heat", "mask", "z", "instance"],
        ),
        (
            vase.as_str(),
            "png",
            "--background transparent --aov depth",
            &["depth"],
        ),
        (vase.as_str(), "ppm", "--samples auto:4", &[]),
        ("a.scn", "qoi", "--background transparent --srgb", &[]),
        ("a.scn", "qoi", "", &[]),
        ("a.scn", "bmp", "", &[]),
        ("a.scn", "tiff", "--background transparent", &[]),
        ("a.scn", "tif", "--samples 9", &[]),
        ("a.scn", "exr", "--samples 4", &[]),
        ("a.scn", "exr", "--background transparent", &[]),
        (
            "a.scn",
            "exr",
            "--aov depth,normal,albedo,id,heat,mask,z,instance",
            &[],
        ),
        (
            vase.as_str(),
            "exr",
            "--background transparent --aov id,depth --samples auto:5",
            &[],
        ),
    ] {
        let folder = Folder::new();
        render(&folder, input, &format!("whole.{format}"), options);
        let names = render_tiles(&folder, input, format, options);
        let kinds = std::iter::once(String::new()).chain(aovs.iter().map(|aov| format!(".{aov}")));
        for kind in kinds {
            let output = format!("merged{kind}.{format}");
            // In any order.
            let tiles: Vec<String> = names
                .iter()
                .rev()
                .map(|name| format!("{name}{kind}.{format}"))
                .collect();
            let mut arguments = vec!["merge", "-o", &output];
            arguments.extend(tiles.iter().map(String::as_str));
            folder.run(&arguments).succeeded();
            assert!(
                read(&folder, &output) == read(&folder, &format!("whole{kind}.{format}")),
                "{input} {options}: {output}"
            );
        }
    }
}

/// What is not a crop has no place in its file, and a crop is the same picture for all readers.
#[test]
fn only_crops_say_their_place() {
    for format in ["png", "ppm", "qoi", "bmp", "tiff", "exr"] {
        let folder = Folder::new();
        let (whole, all) = (format!("whole.{format}"), format!("all.{format}"));
        render(&folder, "a.scn", &whole, "");
        render(&folder, "a.scn", &all, "--crop 0,0,61,43");
        let says = |name: &str| {
            let bytes = read(&folder, name);
            let text = b"0,0,61,43 of 61x43, samples 1";
            bytes.windows(text.len()).any(|window| window == text)
        };
        assert!(!says(&whole) && says(&all), "{format}");
        let [whole, all] = [&whole, &all].map(|name| image::open(folder.path(name)).expect("a picture"));
        assert!(whole == all, "{format}");
        folder
            .run_line(&format!("merge all.{format} -o - "))
            .code
            .expect("an end");
    }
}

#[test]
fn overlapping_tiles_may_agree() {
    let folder = Folder::new();
    render(&folder, "a.scn", "whole.png", "");
    render(&folder, "a.scn", "a.png", "--crop 0,0,40,43");
    render(&folder, "a.scn", "b.png", "--crop 20,0,61,43");
    folder.run_line("merge a.png b.png a.png -o c.png").succeeded();
    assert!(read(&folder, "c.png") == read(&folder, "whole.png"));
    let piped = folder.run_line("merge a.png b.png -o -");
    assert!(piped.succeeded().stdout == read(&folder, "whole.png"));
    // A tile is an input.
    folder.fails(
        &["merge", "a.png", "b.png", "-o", "a.png"],
        2,
        "a.png would replace the tile; write to another file",
    );
    folder.write("d.png", "kept");
    folder
        .run_line("merge a.png b.png -o d.png --skip-existing")
        .succeeded();
    assert_eq!(read(&folder, "d.png"), b"kept");
    // Its tiles may be gone.
    folder
        .run_line("merge gone.png -o d.png --skip-existing")
        .succeeded();
    folder.run_line("merge a.png b.png -o d.png").succeeded();
    assert!(read(&folder, "d.png") == read(&folder, "whole.png"));
}

#[test]
fn json_says_what_was_merged() {
    let folder = Folder::new();
    render(&folder, "a.scn", "top.png", "--crop 0,0,61,20");
    render(&folder, "a.scn", "bottom.png", "--crop 0,20,61,43");
    let run = folder.run_line("merge top.png bottom.png -o all.png --json -");
    let json = run.succeeded().text();
    let start = r#"{"schema":1,"output":"all.png","width":61,"height":43,"tiles":2,"seconds":"#;
    assert!(json.starts_with(start), "{json}");
    for (json, words) in [
        ("top.png", "top.png would replace the tile"),
        (
            "all.png",
            "both the picture and the JSON would be written to all.png",
        ),
    ] {
        let run = folder.run_line(&format!("merge top.png bottom.png -o all.png --json {json}"));
        run.failed(2, words);
    }
    let run = folder.run_line("generate spheres --count 1000 -o made --json -");
    let start =
        r#"{"schema":1,"kind":"spheres","seed":0,"scene":"made/spheres.scn","meshes":[],"spheres":1000,"#;
    assert!(run.succeeded().text().starts_with(start));
    let run = folder.run_line("generate terrain --count 200 -o . --json ./terrain.ply");
    run.failed(2, "both the scene and the JSON would be written to ./terrain.ply");
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn tiles_that_do_not_fit_are_refused() {
    let folder = Folder::new();
    let tile = |name: &str, options: &str| render(&folder, "a.scn", name, options);
    tile("a.png", "--crop 0,0,30,43");
    tile("b.png", "--crop 30,0,61,43");
    tile("b.exr", "--crop 30,0,61,43");
    tile("aov.exr", "--crop 0,0,30,43 --aov id");
    tile("few.png", "--crop 30,0,61,20");
    tile("soft.png", "--crop 30,0,61,43 --samples 4");
    tile("auto.png", "--crop 30,0,61,43 --samples auto:4");
    tile("alpha.png", "--crop 30,0,61,43 --background transparent");
    tile("other.png", "--crop 20,0,61,43 --view 2");
    tile("srgb.png", "--crop 20,0,61,43 --srgb");
    tile("layers.png", "--crop 30,0,61,43 --aov normal,z");
    tile("deep.png", "--crop 0,0,30,43 --aov z --z-step 0.5");
    tile("whole.png", "");
    tile("b.jpg", "--crop 30,0,61,43");
    tile("b.gif", "--crop 30,0,61,43 --turntable 2");
    folder
        .run_line("a.scn -s 64x48 --crop 30,0,61,43 -o large.png -q")
        .succeeded();
    let torn = read(&folder, "b.png");
    fs::write(folder.path("torn.png"), &torn[..torn.len() - 40]).expect("a file");
    let moved = torn
        .windows(9)
        .position(|window| window == b"30,0,61,4")
        .expect("a place");
    let mut wrong = torn.clone();
    wrong[moved] = b'2';
    fs::write(folder.path("moved.png"), wrong).expect("a file");
    folder.write("text.png", "no picture");
    for (tiles, words) in [
        (
            "a.png",
            "tiles are missing: none covers --crop 30,0,61,43 of 61x43",
        ),
        (
            "a.png few.png",
            "tiles are missing: none covers --crop 30,20,61,43 of 61x43",
        ),
        (
            "b.png few.png",
            "tiles are missing: none covers --crop 0,0,30,43 of 61x43",
        ),
        (
            "a.png large.png",
            "large.png is of a picture of 64x48, but a.png is of a picture of 61x43",
        ),
        (
            "a.png soft.png",
            "soft.png was rendered with --samples 4, but a.png was rendered with --samples 1",
        ),
        (
            "soft.png auto.png",
            "auto.png was rendered with --samples auto:4, but soft.png was rendered with --samples 4",
        ),
        ("a.png b.exr", "b.exr is EXR, but a.png is PNG"),
        (
            "a.png alpha.png",
            "alpha.png has the channels RGBA, but a.png has the channels RGB",
        ),
        ("a.png srgb.png", "srgb.png shows sRGB, but a.png shows linear"),
        (
            "a.png layers.normal.png",
            "layers.normal.png shows normal, but a.png shows linear",
        ),
        (
            "layers.z.png deep.z.png",
            "deep.z.png shows z 0.5, but layers.z.png shows z 0.001",
        ),
        (
            "a.png other.png",
            "other.png overlaps a tile before it and differs from it, first at pixel 2",
        ),
        (
            "a.png whole.png",
            "whole.png: not a tile: only pictures of octray render --crop record their place",
        ),
        ("a.png text.png", "text.png: not a tile"),
        (
            "a.png b.jpg",
            "b.jpg: JPEG loses detail in each tile; render the tiles as .png",
        ),
        ("a.png b.gif", "b.gif: animations are not merged"),
        ("a.png a.scn", "a.scn: unknown extension, expected .png"),
        ("a.png none.png", "cannot read the tile none.png: file not found"),
        ("a.png torn.png", "cannot read the tile torn.png: "),
        ("a.png b.png moved.png", "cannot read the tile moved.png: "),
    ] {
        let arguments: Vec<&str> = ["merge"]
            .into_iter()
            .chain(tiles.split(' '))
            .chain(["-o", "new.png"])
            .collect();
        folder.fails(&arguments, 1, words);
    }
    folder.fails(
        &["merge", "aov.exr", "b.exr", "-o", "new.exr"],
        1,
        "b.exr has the channels B, G, R, but aov.exr has the channels B, G, R, id.primitive (whole numbers)",
    );
    folder.fails(
        &["merge", "a.png", "b.png", "-o", "new.exr"],
        2,
        "new.exr would be EXR, but the tiles are PNG: name a picture of their format",
    );
    folder.fails(
        &["merge", "a.png", "b.png", "-o", "none/new.png"],
        1,
        "directory `none` does not exist",
    );
    folder.fails(
        &["merge", "a.png", "b.png", "-o", "new.png", "--max-memory", "1K"],
        1,
        "a picture of 61x43 needs about",
    );
    folder.fails(&["merge", "-o", "new.png"], 2, "<TILE>");
}
