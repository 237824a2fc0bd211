//! Tests of `plane`.

use super::*;

#[test]
fn planes_keep_their_place() {
    let far = Vec3::new(8000.5, -5500.25, 100.0);
    let mut builder = SceneBuilder::new();
    builder.add_sphere(far, 1.0, MaterialId(1)).unwrap();
    builder
        .add_plane(Vec3::new(3.0, 4.0, 99.0), Vec3::Z * 7.0, MaterialId(2))
        .unwrap();
    let oblique = Vec3::new(1.0, 2.0, -2.0);
    builder.add_plane(far, oblique, MaterialId(1)).unwrap();
    let scene = builder.finish();
    assert_eq!(scene.origin(), far);
    assert_eq!(scene.planes()[0].point, Vec3::new(0.0, 0.0, -1.0));
    assert_eq!(scene.planes()[0].normal, Vec3::Z);
    assert_eq!(scene.planes()[1].point, Vec3::ZERO);
    assert_eq!((scene.plane_id(1), scene.primitive_count()), (PrimitiveId(2), 1));
    assert_eq!(scene.material_of(PrimitiveId(1)), MaterialId(2));
}

#[test]
fn planes_without_a_normal_are_refused() {
    let mut builder = SceneBuilder::new();
    let mut add = |normal| builder.add_plane(Vec3::ZERO, normal, MaterialId(1));
    assert!(matches!(add(Vec3::ZERO), Err(SceneError::NotPositive { .. })));
    assert!(matches!(add(Vec3::NAN), Err(SceneError::NotUsable { .. })));
    for _ in 0..MAX_PLANES {
        add(Vec3::new(1e-30, 0.0, 1e-30)).unwrap();
    }
    assert!(matches!(add(Vec3::X), Err(SceneError::TooMany { .. })));
}
