//! The config file, completions and manual pages.

use crate::program::Folder;
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
            "c.toml:1:2: `render`: the options are not in sections",
        ),
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

#[test]
fn completions_for_every_shell() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = folder.run(&["completions", shell]);
        let text = run.succeeded().text();
        for word in ["octray", "turntable", "generate"] {
            assert!(text.contains(word), "{shell}: {word}");
        }
    }
    folder.fails(&["completions", "csh"], 2, "bash");
    let run = folder.shell("\"$0\" completions bash > c.sh && bash -n c.sh");
    run.succeeded();
}

#[test]
fn every_command_has_a_manual_page() {
    let folder = Folder::new();
    let run = folder.run(&["man"]);
    let page = run.succeeded().text();
    assert!(page.contains(".TH octray 1") && page.contains("render"), "{page}");
    for command in [
        "render",
        "info",
        "bench",
        "generate",
        "merge",
        "job",
        "completions",
        "man",
    ] {
        let run = folder.run(&["man", command]);
        let page = run.succeeded().text();
        assert!(page.contains(&format!("octray-{command}")), "{page}");
        assert!(page.contains("OPTIONS"), "{page}");
    }
    folder.fails(&["man", "rendre"], 2, "expected one of render, ");
}
