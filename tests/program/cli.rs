//! The command line: arguments, exit codes, messages. (Files and pipes: `cli_output.rs`.)

use crate::program::{Folder, assert_contains, on_a_terminal};
use serde_json::Value;

#[test]
fn a_scene_alone_writes_a_png_named_after_it() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("deep")).unwrap();
    folder.write("deep/b.c.scn", "sphere 0 0 0.5 0.5\n");
    let run = folder.run(&["deep/b.c.scn"]);
    assert!(run.succeeded().stdout.is_empty());
    assert_eq!(folder.names(), ["a.scn", "b.c.png", "deep"]);
    let picture = image::open(folder.path("b.c.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (512, 512));
}

#[test]
fn render_is_the_default_command() {
    let folder = Folder::new();
    folder.run(&["a.scn", "-o", "1.ppm", "--view", "2"]).succeeded();
    folder.run_line("render --view=2 a.scn -o2.ppm").succeeded();
    folder.run_line("--view 2 --output 3.ppm -- a.scn").succeeded();
    let read = |name| std::fs::read(folder.path(name)).unwrap();
    assert_eq!(read("1.ppm"), read("2.ppm"));
    assert_eq!(read("1.ppm"), read("3.ppm"));
}

#[test]
fn scenes_may_have_the_names_of_commands() {
    let folder = Folder::new();
    for name in ["render", "bench", "info"] {
        folder.write(name, "sphere 0 0 0.5 0.5\n");
        folder.run(&[&format!("./{name}"), "--size", "9"]).succeeded();
        assert!(folder.path(&format!("{name}.png")).exists());
    }
    folder.run(&["render", "render", "-o", "again.png"]).succeeded();
    folder.run(&["info", "bench"]).succeeded();
    folder.fails(&["render"], 2, "<SCENE>");
    folder.fails(&["bench"], 2, "<SCENE>");
}

#[test]
fn options_take_effect() {
    let folder = Folder::new();
    let all = "a.scn -o a.qoi --size 33x17 --eye -1,2,-3 --target -0.5,0,0 --up 0,-1,0.1 --fov 30.5 \
               --threads 2 --mode scalar --no-shadows --max-depth 1 --samples 4 --stats --quiet";
    let run = folder.run_line(all);
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.stdout.is_empty());
    let picture = image::open(folder.path("a.qoi")).unwrap();
    assert_eq!((picture.width(), picture.height()), (33, 17));
    let words = ["33x17, 4 samples", "depth 1, shadows off", "scalar", "2 threads"];
    assert_contains(&run.stderr, &words);
    folder
        .run_line("a.scn --mode=packet --target 0,0,0 --up=-1,0,0 --fov=179")
        .succeeded();
}

