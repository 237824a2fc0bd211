//! Slips that have a likely meaning: the error says what to write instead.

use crate::program::{Folder, assert_contains};
use std::fs;

#[test]
fn names_of_pictures_with_the_placeholders_of_other_programs() {
    let folder = Folder::new();
    for (name, words) in [
        ("f_%04d.png", "octray numbers frames with #, such as f_####.png"),
        ("f_%6d.png", "such as f_######.png"),
        ("f_%d.png", "such as f_####.png"),
        ("{pose}.png", "{pose} in the name needs --poses"),
        (
            "{name}.png",
            "unknown placeholder {name}; {stem} is the scene's name",
        ),
    ] {
        folder.fails(&["a.scn", "-o", name], 2, words);
        if name.contains('%') {
            folder.fails(&["a.scn", "--turntable=2", "-o", name], 2, words);
        }
    }
    for name in ["100%done.png", "%s.png", "50%.png"] {
        folder.run(&["a.scn", "-s8x8", "-o", name]).succeeded();
        assert!(folder.path(name).exists(), "{name}");
    }
}

#[test]
fn formats_of_pictures() {
    let folder = Folder::new();
    let words = "a.webp: octray does not write .webp, expected .png, ";
    folder.fails(&["a.scn", "-o", "a.webp"], 2, words);
    let words = "a.scn: unknown extension, expected .png, .ppm, .qoi, .bmp, .tiff, .tif or .exr";
    folder.fails(&["merge", "a.scn", "-o", "m.png"], 1, words);
}

/// On Windows it separates folders.
#[cfg(unix)]
#[test]
fn a_backslash_in_the_name_of_a_picture() {
    let folder = Folder::new();
    folder.run(&["a.scn", "-s8x8", "-o", r"pics\a.png"]).succeeded();
    assert!(folder.path(r"pics\a.png").exists());
    fs::create_dir(folder.path("pics")).unwrap();
    folder.fails(&["a.scn", "-o", r"pics\b.png"], 2, r"write `/` instead of `\`");
    folder.run(&["a.scn", "-s8x8", "-o", r"pics\a.png"]).succeeded();
    // Its name comes from the scene's.
    fs::copy(folder.path("a.scn"), folder.path(r"pics\c.scn")).unwrap();
    folder.run(&[r"pics\c.scn", "-s8x8"]).succeeded();
}

#[cfg(unix)]
#[test]
fn broken_links() {
    let folder = Folder::new();
    std::os::unix::fs::symlink("gone.ply", folder.path("link.ply")).unwrap();
    folder.fails(
        &["link.ply"],
        1,
        "link.ply: file not found; it is a broken link to `gone.ply`",
    );
    folder.write("b.scn", "mesh link.ply\n");
    let run = folder.run(&["b.scn"]);
    assert_contains(
        &run.stderr,
        &["  caused by: link.ply: file not found; it is a broken link to `gone.ply`"],
    );
}

/// The content says that a file is a scene, whatever it is called; its name, what else it may be.
#[test]
fn scenes_with_names_of_other_formats() {
    let folder = Folder::new();
    let scene = fs::read_to_string(folder.path("a.scn")).unwrap();
    for name in ["a.pcd", "a.step", "a.xyz"] {
        folder.write(name, &format!("\u{feff}// a comment\n\n{scene}"));
        folder.run(&[name, "-s8x8"]).succeeded();
        folder.run(&["info", name]).succeeded();
    }
    folder.write("b.pcd", "sphere 1\n");
    let run = folder.run(&["b.pcd"]);
    assert_contains(&run.stderr, &["error: b.pcd:1:9: `sphere` with 1 of 4 values"]);
    for (name, text, words) in [
        (
            "c.pcd",
            "# .PCD v0.7\nsphere 0 0 0 1\n",
            "this is a PCD point cloud",
        ),
        ("c.wrl", "#VRML V2.0 utf8\nmaterial Material {}\n", "this is VRML"),
        ("d.step", "HEADER;\nsphere 0 0 0 1\n", "this is a STEP file"),
        ("e.pcd", "", "this is a PCD point cloud"),
        ("f.xyz", "1 2 3\n", "this is an XYZ point cloud"),
    ] {
        folder.write(name, text);
        folder.fails(&[name], 1, words);
    }
}

