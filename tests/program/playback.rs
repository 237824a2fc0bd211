//! Animations of glTF files, played.

use crate::{crops::SWING, program::Folder};
use image::RgbImage;

/// The swing, which says that it takes two seconds.
pub fn swing() -> String {
    SWING.replace(
        r#""count":2,"type":"SCALAR""#,
        r#""count":2,"type":"SCALAR","max":[2]"#,
    )
}

fn folder() -> Folder {
    let folder = Folder::new();
    let timed = swing();
    folder.write("swing.gltf", &timed);
    folder.write("endless.gltf", SWING);
    let long = timed.replace(r#""max":[2]"#, r#""max":[1e9]"#);
    folder.write("long.gltf", &long);
    folder
}

fn picture(folder: &Folder, name: &str) -> RgbImage {
    let picture = image::open(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
    picture.into_rgb8()
}

#[test]
fn frames_are_poses() {
    let folder = folder();
    let still = [
        "swing.gltf",
        "-s=40",
        "--animation=swing",
        "--eye=3,1,4",
        "--target=0,0,0",
        "--aov=depth",
    ];
    let played = [&still[..], &["--fps=2", "-o=f#.png"]].concat();
    folder.run(&played).succeeded();
    for (frame, seconds) in ["0", "0.5", "1", "1.5"].iter().enumerate() {
        let time = format!("--animation-time={seconds}");
        folder
            .run(&[&still[..], &[&time, "-o=still.png"]].concat())
            .succeeded();
        // Light differs: it stands around all poses.
        let expected = picture(&folder, "still.depth.png");
        let found = picture(&folder, &format!("f{}.depth.png", frame + 1));
        assert!(found == expected, "{seconds} s");
    }
    assert!(!folder.path("f5.png").exists());
}

#[test]
fn the_camera_sees_all_poses_and_stands_still() {
    let folder = folder();
    let arguments = ["swing.gltf", "-s=48", "--fps=4", "--aov=mask", "-o=f#.png"];
    folder
        .run(&[&arguments[..], &["--save-poses=all.json"]].concat())
        .succeeded();
    let json = std::fs::read_to_string(folder.path("all.json")).expect("poses");
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let frames = json["frames"].as_array().expect("frames");
    assert_eq!(frames.len(), 8);
    let mut touched = [false; 4];
    for (i, frame) in frames.iter().enumerate() {
        assert_eq!(frame["transform_matrix"], frames[0]["transform_matrix"], "{i}");
        let mask = picture(&folder, &format!("f{}.mask.png", i + 1));
        for (x, y, pixel) in mask.enumerate_pixels().filter(|(.., pixel)| pixel.0[0] > 0) {
            let gaps = [x, y, 47 - x, 47 - y];
            assert!(gaps.iter().all(|gap| *gap > 0), "{i} {x} {y} {pixel:?}");
            touched = std::array::from_fn(|side| touched[side] || gaps[side] < 4);
        }
    }
    // The margin is 3 % on each side, and the view as narrow as that allows in one direction.
    assert!(
        touched[0] && touched[2] || touched[1] && touched[3],
        "{touched:?}"
    );
    // A part has the frames of the whole.
    let whole = picture(&folder, "f6.png");
    folder
        .run(&[&arguments[..], &["--frames=6"]].concat())
        .succeeded();
    assert!(picture(&folder, "f6.png") == whole);
}

/// A turntable plays nothing.
#[test]
fn frames_per_second_without_an_animation_are_reported() {
    let folder = folder();
    for (options, is_idle) in [
        ("--turntable=2 -o a#.png", true),
        ("--frames=1 -o b#.png", false),
        ("--turntable=2 -o a.gif", false),
    ] {
        let run = folder.run_line(&format!("swing.gltf -s=8 --style=plain --fps=2 {options}"));
        let found = run.stderr.contains("--fps has no effect");
        assert_eq!((run.code, found), (Some(0), is_idle), "{options}: {run:?}");
    }
}

/// Large files are read by several threads, before the pictures have names.
#[test]
fn large_files_are_played() {
    let folder = folder();
    let padded = std::fs::read_to_string(folder.path("swing.gltf")).expect("a file") + &" ".repeat(5 << 20);
    folder.write("large.gltf", &padded);
    folder
        .run(&["large.gltf", "-s=16", "--fps=1", "--style=plain", "-o=a#.png"])
        .succeeded();
    assert!(folder.path("a1.png").exists());
}

/// Tasks show what a call of the whole shows.
#[test]
fn jobs_have_the_frames_per_second() {
    let folder = folder();
    let job = "job swing.gltf -s 16 --fps 2 --chunk 3 -o a#.png --for parallel --into j";
    folder.run_line(job).succeeded();
    let commands = std::fs::read_to_string(folder.path("j/commands.txt")).expect("commands");
    assert_eq!(commands.matches("--fps=2").count(), 2, "{commands}");
}

#[test]
fn animations_are_played_into_one_file() {
    let folder = folder();
    // The first animation, without its name.
    folder
        .run(&["swing.gltf", "-s=16", "--fps=5", "-o=f.y4m", "--style=plain"])
        .succeeded();
    let bytes = std::fs::read(folder.path("f.y4m")).expect("an animation");
    let header = b"YUV4MPEG2 W16 H16 F5:1 Ip A1:1 C444 Xoctray\n";
    assert!(bytes.starts_with(header));
    assert_eq!(bytes.len(), header.len() + 10 * ("FRAME\n".len() + 3 * 16 * 16));
    folder
        .run(&["endless.gltf", "-s=16", "--frames=1-3", "-o=f.gif"])
        .succeeded();
    let info = folder.run(&["info", "swing.gltf"]);
    let info = String::from_utf8(info.succeeded().stdout.clone()).expect("text");
    assert!(info.contains("animation          \"swing\" 2 s\n"), "{info}");
    for (arguments, expected) in [
        (
            "endless.gltf -o a.gif",
            "endless.gltf: the file does not say how long its animation is",
        ),
        (
            "swing.gltf --animation-time 1 -o a.gif",
            "--animation-time shows one pose",
        ),
        ("swing.gltf --frames 50-51 -o a#.png", "the last frame is 50"),
        (
            "swing.gltf --fps 100 --sheet 3 --animation 2",
            "there is no animation `2`, expected `swing`",
        ),
        (
            "swing.gltf --animation-time 1 --frames 1-3 -o a#.png",
            "--animation-time shows one pose",
        ),
        (
            "- --animation swing --frames 1-2 -o a#.png",
            "played from files, not from standard input",
        ),
        (
            "- --animation swing -o a.gif",
            "played from files, not from standard input",
        ),
        ("- -o a.gif", "or name the file of a mesh that moves"),
        ("- -o a#.png", "or name the file of a mesh that moves"),
        (
            "long.gltf --frames 1-2 -o a#.png",
            "25000000000 frames, 25 for each second",
        ),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let line = format!("\"$0\" {} < swing.gltf", arguments.join(" "));
        let run = folder.shell(&line);
        assert!(run.stderr.contains(expected), "{arguments:?}: {}", run.stderr);
        assert!(matches!(run.code, Some(1 | 2)), "{arguments:?}");
    }
}

/// A job makes no tasks that would all fail: it says what rendering says.
#[test]
fn jobs_check_animations_and_lenses() {
    let folder = Folder::new();
    folder.write("swing.gltf", &swing());
    folder.write("c.toml", "animation = 'run'\n");
    for (line, words) in [
        ("a.scn --focus 3", "--focus needs a lens"),
        ("swing.gltf --focus 3", "--focus needs a lens"),
        (
            "swing.gltf --animation run",
            "there is no animation `run`, expected `swing`",
        ),
        (
            "swing.gltf --config c.toml",
            "`swing`; --animation is set in c.toml:1:1",
        ),
    ] {
        let rendered = folder.run_line(&format!("render {line}"));
        let job = folder.run_line(&format!("job {line} --for slurm --into farm"));
        assert!(job.stderr.contains(words), "{line}: {}", job.stderr);
        assert_eq!((job.code, job.stderr), (rendered.code, rendered.stderr), "{line}");
    }
    for (into, options) in [
        ("a", "--animation swing"),
        ("b", "--animation-time 1"),
        ("c", "--focus 3 --aperture 0.1"),
        ("d", "--animation run --keep-going"),
    ] {
        let line = format!("job swing.gltf {options} --for slurm --into {into}");
        folder.run_line(&line).succeeded();
    }
}
