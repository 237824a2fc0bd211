//! Options as people type them: short ones, any number of samples, JSON, meshes from standard input.

use crate::program::{Folder, Run, assert_contains, on_a_terminal, shipped_mesh};
use serde_json::Value;
use std::fs;

/// The bytes of the picture that a line of arguments makes.
fn picture(folder: &Folder, arguments: &str) -> Vec<u8> {
    let line = format!("{arguments} -o made.ppm -q");
    folder.run_line(&line).succeeded();
    fs::read(folder.path("made.ppm")).unwrap()
}

fn with_input(folder: &Folder, input: &str, arguments: &str) -> Run {
    folder.shell(&format!("\"$0\" {arguments} < '{input}'"))
}

#[test]
fn short_options() {
    let folder = Folder::new();
    folder.write("empty.scn", "// nothing\n");
    folder.run_line("empty.scn -q -s 33x17 -j 2").succeeded();
    assert_eq!(
        image::image_dimensions(folder.path("empty.png")).unwrap(),
        (33, 17)
    );
    folder.run_line("bench a.scn -s8x8 --repeat 1").succeeded();
    folder.run_line("verify --rays 1000 -j1").succeeded();
    folder.fails(&["a.scn", "-w", "8"], 2, "-w");
    folder.fails(&["a.scn", "-j", "0"], 2, "--threads");
}

#[test]
fn any_number_of_samples() {
    let folder = Folder::new();
    for (samples, pattern) in [(1, "grid"), (4, "grid"), (9, "grid"), (5, "sobol"), (2, "sobol")] {
        let given = picture(&folder, &format!("a.scn -s 40x30 --samples {samples}"));
        let line = format!("a.scn -s 40x30 --samples {samples} --pattern {pattern}");
        assert_eq!(given, picture(&folder, &line), "{samples}");
    }
    for (line, words) in [
        (
            "--samples 5 --pattern grid",
            "--pattern grid needs a square number of samples: use --samples 4 or 9, or --pattern sobol for 5",
        ),
        ("--samples 3 --pattern stratified", "use --samples 1 or 4"),
        (
            "--samples auto --pattern grid",
            "--pattern grid needs the same samples in every pixel: use a number with --samples, or --pattern sobol for auto",
        ),
        (
            "--samples auto:5 --pattern stratified",
            "--pattern stratified needs the same",
        ),
        ("--samples auto:0", "expected a whole number, 1 or more"),
        (
            "--samples auto:",
            "expected a whole number, 1 or more, such as auto:64",
        ),
        ("--samples auto5", "expected a whole number, auto or auto:N"),
        ("--samples many", "expected a whole number, 1 or more, or auto"),
        (
            "--samples 4294967296",
            "expected a whole number from 1 to 4294967295, or auto",
        ),
    ] {
        let arguments: Vec<&str> = std::iter::once("a.scn").chain(line.split(' ')).collect();
        folder.fails(&arguments, 2, words);
    }
}

/// `auto` is `auto:16`, and takes less than that.
#[test]
fn samples_by_need() {
    let folder = Folder::new();
    let auto = picture(&folder, "a.scn -s 40x30 --samples auto");
    assert_eq!(
        auto,
        picture(&folder, "a.scn -s 40x30 --samples auto:16 --pattern sobol")
    );
    assert_eq!(
        auto,
        picture(&folder, "a.scn -s 40x30 --samples auto --mode scalar")
    );
    assert_eq!(
        picture(&folder, "a.scn -s 40x30 --samples auto:1"),
        picture(&folder, "a.scn -s 40x30 --samples 1 --pattern sobol")
    );
    folder.write("auto.toml", "samples = \"auto\"\n");
    assert_eq!(auto, picture(&folder, "a.scn -s 40x30 --config auto.toml"));
    let run = folder.run_line("a.scn -s 40x30 --samples auto:9 --stats --json -");
    assert_contains(&run.stderr, &["40x30, up to 9 samples per pixel"]);
    assert_contains(run.text(), &["\"samples\":9,\"adaptive\":true"]);
    let figures: serde_json::Value = serde_json::from_str(run.text()).expect("JSON");
    let rays = figures["rays"]["camera"].as_u64().expect("a count");
    assert!((40 * 30..40 * 30 * 9 / 2).contains(&rays), "{rays}");
}

