use super::*;

/// Two squares that meet at `degrees` and share no vertices.
fn roof(degrees: f64) -> TriangleMesh {
    let (s, c) = (
        libm::sin(degrees.to_radians()) as f32,
        libm::cos(degrees.to_radians()) as f32,
    );
    TriangleMesh {
        x: vec![-1.0, 0.0, 0.0, -1.0, 0.0, c, c, 0.0],
        y: vec![0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0],
        z: vec![0.0, 0.0, 0.0, 0.0, 0.0, s, s, 0.0],
        normals: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
    }
}

#[test]
fn a_blunt_edge_is_smoothed_and_a_sharp_one_kept() {
    let mut blunt = roof(20.0);
    blunt.smooth_normals(30.0).expect("little memory");
    // The two vertices of the edge are shared now; their normals lie between those of the faces.
    assert_eq!(blunt.x.len(), 6);
    let edge = blunt.triangles[0][1] as usize;
    let expected = DVec3::new(
        -libm::sin(10_f64.to_radians()),
        0.0,
        libm::cos(10_f64.to_radians()),
    );
    assert!((blunt.normals[edge].as_dvec3() - expected).length() < 1e-6);

    let mut sharp = roof(40.0);
    sharp.smooth_normals(30.0).expect("little memory");
    assert_eq!(sharp.x.len(), 8);
    assert_eq!(sharp.normals[sharp.triangles[0][1] as usize], Vec3::Z);
}

#[test]
fn colours_split_vertices() {
    let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    let mut mesh = roof(20.0);
    mesh.colors = [[red; 4], [blue; 4]].concat();
    mesh.smooth_normals(30.0).expect("little memory");
    assert_eq!((mesh.x.len(), mesh.colors.len()), (8, 8));
    for (triangles, color) in [(&mesh.triangles[..2], red), (&mesh.triangles[2..], blue)] {
        for &vertex in triangles.as_flattened() {
            assert_eq!(mesh.colors[vertex as usize], color);
        }
    }
    let mut mesh = roof(20.0);
    mesh.colors = vec![red; 8];
    mesh.smooth_normals(30.0).expect("little memory");
    assert_eq!(mesh.colors, [red; 6]);
}

#[test]
fn existing_normals_are_kept() {
    let mut mesh = roof(20.0);
    mesh.normals = vec![Vec3::X; 8];
    mesh.smooth_normals(30.0).expect("little memory");
    assert_eq!(mesh.normals, [Vec3::X; 8]);
    let empty = TriangleMesh::default().smooth_normals(30.0);
    assert_eq!(empty, Ok(()));
}