#[test]
fn wrong_values_are_usage_errors() {
    let folder = Folder::new();
    for (arguments, words) in [
        ("--samples 5 --pattern grid --filter tent", "--pattern sobol"),
        ("--samples 0", "--samples"),
        ("--samples -1", "-1"),
        ("--size 0x5", "WIDTHxHEIGHT"),
        ("--size 12x", "WIDTHxHEIGHT"),
        ("--size 5000000000x1", "WIDTHxHEIGHT"),
        ("--view 7", "from 1 to 6"),
        ("--view 0", "from 1 to 6"),
        ("--threads 0", "--threads"),
        ("--threads many", "--threads"),
        ("--max-depth 0", "--max-depth"),
        ("--mode fast", "packet, scalar"),
        ("--stats=xml", "--stats"),
        ("--eye 1,2", "x,y,z"),
        ("--eye 1,2,3,4", "x,y,z"),
        ("--eye nan,0,0", "three finite numbers"),
        ("--eye 1e30,0,0", "1e9"),
        ("--eye --up", "x,y,z"),
        ("--fov wide", "--fov"),
        ("--fov 0", "'--fov <DEG>': expected degrees"),
        ("--fov -30", "'--fov <DEG>': expected degrees"),
        ("--fov 180", "'--fov <DEG>': expected degrees"),
        ("--fov nan", "'--fov <DEG>': expected degrees"),
        // Straight down: parallel to the default up.
        ("--eye 0,0,5", "up vector"),
        ("--eye 0,0,5 --target 0,0,-1", "up vector"),
        ("--up 0,0,0", "up vector"),
        ("--eye 1,2,3 --target 1,2,3", "eye and target are the same point"),
        ("--view 2 --eye 1,2,3", "use one of them"),
        ("--camera front --view 2", "use one of them"),
        ("--eye 1,2,3 --camera front", "use one of them"),
        ("--camera front", "the scene defines none; use --view or --eye"),
        ("--sise 5x5", "--size"),
        ("--width 5", "--size WIDTHxHEIGHT"),
        ("--wireframe", "--edges draws the edges of triangles"),
        ("--spp=5", "--samples"),
        ("--bounces=5", "--max-depth N"),
        ("--hdri a.hdr", "--environment FILE"),
        ("--light 1,2,3", "a scene (.scn) has lines"),
        ("--environment a.scn", "--environment applies to meshes only"),
        ("--environment-rotate 5", "--environment"),
        ("--gamma 2.2", "--srgb"),
        ("--transparent", "--background transparent"),
        ("--bg-color", "--background COLOR"),
        ("--caustics", "--help lists the options"),
        ("--size", "--size"),
        ("--size 5x5 --size 5x5", "multiple times"),
        ("-o a.gif", ".png"),
        ("-o a", ".png"),
        ("-o .png", ".png"),
        ("-o a.scn", "a.scn is a scene or a mesh, not a picture"),
        ("-o a-#.png", "# stands for the number of a frame"),
        (
            "-o {dir}/a.png",
            "unknown placeholder {dir}; {stem} is the scene's name",
        ),
    ] {
        let arguments: Vec<_> = std::iter::once("a.scn").chain(arguments.split(' ')).collect();
        folder.fails(&arguments, 2, words);
    }
    folder.fails(&["bnech", "a.scn"], 2, "'bench'");
    folder.fails(&["info"], 2, "<SCENE>");
    folder.fails(&["bench"], 2, "generated ones with --all");
    folder.fails(&["bench", "a.scn", "--quick"], 2, "--quick goes with --all");
    folder.write("-dash.ply", "");
    folder.fails(&["-dash.ply"], 2, "./-dash.ply");
    folder.fails(&["info", "a.scn", "--size", "5x5"], 2, "--size");
    folder.fails(
        &["bench", "a.scn", "--method", "guess"],
        2,
        "scalar, packet, single, render",
    );
    folder.fails(&["bench", "a.scn", "--repeat", "0"], 2, "--repeat");
}

/// A scene's camera renders the same picture as the same camera in options.
#[test]
fn the_scenes_cameras() {
    let folder = Folder::new();
    let shapes = "light 3 -2 5 0.7\nmaterial 1\nsphere 0 0 0.5 0.5\nsphere 0.6 0.4 0.2 0.2\n";
    folder.write("plain.scn", shapes);
    folder.write(
        "b.scn",
        &format!(
            "camera eye 3 -2 1.5 target 0.1 0 0.4 fov 30\ncamera \"far away\" eye 9 1 3 target 0 0 0 up 0 1 0\n{shapes}"
        ),
    );
    let read = |arguments: &[&str]| {
        let arguments: Vec<_> = arguments
            .iter()
            .chain(&["--size=64x48", "-o=a.ppm"])
            .copied()
            .collect();
        folder.run(&arguments).succeeded();
        std::fs::read(folder.path("a.ppm")).unwrap()
    };
    let first = read(&["b.scn"]);
    assert_eq!(
        first,
        read(&["plain.scn", "--eye=3,-2,1.5", "--target=0.1,0,0.4", "--fov=30"])
    );
    let wide = read(&["b.scn", "--fov=50"]);
    assert_eq!(
        wide,
        read(&["plain.scn", "--eye=3,-2,1.5", "--target=0.1,0,0.4", "--fov=50"])
    );
    assert_ne!(first, wide);
    assert_eq!(
        read(&["b.scn", "--camera", "far away"]),
        read(&["plain.scn", "--eye=9,1,3", "--target=0,0,0", "--up=0,1,0"])
    );
    assert_eq!(read(&["b.scn", "--view=2"]), read(&["plain.scn", "--view=2"]));
    folder.fails(&["b.scn", "--camera", "far-away"], 2, "did you mean `far away`?");
    folder.fails(&["b.scn", "--camera", "x"], 2, "expected 1 (unnamed), `far away`");
    assert_eq!(first, read(&["b.scn", "--camera=1"]));
}

