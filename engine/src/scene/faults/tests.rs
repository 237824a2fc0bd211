use crate::scene::{MaterialId, MeshFaults, SceneBuilder, TriangleMesh};

fn faults(triangles: &[[u32; 3]]) -> MeshFaults {
    // A 4 x 4 grid, and a copy of its first vertex.
    let grid = |f: fn(usize) -> usize| (0..16).chain([0]).map(|i| f(i) as f32).collect();
    let mesh = TriangleMesh {
        x: grid(|i| i % 4),
        y: grid(|i| i / 4),
        z: vec![0.0; 17],
        normals: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: triangles.to_vec(),
    };
    let mut builder = SceneBuilder::new();
    builder.add_mesh(mesh, MaterialId(1)).expect("a mesh");
    builder.finish().mesh_faults()
}

#[test]
fn each_fault_is_counted_once() {
    let good = [[0, 1, 5], [16, 5, 4], [1, 2, 6], [1, 6, 5]];
    assert_eq!(faults(&good).total(), 0);
    let with = |more: &[[u32; 3]]| faults(&[&good[..], more].concat());
    assert_eq!(with(&[[0, 1, 2], [3, 3, 7]]).degenerate, 2);
    assert_eq!(with(&[[9, 10, 14], [14, 10, 9], [9, 10, 14]]).duplicate, 2);
    let turned = [[0, 1, 5], [0, 4, 5], [1, 2, 6], [1, 6, 5]];
    assert_eq!(
        faults(&turned),
        MeshFaults {
            inverted: 1,
            ..MeshFaults::default()
        }
    );
    assert_eq!(faults(&[]), MeshFaults::default());
}

/// Two pyramids without bases that share one edge of their rims: each faces outwards.
#[test]
fn bodies_that_touch_at_an_edge_are_not_inverted() {
    let mesh = TriangleMesh {
        x: vec![0.0, 1.0, 0.5, 0.5, 0.5, 0.5],
        y: vec![0.0, 0.0, 1.0, 0.3, -1.0, -0.3],
        z: vec![0.0, 0.0, 0.0, 1.0, 0.0, -1.0],
        triangles: vec![[0, 1, 3], [1, 2, 3], [2, 0, 3], [0, 1, 5], [1, 4, 5], [4, 0, 5]],
        ..TriangleMesh::default()
    };
    let mut builder = SceneBuilder::new();
    builder.add_mesh(mesh, MaterialId(1)).expect("a mesh");
    assert_eq!(builder.finish().mesh_faults().inverted, 0);
}

/// Part of a 3 x 3 sheet of squares.
#[test]
fn an_inverted_part_of_a_sheet_is_counted() {
    let sheet = |turned: fn(u32) -> bool| {
        let squares = (0..9).flat_map(|i| {
            let a = i / 3 * 4 + i % 3;
            let square = [[a, a + 1, a + 5], [a, a + 5, a + 4]];
            square.map(|[a, b, c]| if turned(i) { [a, c, b] } else { [a, b, c] })
        });
        faults(&squares.collect::<Vec<_>>()).inverted
    };
    assert_eq!(sheet(|i| i == 0), 2);
    assert_eq!(sheet(|i| i == 4), 2);
    assert_eq!(sheet(|i| i < 3), 6);
    assert_eq!(sheet(|i| i < 6), 6);
    assert_eq!(sheet(|i| i / 3 == 1), 6);
}

/// Two prototypes of one mesh, and the mesh itself.
#[test]
fn prototypes_are_no_copies_of_each_other() {
    let mesh = || TriangleMesh {
        x: vec![0.0, 1.0, 0.0, 0.0],
        y: vec![0.0, 0.0, 1.0, 0.0],
        z: vec![0.0, 0.0, 0.0, 1.0],
        triangles: vec![[0, 1, 2], [2, 1, 0], [0, 2, 3], [1, 1, 1]],
        ..TriangleMesh::default()
    };
    let mut builder = SceneBuilder::new();
    for _ in 0..2 {
        builder.add_mesh(mesh(), MaterialId(1)).expect("a mesh");
        let stored = builder.add_prototype(|builder| builder.add_mesh(mesh(), MaterialId(1)));
        stored.expect("a prototype");
    }
    let faults = builder.finish().mesh_faults();
    // One within each prototype; of the meshes that one, and all of the second.
    assert_eq!(faults.duplicate, 1 + 1 + 1 + 4);
    assert_eq!(faults.degenerate, 4);
}

/// Two squares of `n` x `n` quads in one plane: one of them is turned.
#[test]
fn half_of_a_surface_may_be_inverted() {
    for n in [1, 2, 5, 20] {
        let across = 2 * n + 1;
        let vertices = across * (n + 1);
        let mut triangles = Vec::new();
        for y in 0..n {
            for x in 0..2 * n {
                let a = y * across + x;
                for [i, j, k] in [[a, a + 1, a + across + 1], [a, a + across + 1, a + across]] {
                    triangles.push(if x < n { [i, k, j] } else { [i, j, k] }.map(|i| i as u32));
                }
            }
        }
        let mesh = TriangleMesh {
            x: (0..vertices).map(|i| (i % across) as f32).collect(),
            y: (0..vertices).map(|i| (i / across) as f32).collect(),
            z: vec![0.0; vertices],
            triangles,
            ..TriangleMesh::default()
        };
        let mut builder = SceneBuilder::new();
        builder.add_mesh(mesh, MaterialId(1)).expect("a mesh");
        assert_eq!(builder.finish().mesh_faults().inverted, 2 * n * n, "{n}");
    }
}