#[test]
fn names_with_spaces_and_without_quotes() {
    let folder = Folder::new();
    folder.fails(&["my", "models/my"], 1, "my: file not found");
    fs::create_dir(folder.path("my models")).unwrap();
    folder.write("my models/my ball.scn", "sphere 0 0 0 1\n");
    let words = "my: file not found; put quotes around a name with spaces: \"my models/my ball.scn\"";
    folder.fails(&["my", "models/my", "ball.scn"], 1, words);
    folder.fails(&["a.scn", "my", "models/my", "ball.scn"], 1, words);
    let run = folder.run(&[
        "a.scn",
        "my",
        "models/my",
        "ball.scn",
        "--keep-going",
        "-s8x8",
        "-o{stem}-1.png",
    ]);
    assert!(!run.stderr.contains("quotes"), "{run:?}");
}

#[test]
fn pictures_among_the_scenes() {
    let folder = Folder::new();
    let hint = "to write it, use -o out.png";
    folder.fails(
        &["a.scn", "out.png"],
        1,
        &format!("out.png: file not found; {hint}"),
    );
    folder.fails(
        &["a.scn", "a.qoi"],
        1,
        "a.qoi: file not found; to write it, use -o a.qoi",
    );
    folder.run(&["a.scn", "-s8x8", "-o", "out.png"]).succeeded();
    let words = format!("out.png: this is a PNG picture, expected a scene or a mesh; {hint}");
    folder.fails(&["a.scn", "out.png"], 1, &words);
    let run = folder.run(&["a.scn", "out.png", "-o", "{stem}-1.png"]);
    assert!(!run.stderr.contains(hint) && run.code == Some(1), "{run:?}");
    // A picture's name may be that of a scene.
    folder.write("b.ppm", "sphere 0 0 0 1\n");
    folder.run(&["a.scn", "b.ppm", "-s8x8", "--quiet"]).succeeded();
}

#[test]
fn steps_of_depth_without_depth() {
    let folder = Folder::new();
    for aovs in [&[][..], &["--aov=depth"]] {
        let arguments = [&["a.scn", "--z-step=0.1"], aovs].concat();
        folder.fails(&arguments, 2, "--z-step needs --aov z");
    }
    folder.write("c.toml", "z-step = 0.1\n");
    folder.run_line("a.scn -s 8x8 --config c.toml").succeeded();
    folder
        .run_line("a.scn -s 8x8 --z-step 0.1 --aov mask,z")
        .succeeded();
}

