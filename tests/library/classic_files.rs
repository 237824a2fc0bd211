//! The original classic scenes load completely: primitives, normals and materials. Skipped where they are absent.

use crate::classic_images::folder;
use octray::{format::load, scene::Scene};

fn scene(name: &str) -> Option<Scene> {
    let path = folder()?.join("framework").join(name);
    Some(load(&path).unwrap_or_else(|error| panic!("{}", error.report())))
}

#[test]
fn counts() {
    // Lights, spheres, triangles and vertices of slab, cube and tetrahedron. 4 of the slab's 16 faces are quads, 64 of the
    // finer slab's 256.
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
            scene.lights().len(),
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
