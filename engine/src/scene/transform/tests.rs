use super::*;

/// A triangle with its face normal at every corner.
fn mesh() -> TriangleMesh {
    TriangleMesh {
        x: vec![1.0, 0.0, 0.0],
        y: vec![0.0, 2.0, 0.0],
        z: vec![0.0, 0.0, 3.0],
        normals: vec![Vec3::new(6.0, 3.0, 2.0); 3],
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: vec![[0, 1, 2]],
    }
}

fn corners(mesh: &TriangleMesh) -> [Vec3; 3] {
    mesh.triangles[0].map(|i| {
        let i = i as usize;
        Vec3::new(mesh.x[i], mesh.y[i], mesh.z[i])
    })
}

fn facet(mesh: &TriangleMesh) -> Vec3 {
    let [a, b, c] = corners(mesh);
    (b - a).cross(c - a).normalize()
}

#[test]
fn quarter_turns_are_exact() {
    let mut mesh = mesh();
    Transform::IDENTITY
        .then_rotate(DVec3::Z * 7.0, 90.0)
        .apply(&mut mesh);
    assert_eq!(
        corners(&mesh),
        [Vec3::Y, Vec3::new(-2.0, 0.0, 0.0), Vec3::new(0.0, 0.0, 3.0)]
    );
    for (degrees, expected) in [
        (0.0, (0.0, 1.0)),
        (180.0, (0.0, -1.0)),
        (-90.0, (-1.0, 0.0)),
        (630.0, (-1.0, 0.0)),
    ] {
        assert_eq!(sin_cos_degrees(degrees), expected, "{degrees}");
    }
    let (sin, cos) = sin_cos_degrees(150.0);
    assert!((sin - 0.5).abs() < 1e-15 && (cos + 0.75_f64.sqrt()).abs() < 1e-15);
}

#[test]
fn steps_apply_in_order() {
    let mut mesh = mesh();
    let up = DVec3::new(0.0, 0.0, 1.0);
    Transform::IDENTITY
        .then_translate(up)
        .then_scale(DVec3::splat(2.0))
        .then_translate(up)
        .apply(&mut mesh);
    assert_eq!(mesh.z, [3.0, 3.0, 9.0]);
    assert_eq!(mesh.x, [2.0, 0.0, 0.0]);
}

#[test]
fn normals_stay_perpendicular_and_in_front() {
    for factors in [
        DVec3::new(1.0, 1.0, 1.0),
        DVec3::new(5.0, 0.1, 2.0),
        DVec3::new(-1.0, 3.0, 0.5),
        DVec3::new(-1.0, -3.0, -0.5),
        DVec3::splat(1e-9),
    ] {
        let mut mesh = mesh();
        Transform::IDENTITY
            .then_rotate(DVec3::new(1.0, 2.0, 3.0), 33.0)
            .then_scale(factors)
            .apply(&mut mesh);
        // The origin stays behind the triangle.
        assert!(facet(&mesh).dot(corners(&mesh)[0]) > 0.0, "{factors}");
        for normal in &mesh.normals {
            assert!(normal.abs_diff_eq(facet(&mesh), 1e-5), "{factors}: {normal}");
        }
    }
}

#[test]
fn the_identity_keeps_every_bit() {
    let mut mesh = mesh();
    mesh.x[0] = -0.0;
    Transform::IDENTITY.apply(&mut mesh);
    assert!(mesh.x[0].is_sign_negative());
    assert_eq!(mesh.normals[0], Vec3::new(6.0, 3.0, 2.0));
}

#[test]
fn orthographic_views_are_scaled() {
    let view = View {
        projection: Projection::Orthographic { height: 3.0 },
        up: DVec3::Z * 7.0,
        ..View::classic(1).unwrap()
    };
    let scaled = Transform::IDENTITY.then_scale(DVec3::splat(-2.0)).view(&view);
    assert_eq!(scaled.projection, Projection::Orthographic { height: 6.0 });
}

#[test]
fn a_missing_normal_stays_missing() {
    let mut mesh = mesh();
    mesh.normals[1] = Vec3::ZERO;
    Transform::IDENTITY.then_scale(DVec3::splat(2.0)).apply(&mut mesh);
    assert_eq!(mesh.normals[1], Vec3::ZERO);
}
