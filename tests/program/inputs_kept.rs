//! No output of a call replaces a file that the call reads.

use crate::{
    overwriting::{FOREIGN, SMALL, keeps, read, replaces},
    program::Folder,
};
use std::fs;

fn write_mesh(folder: &Folder, name: &str) {
    let text = format!("mtllib {name}.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.write(&format!("{name}.obj"), &text);
    let text = "newmtl a\nKd 1 0 0\nmap_Kd -s 1 1 1 -clamp on wood.png\nmap_Bump -bm 0.2 deep\\bump 1.png\n";
    folder.write(&format!("{name}.mtl"), text);
}

#[test]
fn files_of_the_command_line_are_kept() {
    let folder = Folder::new();
    for name in ["a.ppm", "b1.ppm"] {
        fs::copy(folder.path("a.scn"), folder.path(name)).unwrap();
    }
    folder.write("config.png", "");
    folder.write("b.scn", "sphere 0 0 0 1\n");
    folder.run_line(&format!("a.scn -o r.png {SMALL}")).succeeded();
    folder.run_line(&format!("a.scn -o a.png {SMALL}")).succeeded();
    for force in ["", " --force"] {
        for (file, arguments, words) in [
            (
                "a.ppm",
                "./a.ppm -o a.ppm",
                "would replace the scene, ./a.ppm; write to another",
            ),
            ("a.ppm", "a.ppm -o {stem}.ppm", "would replace the scene;"),
            // The first scene's picture is the second scene.
            (
                "b1.ppm",
                "b.scn b1.ppm -o {stem}#.ppm --turntable 1",
                "b1.ppm would replace the scene;",
            ),
            (
                "r.png",
                "a.scn -o r.png --compare r.png",
                "r.png would replace the reference;",
            ),
            (
                "a.png",
                "a.scn --compare a.png",
                "a.png would replace the reference;",
            ),
            (
                "a.png",
                "a.scn -o b.png --compare a.png --difference a.png",
                "a.png would replace the reference;",
            ),
            (
                "config.png",
                "a.scn -o config.png --config config.png",
                "config.png would replace the config file;",
            ),
        ] {
            keeps(&folder, file, &format!("{arguments}{force}"), 2, words);
        }
    }
    // The default config file.
    fs::create_dir(folder.path("octray")).unwrap();
    folder.write("octray/config.toml", "view = 2\n");
    fs::hard_link(folder.path("octray/config.toml"), folder.path("c.png")).unwrap();
    let words = "c.png would replace the config file, ";
    keeps(&folder, "c.png", "a.scn -o c.png", 2, words);
    replaces(&folder, "c.png", "a.scn -o c.png --no-config");
}

/// A mesh with a material library that names textures.
#[test]
fn files_of_a_scene_are_kept() {
    let folder = Folder::new();
    write_mesh(&folder, "bunny");
    fs::create_dir(folder.path("deep")).unwrap();
    for texture in ["wood.png", "deep/bump 1.png", "bunny.png", "gltf.png"] {
        folder.write(texture, "a texture");
    }
    fs::hard_link(folder.path("bunny.mtl"), folder.path("link.png")).unwrap();
    fs::hard_link(folder.path("deep/bump 1.png"), folder.path("bump.png")).unwrap();
    folder.write("all.scn", "include part.ppm\n");
    folder.write("part.ppm", "light 1 2 3 1\nmaterial 1\nmesh bunny.obj\n");
    folder.write_gltf(
        "g",
        r#""images":[{"uri":"gl%74f.png"}],"textures":[{"source":0}]"#,
    );
    fs::hard_link(folder.path("g.bin"), folder.path("buffer.png")).unwrap();
    // The texture of the same name is foreign.
    keeps(&folder, "bunny.png", "bunny.obj", 1, FOREIGN);
    for force in ["", " --force"] {
        for (file, arguments, words) in [
            (
                "wood.png",
                "bunny.obj -o wood.png",
                "wood.png would replace a file of bunny.obj;",
            ),
            (
                "wood.png",
                "all.scn -o wood.png",
                "wood.png would replace a file of all.scn;",
            ),
            (
                "bump.png",
                "bunny.obj -o bump.png",
                "a file of bunny.obj, deep/bump 1.png; write to",
            ),
            (
                "link.png",
                "bunny.obj -o link.png",
                "a file of bunny.obj, bunny.mtl;",
            ),
            ("link.png", "all.scn -o link.png", "a file of all.scn, bunny.mtl;"),
            ("part.ppm", "all.scn -o part.ppm", "a file of all.scn;"),
            ("gltf.png", "g.gltf -o gltf.png", "a file of g.gltf;"),
            ("buffer.png", "g.gltf -o buffer.png", "a file of g.gltf, g.bin;"),
        ] {
            keeps(&folder, file, &format!("{arguments}{force}"), 2, words);
        }
    }
    // From standard input.
    let run = folder.shell("\"$0\" - -o part.ppm < all.scn");
    run.failed(2, "a file of -");
    assert!(read(&folder, "part.ppm").starts_with(b"light"));
    replaces(&folder, "bunny.png", "bunny.obj --force --quiet");
}

#[test]
fn a_picture_replaces_no_file_of_the_next_scene() {
    let folder = Folder::new();
    write_mesh(&folder, "m");
    fs::copy(folder.path("m.obj"), folder.path("b.png")).unwrap();
    folder.write("b.scn", "sphere 0 0 0 1\n");
    folder.write("c.scn", "include d.scn\n");
    folder.write("d.scn", "light 1 2 3 1\nsphere 0 0 0 1\ninclude b.png\n");
    let words = "b.png would replace a file of c.scn;";
    keeps(&folder, "b.png", "b.scn c.scn --force", 2, words);
    assert!(!folder.path("c.png").exists());
}

#[test]
#[cfg(unix)]
fn links_lead_to_the_same_file() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    symlink("a.scn", folder.path("link.png")).unwrap();
    fs::hard_link(folder.path("a.scn"), folder.path("hard.png")).unwrap();
    fs::create_dir(folder.path("deep")).unwrap();
    symlink("../a.scn", folder.path("deep/a.png")).unwrap();
    symlink("deep", folder.path("folder")).unwrap();
    for name in ["link.png", "hard.png", "deep/a.png", "folder/a.png"] {
        let words = format!("{name} would replace the scene, a.scn;");
        keeps(&folder, "a.scn", &format!("a.scn --force -o {name}"), 2, &words);
    }
    // A derived name that is a link to a foreign file, to an own one, to nothing.
    folder.write("foreign", "kept");
    symlink("foreign", folder.path("a.png")).unwrap();
    keeps(&folder, "foreign", "a.scn", 1, FOREIGN);
    folder.run_line(&format!("a.scn -o own.png {SMALL}")).succeeded();
    for target in ["own.png", "new.png"] {
        fs::remove_file(folder.path("a.png")).unwrap();
        symlink(target, folder.path("a.png")).unwrap();
        folder.run_line(&format!("a.scn --view 2 {SMALL}")).succeeded();
        assert!(fs::symlink_metadata(folder.path("a.png")).unwrap().is_symlink());
    }
    assert_eq!(read(&folder, "own.png"), read(&folder, "new.png"));
}

