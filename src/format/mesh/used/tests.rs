//! What is dropped from each format, and what is said of it.

use super::*;
use crate::format::mesh::{Cloud, parse};
use std::io;

/// Vertices along x, each with a colour and a texture coordinate of its number.
fn mesh(count: u32, triangles: &[[u32; 3]]) -> LoadedMesh {
    let numbers: Vec<f32> = (0..count).map(|i| i as f32).collect();
    LoadedMesh {
        columns: TriangleMesh {
            x: numbers.clone(),
            y: numbers.clone(),
            z: numbers.clone(),
            colors: numbers.iter().map(|&i| [i; 3]).collect(),
            uvs: numbers.iter().map(|&i| [i; 2]).collect(),
            tangents: numbers.iter().map(|&i| [i; 4]).collect(),
            triangles: triangles.to_vec(),
            ..TriangleMesh::default()
        },
        ..LoadedMesh::default()
    }
}

fn unusable(count: usize) -> Unusable<LoadError> {
    let mut unusable = Unusable {
        count,
        ..Unusable::default()
    };
    unusable.keep_first(|| LoadError::whole_file(Path::new("a.x"), "the first"));
    unusable
}

fn kept(mut mesh: LoadedMesh, unusable: Unusable<LoadError>) -> Result<LoadedMesh, String> {
    let kept = mesh.keep_used(unusable, Path::new("a.x"), &Budget::unlimited());
    kept.map(|()| mesh).map_err(|error| error.to_string())
}

#[test]
fn vertices_that_no_triangle_uses_are_dropped() {
    let found = kept(mesh(6, &[[5, 1, 3], [3, 1, 4]]), Unusable::default()).expect("a mesh");
    assert_eq!(found.columns.x, [1.0, 3.0, 4.0, 5.0]);
    assert_eq!(found.columns.triangles, [[3, 0, 1], [1, 0, 2]]);
    assert_eq!(
        (
            found.columns.colors[3],
            found.columns.uvs[3],
            found.columns.tangents[3]
        ),
        ([5.0; 3], [5.0; 2], [5.0; 4])
    );
    assert!(found.notes.is_empty());
    // Without triangles they are counted in an error.
    let found = kept(mesh(6, &[]), Unusable::default()).expect("vertices");
    assert_eq!(found.columns.x.len(), 6);
}

#[test]
fn triangles_with_unusable_corners_are_dropped() {
    let mut broken = mesh(6, &[[0, 1, 2], [1, 2, 3], [3, 4, 5]]);
    (broken.columns.z[0], broken.surface_of) = (f32::NAN, vec![7, 8, 9]);
    broken.notes = vec!["a.x: left out: 1 light".to_owned()];
    let found = kept(broken, unusable(1)).expect("a mesh");
    assert_eq!(found.columns.triangles, [[0, 1, 2], [2, 3, 4]]);
    assert_eq!(found.surface_of, [8, 9]);
    assert_eq!(
        found.notes,
        ["a.x: left out: 1 light, 1 vertex that is NaN or too large, 1 triangle that uses it"]
    );
    let mut broken = mesh(3, &[[0, 1, 2]]);
    broken.columns.z[0] = f32::INFINITY;
    assert_eq!(kept(broken, unusable(1)).expect_err("nothing"), "a.x: the first");
}

#[test]
fn unusable_points_are_dropped() {
    let cloud = |lines: &[[u32; 2]]| {
        let mut cloud = mesh(4, &[]);
        (cloud.columns.y[1], cloud.columns.x[2]) = (f32::NAN, -2e9);
        cloud.cloud = Some(Cloud {
            radius: None,
            lines: lines.to_vec(),
        });
        cloud
    };
    let found = kept(cloud(&[]), unusable(2)).expect("points");
    assert_eq!(found.columns.x, [0.0, 3.0]);
    assert_eq!(found.notes, ["a.x: left out: 2 points that are NaN or too large"]);
    let found = kept(cloud(&[[0, 1], [3, 0]]), unusable(2)).expect("a line");
    assert_eq!(found.cloud.expect("a cloud").lines, [[1, 0]]);
    assert_eq!(
        found.notes,
        ["a.x: left out: 2 vertices that are NaN or too large, 1 line that uses them"]
    );
}

