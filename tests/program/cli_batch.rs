//! Several pictures per call, scenes from standard input, turntables, comparisons.

use crate::program::{Folder, Run};
use std::{fs, io::Write, process::Stdio};

const SMALL: &str = "--size=24x16";

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The program with a text on standard input.
fn fed(folder: &Folder, arguments: &[&str], text: &str) -> Run {
    let mut child = folder.command(arguments).stdin(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    Run::new(child.wait_with_output().unwrap())
}

#[test]
fn each_scene_has_a_picture() {
    let folder = Folder::new();
    fs::create_dir(folder.path("out")).unwrap();
    folder.write("b.scn", "light 9 -4 10 0.7\nmaterial 1\nsphere 0 0 0.3 0.5\n");
    folder.run(&["a.scn", "b.scn", SMALL]).succeeded();
    folder
        .run(&["render", "a.scn", "b.scn", SMALL, "-o", "out/{stem}-x.png"])
        .succeeded();
    folder.run(&["b.scn", SMALL, "-o", "alone.png"]).succeeded();
    assert_eq!(
        folder.names(),
        ["a.png", "a.scn", "alone.png", "b.png", "b.scn", "out"]
    );
    for name in ["b.png", "out/b-x.png"] {
        assert_eq!(read(&folder, name), read(&folder, "alone.png"));
    }
    assert_eq!(read(&folder, "a.png"), read(&folder, "out/a-x.png"));
}

#[test]
fn equal_output_names_are_refused() {
    let folder = Folder::new();
    fs::create_dir(folder.path("deep")).unwrap();
    for name in ["b.scn", "deep/a.scn"] {
        folder.write(name, "sphere 0 0 0.5 0.5\n");
    }
    folder.fails(&["a.scn", "b.scn", "-o", "x.png"], 2, "{stem}");
    folder.fails(&["a.scn", "deep/a.scn"], 2, "both be written to a.png");
    folder.fails(
        &["a.scn", "a.scn"],
        2,
        "two pictures of a.scn would be written to",
    );
    folder.fails(&["a.scn", "b.scn", "-o", "-"], 2, "standard output");
    folder.fails(&["a.scn", "--turntable", "2", "-o", "x.png"], 2, "####");
    // Two spellings of one path.
    folder.fails(
        &["a.scn", "deep/../a.scn", "-o", "deep/../{stem}.png"],
        2,
        "both be written",
    );
    folder.fails(
        &["a.scn", "--turntable=2", "-o", "no/x-#.png"],
        1,
        "does not exist",
    );
}

#[test]
fn a_failure_ends_the_call_and_keeps_finished_pictures() {
    let folder = Folder::new();
    folder.write("bad.scn", "sphere 1 2\n");
    let run = folder.run(&["a.scn", "bad.scn", SMALL]);
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.contains("bad.scn:1:"), "{run:?}");
    assert_eq!(folder.names(), ["a.png", "a.scn", "bad.scn"]);
}

#[test]
fn inputs_are_checked_before_rendering() {
    let folder = Folder::new();
    folder.write("a.ply", "ply\n");
    folder.write("a.fbx", "Kaydara");
    folder.write("c.scn", "sphere 0 0 0 1\n");
    for (last, words) in [
        ("b.scn", "b.scn: file not found; did you mean `a.scn` or `c.scn`?"),
        ("a.obj", "a.obj: file not found; did you mean `a.ply` or `a.scn`?"),
        (".", ".: this is a directory"),
        ("a.fbx", "this is an FBX file, which octray does not read"),
    ] {
        folder.fails(&["c.scn", last, SMALL, "-o", "{stem}-1.png"], 1, words);
    }
    folder.write("b.scn", "sphere 0 0 0 1\n");
    folder.fails(&["a.ply", "b.scn", SMALL, "--ground"], 2, "b.scn is a scene");
}

#[test]
fn scenes_come_from_standard_input() {
    let folder = Folder::new();
    fs::create_dir(folder.path("parts")).unwrap();
    folder.write("parts/ball.scn", "sphere 0 0 0.5 0.5\n");
    let scene = "light 3 -2 5 0.7\nmaterial 1\ninclude parts/ball.scn\n";
    fed(&folder, &["-", SMALL], scene).succeeded();
    folder.write("same.scn", scene);
    folder.run(&["same.scn", SMALL]).succeeded();
    assert_eq!(read(&folder, "stdin.png"), read(&folder, "same.png"));
    let piped = fed(&folder, &["render", "-", SMALL, "-o-"], scene);
    assert_eq!(piped.succeeded().stdout, read(&folder, "same.png"));
    fed(&folder, &["info", "-"], scene).succeeded();
    for (text, words) in [
        ("sphere 1\n", "error: standard input:1:9: "),
        ("include no.scn\n", "no.scn"),
    ] {
        let run = fed(&folder, &["-", SMALL, "-o", "x.png"], text);
        assert!(run.code == Some(1) && run.stderr.contains(words), "{run:?}");
    }
    assert!(!folder.path("x.png").exists());
}