#[test]
fn any_number_of_samples_with_a_sequence() {
    let folder = Folder::new();
    let read = |options: &str| {
        let arguments = format!("a.scn --size 40x30 -o a.ppm --pattern sobol --quiet {options}");
        folder.run_line(&arguments).succeeded();
        std::fs::read(folder.path("a.ppm")).unwrap()
    };
    let seven = read("--samples 7");
    assert_eq!(seven, read("--samples 7 --mode scalar"));
    assert_ne!(seven, read("--samples 8"));
}

/// A mesh whose only face has two corners.
const FLAT: &str = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n2 0 1\n";

#[test]
fn empty_scenes_and_meshes() {
    let folder = Folder::new();
    folder.write("empty.scn", "// nothing\n");
    let run = folder.run(&["empty.scn"]);
    assert_eq!(run.code, Some(0));
    assert!(run.stderr.contains("the scene is empty"), "{}", run.stderr);
    folder.write("flat.ply", FLAT);
    folder.fails(&["flat.ply"], 1, "no triangles to render (2 vertices");
    folder.run(&["info", "flat.ply"]).succeeded();
    folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n");
    let run = folder.run(&["a.obj", "--smooth-angle", "30"]);
    assert!(run.stderr.contains("has normals of its own"), "{}", run.stderr);
}

#[test]
fn exceeded_limits_exit_with_1() {
    let folder = Folder::new();
    folder.fails(&["a.scn", "--size", "100000x100000"], 1, "pixels");
    folder.fails(&["a.scn", "--size", "8000000x1", "--samples", "4"], 1, "samples");
    folder.fails(&["a.scn", "--size", "70000x1", "-o", "a.jpg"], 1, "JPEG");
}

#[test]
fn without_arguments_the_usage_is_shown() {
    let run = Folder::new().run(&[]);
    assert_eq!(run.code, Some(2));
    assert!(run.stdout.is_empty());
    assert!(
        run.stderr.contains("Usage: octray [render] [OPTIONS] <SCENE>"),
        "{}",
        run.stderr
    );
}

#[test]
fn help_lists_options_and_examples() {
    let folder = Folder::new();
    let top = folder.run(&["--help"]);
    let words = ["Examples:", "render", "info", "bench", "Exit codes"];
    assert_contains(top.succeeded().text(), &words);
    let options = "Examples: --output --size --camera --view --eye --target --up --fov --threads --mode --no-shadows \
                   --max-depth --samples --stats --quiet";
    let options: Vec<_> = options.split(' ').collect();
    for arguments in ["render --help", "a.scn --help", "help render"] {
        assert_contains(folder.run_line(arguments).succeeded().text(), &options);
    }
    let short = folder.run(&["render", "-h"]);
    assert!(short.succeeded().text().contains("--samples"));
    assert!(!short.text().contains("Examples:"));
    assert_eq!(folder.names(), ["a.scn"]);
}

#[test]
fn the_version_names_the_instruction_set() {
    let folder = Folder::new();
    let line = format!("octray {} ({})", env!("CARGO_PKG_VERSION"), octray::isa());
    let short = folder.run(&["-V"]);
    assert_eq!(short.succeeded().text(), format!("{line}\n"));
    let long = folder.run(&["--version"]);
    assert_eq!(long.succeeded().text().lines().next(), Some(line.as_str()));
    assert!(long.text().contains("levels of this CPU: portable"));
}

fn json(text: &str) -> Value {
    assert_eq!(text.lines().count(), 1, "{text}");
    serde_json::from_str(text).unwrap()
}

