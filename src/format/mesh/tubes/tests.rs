//! Tests of `tubes`.

use super::*;

#[test]
fn prisms_stand_around_their_segments() {
    let points = TriangleMesh {
        x: vec![1.0, 4.0, 4.0],
        y: vec![2.0, 6.0, 6.0],
        z: vec![3.0, 3.0, 3.0],
        colors: vec![[1.0, 0.0, 0.0], [0.0; 3], [1.0; 3]],
        ..TriangleMesh::default()
    };
    let lines = [[0, 1], [1, 2], [2, 2], [2, 0]];
    assert_eq!(count(&points, &lines), Ok(2));
    let mesh = prisms(&points, &lines, 0.5, 2).expect("little memory");
    assert_eq!(
        (mesh.x.len(), mesh.triangles.len()),
        (2 * VERTICES, 2 * TRIANGLES)
    );
    assert_eq!(
        [mesh.colors[7], mesh.colors[8], mesh.colors[16]],
        [[1.0, 0.0, 0.0], [0.0; 3], [1.0; 3]]
    );
    let position = |i: u32| Vec3::new(mesh.x[i as usize], mesh.y[i as usize], mesh.z[i as usize]);
    let (start, axis) = (Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.6, 0.8, 0.0));
    let mut area = 0.0;
    for &[a, b, c] in &mesh.triangles[..TRIANGLES] {
        let normal = (position(b) - position(a)).cross(position(c) - position(a));
        area += 0.5 * normal.length();
        for corner in [a, b, c] {
            let from_start = position(corner) - start;
            let along = from_start.dot(axis);
            assert!(along.abs() < 1e-5 || (along - 5.0).abs() < 1e-5, "{along}");
            let outwards = from_start - axis * along;
            assert!((outwards.length() - 0.5).abs() < 1e-5, "{outwards}");
            // The front is outside.
            assert!(mesh.normals[corner as usize].dot(normal) > 0.0);
            assert!(mesh.normals[corner as usize].dot(outwards) > 0.499);
        }
    }
    // Eight sides, each 2 r sin(pi / 8) wide.
    let expected = 8.0 * 5.0 * std::f32::consts::FRAC_PI_8.sin();
    assert!((area - expected).abs() < 1e-3, "{area}");
    assert_eq!(
        count(&points, &[[0, 3]]),
        Err(SceneError::LineIndex {
            index: 3,
            vertices: 3
        })
    );
}