#[test]
fn existing_pictures_are_skipped() {
    let folder = Folder::new();
    folder.write("a.png", "not even a picture");
    folder.write("bad.scn", "nonsense");
    folder.write("bad.png", "");
    folder
        .run(&["a.scn", "bad.scn", SMALL, "--skip-existing"])
        .succeeded();
    assert_eq!(read(&folder, "a.png"), b"not even a picture");
    folder.run(&["a.scn", "--turntable=3", SMALL]).succeeded();
    folder.write("a-0002.png", "kept");
    fs::remove_file(folder.path("a-0003.png")).unwrap();
    folder
        .run(&["a.scn", "--turntable=3", SMALL, "--skip-existing"])
        .succeeded();
    assert_eq!(read(&folder, "a-0002.png"), b"kept");
    assert!(folder.path("a-0003.png").exists());
}

#[test]
fn turntables_go_around() {
    let folder = Folder::new();
    folder.run(&["a.scn", SMALL]).succeeded();
    folder
        .run(&["a.scn", SMALL, "--turntable", "4", "-o", "t-##.png"])
        .succeeded();
    for number in 1..=4 {
        let same = read(&folder, &format!("t-0{number}.png")) == read(&folder, "a.png");
        assert_eq!(same, number == 1, "{number}");
    }
    // --frames renders the same pictures, and no others.
    folder
        .run(&["a.scn", SMALL, "--turntable=4", "--frames=2-3", "-o", "p#.png"])
        .succeeded();
    let names = folder.names();
    let parts: Vec<_> = names.iter().filter(|name| name.starts_with('p')).collect();
    assert_eq!(parts, ["p2.png", "p3.png"]);
    assert_eq!(read(&folder, "p3.png"), read(&folder, "t-03.png"));
    // Picture 3 of 4 is half a turn away.
    folder
        .run(&["a.scn", SMALL, "--eye=3,0,1", "--turntable=4", "-o", "e#.png"])
        .succeeded();
    folder
        .run(&["a.scn", SMALL, "--eye=-3,0,1", "-o", "half.png"])
        .succeeded();
    let half = image::open(folder.path("half.png")).unwrap().into_rgb8();
    let turned = image::open(folder.path("e3.png")).unwrap().into_rgb8();
    let same = half.pixels().zip(turned.pixels()).filter(|(a, b)| a == b).count();
    assert!(same >= 24 * 16 * 9 / 10, "{same}");
}

#[test]
fn invalid_turntables_and_comparisons_are_refused() {
    let folder = Folder::new();
    for (arguments, words) in [
        ("--turntable 0", "0"),
        ("--turntable 10001", "10000"),
        ("--frames 1-2", "--turntable"),
        ("--turntable 4 --frames 3-5", "from 1 to 4"),
        ("--turntable 4 --frames 3-2", "2-3"),
        ("--turntable 4 --frames 0-2", "A-B"),
        ("--skip-existing --compare a.png", "cannot be used with"),
        ("--tolerance 2", "--compare"),
        ("--difference d.png", "--compare"),
        ("--compare a.png --tolerance 256", "0 to 255"),
        ("--compare a.png --allow-pixels 5", "share"),
    ] {
        let mut all = vec!["a.scn"];
        all.extend(arguments.split_whitespace());
        folder.fails(&all, 2, words);
    }
}

#[test]
fn statistics_of_each_picture() {
    let folder = Folder::new();
    let run = folder.run(&["a.scn", SMALL, "--turntable=3", "--json=-"]);
    let lines: Vec<serde_json::Value> = run
        .text()
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let outputs: Vec<_> = lines
        .iter()
        .map(|line| line["output"].as_str().unwrap())
        .collect();
    assert_eq!(outputs, ["a-0001.png", "a-0002.png", "a-0003.png"]);
    assert!(lines[0]["seconds"]["build"].as_f64() > Some(0.0));
    assert_eq!(lines[1]["seconds"]["build"], 0.0);
}

