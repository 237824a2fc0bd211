//! Tests of `origin`.

use super::*;
use crate::scene::{MaterialId, SceneBuilder};

#[test]
fn a_scene_far_from_0_is_stored_relative_to_its_centre_without_rounding() {
    let far = Vec3::new(8000.3, -5500.7, 0.4);
    let mut builder = SceneBuilder::new();
    let matte = MaterialId(1);
    let corners = [far, far + Vec3::X * 3.7, far + Vec3::Y * 0.3];
    builder.add_triangle(corners, matte).unwrap();
    builder.add_sphere(far - Vec3::Z, 1.1, matte).unwrap();
    builder.add_light(far * 1.5, 1.0).unwrap();
    let scene = builder.finish();
    let position = |scene: &Scene| scene.lights()[0].shape.position().map(|p| p + scene.origin());
    assert_eq!(scene.origin().z, 0.0, "the scene contains z = 0");
    let again = scene.triangle(0).map(|corner| corner + scene.origin());
    assert_eq!(again, corners);
    assert_eq!(scene.spheres().center(0) + scene.origin(), far - Vec3::Z);
    assert_eq!(position(&scene), Some(far * 1.5));
    let Aabb { lower, upper } = scene.bounds();
    assert!(lower.cmple(far - Vec3::ONE).all() && upper.cmpge(far).all());
    assert!(scene.vertices().x.iter().all(|x| x.abs() < 5.0));

    // Lights taken from another scene keep their positions.
    let mut lights = SceneBuilder::new();
    lights.add_light(far, 1.0).unwrap();
    let mut scene = scene;
    scene.take_lights(lights.finish());
    assert_eq!(position(&scene), Some(far));
}

#[test]
fn a_scene_around_0_keeps_its_coordinates() {
    for x in [-1.0, 0.0, 0.9] {
        let mut builder = SceneBuilder::new();
        builder.add_sphere(Vec3::splat(x), 0.5, MaterialId(0)).unwrap();
        let scene = builder.finish();
        assert_eq!(
            (scene.origin(), scene.spheres().center(0)),
            (Vec3::ZERO, Vec3::splat(x))
        );
    }
    assert_eq!(SceneBuilder::new().finish().origin(), Vec3::ZERO);
}