#[test]
fn statistics_as_json_and_text() {
    let folder = Folder::new();
    let run = folder.run(&["a.scn", "--json", "-", "--threads", "1"]);
    let stats = json(run.succeeded().text());
    assert_eq!(stats["schema"], 1);
    assert_eq!(stats["scene"], "a.scn");
    assert_eq!((&stats["width"], &stats["height"]), (&512.into(), &512.into()));
    assert_eq!(stats["threads"], 1);
    assert_eq!(stats["isa"], octray::isa());
    for kind in ["camera", "shadow", "reflection", "total"] {
        assert!(stats["rays"][kind].is_u64(), "{kind}");
    }
    for time in ["load", "build", "render", "write", "total"] {
        assert!(
            stats["seconds"][time].as_f64().is_some_and(|s| s >= 0.0),
            "{time}"
        );
    }
    for count in ["triangles", "spheres", "degenerate_triangles"] {
        assert!(stats["primitives"][count].is_u64(), "{count}");
    }
    assert!(stats["rays_per_s"].is_f64());
    assert!(stats["memory_bytes"]["scene"].is_u64() && stats["memory_bytes"]["bvh"].is_u64());

    let text = folder.run(&["--stats", "a.scn"]);
    assert_eq!(text.code, Some(0));
    assert!(text.stdout.is_empty());
    assert_contains(
        &text.stderr,
        &["primitives", "camera", "rays/s", "load", "memory"],
    );
}

#[test]
fn info_prints_text_or_json() {
    let folder = Folder::new();
    let text = folder.run(&["info", "a.scn"]);
    let words = [
        "triangles",
        "spheres",
        "bounds",
        "arrays",
        "depth",
        "nodes",
        "leaf sizes",
        "build time",
    ];
    assert_contains(text.succeeded().text(), &words);
    let info = folder.run(&["info", "a.scn", "--json", "-"]);
    let info = json(info.succeeded().text());
    assert_eq!(info["schema"], 1);
    for count in "vertices triangles degenerate_triangles spheres lights scene_bytes".split(' ') {
        assert!(info[count].is_u64(), "{count}");
    }
    assert!(info["arrays"].is_array() && info["materials"].is_array());
    assert_eq!(info["bvh"]["leaf_sizes"].as_array().map(Vec::len), Some(8));
    assert_eq!(folder.names(), ["a.scn"]);
}

#[test]
fn info_lists_lights_materials_and_cameras() {
    let folder = Folder::new();
    folder.write(
        "b.scn",
        "camera \"far away\" eye 9 1 3 target 0 0 0\nbackground bottom 1 1 1 top 0 0 1\nambient 0.25\n\
         light 3 -2 5 0.5 color 1 0.5 0\ninclude part.scn\n",
    );
    folder.write(
        "part.scn",
        "material blinn_phong ks 0.25 alpha 9\nsphere 0 0 0 1\n\
         material matte cd 0.9 0.8 0.7 checker 0.25 0.5 0 size 2\nsphere 0 0 0 1\n",
    );
    let text = folder.run(&["info", "b.scn"]);
    let words = [
        "light 3 -2 5 0.5 color 1 0.5 0",
        "blinn_phong cd 1 0 0 cs 1 1 1 kd 0.8 ks 0.25 alpha 9, 1 primitive\n",
        "matte cd 0.9 0.8 0.7 checker 0.25 0.5 0 size 2, 1 primitive\n",
        "bottom 1 1 1 top 0 0 1",
        "\"far away\" eye 9 1 3 target 0 0 0 up 0 0 1 fov 45",
        "part.scn",
    ];
    assert_contains(text.succeeded().text(), &words);
    let info = json(folder.run(&["info", "b.scn", "--json", "-"]).succeeded().text());
    assert_eq!(info["cameras"][0]["name"], "far away");
    assert_eq!(info["ambient"], 0.25);
    assert_eq!(info["light_list"][0]["intensity"], 0.5);
    assert_eq!(info["includes"][0], "part.scn");
}