fn try_load(name: &str, bytes: impl Into<Vec<u8>>) -> Result<LoadedMesh, String> {
    let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    parse(bytes.into(), Path::new(name), open).map_err(|error| error.to_string())
}

fn load(name: &str, bytes: impl Into<Vec<u8>>) -> LoadedMesh {
    try_load(name, bytes).unwrap_or_else(|error| panic!("{error}"))
}

/// A unit triangle and a vertex that no face uses, in three formats.
#[test]
fn vertices_without_faces_do_not_count() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
               element face 1\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0\n1000 2 3\n1 0 0\n0 1 0\n3 0 2 3\n";
    for (name, text) in [
        ("a.obj", "v 0 0 0\nv 1000 2 3\nv 1 0 0\nv 0 1 0\nf 1 3 4\n"),
        ("a.off", "OFF\n4 1 0\n0 0 0\n1000 2 3\n1 0 0\n0 1 0\n3 0 2 3\n"),
        ("a.ply", ply),
    ] {
        for far in ["1000", "nan"] {
            let mesh = load(name, text.replace("1000", far));
            assert_eq!(mesh.columns.x, [0.0, 1.0, 0.0], "{name}");
            assert_eq!(mesh.columns.triangles, [[0, 1, 2]], "{name}");
            let note = format!("{name}: left out: 1 vertex that is NaN or too large");
            assert_eq!(mesh.notes, if far == "nan" { vec![note] } else { vec![] });
        }
    }
}

#[test]
fn faces_with_unusable_corners_are_left_out_whole() {
    let corners = ["0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 1", "1 0 1"];
    let header = "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    for unusable in 0..4 {
        for number in ["nan", "-inf", "3e38"] {
            let vertex = |(i, corner): (usize, &&str)| {
                if i == unusable {
                    format!("0 1 {number}")
                } else {
                    (*corner).to_owned()
                }
            };
            let lines: Vec<String> = corners.iter().enumerate().map(vertex).collect();
            let rows = lines.join("\n");
            for (name, text) in [
                (
                    "a.obj",
                    format!("v {}\nf 1 2 3 4\nf 3 5 6\nf 2 5 6\n", lines.join("\nv ")),
                ),
                ("a.off", format!("OFF\n6 2 0\n{rows}\n4 0 1 2 3\n3 4 5 4\n")),
                ("a.ply", format!("{header}{rows}\n4 0 1 2 3\n3 4 5 4\n")),
            ] {
                let mesh = load(name, text);
                let quad_is_gone = mesh.columns.triangles.len() <= 2;
                assert!(quad_is_gone, "{name} {unusable}: {:?}", mesh.columns.triangles);
                assert!(mesh.columns.x.iter().all(|x| x.is_finite()));
                let note = format!("{name}: left out: 1 vertex that is NaN or too large, ");
                assert!(mesh.notes[0].starts_with(&note), "{:?}", mesh.notes);
            }
        }
    }
    let stl = |z: &str| {
        let facet = |z: &str| {
            format!(
                "facet normal 0 0 0\nouter loop\nvertex 0 0 {z}\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
            )
        };
        format!("solid\n{}{}endsolid\n", facet(z), facet("5"))
    };
    let mesh = load("a.stl", stl("nan"));
    assert_eq!((mesh.columns.triangles.len(), mesh.columns.x.len()), (1, 3));
    assert_eq!(
        mesh.notes,
        ["a.stl: left out: 1 vertex that is NaN or too large, 1 triangle that uses it"]
    );
    let mut binary = vec![0; 84];
    binary[80] = 2;
    for z in [f32::INFINITY, 5.0] {
        let numbers = [0.0, 0.0, 1.0, 0.0, 0.0, z, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        binary.extend(numbers.into_iter().flat_map(f32::to_le_bytes).chain([0; 2]));
    }
    let read = load("b.stl", binary);
    assert_eq!((read.columns.triangles.len(), read.columns.z[0]), (1, 5.0));
    assert_eq!(
        read.notes,
        ["b.stl: left out: 1 vertex that is NaN or too large, 1 triangle that uses it"]
    );
}