/// The JSON of every command goes to a file or to standard output, one line for each answer.
#[test]
fn json_of_every_command() {
    let folder = Folder::new();
    for (line, field) in [
        ("a.scn -s 8x8", "rays"),
        ("info a.scn", "bvh"),
        ("bench a.scn -s 8x8 --repeat 1", "results"),
        ("verify --rays 1000", "agree"),
    ] {
        let run = folder.run_line(&format!("{line} --json -"));
        let printed: Value = serde_json::from_str(run.succeeded().text()).unwrap();
        assert_eq!((&printed["schema"], run.text().lines().count()), (&1.into(), 1));
        folder.run_line(&format!("{line} --json made.json")).succeeded();
        let written = fs::read_to_string(folder.path("made.json")).unwrap();
        let written: Value = serde_json::from_str(&written).unwrap();
        assert!(!written[field].is_null() && !printed[field].is_null(), "{line}");
        let mut arguments: Vec<&str> = line.split(' ').collect();
        arguments.extend(["--json", "no/made.json"]);
        let words = "cannot write no/made.json: directory `no` does not exist";
        folder.fails(&arguments, 1, words);
    }
    folder.fails(
        &["a.scn", "--json", "-", "-o", "-"],
        2,
        "name a file for one of them",
    );
    folder.fails(
        &["a.scn", "--json", "a.png"],
        2,
        "both the picture and the JSON would be written to a.png",
    );
    folder.fails(&["a.scn", "--json", "."], 1, "it is a directory");
    folder.fails(&["a.scn", "--json", "new/"], 1, "it is a directory");
    if cfg!(target_os = "linux") {
        folder.run_line("info a.scn --json /dev/null").succeeded();
        let kind = fs::metadata("/dev/null").unwrap().file_type();
        assert!(!kind.is_file(), "it was replaced");
    }
}

#[test]
fn json_of_the_pictures_before_a_failure() {
    let folder = Folder::new();
    folder.write("b.scn", "sphere\n");
    let run = folder.run_line("a.scn b.scn -s 8x8 --json made.json");
    assert_eq!(run.code, Some(1));
    assert!(run.stderr.starts_with("error: b.scn:1:"), "{run:?}");
    let written = fs::read_to_string(folder.path("made.json")).unwrap();
    let outputs: Vec<&str> = written.lines().filter(|line| line.contains("a.png")).collect();
    assert_eq!((outputs.len(), written.lines().count()), (1, 1));
}

#[test]
fn meshes_from_standard_input() {
    let folder = Folder::new();
    fs::copy(shipped_mesh("vase.mtl"), folder.path("vase.mtl")).unwrap();
    for mesh in ["vase.obj", "gear.stl", "cube.ply", "mobile.gltf", "stairs.3mf"] {
        let mesh = shipped_mesh(mesh);
        let options = "-s 40x30 --ground";
        let expected = picture(&folder, &format!("{mesh} {options}"));
        with_input(&folder, &mesh, &format!("- {options} -o made.ppm -q")).succeeded();
        assert_eq!(fs::read(folder.path("made.ppm")).unwrap(), expected, "{mesh}");
        with_input(&folder, &mesh, "info -").succeeded();
        with_input(&folder, &mesh, "bench - -s 8x8 --repeat 1").succeeded();
    }
    with_input(&folder, "a.scn", "- -s 8x8").succeeded();
    assert!(folder.path("stdin.png").exists());
    for (text, options, code, words) in [
        ("sphere 0 0 0 1\n", "--ground", 2, "and standard input is a scene"),
        (
            "vn 0 0 1\n",
            "",
            1,
            "standard input: no triangles to render (0 vertices",
        ),
    ] {
        folder.write("input", text);
        with_input(&folder, "input", &format!("- {options}")).failed(code, words);
    }
    folder.write("input", "sphere 0 0 0\n");
    let faulty = with_input(&folder, "input", "-");
    assert!(
        faulty.stderr.starts_with("error: standard input:1:13: "),
        "{faulty:?}"
    );
    // What should have written to the pipe has failed: no picture.
    let empty = with_input(&folder, "/dev/null", "- -s 8x8");
    empty.failed(
        1,
        "standard input: the input is empty, expected a scene or a mesh",
    );
    folder.write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("input", "light 0 0 9 1\nmesh m.obj\n");
    with_input(&folder, "input", "- -s 8x8").succeeded();
}

