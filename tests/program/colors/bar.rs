//! `--color-bar`.

use super::{VIRIDIS, squares};
use crate::program::Folder;
use std::fs;

const LINE: &str = "a.ply --color-by q --color-bar -q -s 200x150";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("a.ply", &squares(Some(["-1", "1.5", "4"]), None));
    folder
}

#[test]
fn the_bar_has_the_colors_of_the_map_and_covers_only_the_right_side() {
    let folder = folder();
    let picture = |options: &str| {
        folder.run_line(&format!("{options} -o p.png")).succeeded();
        image::open(folder.path("p.png")).unwrap().into_rgba8()
    };
    let bare = picture(&LINE.replace("--color-bar ", ""));
    let with_bar = picture(LINE);
    let columns =
        |of: &image::RgbaImage| -> Vec<_> { of.rows().flat_map(|row| row.take(90)).copied().collect() };
    assert_eq!(columns(&bare), columns(&with_bar));
    for options in [
        "",
        " --background transparent",
        " --style plain",
        " --background white --linear",
    ] {
        let picture = picture(&format!("{LINE}{options}"));
        for [r, g, b] in [VIRIDIS[0], VIRIDIS[2]] {
            // A row has several of the map's colours.
            let is_near = |pixel: &&image::Rgba<u8>| {
                let apart = pixel.0.iter().zip([r, g, b, 255]).map(|(a, b)| a.abs_diff(b));
                apart.max() <= Some(6)
            };
            let found = picture.pixels().filter(is_near).count();
            assert!(found >= 8, "{options}: {found} pixels of {r} {g} {b}");
        }
    }
    // The colours of floats are linear.
    picture(LINE);
    let floats = folder.run_line(&format!("{LINE} -o p.exr --compare p.png --tolerance 1"));
    floats.succeeded();
}

#[test]
fn crops_have_their_part_of_the_bar() {
    let folder = folder();
    for options in [
        "-o whole.png",
        "-o 1.png --crop 0,0,150,70",
        "-o 2.png --crop 150,0,200,70",
        "-o 3.png --crop 0,70,200,150",
    ] {
        folder.run_line(&format!("{LINE} {options}")).succeeded();
    }
    folder
        .run_line("merge 1.png 2.png 3.png -o merged.png")
        .succeeded();
    let file = |name| fs::read(folder.path(name)).unwrap();
    assert!(file("merged.png") == file("whole.png"));
}

#[test]
fn small_pictures_have_no_room() {
    let folder = folder();
    let small = folder.run_line("a.ply --color-by q --color-bar -s 159x400 -o p.png");
    small.failed(
        2,
        "--color-bar needs a picture of at least 160x120 pixels, found 159x400",
    );
    folder
        .run_line("a.ply --color-bar -o p.png")
        .failed(2, "--color-by");
    assert!(!folder.path("p.png").exists());
}