#[test]
fn a_mesh_that_lost_its_faces() {
    let folder = Folder::new();
    let warning = "is the file cut short?";
    for line in ["usemtl red", "mtllib a.mtl", "vt 0 0", "vn 0 0 1"] {
        folder.write("a.obj", &format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\n"));
        let run = folder.run_line("a.obj -s 8x8");
        let word = line.split(' ').next().unwrap();
        let words = format!("a.obj: no faces, but `{word}`: its vertices are shown as balls; {warning}");
        assert_contains(&run.stderr, &[&words]);
        assert_eq!(run.code, Some(0), "{run:?}");
    }
    for text in [
        "v 0 0 0\nv 1 0 0\n",
        "v 0 0 0\nv 1 0 0\nvt 0 0\nusemtl red\nl 1 2\n",
    ] {
        folder.write("a.obj", text);
        let run = folder.run_line("a.obj -s 8x8");
        assert!(!run.stderr.contains(warning), "{run:?}");
    }
}

#[test]
fn models_that_are_not_read() {
    let folder = Folder::new();
    for (name, text, kind) in [
        ("a.dae", "<?xml version=\"1.0\"?>\n", "COLLADA"),
        ("a.fbx", "; FBX 7.4.0 project file\n", "an FBX file"),
        ("b.fbx", "Kaydara FBX Binary  \0", "an FBX file"),
        ("a.usda", "#usda 1.0\n", "a USD file"),
        ("a.usdz", "PK\x03\x04 and more", "a USD file"),
        ("a.3ds", "MM\0\0", "a 3D Studio file"),
        ("a.svg", "<svg/>", "an SVG drawing"),
        ("a.blend", "BLENDER-v300", "a Blender file"),
    ] {
        folder.write(name, text);
        let words = format!(
            "{name}: this is {kind}, which octray does not read; convert it to glTF (.glb), for example with Blender"
        );
        folder.fails(&[name], 1, &words);
        folder.write("b.scn", &format!("mesh {name}\n"));
        let run = folder.run(&["b.scn"]);
        assert_contains(&run.stderr, &["error: b.scn:1:6: ", &words]);
    }
    folder.write("a.step", "ISO-10303-21;\n");
    folder.fails(&["a.step"], 1, "a.step: this is a STEP file, which octray does not read; convert it to glTF (.glb), for example with FreeCAD");
    for (name, text, words) in [
        (
            "a.pcd",
            "# .PCD v0.7\n",
            "a PCD point cloud, which octray does not read; convert it to PLY, for example with CloudCompare",
        ),
        ("cloud", "# .PCD v0.7\n", "a PCD point cloud"),
        ("a.las", "LASF\0\0", "a LAS point cloud"),
        ("a.laz", "LASF\0\0", "a LAS point cloud"),
        ("a.e57", "ASTM-E57", "an E57 point cloud"),
        ("a.xyz", "1 2 3\n", "an XYZ point cloud"),
        ("a.pts", "1\n1 2 3\n", "a PTS point cloud"),
        (
            "a.splat",
            "\0\0",
            "a file of Gaussian splats, which octray does not read; convert it to PLY",
        ),
        (
            "a.dxf",
            "0\nSECTION\n",
            "a DXF drawing, which octray does not read; convert it to glTF (.glb), for example with FreeCAD",
        ),
        ("a.dwg", "AC1032", "a DWG drawing"),
        ("a.brep", "DBRep_DrawableShape\n", "an Open CASCADE file"),
        ("a.sldprt", "\0", "a SolidWorks file"),
        (
            "a.amf",
            "<?xml version=\"1.0\"?>",
            "an AMF file, which octray does not read; convert it to 3MF",
        ),
        (
            "a.msh",
            "$MeshFormat\n",
            "a Gmsh mesh, which octray does not read; convert it to STL or PLY, for example with Gmsh",
        ),
        ("b.msh", "MSH 2\n", "a Gmsh mesh"),
        (
            "a.vti",
            "",
            "a VTK file of another type than .vtk, .vtp and .vtu, which octray does not read; convert it to .vtp",
        ),
        (
            "a.vtkhdf",
            "",
            "an HDF5 file, which octray does not read; convert it to .vtp, for example with ParaView",
        ),
    ] {
        folder.write(name, text);
        folder.fails(&[name], 1, &format!("{name}: this is {words}"));
    }
}

/// A misspelt statement makes no scene of a file with an extension of its own; a text may be one.
#[test]
fn other_files_get_no_suggestions_of_statements() {
    let folder = Folder::new();
    for name in ["a.mesh", "a.dat", "a.neu"] {
        folder.write(name, "MSH 2\nnodes 3\n");
        folder.fails(
            &[name],
            1,
            &format!("{name}: unknown file type, expected a scene (.scn) or a mesh"),
        );
    }
    folder.write("scene", "MSH 2\n");
    let run = folder.run(&["scene"]);
    assert_contains(&run.stderr, &["did you mean `mesh`?"]);
    folder.write("scene.dat", "light 3 -2 5 0.7\nsphre 0 0 0 1\n");
    let run = folder.run(&["scene.dat"]);
    assert_contains(&run.stderr, &["did you mean `sphere`?"]);
}

#[test]
fn meshes_with_the_extension_of_another_format() {
    let folder = Folder::new();
    let obj = "# A vase\n\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let off = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let stl = "solid a\nfacet normal 0 0 1\n";
    for (name, text, kind) in [
        ("a.ply", obj, "an OBJ mesh; rename it to `a.obj`"),
        ("a.stl", obj, "an OBJ mesh; rename it to `a.obj`"),
        ("a.off", obj, "an OBJ mesh; rename it to `a.obj`"),
        ("a.glb", obj, "an OBJ mesh; rename it to `a.obj`"),
        ("a.obj", "{\"asset\":{}}", "a glTF mesh; rename it to `a.gltf`"),
        ("a.ply", off, "an OFF mesh; rename it to `a.off`"),
        ("a.obj", stl, "an STL mesh; rename it to `a.stl`"),
    ] {
        folder.write(name, text);
        folder.fails(&[name], 1, &format!("{name}: this looks like {kind}"));
    }
    folder.write("b.scn", obj);
    let run = folder.run(&["b.scn"]);
    assert_contains(
        &run.stderr,
        &["error: b.scn:1:1: found `#`: this looks like an OBJ mesh"],
    );
    folder.write("b.scn", "# A scene\nsphere 0 0 0 1\n");
    let run = folder.run(&["b.scn"]);
    assert_contains(&run.stderr, &["`#` does not start a comment, expected `//`"]);
}

#[test]
fn options_of_other_programs() {
    let folder = Folder::new();
    for (option, words) in [
        (
            "--gamma=2.2",
            "--srgb encodes for screens (the default for meshes), --linear does not",
        ),
        ("--quality=9", "--samples N"),
        ("--silent", "-q or --quiet"),
        ("--interactive", "octray view SCENE"),
        ("--window", "octray view SCENE"),
        ("--video", "--turntable N"),
        ("--overwrite", "--force replaces files"),
        ("-w=800", "--size WIDTHxHEIGHT"),
        ("--tile=1", "--crop x0,y0,x1,y1"),
        ("--seed=1", "--help lists the options"),
        ("--preset=a", "--help lists the options"),
        ("--list", "--help lists the options"),
        ("--scale=2", "--help lists the options"),
        ("--sise=8", "'--size'"),
        ("--smooth=8", "'--smooth-angle'"),
        ("--sample=8", "'--samples'"),
    ] {
        folder.fails(&["a.scn", option], 2, words);
        let run = folder.run(&["a.scn", option]);
        let suggests = words.starts_with('\'');
        assert_eq!(run.stderr.contains("similar argument"), suggests, "{run:?}");
    }
}

#[test]
fn commands_and_inputs() {
    let folder = Folder::new();
    for command in ["info", "bench"] {
        let words = format!("octray {command} takes one scene");
        folder.fails(&[command, "a.scn", "a.scn"], 2, &words);
    }
    folder.fails(&["-version"], 2, "write --version");
    folder.fails(&["help", "rendr"], 2, "'render'");
    folder.fails(&["help", "nonsense"], 2, "nonsense");
    folder.fails(
        &["help", "render", "view"],
        2,
        "error: `octray help` takes one command, such as octray help render",
    );
    folder.fails(&["help", "nonsense", "view"], 2, "nonsense");
    let help = folder.run(&["help"]);
    for arguments in ["help --help", "help -h"] {
        assert_eq!(folder.run_line(arguments).succeeded().text(), help.text());
    }
    let help = folder.run(&["help", "merge"]);
    assert_eq!(
        folder.run_line("help merge --help").succeeded().text(),
        help.text()
    );
    fs::create_dir(folder.path("scenes")).unwrap();
    folder.fails(
        &["scenes"],
        1,
        "scenes: this is a directory, expected files such as scenes/*.scn",
    );
}

#[test]
fn what_is_left_of_the_memory_limit() {
    let folder = Folder::new();
    let white = image::RgbImage::from_pixel(2048, 1024, image::Rgb([255; 3]));
    white.save(folder.path("e.png")).unwrap();
    folder.write("b.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let run = folder.run(&["b.obj", "--environment=e.png", "-s8x8", "--max-memory=50M"]);
    assert_contains(
        &run.stderr,
        &["e.png: it takes ", ", but 50.0 MiB of the memory limit are left"],
    );
}

#[test]
fn mesh_errors_suggest_a_remedy() {
    let folder = Folder::new();
    folder.write("square.obj", "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf 1 2 3 4\n");
    folder.write("letter.doc", "Dear reader");
    let kinds =
        "expected a scene (.scn) or a mesh (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu)";
    folder.fails(&["letter.doc"], 1, kinds);
    folder.fails(
        &["squre.obj"],
        1,
        "squre.obj: file not found; did you mean `square.obj`?",
    );
    folder.fails(&["square.ply"], 1, "did you mean `square.obj`?");
    folder.fails(&["no/square.obj"], 1, "directory `no` does not exist");
    folder.fails(&[".\\square.obj"], 1, "write `/` instead of `\\`");
    folder.fails(&["a.scn", "--ground"], 2, "--ground applies to meshes only");
    for [option, value] in [["--animation", "walk"], ["--animation-time", "2"]] {
        let words = format!("error: {option} applies to meshes only");
        folder.fails(&["a.scn", option, value], 2, &words);
    }
    folder.fails(
        &["square.obj", "--camera", "front"],
        2,
        "no camera `front`: the mesh defines none; use --from or --eye",
    );
    folder.fails(
        &["square.obj", "--smooth-angle", "200"],
        2,
        "degrees from 0 to 180",
    );
    folder.fails(&["square.obj", "--fov", "180"], 2, "less than 180");
    folder.fails(
        &["square.obj", "--eye", "1,2,3", "--target", "1,2,3"],
        2,
        "eye and target are the same point",
    );
}