#[test]
fn six_up_axes() {
    let folder = Folder::new();
    let mesh = shipped_mesh("mobile.gltf");
    let all = ["x", "y", "z", "-x", "-y", "-z"]
        .map(|axis| picture(&folder, &format!("{mesh} -s 40x30 --up-axis {axis}")));
    assert_eq!(all[1], picture(&folder, &format!("{mesh} -s 40x30")));
    assert_eq!(all[4], picture(&folder, &format!("{mesh} -s 40x30 --up-axis=-y")));
    for (i, one) in all.iter().enumerate() {
        assert!(!all[..i].contains(one), "{i}");
    }
    folder.write("defaults.toml", "up-axis = \"-y\"\n");
    assert_eq!(
        all[4],
        picture(&folder, &format!("{mesh} -s 40x30 --config defaults.toml"))
    );
    let words = "expected x, y, z, -x, -y or -z";
    folder.fails(&[&mesh, "--up-axis", "up"], 2, words);
}

/// An orthographic view that fits leaves a margin of 3 % on each side of the picture in one direction, and shows the box's
/// own proportions.
#[test]
fn meshes_are_framed_from_their_sides() {
    let folder = Folder::new();
    let corners: String = (0..8)
        .map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, 0.25 * f64::from(i >> 2)))
        .collect();
    let faces = "f 1 2 4 3\nf 5 6 8 7\nf 1 2 6 5\nf 3 4 8 7\nf 1 3 7 5\nf 2 4 8 6\n";
    folder.write("box.obj", &(corners.replace("v 1 ", "v 2 ") + faces));
    let covered = |options: &str| {
        let line = format!("box.obj -s 200 --style plain --background transparent -q -o a.png {options}");
        folder.run_line(&line).succeeded();
        let picture = image::open(folder.path("a.png")).expect("a picture").into_rgba8();
        let seen = picture.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[3] > 0);
        let (x, y): (Vec<u32>, Vec<u32>) = seen.map(|(x, y, _)| (x, y)).unzip();
        [x, y].map(|all| {
            (
                all.iter().min().copied().unwrap(),
                all.iter().max().copied().unwrap() + 1,
            )
        })
    };
    for (sides, [width, height]) in [
        (["front", "back"], [188, 94]),
        (["right", "left"], [47, 188]),
        (["top", "bottom"], [188, 24]),
    ] {
        for side in sides {
            for (found, wanted) in covered(&format!("--from {side} --ortho fit"))
                .into_iter()
                .zip([width, height])
            {
                assert!(
                    (found.1 - found.0).abs_diff(wanted) <= 1,
                    "{side}: {found:?}, {wanted}"
                );
                assert!((found.0 + found.1).abs_diff(200) <= 2, "{side}: {found:?}");
            }
        }
    }
    let default = picture(&folder, "box.obj -s 20 --style plain");
    assert_eq!(
        default,
        picture(&folder, "box.obj -s 20 --style plain --from 35,20")
    );
    folder.fails(
        &["box.obj", "--from", "above"],
        2,
        "expected front, right, back, left, top, bottom, or AZIMUTH,ELEVATION",
    );
    folder.fails(
        &["box.obj", "--from", "0,95"],
        2,
        "expected an elevation from -90 to 90 degrees",
    );
    folder.fails(
        &["box.obj", "--eye", "1,2,3", "--ortho", "fit"],
        2,
        "--ortho fit frames the mesh",
    );
    folder.write("a.scn", "light 0 0 9 1\nsphere 0 0 0 1\n");
    folder.fails(&["a.scn", "--from", "top"], 2, "--from applies to meshes only");
    folder.fails(
        &["a.scn", "--ortho", "fit"],
        2,
        "--ortho fit applies to meshes only",
    );
}

#[test]
fn a_mesh_on_its_side_is_noticed() {
    let folder = Folder::new();
    folder.write(
        "cone.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 2\nf 4 3 2 1\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n",
    );
    let run = folder.run_line("cone.obj -s 8x8");
    let words = "warning: cone.obj: assumed y is up (OBJ has no such field), but its flat side faces -z; --up-axis z turns it\n";
    assert_eq!(run.stderr, words);
    folder.run_line("cone.obj -s 8x8 --up-axis z").succeeded();
    folder.run_line("cone.obj -s 8x8 --up-axis y").succeeded();
    folder.run_line("cone.obj -s 8x8 -q").succeeded();
}

