//! Animated scenes: frames in pictures, animations, sheets and jobs, and which options go with them.

use crate::program::Folder;
use std::fs;

const SCENE: &str = "\
light 3 -2 5 0.7
camera eye 3 -1 2 target 0 0 0.3
  at 1
  at 5.5 eye 3 1 2
material 1
instance \"m.obj\"
  at 0 rotate 0 0 1 0
  at 4 rotate 0 0 1 90
include part.scn
";

const PART: &str = "instance m.obj scale 0.3\n  at 2 translate 0 0 0\n  at 4 translate 1 0 0\n";

const SMALL: &str = "--size=24x18";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("m.scn", SCENE);
    folder.write("part.scn", PART);
    folder.write(
        "m.obj",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n",
    );
    folder
}

fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Beside a moving scene, a still one has one frame, whose number is written out.
#[test]
fn jobs_of_moving_and_still_scenes() {
    let folder = folder();
    let scenes = format!("m.scn a.scn {SMALL} --fps 9");
    let all = (1..=6)
        .map(|i| format!("m-{i}.png"))
        .chain(["a-1.png".to_owned()]);
    folder
        .run_line(&format!("{scenes} -o w-{{stem}}-#.png --quiet"))
        .succeeded();
    for (into, options, prefix) in [
        ("frames", "-o f-{stem}-#.png --chunk 4", "f-"),
        ("tiles", "-o t-{stem}-#.png --tiles 2x1", "t-"),
    ] {
        folder
            .run_line(&format!("job {scenes} {options} --for slurm --into {into}"))
            .succeeded();
        for file in ["commands.txt", "merge.txt"] {
            let commands = fs::read_to_string(folder.path(into).join(file)).unwrap_or_default();
            for command in commands.lines() {
                folder.shell(&command.replacen("octray", "\"$0\"", 1)).succeeded();
            }
        }
        for name in all.clone() {
            assert!(
                read(&folder, &format!("{prefix}{name}")) == read(&folder, &format!("w-{name}")),
                "{prefix}{name}"
            );
        }
    }
    // Without -o.
    folder
        .run_line(&format!(
            "job m.scn a.scn {SMALL} --frames 1-1 --for slurm --into default"
        ))
        .succeeded();
    let commands = fs::read_to_string(folder.path("default/commands.txt")).expect("commands");
    for command in commands.lines() {
        folder.shell(&command.replacen("octray", "\"$0\"", 1)).succeeded();
    }
    assert!(read(&folder, "a-0001.png") == read(&folder, "w-a-1.png"));
    assert!(read(&folder, "m-0001.png") == read(&folder, "w-m-1.png"));
}

#[test]
fn frames_are_the_same_in_any_call() {
    let folder = folder();
    // As many frames as the last keyframe says, rounded up.
    folder
        .run(&["m.scn", SMALL, "-o", "w#.png", "--json=w.json"])
        .succeeded();
    assert!(folder.path("w6.png").exists() && !folder.path("w7.png").exists());
    let all: Vec<_> = (1..=6).map(|i| read(&folder, &format!("w{i}.png"))).collect();
    assert!(all.windows(2).all(|two| two[0] != two[1]));
    let json = fs::read_to_string(folder.path("w.json")).expect("JSON");
    let frames: Vec<_> = json
        .lines()
        .map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON")["frame"].as_u64())
        .collect();
    assert_eq!(frames, (1..=6).map(Some).collect::<Vec<_>>());
    // A still picture is the first frame.
    folder.run(&["m.scn", SMALL, "-o", "still.png"]).succeeded();
    assert!(read(&folder, "still.png") == all[0]);
    // One frame, and a part of them.
    folder
        .run(&["m.scn", SMALL, "--frames=4", "-o", "one.png"])
        .succeeded();
    assert!(read(&folder, "one.png") == all[3]);
    folder
        .run(&["m.scn", SMALL, "--frames=2-3", "--mode=scalar", "-o", "s#.png"])
        .succeeded();
    assert!(read(&folder, "s3.png") == all[2] && !folder.path("s4.png").exists());
    // The work of a job in two parts; one is done again.
    folder
        .run_line(&format!(
            "job m.scn {SMALL} -o j#.png --chunk 3 --for slurm --into farm"
        ))
        .succeeded();
    let commands = fs::read_to_string(folder.path("farm/commands.txt")).expect("commands");
    assert_eq!(commands.lines().count(), 2);
    for command in commands.lines() {
        let command = command.replacen("octray", "\"$0\"", 1);
        folder.shell(&command).succeeded();
        fs::remove_file(folder.path("j2.png")).expect("a picture");
        folder.shell(&command).succeeded();
        folder.write("j2.png", "");
    }
    for i in [1, 3, 4, 5, 6] {
        assert!(read(&folder, &format!("j{i}.png")) == all[i - 1], "{i}");
    }
    // Animations, sheets and standard input.
    for name in ["f.gif", "f.apng", "f.y4m"] {
        folder.run(&["m.scn", SMALL, "--fps=5", "-o", name]).succeeded();
    }
    let frame = "FRAME\n".len() + 3 * 24 * 18;
    assert_eq!(
        read(&folder, "f.y4m").len() % frame,
        read(&folder, "f.y4m").len() - 6 * frame
    );
    folder
        .run(&["m.scn", SMALL, "--frames=1-6", "--sheet=3"])
        .succeeded();
    folder
        .shell("\"$0\" - --size=24x18 --frames 5-6 -o p#.png < m.scn")
        .succeeded();
    assert!(read(&folder, "p6.png") == all[5]);
}

