//! The fields of `--json`, which docs/json.md lists.

use crate::program::Folder;
use serde_json::Value;
use std::{collections::BTreeSet, fs, path::Path};

/// Every key of an object and of those in it.
fn keys(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(members) => {
            for (key, value) in members {
                found.insert(key.clone());
                keys(value, found);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| keys(value, found)),
        _ => {}
    }
}

/// The part of docs/json.md about a command, without what it says about all of them.
fn section(command: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/json.md");
    let text = fs::read_to_string(path).unwrap();
    let (_, section) = text.split_once(&format!("\n## {command}\n")).unwrap();
    section.split("\n## ").next().unwrap().to_owned()
}

#[test]
fn the_document_has_every_field() {
    let folder = Folder::new();
    folder.write(
        "b.scn",
        "camera one eye 3 0 1 target 0 0 0 fov 40 aperture 0.1 focus 2\nlight 3 -2 5 0.7\n\
         light 1 1 3 0.5 spot 0 0 -1 20 30\nmaterial matte cd 1 0 0\nsphere 0 0 0 1\n",
    );
    folder.write(
        "q.ply",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nproperty float q\n\
         end_header\n0 0 0 1\n",
    );
    for half in ["0,0,16,16", "16,0,32,16"] {
        let tile = format!(
            "a.scn --size=32x16 --crop={half} -o {}.png -q",
            &half[..2].replace(',', "_")
        );
        folder.run_line(&tile).succeeded();
    }
    let missing_b = "b.scn --size=16 -o t-#.png --turntable=2 --aov=depth,heat -q --json=-";
    for (command, arguments) in [
        ("render", missing_b),
        ("render", "q.ply --size=8 --color-by=q -q --json=-"),
        ("info", "info q.ply --json=-"),
        ("info", "info b.scn --json=-"),
        ("bench", "bench a.scn --size=16 --repeat=1 --json=-"),
        ("verify", "verify --seconds=0.1 --json=-"),
        ("merge", "merge 0_.png 16.png -o merged.png --json=-"),
        ("generate", "generate flake --count=10 --json=-"),
    ] {
        let run = folder.run_line(arguments);
        assert_eq!(run.code, Some(0), "{run:?}");
        let mut found = BTreeSet::new();
        for line in run.text().lines() {
            keys(&serde_json::from_str(line).unwrap(), &mut found);
        }
        found.remove("schema");
        assert!(found.len() > 4, "{found:?}");
        let section = section(command);
        for key in found {
            assert!(section.contains(&format!("`{key}`")), "{command}: {key}");
        }
    }
}

/// As docs/json.md says: no line for what is skipped, and no file if nothing is rendered.
#[test]
fn what_is_skipped_has_no_line() {
    let folder = Folder::new();
    let run = folder.run_line("a.scn no.scn --keep-going --size=8 --json=a.json");
    assert_eq!(run.code, Some(1), "{run:?}");
    let lines = fs::read_to_string(folder.path("a.json")).unwrap();
    assert_eq!(lines.lines().count(), 1, "{lines}");
    folder
        .run_line("a.scn --skip-existing --size=8 --json=b.json")
        .succeeded();
    assert!(!folder.path("b.json").exists());
}

/// If all is well and standard error is no terminal.
#[test]
fn streams_have_the_json_and_nothing_else() {
    let folder = Folder::new();
    for (arguments, lines) in [
        ("a.scn --size=8 -o t#.png --turntable=3", 3),
        ("a.scn --size=8 -o t.gif --turntable=3", 3),
        ("a.scn --size=8 -o s#.png --sphere=2 --save-poses=poses.json", 2),
        ("a.scn --size=8 -o p#.png --poses=poses.json", 2),
        ("a.scn a.scn --size=8 --sheet=2 -o sheet.png", 2),
        ("a.scn --size=8 -o a.png --aov=depth,mask", 1),
    ] {
        for option in ["", " --quiet", " --json=-", " --quiet --json=-"] {
            let run = folder.run_line(&format!("{arguments}{option}"));
            assert!(
                run.code == Some(0) && run.stderr.is_empty(),
                "{arguments}{option}: {run:?}"
            );
            let found: Vec<serde_json::Value> = run
                .text()
                .lines()
                .map(|line| serde_json::from_str(line).unwrap())
                .collect();
            let expected = if option.contains("json") { lines } else { 0 };
            assert_eq!(found.len(), expected, "{arguments}{option}: {run:?}");
        }
    }
    for option in ["", " --quiet"] {
        let into = if option.is_empty() { "farm" } else { "quiet" };
        let run = folder.run_line(&format!(
            "job a.scn -o j.png --for=parallel --into={into}{option}"
        ));
        assert!(
            run.code == Some(0) && run.stderr.is_empty() && run.text().is_empty(),
            "{run:?}"
        );
    }
}