#[test]
fn unusable_points_and_normals_are_left_out() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               property float nx\nproperty float ny\nproperty float nz\nend_header\n\
               0 0 0 0 0 1\nnan nan nan nan nan nan\n1 0 0 0 nan 1\n";
    let mesh = load("a.ply", ply);
    assert_eq!(mesh.columns.x, [0.0, 1.0]);
    assert_eq!(mesh.columns.normals, [Vec3::Z, Vec3::ZERO]);
    assert_eq!(
        mesh.notes,
        ["a.ply: left out: 2 normals that are NaN or too large, 1 point that is NaN or too large"]
    );
    let error = try_load("a.obj", "v nan 0 0\nv 0 inf 0\n").expect_err("nothing remains");
    assert_eq!(error, "a.obj:1:3: x is NaN, expected a finite number");
}

#[test]
fn faces_with_few_corners_are_left_out() {
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               element face 3\nproperty list uchar int vertex_indices\nend_header\n\
               0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n1 0\n";
    let stl = "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
               facet normal 0 0 0\nouter loop\nvertex 0 0 9\nvertex 1 0 0\nendloop\nendfacet\n\
               facet normal 0 0 0\nouter loop\nendloop\nendfacet\nendsolid\n";
    for (name, text) in [
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\nf 3\n"),
        ("a.off", "OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n3 0 1 2\n1 0\n"),
        ("a.ply", ply),
        ("a.stl", stl),
    ] {
        let mesh = load(name, text);
        assert_eq!(
            (mesh.columns.x.len(), mesh.columns.triangles.len()),
            (3, 1),
            "{name}"
        );
        assert_eq!(
            mesh.notes,
            [format!("{name}: left out: 2 faces with fewer than 3 corners")]
        );
    }
}

/// Two nodes with two triangles each, the second of which has the corner x, 5, 0.
#[cfg(feature = "gltf")]
#[test]
fn triangles_of_gltf_with_unusable_corners_are_left_out() {
    use crate::format::mesh::{Sharing, parse_shared};
    use base64::{Engine, prelude::BASE64_STANDARD};
    let loaded = |x: [f32; 2], nodes: &str, sharing| {
        let corners = [x[0], 1.0, 0.0, 1.0, 0.0, 0.0, 2.0, 1.0, 0.0, x[1], 5.0, 0.0];
        let bytes: Vec<u8> = corners.into_iter().flat_map(f32::to_le_bytes).collect();
        let bytes = [bytes, vec![0, 1, 2, 2, 1, 3]].concat();
        let data = BASE64_STANDARD.encode(bytes);
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{nodes}],"materials":[{{}}],
            "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
            {{"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":6}}],
            "buffers":[{{"byteLength":54,"uri":"data:application/octet-stream;base64,{data}"}}]}}"#
        );
        let open = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
        parse_shared(json.into(), Path::new("a.gltf"), open, sharing).map_err(|error| error.to_string())
    };
    let twice = r#"{"mesh":0},{"mesh":0,"translation":[0,0,3]}"#;
    for x in [f32::NAN, f32::NEG_INFINITY, 2e9] {
        let baked = loaded([0.0, x], twice, Sharing::Never).expect("a mesh");
        assert_eq!(baked.columns.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(baked.surface_of, [0, 0]);
        let note = "a.gltf: left out: 2 vertices that are NaN or too large, 2 triangles that use them";
        assert_eq!(baked.notes, [note]);
        let shared = loaded([0.0, x], twice, Sharing::Always).expect("a mesh");
        let part = &shared.shared[0];
        assert_eq!((part.columns.x.len(), part.placements.len()), (3, 2));
        assert_eq!((part.columns.triangles.len(), part.surface_of.len()), (1, 1));
        let note = "a.gltf: left out: 1 vertex that is NaN or too large, 1 triangle that uses it";
        assert_eq!(shared.notes, [note]);
    }
    // A node moves its mesh too far.
    let far = r#"{"mesh":0},{"mesh":0,"translation":[0,0,2e9]}"#;
    let mesh = loaded([0.0; 2], far, Sharing::Never).expect("a mesh");
    assert_eq!(mesh.columns.triangles.len(), 2);
    let nothing = r#"{"mesh":0,"translation":[0,2e9,0]}"#;
    assert_eq!(
        loaded([0.0; 2], nothing, Sharing::Never).expect_err("nothing is left"),
        "a.gltf: accessors[0]: vertex 1 of 4: y is 2e9, but numbers above 1e9 are not supported"
    );
}
