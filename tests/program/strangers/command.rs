//! Calls of the command line: options, config files, references, standard streams.

use super::Call;
use crate::{long::rounds, program::Folder};
use std::fs::{self, File};

/// Words that act on a terminal, hide or reorder: ESC, BEL, C1, and characters of Unicode.
const HOSTILE: &str = "a\u{1b}]0;x\u{7}\u{9b}2J\u{85}\u{61c}\u{200b}\u{202e}\u{2066}\u{2028}b";
const SCENE: &str = "light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.5\n";

fn run(folder: &Folder, arguments: &[&str]) -> super::harness::Ended {
    Call::new(folder, arguments).run()
}

#[test]
fn hostile_names_do_not_act_on_a_terminal() {
    let folder = Folder::new();
    let name = |extension: &str| format!("{HOSTILE}{extension}");
    let scene = &name(".scn")[..];
    folder.write(scene, SCENE);
    folder.write(
        &name(".obj"),
        &format!("mtllib {HOSTILE}\nusemtl {HOSTILE}\no {HOSTILE}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    );
    folder.write("noise.png", HOSTILE);
    let small = "--size=8x8";
    let calls: &[&[&str]] = &[
        &[scene, small],
        &[scene, small, "--stats"],
        &[scene, small, "--json", "-", "-o", "a.png"],
        &[scene, small, "--json", &name(".json")],
        &[scene, small, "--json", &name("/x.json")],
        &[
            scene,
            small,
            "-o",
            &name(".png"),
            "--aov",
            "depth,heat",
            "--stats",
        ],
        &[scene, small, "-o", &name("/x.png")],
        &[scene, small, "-o", &name(".x")],
        &[scene, small, "--compare", "noise.png"],
        &[scene, small, "--compare", &name(".png")],
        &[scene, small, "--compare", &name(".none")],
        &[scene, small, "--camera", HOSTILE],
        &[scene, small, "--ground"],
        &[scene, "a.scn", small, "-o", &name(".png")],
        &[scene, scene, small],
        &[scene, "--size", HOSTILE],
        &[scene, "--view", HOSTILE],
        &[scene, "--aov", HOSTILE],
        &[scene, "--config", HOSTILE],
        &[scene, &format!("--{HOSTILE}")],
        &[scene, &format!("--size={HOSTILE}"), "--view=9"],
        &[scene, "--crop", HOSTILE, "--crop", HOSTILE],
        &["info", scene],
        &["info", scene, "--json", "-"],
        &["info", scene, "--json", &name(".json")],
        &["info", HOSTILE],
        &["info", &name(".obj")],
        &["info", &name(".obj"), "--json", "-"],
        &[&name(".obj"), small],
        &["bench", scene, small, "--repeat=1", "--method=packet"],
        &["bench", scene, small, "--method", HOSTILE],
        &["verify", "--rays", HOSTILE],
        &["generate", HOSTILE],
        &["generate", "spheres", "--count=9", "-o", HOSTILE],
        &["man", HOSTILE],
        &["completions", HOSTILE],
        &[HOSTILE],
    ];
    for call in calls {
        run(&folder, call);
    }
}

#[test]
fn json_holds_the_name_as_it_is() {
    let folder = Folder::new();
    let scene = format!("{HOSTILE}.scn");
    folder.write(&scene, SCENE);
    for arguments in [
        &["info", &scene, "--json", "-"][..],
        &[&scene, "--json", "-", "--size=8x8"],
    ] {
        let ended = run(&folder, arguments);
        let json: serde_json::Value = serde_json::from_str(&ended.stdout).unwrap();
        assert_eq!(json["scene"], scene.as_str());
    }
}

#[test]
fn hostile_words_of_files_do_not_act_on_a_terminal() {
    let folder = Folder::new();
    let quoted = format!("\"{}\"", HOSTILE.replace('\u{85}', ""));
    for (i, text) in [
        HOSTILE.to_owned(),
        format!("include {quoted}\n"),
        format!("mesh {quoted}.obj\n"),
        "camera \"\u{1b}[2J\u{202e}\" eye 3 1 1 target 0 0 0\nsphere 0 0 0 1\n".to_owned(),
        format!("sphere 0 0 0 {HOSTILE}\n"),
    ]
    .iter()
    .enumerate()
    {
        let name = format!("{i}.scn");
        folder.write(&name, text);
        run(&folder, &[&name, "--size=8x8"]);
        run(&folder, &["info", &name]);
        run(&folder, &["info", &name, "--json", "-"]);
        run(&folder, &[&name, "--size=8x8", "--camera", "\u{1b}[2K"]);
    }
    for text in [
        format!("{HOSTILE} = 1\n"),
        "\"\\u001b[2J\\u202e\" = 1\n".to_owned(),
        "camera = \"\\u001b[2J\\u202e\\u061c\"\n".into(),
        "size = \"\\u001b[2J\\u202e\\u061c\"\n".into(),
        "output = \"\\u001b[2J\\u202e\\u061c.png\"\n".into(),
        "compare = \"\\u001b[2J\\u202e\\u061c.png\"\n".into(),
        "output = \"\\u001b[2J\\u202e\\u061c\"\n".into(),
    ] {
        folder.write("c.toml", &text);
        run(&folder, &["a.scn", "--config=c.toml", "--size=8x8", "--stats"]);
        run(&folder, &["a.scn", "--config=c.toml"]);
    }
}

#[test]
fn long_words_are_cut() {
    let folder = Folder::new();
    // Near the most that the system takes as one argument.
    let argument = "\u{e9}".repeat(60_000);
    let option = format!("--{argument}");
    let calls: &[&[&str]] = &[
        &[&argument],
        &["info", &argument],
        &["a.scn", "-o", &argument],
        &["a.scn", "--camera", &argument],
        &["a.scn", "--size", &argument],
        &["a.scn", "--json", &argument],
        &["a.scn", "--compare", &argument],
        &["a.scn", "--config", &argument],
        &["a.scn", &option],
        &["man", &argument],
        &["generate", "spheres", "--count=9", "-o", &argument],
    ];
    for call in calls {
        run(&folder, call);
    }
    for key in ["camera", "size", "output", "compare", "eye", "aov", "nonsense"] {
        folder.write("c.toml", &format!("{key} = '{}'\n", "x".repeat(250_000)));
        run(&folder, &["a.scn", "--config=c.toml"]);
    }
    folder.write("c.toml", &format!("{} = 1\n", "x".repeat(250_000)));
    run(&folder, &["a.scn", "--config=c.toml"]);
    let word = "w".repeat(1_000_000);
    for (name, text) in [
        ("w.scn", word.clone()),
        (
            "w.obj",
            format!("mtllib {word}\no {word}\nusemtl {word}\n{word} 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ),
        (
            "w.ply",
            format!("ply\nformat ascii 1.0\ncomment {word}\nelement {word} 1\n"),
        ),
        ("w.stl", format!("solid {word}\nfacet {word}\n")),
        (
            "w.gltf",
            format!(
                r#"{{"asset":{{"version":"2.0"}},"extensionsUsed":["{word}"],"images":[{{"uri":"{word}"}}],
                "cameras":[{{"type":"{word}"}}],"buffers":[{{"uri":"{word}","byteLength":3}}]}}"#
            ),
        ),
    ] {
        folder.write(name, &text);
        run(&folder, &[name]);
        run(&folder, &["info", name]);
    }
}

#[test]
fn long_lists_are_cut() {
    let folder = Folder::new();
    let mut text = String::from("sphere 0 0 0 1\n");
    for i in 0..1000 {
        text += &format!("camera \"camera {i}\" eye 3 1 {i} target 0 0 0\nlight 3 1 {i} 0.001\n");
        text += &format!(
            "material matte cd 1 0 {}\nsphere {i} 0 0 0.1\n",
            f64::from(i) / 1000.0
        );
    }
    folder.write("many.scn", &text);
    let ended = run(&folder, &["info", "many.scn"]);
    for words in ["and 994 more", "and 995 more"] {
        assert!(ended.stdout.contains(words), "{words}: {}", ended.stdout);
    }
    run(&folder, &["many.scn", "--camera", "x", "--size=8x8"]);
    // Each of the meshes has something to say.
    let mut text = String::new();
    for i in 0..300 {
        text += &format!("mesh {i}.obj\n");
        folder.write(
            &format!("{i}.obj"),
            "usemtl none\nvt 0 0\nl 1 2\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        );
    }
    folder.write("noted.scn", &text);
    let ended = run(&folder, &["noted.scn", "--size=8x8"]);
    assert!(ended.stderr.lines().count() <= 21, "{}", ended.stderr);
    assert!(ended.stderr.contains("more warnings"), "{}", ended.stderr);
    run(&folder, &["info", "noted.scn"]);
}

#[test]
fn references_are_bounded() {
    let folder = Folder::new();
    run(&folder, &["a.scn", "--size=8x8", "-o", "r.jpg", "--quiet"]);
    run(&folder, &["a.scn", "--size=8x8", "-o", "r.png", "--quiet"]);
    fs::copy(folder.path("r.jpg"), folder.path("large.jpg")).unwrap();
    for name in ["r.jpg", "r.png"] {
        File::options()
            .write(true)
            .open(folder.path(name))
            .unwrap()
            .set_len(5 << 30)
            .unwrap();
        Call::new(
            &folder,
            &["a.scn", "--size=8x8", "-o", "a.png", "--compare", name],
        )
        .refused("the file has 5.0 GiB, expected at most");
    }
    let call = [
        "a.scn",
        "--size=4096x4096",
        "-o",
        "a.png",
        "--compare",
        "large.jpg",
    ];
    let large = File::options()
        .write(true)
        .open(folder.path("large.jpg"))
        .unwrap();
    large.set_len(300 << 20).unwrap();
    Call::new(&folder, &call)
        .within(50)
        .refused("a picture of 4096x4096 needs");
    for name in [".", "/dev/zero", "/dev/stdin"] {
        Call::new(
            &folder,
            &["a.scn", "--size=8x8", "-o", "a.png", "--compare", name],
        )
        .refused("expected a file");
    }
    if folder.make_pipe("pipe") {
        Call::new(&folder, &["a.scn", "--size=8x8", "--compare", "pipe"]).refused("expected a file");
        Call::new(&folder, &["a.scn", "--config", "pipe"]).refused("expected a file");
    }
    // Broken pictures, among them sizes that are not there.
    run(&folder, &["a.scn", "--size=64x64", "-o", "whole.exr", "--quiet"]);
    for name in [
        "whole.png",
        "whole.jpg",
        "whole.bmp",
        "whole.tiff",
        "whole.qoi",
        "whole.ppm",
        "whole.exr",
    ] {
        run(&folder, &["a.scn", "--size=64x64", "-o", name, "--quiet"]);
        let whole = fs::read(folder.path(name)).unwrap();
        for step in (0..24).step_by(rounds(2, 1)) {
            let mut broken = whole.clone();
            if step < 12 {
                broken.truncate(whole.len() * step / 12);
            } else {
                for byte in broken.iter_mut().skip((step - 12) * 4).take(4) {
                    *byte = 0xff;
                }
            }
            fs::write(folder.path("broken"), broken).unwrap();
            let call = [
                "a.scn",
                "--size=64x64",
                "-o",
                "b.png",
                "--compare",
                "broken",
                "--force",
                "--allow-pixels=1",
            ];
            run(&folder, &call);
        }
    }
}

#[test]
fn options_that_make_lists_are_limited() {
    let folder = Folder::new();
    folder.write("c.toml", "frames = '1-4294967295'\nturntable = 10000\n");
    Call::new(&folder, &["a.scn", "--config=c.toml"]).refused("expected numbers from 1 to 10000");
    let calls: &[&[&str]] = &[
        &["a.scn", "--turntable=10000", "--frames=1-4294967295"],
        &[&["a.scn"; 11][..], &["--turntable=10000"]].concat(),
        &["bench", "a.scn", "--frames=4294967295"],
        &["bench", "a.scn", "--repeat=4294967295"],
        &["bench", "a.scn", "--size=16384x16384"],
        &["bench", "--all", "--size=16384x16384"],
        &["a.scn", "--size=16384x16384"],
        &["a.scn", "--size=8x8", "--threads=4096", "--quiet"],
        &[
            "a.scn",
            "--size=8x8",
            "--threads=4096",
            "--samples=4",
            "--mode=scalar",
            "--quiet",
        ],
        &["generate", "spheres", "--count=18446744073709551615"],
    ];
    for call in calls {
        run(&folder, call);
    }
}

#[test]
fn nothing_is_rendered_of_nothing() {
    let folder = Folder::new();
    for arguments in [&["-"][..], &["info", "-"], &["bench", "-"]] {
        Call::new(&folder, arguments).refused("the input is empty");
    }
    folder.write("blank", "\n  \n");
    let blank = || File::open(folder.path("blank")).unwrap();
    Call::new(&folder, &["info", "-"]).with_input(blank()).run();
    let within = Call::new(&folder, &["-", "--size=8x8", "--quiet"]).within(200);
    within.with_input(File::open(folder.path("a.scn")).unwrap()).run();
}