/// Statements can be read again, and pinholes have no focus.
#[test]
fn info_says_opacities_and_lenses() {
    let folder = Folder::new();
    folder.write(
        "c.scn",
        "camera eye 3 0 1 target 0 0 0 aperture 0 focus 2\n\
         material silhouette cd 1 0 0 opacity 0.5 tinted\nsphere 0 0 0 1\n\
         material matte cd 0 1 0 checker 0 0 1 size 2 opacity 0.25\nsphere 3 0 0 1\n",
    );
    let info = |name: &str| -> serde_json::Value {
        let run = folder.run(&["info", name, "--json=-"]);
        serde_json::from_str(run.text()).unwrap()
    };
    let (found, mut again) = (info("c.scn"), String::new());
    for material in found["materials"].as_array().unwrap() {
        assert!(material["textures"].is_null(), "{material}");
        again += &format!(
            "material {}\nsphere 0 0 0 1\n",
            material["statement"].as_str().unwrap()
        );
    }
    assert!(again.contains("cd 1 0 0 opacity 0.5 tinted\n"), "{again}");
    assert!(again.contains(" size 2 opacity 0.25\n"), "{again}");
    folder.write("again.scn", &again);
    assert_eq!(info("again.scn")["materials"], found["materials"]);
    let camera = &found["cameras"][0];
    assert!(
        camera.get("focus").is_none() && camera.get("aperture").is_none(),
        "{camera}"
    );
}

/// The BVH of a scene of instances: what is outside, the level over the instances, the meshes.
#[test]
fn info_describes_all_levels() {
    let folder = Folder::new();
    folder.write("m.obj", "v 2 -1 -1\nv 2 1 -1\nv 2 0 1\nf 1 2 3\n");
    let places: String = (0..100).map(|i| format!("{i} {} 0\n", i % 7)).collect();
    folder.write("places.txt", &places);
    folder.write(
        "b.scn",
        "light 0 0 90 1\ninstance m.obj placements places.txt\nmaterial 1\ninstance m.obj\n",
    );
    let run = folder.run_line("info b.scn --json -");
    let info: serde_json::Value = serde_json::from_str(run.succeeded().text()).expect("JSON");
    let bvh = &info["bvh"];
    let numbers = |value: &serde_json::Value| -> Vec<u64> {
        let numbers = value.as_array().expect("an array").iter();
        numbers.map(|number| number.as_u64().expect("a number")).collect()
    };
    assert_eq!(numbers(&bvh["leaf_sizes"]), [0; 8]);
    let (upper, lower) = (&bvh["instances"], &bvh["prototypes"]);
    // Each node but the root, and each instance, is a child of a node.
    let children: u64 = numbers(&upper["child_counts"])
        .iter()
        .zip(1..)
        .map(|(n, of)| n * of)
        .sum();
    assert_eq!(children, upper["nodes"].as_u64().expect("a number") - 1 + 101);
    assert!(upper["depth"].as_u64() >= Some(3), "{upper}");
    // Two meshes, one for each material.
    assert_eq!(
        (&lower["nodes"], &lower["triangle_blocks"], &lower["depth"]),
        (&2.into(), &2.into(), &1.into())
    );
    assert_eq!(numbers(&lower["leaf_sizes"])[0], 2);
    let bytes = |value: &serde_json::Value| value["bytes"].as_u64().expect("a number");
    assert!(bytes(bvh) >= bytes(upper) + bytes(lower) && bytes(upper) > 0);
    let run = folder.run_line("info b.scn");
    let text = run.succeeded().text();
    assert!(
        text.contains("BVH of instances") && text.contains("BVHs of meshes"),
        "{text}"
    );
    assert!(!text.contains("triangle blocks    0"), "{text}");
    let run = folder.run_line("info a.scn --json -");
    assert!(
        run.succeeded()
            .text()
            .contains("\"instances\":null,\"prototypes\":null")
    );
}
