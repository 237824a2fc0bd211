//! Orthographic cameras and lenses against closed forms, and in all modes.
//!
//! `OCTRAY_LONG=1` makes larger pictures.

use crate::{
    long::rounds,
    sameness::{SHIPPED, Sameness, glass_scene, sized, sizes},
    shipped_scene,
};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Aovs, Film, Pattern, Renderer, Settings, render},
    scene::{Background, Camera, Lens, Material, Projection, Scene, SceneBuilder, View},
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
        lens: Lens::PINHOLE,
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

/// A camera with a lens of this diameter, of a view 4 high at the target.
fn with_lens(aperture: f64, focus: Option<f64>, is_orthographic: bool) -> Camera {
    let projection = if is_orthographic {
        Projection::Orthographic { height: 4.0 }
    } else {
        Projection::Perspective {
            fov_degrees: 2.0 * 0.2_f64.atan().to_degrees(),
        }
    };
    Camera::new(&View {
        projection,
        lens: Lens { aperture, focus },
        ..along_y()
    })
    .unwrap()
}

/// A point becomes a disc as wide as the lens is seen from it, in the plane in focus, and keeps its light.
#[test]
fn points_out_of_focus_become_discs() {
    for is_orthographic in [false, true] {
        for (y, focus) in [(0.0, 8.0), (0.0, 14.0), (2.0, 10.0), (-3.0, 10.0)] {
            let distance = 10.0 + y;
            let scene = spheres(&[(Vec3::new(0.0, y as f32, 0.0), 0.03)]);
            let settings = Settings {
                pattern: Pattern::Sobol,
                ..settings(96, 256)
            };
            let film = picture(&scene, &with_lens(1.0, Some(focus), is_orthographic), &settings);
            // Where the cone of rays through the point meets the plane in focus; the height of the view there.
            let diameter = (focus - distance).abs() / distance;
            let height = if is_orthographic { 4.0 } else { 0.4 * focus };
            let sharp = if is_orthographic {
                0.03
            } else {
                0.03 * focus / distance
            };
            let pixel = height / 96.0;
            let mut light = 0.0;
            for (i, value) in film.pixels().iter().enumerate() {
                let [x, y] = [i % 96, i / 96].map(|i| (i as f64 - 47.5) * pixel);
                let from_middle = x.hypot(y);
                light += f64::from(value[0]);
                assert!(
                    value[0] == 0.0 || from_middle < 0.5 * diameter + 1.1 * sharp + pixel,
                    "{is_orthographic} {y} {focus}: {from_middle}"
                );
            }
            let expected = std::f64::consts::PI * (sharp / pixel).powi(2);
            assert!(
                (light / expected - 1.0).abs() < 0.06,
                "{is_orthographic} {y} {focus}: {light} {expected}"
            );
        }
    }
}

#[test]
fn the_target_is_sharp() {
    let scene = spheres(&[(Vec3::new(0.3, 0.0, 0.2), 0.001), (Vec3::ZERO, 0.5)]);
    for is_orthographic in [false, true] {
        let [sharp, lens] = [0.0, 0.2].map(|aperture| {
            picture(
                &scene,
                &with_lens(aperture, None, is_orthographic),
                &settings(64, 64),
            )
        });
        let difference = |(a, b): (&[f32; 3], &[f32; 3])| f64::from((a[0] - b[0]).abs());
        let sum: f64 = sharp.pixels().iter().zip(lens.pixels()).map(difference).sum();
        assert!(sum < 1.0, "{sum}");
        // All rays of the output variables pass through the middle of the lens.
        let [a, b] = [0.0, 0.2].map(|aperture| {
            aovs(
                &scene,
                &with_lens(aperture, None, is_orthographic),
                &settings(64, 1),
            )
        });
        assert_eq!(a, b);
    }
}

/// Where one sample sees nothing, others may: all pixels take four, and those of a blurred sphere take all.
#[test]
fn adaptive_pictures_find_what_is_blurred() {
    let scene = spheres(&[(Vec3::new(0.0, -8.0, 0.0), 0.1)]);
    let bvh = Bvh::build(&scene);
    let adaptive = Settings {
        adaptive: true,
        pattern: Pattern::Sobol,
        ..settings(64, 64)
    };
    let camera = with_lens(0.8, None, false);
    let mut film = <Film>::new(1, 1);
    let stats =
        Renderer::new(&scene, &bvh).render(&camera, &adaptive, &mut film, &|_| ControlFlow::Continue(()));
    let rays = stats.expect("a picture").rays.camera;
    assert!(rays > 8 * 64 * 64, "{rays}");
    let full = Settings {
        adaptive: false,
        ..adaptive
    };
    let full = picture(&scene, &camera, &full);
    let far = |(a, b): &(&[f32; 3], &[f32; 3])| (a[0] - b[0]).abs() > 0.1;
    let count = film.pixels().iter().zip(full.pixels()).filter(far).count();
    assert!(count < 64, "{count}");
}

/// The camera of a classic viewpoint with parallel rays.
fn parallel(view: u32, height: f64) -> Camera {
    let view = View {
        projection: Projection::Orthographic { height },
        ..View::classic(view).expect("views are 1 to 6")
    };
    Camera::new(&view).expect("a view")
}

#[test]
fn orthographic_cameras() {
    let mut scenes = Vec::from(SHIPPED.map(|name| (name, shipped_scene(name))));
    scenes.push(("soft", shipped_scene("soft")));
    scenes.push(("glass", glass_scene()));
    for (i, (name, scene)) in scenes.iter().enumerate() {
        let (camera, sameness) = (parallel(i as u32 % 6 + 1, 2.0), Sameness::of(name, scene));
        for (width, height, samples) in sizes() {
            // What is shaded is tested by `sameness`: here a band and a half of rays are enough.
            sameness.check(&camera, &sized(width.min(1023), height.min(27), samples));
        }
        for adaptive in [false, true] {
            let [width, height] = rounds([29, 15], [75, 27]);
            let settings = Settings {
                adaptive,
                pattern: Pattern::Sobol,
                ..sized(width, height, 9)
            };
            sameness.check(&camera, &settings);
        }
    }
}

#[test]
fn cameras_with_lenses() {
    let mut scenes =
        Vec::from(["evening", "garden", "soft", "forest"].map(|name| (name, shipped_scene(name))));
    scenes.push(("glass", glass_scene()));
    for (i, (name, scene)) in scenes.iter().enumerate() {
        let sameness = Sameness::of(name, scene);
        for parallel in [
            parallel(2, 2.0),
            Camera::classic_view(i as u32 + 1).expect("a view"),
        ] {
            let lens = Lens {
                aperture: 0.2,
                focus: Some(1.5),
            };
            let camera = Camera::new(&View {
                lens,
                ..parallel.view()
            })
            .expect("a view");
            for (pattern, samples, adaptive) in [
                (Pattern::Grid, 4, false),
                (Pattern::Stratified, 4, false),
                (Pattern::Sobol, 9, false),
                (Pattern::Sobol, 16, true),
            ] {
                let settings = Settings {
                    pattern,
                    adaptive,
                    ..sized(rounds(21, 61), rounds(13, 19), samples)
                };
                sameness.check(&camera, &settings);
            }
        }
    }
}