#[test]
fn a_turntable_turns_around_what_moves() {
    let folder = folder();
    // The second of two frames is half a turn away, of the scene as it stands then.
    let call = |options: &str| {
        let options = format!("m.scn {SMALL} --target 0,0,0 --up 0,0,1 {options}");
        folder.run_line(&options).succeeded();
    };
    call("--eye 3,-1,2 --turntable 2 -o t#.png");
    call("--eye 3,-1,2 --frames 1 -o first.png");
    call("--eye -3,1,2 --frames 2 -o second.png");
    assert!(read(&folder, "t1.png") == read(&folder, "first.png"));
    let open = |name: &str| image::open(folder.path(name)).expect("a picture").into_rgb8();
    let (turned, second) = (open("t2.png"), open("second.png"));
    let same = turned
        .pixels()
        .zip(second.pixels())
        .filter(|(a, b)| a == b)
        .count();
    assert!(same >= 24 * 18 * 9 / 10, "{same}");
    let info = folder.run(&["info", "m.scn"]);
    assert!(
        info.succeeded()
            .text()
            .contains("6 (6 keyframes move 2 instances and 1 camera)")
    );
}

#[test]
fn frames_that_are_not_there_are_refused() {
    let folder = folder();
    for (line, words) in [
        ("m.scn --frames 4-7 -o f#.png", "from 1 to 6"),
        ("m.scn --frames 2-3 -o f.png", "run of #"),
        ("a.scn --frames 2-3 -o f#.png", "keyframes"),
        ("a.scn --fps 5 -o f.gif", "keyframes"),
        ("a.scn -o f.gif", "keyframes"),
        (
            "a.scn m.scn --frames 2-3 -o {stem}#.png",
            "--frames 2-3: the last frame of a.scn is 1, expected numbers from 1 to 1",
        ),
        (
            "job a.scn m.scn --for slurm --into farm -o {stem}#b##.png",
            "{stem}#b##.png: a.scn has one frame, and in a job the name of its picture has only one run of #",
        ),
    ] {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        folder.fails(&arguments, 2, words);
    }
    folder.fails(&["no.scn", "--frames=2-3", "-o", "f#.png"], 1, "file not found");
    let stdin = folder.shell("\"$0\" - --frames 5-9 -o f#.png < m.scn");
    stdin.failed(2, "from 1 to 6");
    for options in ["-o f.gif", "-o f#.png", "--fps 5 -o f.gif"] {
        let stdin = folder.shell(&format!("\"$0\" - {options} < m.scn"));
        stdin.failed(
            2,
            "the frames of standard input are not known before it is read: give --frames A-B",
        );
    }
    folder.write(
        "thin.scn",
        "camera eye 1 0 0 target 0 0 0\n at 1\n at 3 eye -1 0 0\nsphere 0 0 5 1\n",
    );
    let run = folder.run(&["thin.scn", "-o", "film.gif"]);
    run.failed(1, "thin.scn:1:1: at 2: eye and target");
    assert!(!folder.path("film.gif").exists());
    // It is found before the first picture.
    folder.fails(&["thin.scn", "-o", "f#.png"], 1, "at 2: eye and target");
    assert!(!folder.path("f1.png").exists());
    folder
        .run(&["thin.scn", "-s=9", "-o", "f#.png", "--frames=1"])
        .succeeded();
}

