//! The course's own scenes load, with as much in them as their files say.

use octray::{format::load, scene::Scene};
use std::{env, path::PathBuf};

/// The course's folder, where it is at hand.
fn classic() -> Option<PathBuf> {
    let shared = env::var_os("OCTRAY_SHARED").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared"),
        PathBuf::from,
    );
    let course = shared.join("course");
    if course.is_dir() {
        return Some(course);
    }
    println!("skipped: no course files in {}", course.display());
    None
}

fn scene(name: &str) -> Option<Scene> {
    let path = classic()?.join("framework").join(name);
    Some(load(&path).unwrap_or_else(|error| panic!("{}", error.report())))
}

#[test]
fn counts() {
    // Lights, spheres, triangles, vertices.
    // The slab of 16 faces has 4 quads, the finer one of 256 has 64.
    let figure = [2, 3, 20 + 10 + 3, 34 + 28 + 9];
    let expected = [
        ("silhouette.scn", figure),
        ("matte.scn", figure),
        ("reflections.scn", figure),
        ("blinn_phong.scn", figure),
        ("cow.scn", [2, 3, 5804 + 320 + 10 + 3, 2903 + 257 + 28 + 9]),
    ];
    for (name, expected) in expected {
        let Some(scene) = scene(name) else { return };
        let found = [
            scene.lights().x.len(),
            scene.spheres().radius.len(),
            scene.triangles().corners.len(),
            scene.vertices().x.len(),
        ];
        println!("{name}: {found:?}");
        assert_eq!(found, expected, "{name}");
        assert_eq!(scene.vertices().normals.len(), scene.vertices().x.len(), "{name}");
    }
}

#[test]
fn materials() {
    for (number, name) in [
        "silhouette.scn",
        "matte.scn",
        "blinn_phong.scn",
        "reflections.scn",
    ]
    .iter()
    .enumerate()
    {
        let Some(scene) = scene(name) else { return };
        let spheres = &scene.spheres().material;
        let mut all = spheres.iter().chain(&scene.triangles().material);
        assert!(all.all(|material| material.0 as usize == number), "{name}");
    }
}