/// Files named after a fault are not known, so nothing is replaced.
#[test]
fn a_faulty_later_scene_loses_nothing() {
    let folder = Folder::new();
    folder.write("part.inc", "sphere 0 0 0 1\n");
    folder.write("b.scn", "bogus\ninclude part.inc\n");
    let own = read(&folder, "part.inc");
    let run = folder.run_line("a.scn b.scn -q -o {stem}.png --json part.inc");
    assert_eq!(run.code, Some(1), "{run:?}");
    assert!(run.stderr.contains("b.scn:1:1: unknown statement"), "{run:?}");
    assert!(read(&folder, "part.inc") == own);
    assert!(!folder.path("a.png").exists());
}

#[test]
#[cfg(target_os = "linux")]
fn standard_output_is_no_input() {
    let folder = Folder::new();
    let own = read(&folder, "a.scn");
    for script in [
        "\"$0\" a.scn -s 8x8 -o - 1<>a.scn",
        "\"$0\" a.scn -s 8x8 -o - >> a.scn",
        "\"$0\" - -s 8x8 -o - <> a.scn >&0",
    ] {
        let run = folder.shell(script);
        run.failed(2, "standard output would replace ");
        assert!(read(&folder, "a.scn") == own, "{script}");
    }
    for script in [
        "\"$0\" a.scn -s 8x8 -o - --json /dev/stdout > x.png",
        "\"$0\" a.scn -s 8x8 -o x.png --json - > x.png",
    ] {
        let run = folder.shell(script);
        run.failed(2, "both the picture and the JSON would be written to ");
    }
}

#[test]
fn json_files_are_no_files_of_the_scene() {
    let folder = Folder::new();
    folder.write("all.scn", "include a.scn\n");
    let bench = "--size=4x4 --repeat=1 --method=scalar --json";
    for (file, scene) in [("all.scn", "the scene"), ("a.scn", "a file of all.scn")] {
        let before = read(&folder, file);
        let run = folder.run_line(&format!("bench all.scn {bench} {file}"));
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(
            run.stderr.contains(&format!("{file} would replace {scene};")),
            "{run:?}"
        );
        assert_eq!(read(&folder, file), before);
    }
    for _ in 0..2 {
        folder
            .run_line(&format!("bench all.scn {bench} new.json"))
            .succeeded();
    }
    for arguments in ["all.scn", "info all.scn", "- < all.scn"] {
        let run = folder.shell(&format!("\"$0\" {arguments} --json a.scn"));
        run.failed(2, "a.scn would replace a file of ");
    }
}

