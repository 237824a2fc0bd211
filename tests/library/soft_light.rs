//! Spherical lights and ambient occlusion against closed forms.

use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Film, Pattern, Settings, render},
    scene::{Background, Camera, Material, Scene, SceneBuilder},
};
use std::ops::ControlFlow;

/// A white ground at z = 0 and nothing else, without light, `scale` times as large as it is said.
pub fn ground(scale: f32) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    builder.set_ambient(0.0).unwrap();
    builder.set_background(Background::constant([0.0; 3])).unwrap();
    let white = builder.add_material(Material::Matte { color: [1.0; 3] }).unwrap();
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0) * (100.0 * scale);
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    builder.add_triangle([a, b, c], white).unwrap();
    builder.add_triangle([a, c, d], white).unwrap();
    builder
}

/// The mean of a picture of 4x4 pixels, `samples` each, of the ground around a point.
pub fn brightness(scene: &Scene, at: DVec3, scale: f32, samples: u32) -> f64 {
    let bvh = Bvh::build(scene);
    // From the side, below what is above.
    let eye = at + DVec3::new(0.9, 0.2, 0.05) * f64::from(scale);
    let camera = Camera::look_at(eye, at, DVec3::Z, 0.01).unwrap();
    let settings = Settings {
        width: 4,
        height: 4,
        samples,
        pattern: Pattern::Sobol,
        ..Settings::default()
    };
    let film: Film = render(scene, &bvh, &camera, &settings, &|_| ControlFlow::Continue(()))
        .unwrap()
        .film;
    film.pixels()
        .iter()
        .map(|[red, _, _]| f64::from(*red))
        .sum::<f64>()
        / 16.0
}

/// Below a sphere, the blocked share is the squared sine of the angle under which its radius is seen, whatever the scale.
#[test]
fn a_sphere_blocks_the_ambient_light_below_it() {
    for scale in [1.0, 1e-3, 1e4] {
        for height in [0.5_f32, 0.8, 2.0] {
            let mut builder = ground(scale);
            builder.set_ambient(1.0).unwrap();
            builder.set_ambient_reach(Some(50.0 * scale)).unwrap();
            let red = builder
                .add_material(Material::Silhouette {
                    color: [1.0, 0.0, 0.0],
                })
                .unwrap();
            builder
                .add_sphere(Vec3::Z * (height * scale), 0.45 * scale, red)
                .unwrap();
            let found = brightness(&builder.finish(), DVec3::ZERO, scale, 1024);
            let expected = 1.0 - f64::from(0.45 / height).powi(2);
            assert!(
                (found - expected).abs() < 4e-3,
                "{scale} {height}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn what_is_out_of_reach_blocks_nothing() {
    let mut builder = ground(1.0);
    builder.set_ambient(1.0).unwrap();
    builder.set_ambient_reach(Some(0.3)).unwrap();
    let red = builder
        .add_material(Material::Silhouette {
            color: [1.0, 0.0, 0.0],
        })
        .unwrap();
    builder.add_sphere(Vec3::Z * 0.8, 0.45, red).unwrap();
    let found = brightness(&builder.finish(), DVec3::ZERO, 1.0, 64);
    assert!((found - 1.0).abs() < 1e-6, "{found}");
}

/// All of the sphere is seen: the mean cosine is that to its centre, times half of one plus the half angle's cosine.
#[test]
fn a_spherical_light_lights_like_its_solid_angle() {
    for scale in [1.0, 1e-3, 1e4] {
        for (to_light, radius) in [(Vec3::Z * 2.0, 1.5), (Vec3::new(3.0, 0.0, 4.0), 2.0)] {
            let mut builder = ground(scale);
            builder
                .add_sphere_light(to_light * scale, radius * scale, 0.8, [1.0; 3])
                .unwrap();
            let found = brightness(&builder.finish(), DVec3::ZERO, scale, 1024);
            let sine = radius / to_light.length();
            let expected = 0.8 * to_light.normalize().z * (0.5 + 0.5 * (1.0 - sine * sine).sqrt());
            assert!(
                (found - f64::from(expected)).abs() < 2e-3,
                "{scale} {to_light}: {found}, {expected}"
            );
        }
    }
}

/// An edge through a point's view of the light's centre hides half of it.
#[test]
fn half_a_light_is_half_the_light() {
    let mut builder = ground(1.0);
    builder
        .add_sphere_light(Vec3::Z * 4.0, 0.5, 1.0, [1.0; 3])
        .unwrap();
    let black = builder
        .add_material(Material::Silhouette { color: [0.0; 3] })
        .unwrap();
    let roof = [
        Vec3::new(0.0, -5.0, 2.0),
        Vec3::new(0.0, 5.0, 2.0),
        Vec3::new(-5.0, 0.0, 2.0),
    ];
    builder.add_triangle(roof, black).unwrap();
    let scene = builder.finish();
    let bare = {
        let mut builder = ground(1.0);
        builder
            .add_sphere_light(Vec3::Z * 4.0, 0.5, 1.0, [1.0; 3])
            .unwrap();
        brightness(&builder.finish(), DVec3::ZERO, 1.0, 1024)
    };
    let half = brightness(&scene, DVec3::ZERO, 1.0, 1024);
    assert!((half - 0.5 * bare).abs() < 4e-3, "{half} of {bare}");
    // The penumbra's width follows from the light's size and the distances: 1 at this height.
    for (x, share) in [(-0.6, 0.0), (0.6, 1.0)] {
        let found = brightness(&scene, DVec3::new(x, 0.0, 0.0), 1.0, 64);
        assert!(
            if share == 0.0 { found == 0.0 } else { found > 0.95 },
            "{x}: {found}"
        );
    }
}

/// The error falls with the number of samples, faster than that of random points would.
#[test]
fn more_samples_are_closer() {
    let mut builder = ground(1.0);
    builder.set_ambient(1.0).unwrap();
    builder.set_ambient_reach(Some(50.0)).unwrap();
    let red = builder
        .add_material(Material::Silhouette {
            color: [1.0, 0.0, 0.0],
        })
        .unwrap();
    builder.add_sphere(Vec3::Z, 0.7, red).unwrap();
    let scene = builder.finish();
    let error = |samples| (brightness(&scene, DVec3::ZERO, 1.0, samples) - (1.0 - 0.49)).abs();
    // Independent samples would have deviations of 0.125 / 4 and 0.0078 / 4 in the mean of 16 pixels.
    assert!(
        error(16) < 0.05 && error(4096) < 1e-3,
        "{} {}",
        error(16),
        error(4096)
    );
}

/// A light around everything, or at a point itself, is no error and makes no dark spot.
#[test]
fn points_inside_a_light_are_lit() {
    for (center, radius) in [(Vec3::ZERO, 5.0), (Vec3::ZERO, 1e-20), (Vec3::Z * 0.1, 0.2)] {
        let mut builder = ground(1.0);
        builder.add_sphere_light(center, radius, 1.0, [1.0; 3]).unwrap();
        let found = brightness(&builder.finish(), DVec3::ZERO, 1.0, 16);
        assert!(
            found.is_finite() && (radius < 1e-9 || found > 0.2),
            "{center} {radius}: {found}"
        );
    }
}