/// The text of a scene says how many frames there are, so the loaded scene has as many.
#[test]
fn instances_that_are_nowhere_have_frames() {
    let folder = folder();
    folder.write("none.txt", "# nothing yet\n");
    folder.write(
        "none.scn",
        "light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0 1\ninstance m.obj placements none.txt\n at 1\n at 3 translate 0 0 1\n",
    );
    let warned = |arguments: &[&str]| {
        let run = folder.run(arguments);
        let expected = (Some(0), "warning: none.txt: no placements\n");
        assert_eq!((run.code, run.stderr.as_str()), expected, "{run:?}");
    };
    warned(&["none.scn", SMALL, "-o", "n#.png"]);
    assert!(read(&folder, "n1.png") == read(&folder, "n3.png") && !folder.path("n4.png").exists());
    warned(&["none.scn", SMALL, "-o", "n.gif"]);
    let info = folder.run(&["info", "none.scn"]);
    assert!(info.text().contains("3 (2 keyframes move nothing)"), "{info:?}");
}

/// Some editors put a byte order mark first.
#[test]
fn frames_are_counted_behind_byte_order_marks() {
    let folder = folder();
    folder.write("marked.scn", "\u{feff}include keys.scn\nsphere 0 0 0 1\n");
    folder.write("keys.scn", "\u{feff}include part.scn\n");
    folder
        .run(&["marked.scn", SMALL, "-q", "--frames=4", "-o", "f.png"])
        .succeeded();
    folder.fails(&["marked.scn", "--frames=5", "-o", "f.png"], 2, "from 1 to 4");
}

/// A camera has a lens if it has one at any keyframe.
#[test]
fn a_lens_that_opens_has_a_focus() {
    let folder = folder();
    let opens =
        "camera a eye 3 0 0 target 0 0 0\n at 1\n at 5 aperture 0.5\nsphere 0 0 0 1\ninstance m.obj\n";
    folder.write("opens.scn", opens);
    folder.write("focused.scn", &opens.replace("\n at 1", " focus 2\n at 1"));
    let frames = [SMALL, "-q", "--frames=1-5"];
    let call = |more: &[&str]| folder.run(&[&frames[..], more].concat()).succeeded().code;
    call(&["opens.scn", "--camera=a", "--focus=2", "-o", "o#.png"]);
    call(&["focused.scn", "-o", "f#.png"]);
    call(&["opens.scn", "-o", "t#.png"]);
    // In the first frame it is a pinhole.
    for (frame, differs) in [(1, false), (5, true)] {
        let [o, f, t] = ["o", "f", "t"].map(|name| read(&folder, &format!("{name}{frame}.png")));
        assert!(o == f && (o != t) == differs, "{frame}");
    }
    folder.write("plain.scn", &opens.replace("aperture 0.5", "eye 4 0 0"));
    for line in [
        "plain.scn --focus=2",
        "opens.scn --focus=2 --aperture=0",
        "opens.scn --focus=2 --view=1",
    ] {
        let arguments: Vec<&str> = line.split(' ').chain(["--frames=5", "-o", "p.png"]).collect();
        folder.fails(&arguments, 2, "--focus needs a lens");
    }
}

#[test]
fn a_frame_without_a_view_is_named() {
    let folder = folder();
    folder.write("c.toml", "up = '0,1,0'\n");
    for (times, frame) in [(["1", "3"], 3), (["3", "1"], 1)] {
        let [at, ends] = times.map(|time| format!("at {time}"));
        let side = format!(" {at}\n");
        let end = format!(" {ends} eye 0 3 0\n");
        let keyframes = if frame == 1 { end + &side } else { side + &end };
        folder.write(
            "turns.scn",
            &format!("camera eye 3 0 0 target 0 0 0\n{keyframes}sphere 0 0 0 1\n"),
        );
        let place = format!("for a view straight down (in frame {frame})");
        folder.fails(&["turns.scn", "--up=0,1,0", "-o", "f#.png"], 2, &place);
        let set = format!("{place}; --up is set in c.toml:1:1");
        folder.fails(&["turns.scn", "--config=c.toml", "-o", "f#.png"], 2, &set);
    }
}