#[test]
fn equal_pictures_agree_in_every_lossless_format() {
    let folder = Folder::new();
    for extension in ["png", "ppm", "qoi", "bmp", "tiff", "exr"] {
        let reference = format!("ref.{extension}");
        let output = format!("new.{extension}");
        folder.run(&["a.scn", SMALL, "-o", &reference]).succeeded();
        let run = folder.run(&["a.scn", SMALL, "-o", &output, "--compare", &reference]);
        assert_eq!(run.code, Some(0), "{run:?}");
        let words = format!("{output} agrees with {reference}: 0 of 384 pixels");
        assert!(run.stderr.starts_with(&words), "{run:?}");
        assert_eq!(run.stderr.lines().count(), 1);
        // Floats are compared as bytes.
        folder
            .run_line(&format!("a.scn {SMALL} -o new.png --quiet --compare {reference}"))
            .succeeded();
    }
    assert!(!folder.names().iter().any(|name| name.contains("difference")));
}

/// Pictures of meshes are sRGB, but their EXR files are linear.
#[test]
fn bytes_are_compared_with_floats() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for background in ["scene", "transparent"] {
        let line = format!("a.obj {SMALL} --background {background}");
        folder.run_line(&format!("{line} -o ref.png")).succeeded();
        folder.run_line(&format!("{line} -o ref.exr")).succeeded();
        for [reference, output] in [["ref.png", "new.exr"], ["ref.exr", "new.png"]] {
            let run = folder.run_line(&format!("{line} -o {output} --compare {reference}"));
            let agrees = run.stderr.contains("agrees with");
            assert!(agrees && run.code == Some(0), "{run:?}");
        }
        let run = folder.run_line(&format!("{line} --linear -o new.exr --compare ref.png"));
        run.failed(5, "differs from");
    }
}

/// Floats have premultiplied colours, bytes straight ones. The average has alpha if a picture has.
#[test]
fn half_transparent_pictures_are_compared() {
    let folder = Folder::new();
    let line = format!("a.scn {SMALL} --samples 4 --background transparent");
    folder.run_line(&format!("{line} -o ref.exr")).succeeded();
    let floats = image::open(folder.path("ref.exr")).unwrap().into_rgba32f();
    let is_partial = |pixel: &image::Rgba<f32>| pixel.0[3] > 0.0 && pixel.0[3] < 1.0;
    assert!(floats.pixels().any(is_partial));
    floats.save(folder.path("straight.tiff")).unwrap();
    let bytes = format!("{line} -o new.png -q --compare ref.exr");
    folder.run_line(&bytes).succeeded();
    // The colours of the TIFF file are called straight.
    folder
        .run_line(&format!(
            "{line} -o new.exr --compare straight.tiff --tolerance 1"
        ))
        .failed(5, "new.exr differs from straight.tiff");
    let mut opaque = image::open(folder.path("new.png")).unwrap().into_rgba8();
    opaque
        .pixels_mut()
        .for_each(|pixel| pixel.0[3] = pixel.0[3].wrapping_sub(4));
    opaque.save(folder.path("fainter.png")).unwrap();
    let run = folder.run_line(&format!("{line} -o new.png --compare fainter.png"));
    assert!(!run.stderr.contains(" 0.0000 on average"), "{run:?}");
}

#[test]
fn differences_are_reported_and_written() {
    let folder = Folder::new();
    folder.run(&["a.scn", SMALL, "-o", "ref.png"]).succeeded();
    let mut changed = image::open(folder.path("ref.png")).unwrap().into_rgb8();
    changed.get_pixel_mut(3, 2).0 = [250, 255, 255];
    changed.get_pixel_mut(4, 2).0 = [255, 245, 255];
    changed.save(folder.path("changed.png")).unwrap();

    let compare = |more: &str| {
        let mut all = vec!["a.scn", SMALL, "-o", "new.png", "--compare", "changed.png"];
        all.extend(more.split_whitespace());
        folder.run(&all)
    };
    compare("").failed(5, "new.png differs from changed.png: 2 of 384 pixels");
    let shown = image::open(folder.path("new-difference.png"))
        .unwrap()
        .into_rgb8();
    assert_eq!(shown.get_pixel(3, 2).0, [128, 0, 0]);
    assert_eq!(shown.get_pixel(4, 2).0, [0, 255, 0]);
    assert_eq!(shown.pixels().filter(|pixel| pixel.0 != [0; 3]).count(), 2);
    assert_eq!(read(&folder, "new.png"), read(&folder, "ref.png"));

    compare("--tolerance 5 --difference d.qoi").failed(5, "1 of 384 pixels");
    assert!(folder.path("d.qoi").exists());
    for agreeing in [
        "--tolerance 10",
        "--allow-pixels 0.006",
        "--tolerance 5 --allow-pixels 0.003",
    ] {
        let run = compare(agreeing);
        assert_eq!(run.code, Some(0), "{agreeing}: {run:?}");
    }
    compare("--allow-pixels 0.004").failed(5, "2 of 384");
    // Alpha counts.
    let mut clear = image::open(folder.path("ref.png")).unwrap().into_rgba8();
    clear.get_pixel_mut(0, 0).0[3] = 0;
    clear.save(folder.path("changed.png")).unwrap();
    compare("--tolerance 254").failed(5, "1 of 384");
}

