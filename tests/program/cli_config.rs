//! The config file.

use crate::{playback::swing, program::Folder};
use std::fs;

const SMALL: &str = "--size=24x16";

#[test]
fn a_config_file_gives_defaults_and_the_command_line_wins() {
    let folder = Folder::new();
    folder.write(
        "c.toml",
        "# a comment\nsize = \"9x7\"\nview = 3\nmax-depth = 1\nno-shadows = true\nquiet = false\noutput = \"{stem}.ppm\"\n",
    );
    folder.run(&["a.scn", "--config", "c.toml"]).succeeded();
    folder
        .run_line("a.scn -o same.ppm --size=9x7 --view=3 --max-depth=1 --no-shadows")
        .succeeded();
    let read = |name| fs::read(folder.path(name)).unwrap();
    assert_eq!(read("a.ppm"), read("same.ppm"));
    // --eye replaces `view` of the file, which it excludes.
    folder
        .run_line("a.scn --config=c.toml --eye=3,1,2 -o eye.ppm --max-depth 3")
        .succeeded();
    folder
        .run_line("a.scn -o eye2.ppm --size=9x7 --eye=3,1,2 --no-shadows")
        .succeeded();
    assert_eq!(read("eye.ppm"), read("eye2.ppm"));
    // A default for animations leaves other pictures alone.
    folder.write("fps.toml", "fps = 10\n");
    folder
        .run_line("a.scn --config=fps.toml -o still.ppm --size 9x7")
        .succeeded();
}

#[test]
fn the_default_config_file_is_read() {
    let folder = Folder::new();
    fs::create_dir(folder.path("octray")).unwrap();
    folder.write("octray/config.toml", "size = '8x6'\neye = [3, -1.5, 2]\n");
    let size = |name| image::image_dimensions(folder.path(name)).unwrap();
    folder.run(&["a.scn"]).succeeded();
    assert_eq!(size("a.png"), (8, 6));
    folder.run(&["a.scn", "--no-config", "-o", "b.png"]).succeeded();
    assert_eq!(size("b.png"), (512, 512));
    folder.write("other.toml", "");
    folder
        .run(&["a.scn", "--config=other.toml", "-o", "c.png"])
        .succeeded();
    assert_eq!(size("c.png"), (512, 512));
    folder
        .run(&["a.scn", "--eye=3,-1.5,2", SMALL, "--no-config", "-o", "d.png"])
        .succeeded();
    folder.run(&["a.scn", SMALL, "-o", "e.png"]).succeeded();
    assert_eq!(
        fs::read(folder.path("d.png")).unwrap(),
        fs::read(folder.path("e.png")).unwrap()
    );
    // Only `render` reads it.
    folder.write("octray/config.toml", "nonsense");
    folder.run(&["info", "a.scn"]).succeeded();
    let run = folder.run(&["a.scn"]);
    assert!(
        run.code == Some(1) && run.stderr.contains("config.toml:1:"),
        "{run:?}"
    );
}

