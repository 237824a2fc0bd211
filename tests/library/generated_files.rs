//! A generated scene that is written and loaded again is the same scene, bit for bit.

use octray::{
    format,
    generate::{Kind, Options, Shape, generate, write_ply},
    scene::Scene,
};
use std::fs::File;

fn bits(column: &[f32]) -> Vec<u32> {
    column.iter().map(|x| x.to_bits()).collect()
}

fn assert_same(kind: &str, a: &Scene, b: &Scene) {
    let floats = |s: &Scene| {
        let (v, b) = (s.vertices(), s.spheres());
        let normals: Vec<f32> = v.normals.iter().flat_map(glam::Vec3::to_array).collect();
        [
            &v.x,
            &v.y,
            &v.z,
            &normals,
            &b.center_x,
            &b.center_y,
            &b.center_z,
            &b.radius,
        ]
        .map(|column| bits(column))
    };
    assert!(floats(a) == floats(b), "{kind}: a column of numbers differs");
    assert_eq!(a.lights(), b.lights(), "{kind}: lights differ");
    let (ta, tb) = (a.triangles(), b.triangles());
    assert!(ta.corners == tb.corners, "{kind}: corners differ");
    assert!(
        ta.material == tb.material && a.spheres().material == b.spheres().material,
        "{kind}: materials differ"
    );
}

#[test]
fn files_give_back_what_was_generated() {
    for kind in Kind::ALL {
        let count = Some(kind.min_count().max(3_000));
        let generated = generate(kind, Options { seed: 9, count }).expect("a count within its limits");
        let folder = tempfile::tempdir().expect("a folder");
        for part in &generated.parts {
            if let (Shape::Mesh(mesh), Some(name)) = (&part.shape, generated.mesh_file_name(part)) {
                let mut file = File::create(folder.path().join(name)).expect("a file");
                write_ply(mesh, &mut std::io::BufWriter::new(&mut file)).expect("a mesh on disk");
            }
        }
        let path = folder.path().join("made.scn");
        let mut file = File::create(&path).expect("a file");
        generated.write_scn(&mut file).expect("a scene on disk");
        let loaded = format::load(&path).unwrap_or_else(|error| panic!("{error:?}"));
        let made = generated.into_scene().expect("a scene");
        assert_same(kind.name(), &made, &loaded);
    }
}