#[test]
fn references_may_be_patterns() {
    let folder = Folder::new();
    fs::create_dir(folder.path("ref")).unwrap();
    let turntable = ["a.scn", SMALL, "--turntable=3", "-o"];
    folder
        .run(&[&turntable[..], &["ref/{stem}#.png"]].concat())
        .succeeded();
    fs::copy(folder.path("ref/a1.png"), folder.path("ref/a2.png")).unwrap();
    let compared = ["{stem}-##.png", "--compare=ref/{stem}#.png", "--quiet"];
    let run = folder.run(&[&turntable[..], &compared].concat());
    assert_eq!(run.code, Some(5));
    assert!(
        run.stderr.starts_with("error: 1 of 3 pictures differ")
            && run.stderr.contains("a-02.png differs from ref/a2.png"),
        "{run:?}"
    );
    assert_eq!(
        folder.names(),
        [
            "a-01.png",
            "a-02-difference.png",
            "a-02.png",
            "a-03.png",
            "a.scn",
            "ref"
        ]
    );
}

#[test]
fn references_that_cannot_be_compared_are_errors() {
    let folder = Folder::new();
    folder
        .run(&["a.scn", "--size=9x9", "-o", "small.png"])
        .succeeded();
    folder.write("text.png", "no picture");
    folder.write("bad.png", "\u{89}PNG");
    let mut cut = read(&folder, "small.png");
    cut.truncate(cut.len() / 2);
    fs::write(folder.path("cut.png"), cut).unwrap();
    for (arguments, code, words) in [
        ("--compare none.png", 1, "file not found"),
        ("--compare .", 1, "expected a file"),
        ("--compare text.png", 1, "cannot read the reference text.png"),
        ("--compare bad.png", 1, "bad.png"),
        ("--compare small.png", 1, "9x9"),
        (
            "--compare small.png --size 9x9 -o small.png",
            2,
            "replace the reference",
        ),
        (
            "--compare small.png --size 9x9 --difference small.png",
            2,
            "replace the reference",
        ),
        (
            "--compare small.png --size 9x9 --difference new.png -o new.png",
            2,
            "two pictures of a.scn would be written to",
        ),
        ("--compare small.png --size 9x9 --difference d.exr", 2, "EXR"),
    ] {
        let mut all = vec!["a.scn"];
        all.extend(arguments.split_whitespace());
        folder.fails(&all, code, words);
    }
    let run = folder.run(&["a.scn", "--size=9x9", "--compare=cut.png"]);
    run.failed(1, "cannot read the reference cut.png");
}

/// Poses whose pictures would have one name are named, and a pattern that keeps them apart.
#[test]
fn poses_of_one_name() {
    let folder = Folder::new();
    let poses = |names: &[&str]| {
        let matrix = r#""transform_matrix":[[1,0,0,0],[0,0,-1,-4],[0,1,0,0],[0,0,0,1]]"#;
        let frame = |name: &&str| format!(r#"{{"file_path":"{name}",{matrix}}}"#);
        let frames: Vec<String> = names.iter().map(frame).collect();
        folder.write(
            "t.json",
            &format!(r#"{{"camera_angle_x":0.8,"frames":[{}]}}"#, frames.join(",")),
        );
    };
    let call = "a.scn --size 8x6 --poses t.json -o";
    let fails = |pattern: &str, words: &str| {
        let line = format!("{call} {pattern}");
        folder.fails(&line.split(' ').collect::<Vec<_>>(), 2, words);
    };
    poses(&["a/x.png", "b/x.png"]);
    fails(
        "{pose}.png",
        "poses 1 (a/x.png) and 2 (b/x.png) would both be written to x.png; use {pose}_#.png",
    );
    fails("r-{pose}.png", "use r-{pose}_#.png");
    fails(
        "x.png",
        "several frames would be written to x.png; add a run of # for the frame number, such as x-####.png",
    );
    folder.run_line("a.scn --size 8x6 -o a.png").succeeded();
    fails(
        "a-#.png --compare a.png --difference {pose}-d.png",
        "use {pose}-d_#.png",
    );
    folder.run_line(&format!("{call} {{pose}}_#.png")).succeeded();
    assert!(folder.path("x_2.png").exists());
    let names: Vec<String> = (0..11)
        .map(|i| ["a1", "b", "a"][i.min(1) + i / 10].to_owned())
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    poses(&names);
    fails(
        "{pose}#.png",
        "poses 1 (a1) and 11 (a) would both be written to a11.png; use {pose}_#.png",
    );
    folder.run_line(&format!("{call} {{pose}}_#.png")).succeeded();
}