#[test]
fn errors_name_the_place() {
    let folder = Folder::new();
    for (text, words) in [
        (
            "sizes = '8x6'\n",
            "c.toml:1:1: `octray render` has no option `sizes`, did you mean `size`?",
        ),
        (
            "\n  nothing-alike = 1\n",
            "c.toml:2:3: `octray render` has no option `nothing-alike`; ",
        ),
        (
            "[render]\nsize = '8x6'\n",
            "c.toml:1:2: a config file has no sections; remove `[render]`",
        ),
        (
            "view = 2\nsize = 1920x1080\n",
            "text needs quotes: size = \"1920x1080\"",
        ),
        (
            "from = front # and centre\n",
            "text needs quotes: from = \"front\"\n",
        ),
        ("quiet = True\n", "`quiet` is a switch, expected true or false"),
        ("config = 'c.toml'\n", "c.toml:1:1"),
        ("view = 2\nsize = '8x'\n", "c.toml:2:8: invalid value '8x'"),
        ("view = 7\n", "c.toml:1:8: invalid value '7'"),
        ("mode = 'slow'\n", "packet, scalar"),
        (
            "quiet = 1\n",
            "c.toml:1:9: `quiet` is a switch, expected true or false",
        ),
        ("view = true\n", "c.toml:1:8: expected a string, a number"),
        ("[view]\na = 1\n", "c.toml:1:"),
        ("view = 1979-05-27\n", "c.toml:1:8"),
        (
            "view = 1\neye = [1, 2, 3]\n",
            "c.toml:2:1: `eye` cannot be used with `view`",
        ),
        ("view = 1\nview = 2\n", "c.toml:2:1"),
        ("view = \n", "c.toml:1:"),
        ("\u{1}", "c.toml:1:"),
        ("view = '\u{1b}[2J'\n", "c.toml:1:"),
        ("x = \"", "c.toml:1:"),
        ("skip-existing = true\ncompare = 'a.png'\n", "c.toml:2:1"),
    ] {
        folder.write("c.toml", text);
        let run = folder.run(&["a.scn", "--config=c.toml"]);
        assert_eq!(run.code, Some(1), "{text}: {run:?}");
        assert!(run.stderr.contains(words), "{text}: {run:?}");
        assert!(!run.stderr.contains('\u{1b}'), "{run:?}");
        assert_eq!(folder.names(), ["a.scn", "c.toml"]);
    }
    fs::write(folder.path("c.toml"), [0xff, 0xfe]).unwrap();
    folder.fails(&["a.scn", "--config=c.toml"], 1, "c.toml: ");
    folder.fails(&["a.scn", "--config=none.toml"], 1, "file not found");
    folder.fails(&["a.scn", "--config=."], 1, "expected a file");
    folder.fails(
        &["a.scn", "--config=c.toml", "--no-config"],
        2,
        "cannot be used with",
    );
}

/// Defaults for meshes leave scenes alone, and a default without the option that it needs has no effect.
#[test]
fn defaults_that_do_not_apply_are_skipped() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.run(&["a.scn", SMALL, "-o", "expected.png"]).succeeded();
    let read = |name| fs::read(folder.path(name)).unwrap();
    for default in [
        "from = \"top\"",
        "ground = true",
        "environment = \"no.hdr\"",
        "environment-rotate = 30",
        "ortho = \"fit\"",
        "animation = \"walk\"",
        "animation-time = 1",
        "point-size = 2",
        "up-axis = \"x\"",
        "smooth-angle = 30",
        "lit-from = [1, 2, 3]",
        "style = \"clay\"",
        "tolerance = 2",
        "allow-pixels = 0.1",
        "difference = \"d.png\"",
        "focus = 2",
        "edge-color = \"ff0000\"",
        "frames = \"2-3\"",
    ] {
        folder.write("c.toml", default);
        folder.run(&["a.scn", SMALL, "--config=c.toml"]).succeeded();
        assert_eq!(read("a.png"), read("expected.png"), "{default}");
    }
    // Typed, they are still refused, and for a mesh they count.
    folder.write(
        "c.toml",
        "ground = true\northo = \"fit\"\nenvironment-rotate = 30\n",
    );
    folder.fails(
        &["a.scn", "--config=c.toml", "--from=top"],
        2,
        "--from applies to meshes only",
    );
    folder.fails(
        &["a.scn", "--config=c.toml", "--ground"],
        2,
        "--ground applies to meshes only",
    );
    folder.fails(&["a.scn", "--environment-rotate=30"], 2, "--environment");
    folder.run(&["a.obj", SMALL, "--config=c.toml"]).succeeded();
    folder
        .run(&["a.obj", SMALL, "--ground", "--ortho=fit", "-o", "same.png"])
        .succeeded();
    assert_eq!(read("a.png"), read("same.png"));
    // A place of the camera that does not frame the mesh, and a light without environments.
    let eye = ["a.obj", SMALL, "--eye=3,1,2"];
    folder
        .run(&[&eye[..], &["--config=c.toml", "-o", "eye.png"]].concat())
        .succeeded();
    folder
        .run(&[&eye[..], &["--ground", "-o", "same.png"]].concat())
        .succeeded();
    assert_eq!(read("eye.png"), read("same.png"));
    folder.write("c.toml", "environment = \"no.hdr\"\n");
    folder
        .run(&["a.obj", SMALL, "--config=c.toml", "--style=plain"])
        .succeeded();
    folder.fails(&["a.obj", SMALL, "--config=c.toml"], 1, "no.hdr");
}

