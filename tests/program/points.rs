//! Files without faces on the command line: clouds of spheres, and lines.

use crate::program::Folder;

#[test]
fn clouds_of_points() {
    let folder = Folder::new();
    folder.write("points.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 0 1\np 1 2\n");
    let run = folder.run_line("points.obj -s 64x64");
    assert_eq!(
        (run.succeeded().stderr.contains("warning"), run.code),
        (false, Some(0))
    );
    let picture = image::open(folder.path("points.png")).unwrap().into_rgb8();
    for (name, is_color) in [
        (
            "red",
            (|[r, g, b]: [u8; 3]| r > 128 && g < 60 && b < 60) as fn([u8; 3]) -> bool,
        ),
        ("blue", |[r, g, b]| b > 128 && r < 60 && g < 60),
    ] {
        let shown = picture.pixels().filter(|pixel| is_color(pixel.0)).count();
        assert!(shown > 100, "{name}: {shown}");
    }
    let info = folder.run_line("info points.obj");
    for words in [
        "spheres            2 (with colours)",
        "points.obj: no faces: its points become spheres of radius 0.65",
        "sphere color",
    ] {
        assert!(info.succeeded().text().contains(words), "{info:?}");
    }
    folder.write("same.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\n");
    folder.write("one.obj", "v 1e6 2 3\n");
    for (line, radius) in [("same.obj", "0.5"), ("one.obj", "1000")] {
        let info = folder.run_line(&format!("info {line}"));
        assert!(
            info.text().contains(&format!("spheres of radius {radius}\n")),
            "{info:?}"
        );
        folder.run_line(&format!("{line} -s 16x16 --ground")).succeeded();
        let picture = image::open(folder.path(&line.replace("obj", "png")))
            .unwrap()
            .into_rgb8();
        assert!(
            picture.pixels().any(|pixel| pixel != picture.get_pixel(0, 0)),
            "{line}"
        );
    }
    let smooth = folder.run_line("same.obj -s 8x8 --smooth-angle 30");
    assert!(
        smooth
            .stderr
            .contains("same.obj: points are spheres, so --smooth-angle has no effect"),
        "{smooth:?}"
    );
    // A point reaches as far as its radius: the picture shows all of it.
    folder.run_line("same.obj -s 64x64 --point-size 50").succeeded();
    let picture = image::open(folder.path("same.png")).unwrap().into_rgb8();
    let background = *picture.get_pixel(0, 0);
    assert_ne!(*picture.get_pixel(32, 32), background);
    for i in 0..64 {
        for (x, y) in [(i, 0), (i, 63), (0, i), (63, i)] {
            assert_eq!(*picture.get_pixel(x, y), background);
        }
    }
    folder.write("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nf 1 2 3\n");
    let run = folder.run_line("a.obj -s 8x8 --point-size 1");
    let words = "warning: a.obj: the mesh has faces, so --point-size has no effect\n";
    assert_eq!((run.code, &run.stderr[..]), (Some(0), words));
    let info = folder.run_line("info a.obj");
    assert!(
        info.text().contains("vertices           3 (with colours)"),
        "{info:?}"
    );
}

#[test]
fn lines_are_tubes() {
    let folder = Folder::new();
    folder.write("lines.obj", "v 0 0 0 1 0 0\nv 0 1 0 1 0 0\nv 7 7 7\nl 1 2\n");
    let info = folder.run_line("info lines.obj");
    for words in [
        "spheres            2 (with colours)",
        "lines.obj: no faces: its line becomes a tube of radius 0.0025\n",
    ] {
        assert!(info.succeeded().text().contains(words), "{info:?}");
    }
    // 12.5 pixels a unit; the eight sides of a tube are within its circle.
    for (size, most, least) in [(0.32, 4, 3), (1.6, 20, 18)] {
        let line = format!(
            "lines.obj --style plain -s 50x200 --ortho 16 --eye 0,0.5,9 --target 0,0.5,0 --point-size {size}"
        );
        let run = folder.run_line(&line);
        assert!(!run.succeeded().stderr.contains("warning"), "{run:?}");
        let picture = image::open(folder.path("lines.png")).unwrap().into_rgb8();
        let background = *picture.get_pixel(0, 0);
        let row = (0..50)
            .filter(|&x| *picture.get_pixel(x, 100) != background)
            .count();
        assert!((least..=most).contains(&row), "{size}: {row}");
    }
    let smooth = folder.run_line("lines.obj -s 8x8 --smooth-angle 30");
    let words = "lines.obj: lines are round, so --smooth-angle has no effect";
    assert!(smooth.stderr.contains(words), "{smooth:?}");
    let most: String = (0..5000).map(|_| "l 1 2\n").collect();
    folder.write("many.obj", &("v 0 0 0\nv 0 1 0\n".to_owned() + &most));
    folder.fails(
        &["many.obj", "-s", "8x8", "--max-memory", "4M"],
        1,
        "above the memory limit",
    );
}