#[test]
fn info_counts_primitives_and_bytes() {
    let folder = Folder::new();
    let info = json(folder.run(&["info", "a.scn", "--json", "-"]).succeeded().text());
    assert_eq!((&info["spheres"], &info["lights"]), (&2.into(), &1.into()));
    assert_eq!(info["materials"].as_array().map(Vec::len), Some(2));
    assert_eq!(info["materials"][1]["kind"], "reflection");
    let arrays = info["arrays"].as_array().unwrap();
    let bytes = arrays.iter().map(|array| array["bytes"].as_u64().unwrap());
    assert_eq!(info["scene_bytes"], bytes.sum::<u64>());
}

#[test]
fn a_broken_scene_is_one_error() {
    let folder = Folder::new();
    folder.write("broken.scn", "sphere 0 0 0.5\n");
    for command in ["broken.scn", "info broken.scn", "bench broken.scn"] {
        let run = folder.run_line(command);
        assert_eq!(run.code, Some(1));
        assert!(run.stderr.starts_with("error: broken.scn:1:"), "{run:?}");
        assert_eq!(run.stderr.matches("error:").count(), 1);
        assert!(run.stdout.is_empty());
    }
    let missing = folder.run(&["missing.scn"]);
    assert_eq!(missing.code, Some(1));
    assert!(missing.stderr.contains("missing.scn"), "{missing:?}");
    assert_eq!(folder.names(), ["a.scn", "broken.scn"]);
}

#[test]
fn a_terminal_shows_one_line_unless_quiet() {
    let folder = Folder::new();
    let Some(run) = on_a_terminal(&folder, "a.scn") else {
        return;
    };
    assert_eq!(run.code, Some(0), "{run:?}");
    assert!(run.text().contains("wrote a.png (512x512, "), "{run:?}");
    assert_eq!(run.text().trim_end().lines().count(), 1, "{run:?}");
    let quiet = on_a_terminal(&folder, "a.scn --quiet").unwrap();
    assert_eq!((quiet.code, quiet.text()), (Some(0), ""));
}

#[test]
fn a_png_is_not_written_to_a_terminal() {
    let folder = Folder::new();
    if let Some(run) = on_a_terminal(&folder, "a.scn -o -") {
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(
            run.text().contains("error: will not write a PNG to a terminal"),
            "{run:?}"
        );
    }
}

const SQUARE: &str = "v 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf 1 2 3 4\n";

#[test]
fn every_command_reads_meshes() {
    let folder = Folder::new();
    folder.write("square.obj", SQUARE);
    folder.run(&["square.obj", "--size", "8x8"]).succeeded();
    assert!(folder.path("square.png").exists());
    let info = folder.run(&["info", "square.obj"]);
    assert!(
        info.succeeded()
            .text()
            .contains("2 (0 without area, 0 duplicate, 0 inverted)"),
        "{info:?}"
    );
    folder
        .run_line("bench square.obj --size 16x16 --repeat 1 --ground")
        .succeeded();
    for options in [
        "--eye 3,2,1",
        "--target 1,1,1",
        "--view 2",
        "--up 1,0,0 --fov 70",
        "--up-axis z --ground --smooth-angle 30",
    ] {
        folder
            .run_line(&format!("square.obj --size 8x8 {options}"))
            .succeeded();
    }
}

#[test]
fn mesh_warnings_are_printed_once() {
    let folder = Folder::new();
    folder.write("twice.obj", &format!("{SQUARE}f 1 2 3\nf 1 1 2\n"));
    let run = folder.run(&["twice.obj", "--size", "8x8"]);
    assert_eq!(run.code, Some(0));
    assert_eq!(
        run.stderr,
        "warning: twice.obj: of 4 triangles, 1 without area (never hit), 1 duplicate\n"
    );
    folder.write("square.obj", SQUARE);
    let below = folder.run_line("square.obj --size 8x8 --ground --from bottom");
    assert_eq!(below.code, Some(0));
    assert!(
        below.stderr.contains("the camera is below the ground"),
        "{below:?}"
    );
    folder.run(&["twice.obj", "--size", "8x8", "--quiet"]).succeeded();
    let stats = folder.run(&["twice.obj", "--size", "8x8", "--quiet", "--json=-"]);
    assert!(
        stats
            .text()
            .contains("\"degenerate_triangles\":1,\"duplicate_triangles\":1,\"inverted_triangles\":0")
    );
}
