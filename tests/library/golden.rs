//! Shipped and generated scenes against the golden pictures in `tests/golden`.
//!
//! A picture that differs is written to `target/image-failures` with the expected one and the difference.
//! `OCTRAY_BLESS=1 cargo test golden` replaces golden pictures that differ: look at them before you commit.

use crate::{
    images::{assert_all, compare_golden, to_image},
    shipped_scene,
};
use glam::DVec3;
use octray::{
    accel::Bvh,
    classic,
    generate::{Kind, Options, generate},
    render::{Pattern, Settings, render},
    scene::{Camera, Scene},
};
use std::ops::ControlFlow;

/// The share of pixels that may differ: without fused multiply-add, edges round differently.
const SHARE: f64 = 0.001;

fn picture(scene: &Scene, camera: &Camera, settings: &Settings) -> image::RgbImage {
    let bvh = Bvh::build(scene);
    let frame = render(scene, &bvh, camera, settings, &|_| ControlFlow::Continue(())).expect("it renders");
    to_image(&frame.film)
}

fn settings(width: u32, height: u32) -> Settings {
    Settings {
        width,
        height,
        ..Settings::default()
    }
}

#[test]
fn classic_scenes() {
    assert_all(
        [
            ("silhouette", 1),
            ("matte", 1),
            ("matte", 2),
            ("matte", 4),
            ("blinn_phong", 1),
            ("blinn_phong", 5),
            ("reflections", 1),
            ("reflections", 3),
            ("reflections", 6),
        ]
        .map(|(name, view)| {
            let camera = Camera::classic_view(view).expect("views are 1 to 6");
            let actual = picture(&shipped_scene(name), &camera, &settings(160, 160));
            compare_golden(&format!("{name}-{view}"), &actual, SHARE)
        }),
    );
}

#[test]
fn hall_of_mirrors() {
    let (eye, target) = (DVec3::new(-2.2, -1.3, 1.25), DVec3::new(0.6, 0.35, 0.55));
    let camera = Camera::look_at(eye, target, classic::UP, 70.0).expect("a view");
    let settings = Settings {
        max_depth: 12,
        samples: 4,
        ..settings(160, 120)
    };
    let actual = picture(&shipped_scene("hall_of_mirrors"), &camera, &settings);
    assert_all([compare_golden("hall_of_mirrors", &actual, SHARE)]);
}

#[test]
fn soft_light() {
    let scene = shipped_scene("soft");
    let settings = Settings {
        samples: 16,
        ..settings(160, 120)
    };
    let actual = picture(&scene, &scene.cameras()[0].camera, &settings);
    assert_all([compare_golden("soft", &actual, SHARE)]);
}

#[cfg(feature = "textures")]
#[test]
fn textures() {
    let scene = shipped_scene("garden");
    let settings = Settings {
        samples: 4,
        ..settings(192, 144)
    };
    let actual = picture(&scene, &scene.cameras()[0].camera, &settings);
    assert_all([compare_golden("garden", &actual, SHARE)]);
}

#[test]
fn glass() {
    let scene = shipped_scene("glass");
    let settings = Settings {
        samples: 4,
        max_depth: 9,
        ..settings(192, 144)
    };
    let actual = picture(&scene, &scene.cameras()[0].camera, &settings);
    assert_all([compare_golden("glass", &actual, SHARE)]);
}

#[cfg(feature = "textures")]
#[test]
fn environment() {
    let scene = shipped_scene("sky");
    let settings = Settings {
        samples: 16,
        ..settings(192, 108)
    };
    let actual = picture(&scene, &scene.cameras()[0].camera, &settings);
    assert_all([compare_golden("sky", &actual, SHARE)]);
}

#[test]
fn instances() {
    let scene = shipped_scene("forest");
    let settings = Settings {
        samples: 16,
        ..settings(192, 120)
    };
    let actual = picture(&scene, &scene.cameras()[0].camera, &settings);
    assert_all([compare_golden("forest", &actual, SHARE)]);
}

#[test]
fn depth_of_field_on_a_checkerboard() {
    let scene = shipped_scene("focus");
    let settings = Settings {
        samples: 64,
        pattern: Pattern::Sobol,
        ..settings(192, 144)
    };
    let actual = picture(&scene, &scene.cameras()[0].camera, &settings);
    assert_all([compare_golden("focus", &actual, SHARE)]);
}

#[test]
fn evening_from_its_cameras() {
    let scene = shipped_scene("evening");
    assert_all(
        [("evening-front", 0), ("evening-across", 1)].map(|(name, camera)| {
            let camera = scene.cameras()[camera].camera;
            compare_golden(name, &picture(&scene, &camera, &settings(192, 120)), SHARE)
        }),
    );
}

#[test]
fn generated_scenes() {
    assert_all(Kind::ALL.map(|kind| {
        let count = Some(match kind {
            Kind::Interior => 40_000,
            _ => 10_000,
        });
        let generated = generate(kind, Options { seed: 1, count }).expect("a count within its limits");
        let camera = generated.view.camera().expect("a view");
        let scene = generated.into_scene().expect("a scene");
        // Primitives are about a pixel large; four samples make their edges depend less on rounding.
        let settings = Settings {
            samples: 4,
            ..settings(160, 120)
        };
        let actual = picture(&scene, &camera, &settings);
        compare_golden(&format!("generated-{}", kind.name()), &actual, SHARE)
    }));
}
