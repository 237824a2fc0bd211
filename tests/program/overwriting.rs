//! Which files a call replaces: under a name that octray chose, only its own.

use crate::program::Folder;
use std::fs;

pub const SMALL: &str = "--size=12x8";
pub const FOREIGN: &str = "was not written by octray; name another file with -o or replace it with --force";

pub fn read(folder: &Folder, name: &str) -> Vec<u8> {
    fs::read(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// The arguments, separated by spaces, fail and leave `file` as it is.
pub fn keeps(folder: &Folder, file: &str, arguments: &str, code: i32, words: &str) {
    let before = read(folder, file);
    let arguments: Vec<&str> = arguments.split(' ').chain([SMALL]).collect();
    folder.fails(&arguments, code, words);
    assert!(read(folder, file) == before, "{arguments:?}");
}

/// The arguments succeed and replace `file`.
pub fn replaces(folder: &Folder, file: &str, arguments: &str) {
    let before = read(folder, file);
    folder.run_line(&format!("{arguments} {SMALL}")).succeeded();
    assert!(read(folder, file) != before, "{arguments}");
    if !matches!(file.rsplit('.').next(), Some("y4m" | "json")) {
        image::open(folder.path(file)).unwrap();
    }
}

/// A PNG file of one pixel with a text.
fn png(keyword: &str, text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.add_text_chunk(keyword.into(), text.into()).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[1, 2, 3]).unwrap();
    writer.finish().unwrap();
    bytes
}

#[test]
fn a_derived_name_replaces_only_pictures_of_octray() {
    let folder = Folder::new();
    let own = png("Software", "octray");
    let other = png("Software", "other");
    for foreign in [
        &other[..],
        &png("Software", "octray 2"),
        &png("Comment", "octray"),
        &own[..20],
        &other[..other.len() / 2],
        b"",
        b"GIF89a",
    ] {
        fs::write(folder.path("a.png"), foreign).unwrap();
        for name in ["", " -o {stem}.png", " -o ./{stem}.png"] {
            keeps(&folder, "a.png", &format!("a.scn{name}"), 1, FOREIGN);
        }
        replaces(&folder, "a.png", "a.scn --force");
        fs::write(folder.path("a.png"), foreign).unwrap();
        // The user typed the name.
        replaces(&folder, "a.png", "a.scn -o a.png");
        replaces(&folder, "a.png", "a.scn --view 2");
    }
    // Whatever follows its text.
    for own in [&own[..], &own[..own.len() - 20]] {
        fs::write(folder.path("a.png"), own).unwrap();
        replaces(&folder, "a.png", "a.scn");
    }
    folder.write("a.png", "kept");
    folder.run(&["a.scn", "--skip-existing"]).succeeded();
    assert_eq!(read(&folder, "a.png"), b"kept");
    assert_eq!(folder.names(), ["a.png", "a.scn"]);
    fs::remove_file(folder.path("a.png")).unwrap();
    fs::create_dir(folder.path("a.png")).unwrap();
    folder.fails(&["a.scn"], 1, "it is a directory");
    folder.fails(&["a.scn", "--force"], 1, "it is a directory");
}

#[test]
fn every_format_but_qoi_has_a_mark() {
    let folder = Folder::new();
    for aovs in ["", " --aov depth,normal,albedo,id,heat"] {
        folder
            .run_line(&format!("a.scn -o {{stem}}.exr {SMALL}{aovs}"))
            .succeeded();
        replaces(&folder, "a.exr", "a.scn -o {stem}.exr --view 2");
        let transparent = "a.scn -o {stem}.exr --view 3 --background transparent";
        replaces(&folder, "a.exr", &format!("{transparent}{aovs}"));
        fs::remove_file(folder.path("a.exr")).unwrap();
    }
    let still = ["ppm", "jpg", "bmp", "tiff"].map(|extension| (extension, ""));
    let moving = ["gif", "apng", "y4m"].map(|extension| (extension, " --turntable=2"));
    for (extension, turntable) in still.into_iter().chain(moving) {
        let name = &format!("a.{extension}");
        let call = |view: u32| format!("a.scn -o {{stem}}.{extension}{turntable} --view {view}");
        folder.run_line(&format!("{} {SMALL}", call(1))).succeeded();
        replaces(&folder, name, &call(2));
        if extension == "tiff" {
            replaces(&folder, name, &format!("{} --background transparent", call(3)));
            replaces(&folder, name, &call(2));
        }
        if turntable.is_empty() {
            replaces(&folder, name, &format!("{} --crop 0,0,12,8", call(3)));
            replaces(&folder, name, &call(2));
            // As another program writes it.
            image::open(folder.path(name))
                .unwrap()
                .save(folder.path(name))
                .unwrap();
        } else {
            let mut bytes = read(&folder, name);
            let mark = bytes.windows(6).position(|bytes| bytes == b"octray").unwrap();
            bytes[mark..mark + 6].copy_from_slice(b"others");
            fs::write(folder.path(name), bytes).unwrap();
        }
        keeps(&folder, name, &call(3), 1, FOREIGN);
        replaces(&folder, name, &format!("{} --force", call(3)));
        replaces(&folder, name, &call(2).replace("{stem}", "a"));
    }
    folder.run_line(&format!("a.scn -o a.qoi {SMALL}")).succeeded();
    let why = "may be another program's (QOI files do not say who wrote them); name another file with -o or replace it with --force";
    keeps(&folder, "a.qoi", "a.scn -o {stem}.qoi --view 2", 1, why);
    replaces(&folder, "a.qoi", "a.scn -o {stem}.qoi --view 2 --force");
}

#[test]
fn frames_aovs_and_differences_are_derived() {
    let folder = Folder::new();
    for (file, arguments) in [
        ("a-0002.png", "a.scn --turntable 2"),
        ("t2.png", "a.scn --turntable 2 -o t#.png"),
        ("a.depth.png", "a.scn --aov depth"),
        ("b.depth.png", "a.scn --aov depth -o b.png"),
    ] {
        folder.write(file, "not octray's");
        keeps(&folder, file, arguments, 1, FOREIGN);
        replaces(&folder, file, &format!("{arguments} --force"));
        folder.run_line(&format!("{arguments} {SMALL}")).succeeded();
    }
    folder
        .run_line(&format!("a.scn -o r.png --view 2 {SMALL}"))
        .succeeded();
    let compare = "a.scn -o c.png --compare r.png";
    let differs = |arguments: &str| {
        let run = folder.run_line(&format!("{arguments} {SMALL}"));
        assert_eq!(run.code, Some(5), "{run:?}");
        image::open(folder.path("c-difference.png")).unwrap();
    };
    differs(compare);
    // Its own.
    differs(compare);
    folder.write("c-difference.png", "not octray's");
    keeps(&folder, "c-difference.png", compare, 1, FOREIGN);
    let typed = format!("{compare} --difference c-difference.png");
    for arguments in [typed, format!("{compare} --force")] {
        folder.write("c-difference.png", "not octray's");
        differs(&arguments);
    }
}

#[test]
#[cfg(unix)]
fn a_file_that_appears_meanwhile_is_kept() {
    let folder = Folder::new();
    if !folder.make_pipe("pipe") {
        return;
    }
    // The picture's name is checked before standard input is read.
    let script = "(\"$0\" - --size=12x8 < pipe; echo $? > code) & \
        exec 3> pipe; sleep 1; echo foreign > stdin.png; cat a.scn >&3; exec 3>&-; wait; exit $(cat code)";
    let run = folder.shell(script);
    run.failed(
        1,
        "cannot write stdin.png: another program has created a file of this name meanwhile",
    );
    assert_eq!(read(&folder, "stdin.png"), b"foreign\n");
    assert_eq!(folder.names(), ["a.scn", "code", "pipe", "stdin.png"]);
}

#[test]
fn names_in_a_config_file_are_not_typed() {
    let folder = Folder::new();
    folder.write("c.toml", "output = 'b.png'\n");
    folder.write("b.png", "kept");
    keeps(&folder, "b.png", "a.scn --config c.toml", 1, FOREIGN);
    replaces(&folder, "b.png", "a.scn --config c.toml --force");
    // Its own.
    replaces(&folder, "b.png", "a.scn --config c.toml --view 2");
    folder.write("b.png", "replaced");
    replaces(&folder, "b.png", "a.scn --config c.toml -o b.png");
    folder
        .run_line(&format!("a.scn -o r.png --view 2 {SMALL}"))
        .succeeded();
    folder.write("c.toml", "difference = 'd.png'\ncompare = 'r.png'\n");
    folder.write("d.png", "kept");
    keeps(&folder, "d.png", "a.scn --config c.toml", 1, FOREIGN);
    folder.write("c.toml", "json = 'j.json'\n");
    folder.write("j.json", "kept");
    keeps(
        &folder,
        "j.json",
        "a.scn --config c.toml",
        1,
        "was not written by octray",
    );
    for _ in 0..2 {
        replaces(&folder, "j.json", "a.scn --json j.json");
        replaces(&folder, "j.json", "a.scn --config c.toml");
    }
    folder.write("c.toml", "force = true\n");
    let run = folder.run(&["a.scn", "--config=c.toml"]);
    assert!(
        run.code == Some(1) && run.stderr.contains("`force` belongs on the command line"),
        "{run:?}"
    );
}

#[test]
fn generated_files_replace_only_generated_ones() {
    let folder = Folder::new();
    // In a directory that does not exist yet.
    folder
        .run_line("generate flake --count 2 -o new --json new/a.json")
        .succeeded();
    assert!(read(&folder, "new/a.json").starts_with(b"{"));
    fs::remove_dir_all(folder.path("new")).unwrap();
    let generate = "generate interior --count 20000";
    for _ in 0..2 {
        folder.run_line(generate).succeeded();
    }
    let names = folder.names();
    assert!(names.len() > 3, "{names:?}");
    for name in names.iter().filter(|name| *name != "a.scn") {
        let own = read(&folder, name);
        folder.write(name, "ply\nformat ascii 1.0\ncomment mine\n");
        let arguments: Vec<&str> = generate.split(' ').collect();
        folder.fails(
            &arguments,
            1,
            "was not made by `octray generate`; name another directory",
        );
        assert!(read(&folder, name).ends_with(b"mine\n"));
        folder.run_line(&format!("{generate} --force")).succeeded();
        assert!(read(&folder, name) == own);
    }
}

/// A picture without its AOV is rendered again, if it is octray's own.
#[test]
fn missing_aovs_are_made() {
    let folder = Folder::new();
    let call = "a.scn --size 8x6 -o b.png --skip-existing";
    folder.run_line(call).succeeded();
    let picture = read(&folder, "b.png");
    folder.run_line(&format!("{call} --aov z,mask")).succeeded();
    assert_eq!(folder.names(), ["a.scn", "b.mask.png", "b.png", "b.z.png"]);
    assert!(read(&folder, "b.png") == picture);
    fs::remove_file(folder.path("b.mask.png")).expect("an AOV");
    folder.write("b.png", "somebody's");
    let line = format!("{call} --aov z,mask");
    folder.fails(
        &line.split(' ').collect::<Vec<_>>(),
        1,
        "b.png exists and was not written by octray",
    );
    folder.run_line(call).succeeded();
    assert_eq!(read(&folder, "b.png"), b"somebody's");
}
