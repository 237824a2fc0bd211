//! `OCTRAY_ISA`: every instruction set of this CPU makes the same bytes.

use crate::program::{Folder, PLANE, Run, assert_contains, shipped_mesh};
use octray::Level;
use std::{collections::BTreeMap, fs};

/// A ball of tinted glass with a mirror in it, on another, behind a pane.
const GLASS: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
background bottom 0.9 0.85 0.8 top 0.1 0.3 0.7
light 3 -2 5 0.4 radius 1
directional_light 1 -1 2 0.2 angle 5
light -1 -1 3 0.5 rectangle 1 0 0 0 -1 0 falloff 2 spot 0 0 -1 20 60
material matte
triangle -5 -5 0  5 -5 0  0 5 0
material glass tint 0.5 0.9 0.7
sphere 0 0 0.5 0.5
material glass ior 2.4
sphere 0.1 0 1.2 0.7
material reflection mix 0.6
sphere 0.1 0.1 0.6 0.2
material blinn_phong cd 0.2 0.4 0.9 opacity 0.4
triangle 1 -2 0  2 0 0  1.5 -1 2
";

/// Lit by an image that is rendered first.
const SKY: &str = "\
environment interior.png rotate 70 intensity 1.5
material matte
triangle -5 -5 0  5 -5 0  0 5 0
material blinn_phong
sphere 0 0 0.5 0.5
material reflection
sphere 0.8 0.3 0.3 0.3
";

/// Cubes, a point cloud and a mirror, each stored once.
const INSTANCES: &str = "\
camera eye 3 -3 1.5 target 0 0 0.4 fov 40
light 3 -2 5 0.5 radius 1
light -2 -5 3 0.4
plane 0 0 0 normal 0 0 1
instance helix.ply scale 0.5 point_size 0.1
material blinn_phong cd 0.8 0.5 0.2
instance cube.ply translate -0.5 -0.5 0 scale 0.3 placements placed.txt rotate 0 0 1 15
material glass
instance cube.ply scale 0.4 -0.4 0.6 rotate 1 2 3 40 translate 0.8 -0.6 0.2
material reflection mix 0.6
instance cube.ply scale 1 0.1 1 translate -0.5 1 0
";

/// Runs a line in a folder of its own at a level, and returns what it prints and the files that it leaves.
fn made_at(level: &str, lines: &[&str]) -> (String, BTreeMap<String, Vec<u8>>) {
    let folder = Folder::new();
    folder.write("glass.scn", GLASS);
    fs::copy(shipped_mesh("stairs.3mf"), folder.path("stairs.3mf")).unwrap();
    folder.write("sky.scn", SKY);
    folder.write("plane.scn", PLANE);
    folder.write("instances.scn", INSTANCES);
    for mesh in ["cube.ply", "helix.ply"] {
        fs::copy(shipped_mesh(mesh), folder.path(mesh)).unwrap();
    }
    folder.write(
        "placed.txt",
        "1 0 0\n-1 -0.5 0\n0 -1 0 0  1 0 0 0.9  0 0.2 2 0\n1 0 0\n",
    );
    let mut printed = String::new();
    for line in lines {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        let mut command = folder.command(&arguments);
        let run = Run::new(command.env("OCTRAY_ISA", level).output().unwrap());
        printed += run.succeeded().text();
    }
    let files = folder
        .names()
        .into_iter()
        .filter(|name| folder.path(name).is_file());
    let files = files.map(|name| {
        let bytes = fs::read(folder.path(&name)).unwrap();
        (name, bytes)
    });
    (printed, files.collect())
}

