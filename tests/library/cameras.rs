//! Cameras against closed forms.

use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Aovs, Film, Renderer, Settings, render},
    scene::{Background, Camera, Material, Projection, Scene, SceneBuilder, View},
};
use std::ops::ControlFlow;

fn settings(side: u32, samples: u32) -> Settings {
    Settings {
        width: side,
        height: side,
        samples,
        ..Settings::default()
    }
}

fn picture(scene: &Scene, camera: &Camera, settings: &Settings) -> Film {
    let bvh = Bvh::build(scene);
    let frame = render(scene, &bvh, camera, settings, &|_| ControlFlow::Continue(()));
    frame.expect("a small picture").film
}

fn aovs(scene: &Scene, camera: &Camera, settings: &Settings) -> Aovs {
    let bvh = Bvh::build(scene);
    let aovs = Renderer::new(scene, &bvh).aovs(camera, settings, false, &|_| ControlFlow::Continue(()));
    aovs.expect("AOVs")
}

/// White spheres before a black background.
fn spheres(spheres: &[(Vec3, f32)]) -> Scene {
    let mut builder = SceneBuilder::new();
    builder.set_background(Background::constant([0.0; 3])).unwrap();
    let white = Material::Silhouette { color: [1.0; 3] };
    let white = builder.add_material(white).unwrap();
    for &(center, radius) in spheres {
        builder.add_sphere(center, radius, white).unwrap();
    }
    builder.finish()
}

/// Looks along y at the origin, 10 away from it.
fn along_y() -> View {
    View {
        eye: DVec3::new(0.0, -10.0, 0.0),
        target: DVec3::ZERO,
        up: DVec3::Z,
        projection: Projection::DEFAULT,
    }
}

/// The share of the picture that is white.
fn white(film: &Film) -> f64 {
    let sum: f64 = film.pixels().iter().map(|pixel| f64::from(pixel[0])).sum();
    sum / film.pixels().len() as f64
}

#[test]
fn distance_changes_no_size_in_an_orthographic_view() {
    let camera = Camera::new(&View {
        projection: Projection::Orthographic { height: 4.0 },
        ..along_y()
    });
    let camera = camera.unwrap();
    for y in [-5.0, 0.0, 100.0, 1e5] {
        let scene = spheres(&[(Vec3::new(0.5, y, -0.5), 1.0)]);
        let share = white(&picture(&scene, &camera, &settings(64, 16)));
        assert!((share - std::f64::consts::PI / 16.0).abs() < 2e-3, "{y}: {share}");
        let depth = aovs(&scene, &camera, &settings(64, 1)).pixels[40 * 64 + 40].depth;
        assert!((depth - (9.0 + y)).abs() < 0.02 * (1.0 + y.abs()), "{y}: {depth}");
    }
    // What is beside the view, or behind the eye, is not seen.
    let scene = spheres(&[(Vec3::new(3.1, 0.0, 0.0), 1.0), (Vec3::new(0.0, -12.0, 0.0), 1.0)]);
    assert_eq!(white(&picture(&scene, &camera, &settings(64, 1))), 0.0);
}