/// Typed options win over defaults that contradict them.
#[test]
fn defaults_that_contradict_the_call_are_left_out() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("swing.gltf", &swing());
    let size = "--size=9x7";
    for (default, with, without) in [
        ("eye = [3, 1, 2]", "a.obj --ortho=fit", "a.obj --ortho=fit"),
        ("view = 2", "a.obj --ortho=fit", "a.obj --ortho=fit"),
        ("focus = 2", "a.obj", "a.obj"),
        (
            "focus = 2",
            "a.obj --aperture=0.5",
            "a.obj --aperture=0.5 --focus=2",
        ),
        ("frames = '1-3'", "a.obj", "a.obj"),
        ("animation-time = 1", "a.obj", "a.obj"),
        ("animation = 'walk'", "a.obj", "a.obj"),
        (
            "animation-time = 1",
            "swing.gltf",
            "swing.gltf --animation-time=1",
        ),
        (
            "frames = '1-3'",
            "swing.gltf --animation-time=1",
            "swing.gltf --animation-time=1",
        ),
        (
            "animation-time = 1",
            "swing.gltf --fps=2 -o a.gif",
            "swing.gltf --fps=2 -o b.gif",
        ),
    ] {
        folder.write("c.toml", default);
        let named = |line: &str, name: &str| {
            let has_name = line.contains(" -o");
            if has_name {
                line.to_owned()
            } else {
                format!("{line} -o {name}")
            }
        };
        folder
            .run_line(&format!("{} {size} --config=c.toml", named(with, "a.png")))
            .succeeded();
        folder
            .run_line(&format!("{} {size} --no-config", named(without, "b.png")))
            .succeeded();
        let is_film = with.contains(" -o");
        let [found, expected] = if is_film {
            ["a.gif", "b.gif"]
        } else {
            ["a.png", "b.png"]
        };
        let read = |name| fs::read(folder.path(name)).unwrap();
        assert_eq!(read(found), read(expected), "{default} {with}");
    }
}

#[test]
fn errors_say_where_a_default_is_set() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("swing.gltf", &swing());
    for (default, line, code, words) in [
        (
            "\nframes = '1-3'\n",
            "a.obj --turntable=2 -o a#.png",
            2,
            "expected numbers from 1 to 2; --frames is set in c.toml:2:1",
        ),
        (
            "animation = 'walk'\n",
            "swing.gltf",
            2,
            "there is no animation `walk`, expected `swing`; --animation is set in c.toml:1:1",
        ),
        (
            "animation = 'walk'\n",
            "swing.gltf --keep-going",
            1,
            "there is no animation `walk`, expected `swing`; --animation is set in c.toml:1:1",
        ),
        (
            "turntable = 4\n",
            "a.obj --frames=1-9 -o a#.png",
            2,
            "expected numbers from 1 to 4; --turntable is set in c.toml:1:1",
        ),
        ("frames = '1-3'\n", "a.obj -o a#.png", 2, "there are no frames"),
        ("frames = '1-3'\n", "a.obj --focus=2", 2, "--focus needs a lens"),
    ] {
        folder.write("c.toml", default);
        let line = format!("{line} --config=c.toml");
        let run = folder.run_line(&line);
        assert!(
            run.code == Some(code) && run.stderr.contains(words),
            "{line}: {run:?}"
        );
    }
    folder.write("c.toml", "animation-time = 1\n");
    let run = folder.shell("\"$0\" - -o a.png --config=c.toml < a.obj");
    run.failed(2, "; --animation-time is set in c.toml:1:1");
    folder
        .run_line("job --for=parallel --into=farm a.obj --config=c.toml --tiles=1x1")
        .succeeded();
    let commands = fs::read_to_string(folder.path("farm/commands.txt")).unwrap();
    assert!(!commands.contains("--animation-time"), "{commands}");
}