#[test]
fn pictures_of_nothing_are_noticed() {
    let folder = Folder::new();
    folder.write(
        "a.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    );
    let away = "a.obj -s 9x8 --eye 9,9,9 --target 20,20,20";
    let words = "shows nothing: no camera ray hits a.obj\n";
    let run = folder.run_line(away);
    assert_eq!(
        (run.code, run.stderr),
        (Some(0), format!("warning: a.png {words}"))
    );
    let run = folder.run_line(&format!("{away} --no-shadows -o b.exr"));
    assert_eq!(run.stderr, format!("warning: b.exr {words}"));
    folder.run_line(&format!("{away} -q")).succeeded();
    // A part of a picture may be empty, and so may a scene's.
    folder.run_line(&format!("{away} --crop 0,0,4,4")).succeeded();
    folder.write("b.scn", "sphere 0 0 0 1\n");
    folder
        .run_line("b.scn -s 8x8 --eye 9,9,9 --target 20,20,20")
        .succeeded();
    // What is seen without shadows has no other rays.
    folder.run_line("a.obj -s 9x8 --no-shadows").succeeded();
    let run = folder.run_line(&format!("{away} --turntable=3 -o c#.png"));
    assert!(run.stderr.matches("shows nothing").count() < 2, "{run:?}");
}

#[test]
fn values_are_explained() {
    let folder = Folder::new();
    for (line, words) in [
        ("--eye 3 -4 2", "write --eye 3,-4,2 (no spaces)"),
        ("--eye=3 -4 2", "write --eye 3,-4,2 (no spaces)"),
        ("--target 3, -4, 2", "write --target 3,-4,2 (no spaces)"),
        ("--up -0.5 0 1e0", "write --up -0.5,0,1e0 (no spaces)"),
        (
            "--lit-from 1 2",
            "such as --lit-from -1,2.5,3 (no spaces), found 2",
        ),
        ("--lit-from 0,0,0", "expected a direction"),
        ("-s 800 600", "write -s 800x600 (no spaces)"),
        ("--crop 0 0 8 8", "write --crop 0,0,8,8 (no spaces)"),
        ("--eye 3", "expected three numbers x,y,z"),
        ("-size 8x8", "write --size"),
        ("-output=a.png", "write --output"),
        ("-output a.png", "write --output"),
        ("--aov depth normal", "write --aov depth,normal (no spaces)"),
        ("-o a.mp4", "use -o - | ffmpeg -i - a.mp4"),
        ("--eye 0,0,5", "such as --up 0,1,0 for a view straight down"),
        ("--stats=json", "--json FILE writes JSON"),
        ("--samples 0", "expected a whole number, 1 or more"),
        (
            "--point-size 0",
            "expected a diameter in scene units, above 0 and at most 1e9",
        ),
        (
            "--point-size -0.5",
            "expected a diameter in scene units, above 0 and at most 1e9",
        ),
        (
            "--point-size nan",
            "expected a diameter in scene units, above 0 and at most 1e9",
        ),
        ("--point-size 1", "--point-size applies to meshes only"),
    ] {
        let arguments: Vec<&str> = std::iter::once("a.scn").chain(line.split(' ')).collect();
        folder.fails(&arguments, 2, words);
    }
    folder.run_line("a.scn -s 8x8 --eye -3,4,2").succeeded();
}

#[test]
fn values_may_begin_with_a_minus() {
    let folder = Folder::new();
    for (line, words) in [
        ("--crop -1,2,3,4", "invalid value '-1,2,3,4' for '--crop"),
        (
            "--samples -1",
            "invalid value '-1' for '--samples <N>': expected a whole number, 1 or more",
        ),
        ("-s -1x4", "invalid value '-1x4' for '--size"),
        ("--max-memory -5G", "invalid value '-5G' for '--max-memory"),
        ("--quiet -5", "'--quiet'"),
        ("-5", "unexpected argument '-5'"),
    ] {
        let arguments: Vec<&str> = std::iter::once("a.scn").chain(line.split(' ')).collect();
        folder.fails(&arguments, 2, words);
    }
    folder
        .run(&["a.scn", "--size", "16 x 8", "--eye", "-3,4,2"])
        .succeeded();
    assert_eq!(image::image_dimensions(folder.path("a.png")).unwrap(), (16, 8));
}

#[test]
fn no_more_threads_than_can_be_of_use() {
    let folder = Folder::new();
    let mut command = folder.command(&["a.scn", "-s", "8x8", "--json", "-", "-j", "4096"]);
    let run = Run::new(command.env("RAYON_NUM_THREADS", "65535").output().unwrap());
    let json: Value = serde_json::from_str(run.succeeded().text()).unwrap();
    let cpus = std::thread::available_parallelism().map_or(1, usize::from);
    assert_eq!(json["threads"], (4 * cpus).max(64));
    for arguments in [&["verify", "--rays", "1000"][..], &["info", "a.scn"]] {
        let mut command = folder.command(arguments);
        let run = Run::new(command.env("RAYON_NUM_THREADS", "65535").output().unwrap());
        run.succeeded();
    }
}

#[test]
fn what_is_left_out_is_noted() {
    let folder = Folder::new();
    let ply = "ply\nformat ascii 1.0\ncomment up sideways\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    folder.write("up.ply", ply);
    let run = folder.run_line("up.ply -s 8x8");
    assert!(
        run.stderr
            .contains("a comment that `sideways` is up, which is no axis"),
        "{run:?}"
    );
    folder.write_gltf("g", r#""images":[{"uri":"a.png"}]"#);
    let run = folder.run_line("g.gltf -s 8x8");
    assert!(run.stderr.contains("left out: 1 image"), "{run:?}");
}

#[test]
fn colours_of_usage_errors_survive() {
    let folder = Folder::new();
    let Some(run) = on_a_terminal(&folder, "a.scn --size 8x") else {
        return;
    };
    assert!(run.text().contains("\u{1b}[1m"), "{run:?}");
    let hostile = on_a_terminal(&folder, "a.scn --size $(printf 'x\\033]0;y\\007')").unwrap();
    assert!(
        !hostile.text().contains("\u{1b}]") && !hostile.text().contains('\u{7}'),
        "{hostile:?}"
    );
    assert!(hostile.text().contains("x\\u{1b}]0;y\\u{7}"), "{hostile:?}");
}

#[test]
fn files_of_other_kinds_are_refused() {
    let folder = Folder::new();
    folder.write("notes.txt", "Dear reader,\n");
    folder.fails(
        &["notes.txt"],
        1,
        "notes.txt: unknown file type, expected a scene (.scn)",
    );
    fs::write(folder.path("mesh.off.gz"), b"\x1f\x8b\x08\0packed").unwrap();
    folder.fails(
        &["mesh.off.gz"],
        1,
        "mesh.off.gz: this is compressed by gzip (gunzip unpacks it), expected a scene or a mesh",
    );
    folder.fails(&["."], 1, "this is a directory");
    folder.write("scene.txt", "// A scene\nsphere 0 0 0 1\n");
    folder.run_line("scene.txt -s 8x8").succeeded();
    folder.write("misspelt.txt", "sphre 0 0 0 1\n");
    let run = folder.run(&["misspelt.txt"]);
    assert!(run.stderr.starts_with("error: misspelt.txt:1:1: "), "{run:?}");
}

#[test]
fn one_closing_line_on_a_terminal() {
    let folder = Folder::new();
    let Some(run) = on_a_terminal(&folder, "a.scn -s 64x48") else {
        return;
    };
    let says = |run: &Run, start: &str, end: &str| {
        let text = run.text().trim_end();
        assert_eq!((run.code, text.lines().count()), (Some(0), 1), "{run:?}");
        assert!(text.starts_with(start) && text.ends_with(end), "{run:?}");
    };
    says(&run, "wrote a.png (64x48, ", "s)");
    for line in [
        "-s 64x48 --turntable 24 -o a-##.png",
        "--turntable 24 --crop 0,0,64,48 -o a-##.png",
    ] {
        let run = on_a_terminal(&folder, &format!("a.scn {line}")).unwrap();
        says(&run, "wrote 24 pictures, a-01.png to a-24.png (64x48, ", "s)");
    }
    let run = on_a_terminal(&folder, "a.scn -s 64x48 -q").unwrap();
    assert_eq!((run.code, run.text()), (Some(0), ""));
    folder.run_line("a.scn -s 64x48").succeeded();
}