/// Every output against every file that the call reads, by its name, by links, and through the folder.
#[test]
#[cfg(unix)]
fn no_output_is_an_input() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    folder
        .run_line(&format!("a.scn -o r.png --aov depth,normal {SMALL}"))
        .succeeded();
    fs::copy(folder.path("r.depth.png"), folder.path("n.depth.png")).unwrap();
    fs::hard_link(folder.path("n.depth.png"), folder.path("hard.png")).unwrap();
    symlink("n.depth.png", folder.path("soft.png")).unwrap();
    symlink(".", folder.path("here")).unwrap();
    folder.write("c.toml", "view = 1\n");
    fs::hard_link(folder.path("c.toml"), folder.path("c.depth.png")).unwrap();
    let kept = "n.depth.png";
    for (file, arguments) in [
        // A layer of its own reference.
        (kept, "a.scn -o n.png --aov depth --compare n.depth.png"),
        (kept, "a.scn -o n.png --aov depth --compare hard.png"),
        (kept, "a.scn -o n.png --aov depth --compare soft.png"),
        (kept, "a.scn -o here/n.png --aov depth --compare soft.png"),
        (
            kept,
            "a.scn -o ./here/n.png --aov depth --compare here/here/n.depth.png",
        ),
        (kept, "a.scn -o soft.png --compare hard.png"),
        (
            kept,
            "a.scn -o d.png --compare hard.png --difference here/soft.png",
        ),
        (kept, "a.scn -o d.png --compare hard.png --json here/soft.png"),
        ("c.toml", "a.scn -o c.png --aov depth --config c.toml"),
        ("c.toml", "a.scn -o d.png --json c.depth.png --config c.toml"),
        ("a.scn", "a.scn -o d.png --json here/a.scn"),
        ("a.scn", "a.scn -o d.png --save-poses here/a.scn"),
    ] {
        for force in ["", " --force"] {
            keeps(
                &folder,
                file,
                &format!("{arguments}{force}"),
                2,
                "would replace the ",
            );
        }
    }
    // Two outputs of one call.
    symlink("new.png", folder.path("json.json")).unwrap();
    for line in [
        "a.scn -o new.png --json json.json",
        "a.scn -o new.png --json here/new.png",
        "a.scn -o here/json.json.png --json json.json.png",
    ] {
        folder.fails(&line.split(' ').collect::<Vec<_>>(), 2, "would be written to");
    }
    // Standard input.
    fs::copy(folder.path("a.scn"), folder.path("in.png")).unwrap();
    fs::hard_link(folder.path("in.png"), folder.path("in.json")).unwrap();
    for arguments in [
        "- -o in.png",
        "- -o d.png --json in.json",
        "info - --json in.json",
    ] {
        let run = folder.shell(&format!("\"$0\" {arguments} < in.png"));
        run.failed(2, "would replace the scene");
    }
    assert_eq!(read(&folder, "in.png"), read(&folder, "a.scn"));
}

#[test]
fn a_json_file_replaces_no_input_of_a_later_scene_and_no_output() {
    let folder = Folder::new();
    folder.write("part.inc", "light 1 1 5 1\nsphere 0 0 0 1\n");
    folder.write("b.scn", "include part.inc\n");
    folder.write("broken.scn", "include part.inc\nbogus\n");
    for later in ["b.scn", "broken.scn"] {
        let line = format!("a.scn {later} -q -o {{stem}}.png --json part.inc");
        keeps(&folder, "part.inc", &line, 2, "would replace");
    }
    for line in [
        "a.scn -o n.png --aov depth --json n.depth.png",
        "a.scn -o n.png --json ./n.png",
    ] {
        folder.fails(&line.split(' ').collect::<Vec<_>>(), 2, "would be written to");
    }
}

#[test]
fn a_picture_replaces_no_texture_of_a_later_scene_though_octray_made_it() {
    let folder = Folder::new();
    folder.write("b.mtl", "newmtl m\nmap_Kd tex.png\n");
    folder.write("b.obj", "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n");
    folder
        .run_line(&format!("a.scn -q -o tex.png {SMALL}"))
        .succeeded();
    fs::copy(folder.path("a.scn"), folder.path("tex.scn")).unwrap();
    let vertices = "property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n1 0 0\n";
    folder.write(
        "b.ply",
        &format!("ply\nformat ascii 1.0\ncomment TextureFile tex.png\nelement vertex 2\n{vertices}"),
    );
    for mesh in ["b.obj", "b.ply"] {
        let line = format!("tex.scn {mesh} -q --samples 2");
        keeps(&folder, "tex.png", &line, 2, "would replace");
    }
}