#[test]
fn every_level_makes_the_same_bytes() {
    let lines = [
        "generate interior --count 20000 -o .",
        "generate flake --count 800 -o .",
        "generate terrain --count 2000 -o .",
        "generate pipes --count 1000 -o .",
        "render interior.scn -o interior.png -s 100x75 --max-depth 5",
        "render flake.scn -o flake.exr -s 100x75 --samples 4 --pattern stratified --aov depth,normal",
        "render flake.scn -o scalar.exr -s 80x60 --mode scalar",
        "render terrain.scn -o terrain.png -s 100x75 --background transparent --filter blackman-harris",
        "render pipes.scn -o pipes.ppm -s 100x75 --samples 4",
        "render flake.scn -o auto.png -s 100x75 --samples auto:9 --background transparent",
        "render glass.scn -o glass.exr -s 97x61 --samples 4 --max-depth 7",
        "render glass.scn -o parallel.exr -s 97x61 --samples 4 --max-depth 5 --ortho 2.5",
        "render glass.scn -o lens.exr -s 97x61 --samples 9 --pattern sobol --aperture 0.3 --focus 3.5",
        "render plane.scn -o plane.exr -s 97x61 --samples 4 --max-depth 5 --aov id",
        "render plane.scn -o plane-auto.png -s 97x61 --samples auto:9 --aperture 0.2",
        "render plane.scn -o plane-scalar.exr -s 97x61 --samples 4 --max-depth 5 --mode scalar",
        "render glass.scn -o glass-scalar.exr -s 97x61 --samples 4 --max-depth 7 --mode scalar",
        "render stairs.3mf -o stairs.exr -s 97x61 --samples 4 --aov albedo",
        "render sky.scn -o sky.exr -s 97x61 --samples 4",
        "render sky.scn -o sky-scalar.exr -s 97x61 --samples 4 --mode scalar",
        "render instances.scn -o instances.exr -s 97x61 --samples 4 --max-depth 6 --aov depth,normal,albedo",
        "render instances.scn -o instances-auto.png -s 97x61 --samples auto:9 --aperture 0.2",
        "render instances.scn -o instances-scalar.exr -s 97x61 --samples 4 --max-depth 6 --mode scalar",
        "render instances.scn -o edges.exr -s 97x61 --samples 4 --edges=2.5 --aperture 0.2",
        "render glass.scn -o edges.png -s 97x61 --samples auto:9 --edges",
        "render a.scn -o a.png",
    ];
    let expected = made_at("portable", &lines);
    assert!(expected.1.len() > 14, "{:?}", expected.1.keys());
    for level in Level::all().skip(1) {
        let made = made_at(level.name(), &lines);
        for (name, bytes) in &made.1 {
            assert!(*bytes == expected.1[name], "{name} differs with {level}");
        }
        assert_eq!(made.1.len(), expected.1.len());
    }
}

#[test]
fn every_level_finds_as_many_hits() {
    let folder = Folder::new();
    let counts = |level: Level| {
        let arguments = ["bench", "a.scn", "-s", "64x64", "--repeat", "1", "--json", "-"];
        let mut command = folder.command(&arguments);
        let run = Run::new(command.env("OCTRAY_ISA", level.name()).output().unwrap());
        let json: serde_json::Value = serde_json::from_str(run.succeeded().text()).unwrap();
        assert_eq!(json["isa"], level.instructions());
        let rows = json["results"].as_array().unwrap().clone();
        rows.into_iter()
            .map(|row| {
                assert_eq!(row["agree"], true, "{row}");
                (row["kind"].clone(), row["method"].clone(), row["hits"].clone())
            })
            .collect::<Vec<_>>()
    };
    let expected = counts(Level::PORTABLE);
    for level in Level::all().skip(1) {
        assert_eq!(counts(level), expected, "{level}");
    }
}

#[test]
fn only_levels_of_this_cpu_are_taken() {
    let folder = Folder::new();
    for name in ["sse2", "AVX2", "avx3", " portable"] {
        for arguments in [&["--version"][..], &["a.scn"], &["info", "a.scn"]] {
            let mut command = folder.command(arguments);
            let run = Run::new(command.env("OCTRAY_ISA", name).output().unwrap());
            let line = format!(
                "error: OCTRAY_ISA={name}: no such instruction set, expected portable, avx2 or avx512\n"
            );
            assert_eq!((run.code, run.stderr.as_str()), (Some(2), line.as_str()));
        }
    }
    for level in ["avx2", "avx512"] {
        let mut command = folder.command(&["--version"]);
        let run = Run::new(command.env("OCTRAY_ISA", level).output().unwrap());
        if Level::all().any(|own| own.name() == level) {
            assert_contains(run.succeeded().text(), &[level]);
        } else {
            assert_eq!(run.code, Some(2));
            assert_contains(&run.stderr, &["this CPU does not have these instructions"]);
        }
    }
    let mut command = folder.command(&["--version"]);
    Run::new(command.env("OCTRAY_ISA", "").output().unwrap()).succeeded();
}