/// Numbers, names and files, whether the message names their option or not.
#[test]
fn values_of_defaults_are_explained() {
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (defaults, line, code, option) in [
        ("ortho = -1", "a.obj", 2, "ortho"),
        ("eye = [1, 1, 1]", "a.obj --target=1,1,1", 2, "eye"),
        ("size = '99999x99999'", "a.obj", 1, "size"),
        ("max-memory = '1K'", "a.obj", 1, "max-memory"),
        ("camera = 'nope'", "a.scn", 2, "camera"),
        ("environment = 'nope.hdr'", "a.obj", 1, "environment"),
        ("poses = 'nope'", "a.obj", 1, "poses"),
        ("compare = 'nope.png'", "a.obj", 1, "compare"),
        ("output = 'x.webp'", "a.obj", 2, "output"),
        ("json = 'no/x'", "a.obj", 1, "json"),
        ("background = 'transparent'", "a.obj -o a.jpg", 2, "background"),
    ] {
        folder.write("c.toml", &format!("# One.\n{defaults}\n"));
        let run = folder.run_line(&format!("{line} --config=c.toml"));
        run.failed(code, &format!("; --{option} is set in c.toml:2:1"));
    }
    // What is typed is to blame.
    folder.write("c.toml", "fov = 30\noutput = 'a.png'\nsize = '8x8'\n");
    for line in ["a.obj -o a.webp", "no.obj", "a.obj --json=no/x"] {
        let run = folder.run_line(&format!("{line} --config=c.toml"));
        assert!(
            run.code != Some(0) && !run.stderr.contains("is set in"),
            "{run:?}"
        );
    }
}

/// The calls of a job have only the defaults that apply to their scene.
#[test]
fn jobs_of_scenes_have_no_defaults_for_meshes() {
    let folder = Folder::new();
    folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write(
        "c.toml",
        "ground = true\nstyle = \"clay\"\nfrom = \"top\"\northo = \"fit\"\n",
    );
    let job = "job --for=parallel --into=farm a.scn b.obj --config=c.toml --tiles=1x1";
    folder.run_line(job).succeeded();
    let commands = fs::read_to_string(folder.path("farm/commands.txt")).unwrap();
    let (of_mesh, of_scene): (Vec<_>, Vec<_>) = commands.lines().partition(|line| line.ends_with("b.obj"));
    for option in ["--ground", "--style=clay", "--from=top", "--ortho=fit"] {
        assert!(of_mesh.iter().all(|line| line.contains(option)), "{commands}");
        assert!(!of_scene.iter().any(|line| line.contains(option)), "{commands}");
    }
    assert_eq!((of_mesh.len(), of_scene.len()), (1, 1), "{commands}");
    folder.write(
        "d.toml",
        "ortho = \"fit\"\nstyle = \"plain\"\nenvironment = \"sky.hdr\"\n",
    );
    let job = "job --for=parallel --into=other b.obj --config=d.toml --tiles=1x1 --eye=3,3,3";
    folder.run_line(job).succeeded();
    let commands = fs::read_to_string(folder.path("other/commands.txt")).unwrap();
    assert!(
        !commands.contains("--ortho") && !commands.contains("--environment"),
        "{commands}"
    );
}

/// A default of the focus applies where there is a lens, also one of the scene's own camera.
#[test]
fn jobs_focus_the_lens_of_a_scene() {
    let folder = Folder::new();
    folder.write("plain.scn", "camera eye 3 3 3 target 0 0 0\nsphere 0 0 0 1\n");
    folder.write(
        "lens.scn",
        "camera eye 3 3 3 target 0 0 0 aperture 0.5\nsphere 0 0 0 1\n",
    );
    let opens = "camera eye 3 3 3 target 0 0 0\n at 1\n at 5 aperture 0.5\nsphere 0 0 0 1\n";
    folder.write("opens.scn", opens);
    folder.write("c.toml", "focus = 2\n");
    for (options, is_focused) in [
        ("plain.scn", false),
        ("opens.scn --frames=1", true),
        ("lens.scn", true),
        ("lens.scn --view=2", false),
        ("lens.scn --aperture=0", false),
        ("plain.scn --aperture=0.2", true),
    ] {
        let options = format!("{options} --config=c.toml --size=9x7");
        let job = format!("job --for=parallel --into=farm --tiles=1x1 {options} -o a.png");
        folder.run_line(&job).succeeded();
        let commands = fs::read_to_string(folder.path("farm/commands.txt")).unwrap();
        assert_eq!(
            commands.contains(" --focus=2 "),
            is_focused,
            "{options}: {commands}"
        );
        fs::remove_dir_all(folder.path("farm")).unwrap();
    }
}
