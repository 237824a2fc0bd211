//! Tests of `fit`.

use super::*;

/// The ends of the picture that the points of a mesh reach from the eye: right, left, up, down.
fn ends(mesh: &TriangleMesh, fit: &Fit, view: &FitView) -> [f64; 4] {
    let forward = (fit.target - fit.eye).normalize();
    let right = forward.cross(view.up).normalize();
    let up = right.cross(forward);
    let slope = (view.fov_degrees.expect("perspective").to_radians() * 0.5).tan();
    let mut ends = [f64::NEG_INFINITY; 4];
    for ((&x, &y), &z) in mesh.x.iter().zip(&mesh.y).zip(&mesh.z) {
        let arm = DVec3::new(x.into(), y.into(), z.into()) - fit.eye;
        let half_height = slope * forward.dot(arm);
        let across = right.dot(arm) / (half_height * view.aspect);
        let upwards = up.dot(arm) / half_height;
        for (end, reached) in ends.iter_mut().zip([across, -across, upwards, -upwards]) {
            *end = end.max(reached);
        }
    }
    ends
}

#[test]
fn meshes_are_centred_in_both_directions() {
    let mut random = fastrand::Rng::with_seed(3);
    for case in 0..200 {
        // Plates, rods and lumps.
        let size = [[8.0, 6.0, 0.01], [0.1, 0.1, 9.0], [1.0, 2.0, 3.0]][case % 3];
        let mut column = |axis: usize| (0..50).map(|_| random.f32() * size[axis]).collect();
        let mesh = TriangleMesh {
            x: column(0),
            y: column(1),
            z: column(2),
            ..TriangleMesh::default()
        };
        let view = FitView {
            towards_viewer: DVec3::new(random.f64() - 0.5, random.f64() - 0.5, random.f64() + 0.1),
            up: DVec3::Z,
            fov_degrees: Some(10.0 + 80.0 * random.f64()),
            aspect: [0.5, 1.0, 16.0 / 9.0][case / 3 % 3],
        };
        let fit = view.fit(&mesh).expect("a view");
        let [right, left, up, down] = ends(&mesh, &fit, &view);
        assert!((right - left).abs() < 1e-6 && (up - down).abs() < 1e-6, "{case}");
        // An eye close to the end of a rod stays in front of it.
        assert!(right.max(up) < 1.0 - MARGIN + 1e-6, "{case}");
    }
}
