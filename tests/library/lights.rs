//! Falloff, rectangles and directional lights against closed forms.

use super::soft_light::{brightness, ground};
use glam::{DVec3, Vec3};
use octray::{
    error::SceneError,
    scene::{Background, Environment, EnvironmentPicture, Light, LightShape, Material, SceneBuilder, Spot},
};
use std::f64::consts::PI;

/// The ground under a light.
pub fn lit(light: Light, scale: f32) -> SceneBuilder {
    let mut builder = ground(scale);
    builder.add(light).expect("a light");
    builder
}

#[track_caller]
pub fn assert_close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() < tolerance,
        "{what}: {found}, {expected}"
    );
}

#[test]
fn falloff_is_by_the_square_of_the_distance() {
    for scale in [1.0, 1e-3, 1e4] {
        for height in [1.0_f32, 2.0, 5.0] {
            let position = Vec3::Z * (height * scale);
            let light = Light {
                intensity: 0.6,
                falloff: Some(0.5 * scale),
                ..Light::new(LightShape::Point { position })
            };
            let found = brightness(&lit(light, scale).finish(), DVec3::ZERO, scale, 1);
            let expected = 0.6 * f64::from(0.5 / height).powi(2);
            assert_close(found, expected, 1e-5, &format!("{scale} {height}"));
        }
    }
}

/// In a sphere, light comes from half of all directions and as brightly as at the surface, at its centre, too.
#[test]
fn falloff_is_bounded_inside_a_sphere() {
    for scale in [1.0, 1e-3, 1e4] {
        let light = Light {
            intensity: 0.3,
            falloff: Some(0.5 * scale),
            ..Light::new(LightShape::Sphere {
                center: Vec3::ZERO,
                radius: 0.4 * scale,
            })
        };
        let scene = lit(light, scale).finish();
        for x in [0.0, 0.05, 0.3] {
            let found = brightness(&scene, DVec3::X * (x * f64::from(scale)), scale, 1024);
            let expected = 0.3 * (0.5_f64 / 0.4).powi(2) * 0.25;
            assert_close(found, expected, 4e-3, &format!("{scale} {x}"));
        }
    }
}

#[test]
fn directional_lights_have_parallel_rays() {
    let to_light = DVec3::new(3.0, 0.0, 4.0);
    for scale in [1.0, 1e-3, 1e4] {
        let shape = LightShape::directional(to_light, 0.0).expect("a direction");
        let mut builder = lit(Light::new(shape), scale);
        let black = builder
            .add_material(Material::Silhouette { color: [0.0; 3] })
            .unwrap();
        // Its shadow is around (-1.5, 0).
        builder
            .add_sphere(Vec3::Z * (2.0 * scale), 0.3 * scale, black)
            .unwrap();
        let scene = builder.finish();
        let at = |x: f64| brightness(&scene, DVec3::X * (x * f64::from(scale)), scale, 1);
        for (x, expected) in [(-1.5, 0.0), (-1.2, 0.0), (-1.0, 0.8), (-2.0, 0.8), (50.0, 0.8)] {
            assert_close(at(x), expected, 1e-6, &format!("{scale} {x}"));
        }
    }
}

/// A sun has half shadows as wide as its angle, and the mean cosine of a sphere that looks as large.
#[test]
fn suns_fill_an_angle() {
    let shape = LightShape::directional(DVec3::Z, 60.0).expect("a direction");
    let mut builder = lit(Light::new(shape), 1.0);
    let bare = brightness(&builder.finish(), DVec3::ZERO, 1.0, 1024);
    assert_close(bare, 0.5 + 0.5 * f64::to_radians(30.0).cos(), 2e-3, "bare");
    builder = lit(Light::new(shape), 1.0);
    let black = builder
        .add_material(Material::Silhouette { color: [0.0; 3] })
        .unwrap();
    let roof = [
        Vec3::new(0.0, -50.0, 1.0),
        Vec3::new(0.0, 50.0, 1.0),
        Vec3::new(-50.0, 0.0, 1.0),
    ];
    builder.add_triangle(roof, black).unwrap();
    let scene = builder.finish();
    let half = brightness(&scene, DVec3::ZERO, 1.0, 1024);
    assert_close(half, 0.5 * bare, 4e-3, "half");
    let tangent = f64::to_radians(30.0).tan();
    assert_close(
        brightness(&scene, DVec3::X * (tangent * 1.02), 1.0, 64),
        bare,
        1e-2,
        "lit",
    );
    assert_close(
        brightness(&scene, DVec3::X * (-tangent * 1.02), 1.0, 64),
        0.0,
        1e-6,
        "dark",
    );
}

/// With falloff, a rectangle is a Lambertian emitter: its form factor is known (Howell, *A Catalog of Radiation Heat
/// Transfer Configuration Factors*, B-3).
#[test]
fn rectangles_light_by_their_form_factor() {
    for scale in [1.0, 1e-3, 1e4] {
        for (width, depth, height) in [(1.0_f32, 1.0_f32, 1.0_f32), (3.0, 0.5, 0.7)] {
            let light = Light {
                intensity: 0.4,
                falloff: Some(0.8 * scale),
                ..Light::new(LightShape::Rectangle {
                    center: Vec3::Z * (height * scale),
                    edges: [Vec3::Y * (depth * scale), Vec3::X * (width * scale)],
                })
            };
            let found = brightness(&lit(light, scale).finish(), DVec3::ZERO, scale, 4096);
            // Below the common corner of four rectangles of half the size.
            let [a, b] = [width, depth].map(|side| f64::from(side / (2.0 * height)));
            let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
            let form_factor = 4.0 * (part(a, b) + part(b, a)) / (2.0 * PI);
            let expected = 0.4 * 0.8 * 0.8 / f64::from(width * depth) * PI * form_factor;
            assert_close(found, expected, 2e-3, &format!("{scale} {width} {height}"));
        }
    }
    // Behind it is no light.
    let light = Light::new(LightShape::Rectangle {
        center: Vec3::Z,
        edges: [Vec3::X, Vec3::Y],
    });
    assert_eq!(brightness(&lit(light, 1.0).finish(), DVec3::ZERO, 1.0, 16), 0.0);
}

/// Beside a panel, few of its points light a surface, and these by more than 1: only the mean counts.
#[test]
fn points_beside_a_panel_are_as_bright_as_their_form_factor() {
    let (side, height) = (2.0_f32, 0.1_f32);
    let light = Light {
        intensity: 0.5,
        falloff: Some(1.0),
        ..Light::new(LightShape::Rectangle {
            center: Vec3::Z * (height + side / 2.0) + Vec3::X * 0.1,
            edges: [Vec3::Y * side, Vec3::NEG_Z * side],
        })
    };
    let found = brightness(&lit(light, 1.0).finish(), DVec3::ZERO, 1.0, 1 << 12);
    // The mean over the panel, of cosine x cosine / distance^2.
    let n = 2000;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let [y, z] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(n) * f64::from(side));
            let to_light = DVec3::new(-0.1, y - 1.0, z + f64::from(height));
            sum += to_light.z * 0.1 / to_light.length_squared().powi(2);
        }
    }
    let expected = 0.5 * sum / f64::from(n * n);
    assert_close(found, expected, 0.02 * expected, "beside a panel");
    assert!(expected < 0.9);
}

/// A panel in the ceiling, exactly in its plane.
#[test]
fn rectangles_may_lie_in_a_surface() {
    for (scale, height) in [(1.0, 2.5_f32), (1.0, 0.7), (1e-3, 2.5), (1e4, 1.3)] {
        let light = Light::new(LightShape::Rectangle {
            center: Vec3::Z * (height * scale),
            edges: [Vec3::Y * scale, Vec3::X * scale],
        });
        let bare = brightness(&lit(light, scale).finish(), DVec3::ZERO, scale, 256);
        let mut builder = lit(light, scale);
        let black = builder
            .add_material(Material::Silhouette { color: [0.0; 3] })
            .expect("a material");
        let corner = |x: f32, y: f32| Vec3::new(x, y, height) * scale;
        builder
            .add_triangle([corner(-9.0, -9.0), corner(9.0, -9.0), corner(0.0, 20.0)], black)
            .expect("a ceiling");
        let found = brightness(&builder.finish(), DVec3::ZERO, scale, 256);
        assert_close(found, bare, 1e-6, &format!("{scale} {height}"));
    }
}

/// However near a light is, nothing becomes infinite or dark.
#[test]
fn points_at_a_light_are_lit() {
    for height in [0.0, 1e-30, 1e-12, 1e-3] {
        let position = Vec3::Z * height;
        let light = Light {
            color: [1.0, 0.0, 1.0],
            falloff: Some(1.0),
            ..Light::new(LightShape::Point { position })
        };
        let found = brightness(&lit(light, 1.0).finish(), DVec3::ZERO, 1.0, 16);
        assert!(
            found.is_finite() && (height < 1e-9 || found > 0.9),
            "{height}: {found}"
        );
    }
}

#[test]
fn unusable_lights_are_refused() {
    let error = |light: Light| SceneBuilder::new().add(light).expect_err("unusable");
    let point = Light::new(LightShape::Point { position: Vec3::Z });
    let rectangle = |edges| {
        Light::new(LightShape::Rectangle {
            center: Vec3::Z,
            edges,
        })
    };
    let light = |falloff, intensity| Light {
        falloff,
        intensity,
        ..point
    };
    assert_eq!(
        error(light(Some(0.0), 1.0)).to_string(),
        "falloff is 0, expected a number above 0"
    );
    assert_eq!(
        error(light(None, -1.0)).to_string(),
        "intensity is -1, expected 0 or more"
    );
    assert!(matches!(
        error(light(None, f32::NAN)),
        SceneError::NotUsable { .. }
    ));
    let flat = error(rectangle([Vec3::X, Vec3::X * 2.0]));
    assert_eq!(flat.to_string(), "area is 0, expected a number above 0");
    for (inner, outer) in [(30.0, 20.0), (-1.0, 3.0), (f32::NAN, 3.0)] {
        let spot = Spot::new(DVec3::X, inner, outer);
        assert!(
            matches!(spot, Err(SceneError::InnerAngle { .. })),
            "{inner} {outer}"
        );
    }
    for (inner, outer) in [(0.0, 181.0), (1.0, f32::NAN)] {
        let spot = Spot::new(DVec3::X, inner, outer);
        assert!(
            matches!(spot, Err(SceneError::OutOfRange { .. })),
            "{inner} {outer}"
        );
    }
    assert!(Spot::new(DVec3::ZERO, 1.0, 2.0).is_err());
    assert!(LightShape::directional(DVec3::ZERO, 0.0).is_err());
    assert!(LightShape::directional(DVec3::X, 181.0).is_err());
}

fn in_environment(environment: Environment, scale: f32) -> SceneBuilder {
    let mut builder = ground(scale);
    builder.set_environment(environment).expect("an environment");
    builder
}

fn picture(size: [u32; 2], texels: Vec<[f32; 3]>) -> Environment {
    Environment::Picture(EnvironmentPicture::new(size, texels, 0.0, 1.0).expect("a picture"))
}

fn gradient(bottom: f32, top: f32) -> Environment {
    Environment::Background(Background {
        bottom: [bottom; 3],
        top: [top; 3],
    })
}

/// The white furnace: whatever its direction, a white matte surface is as bright as an even environment, and the share that
/// a sphere above it hides is known.
#[test]
fn even_environments_light_evenly() {
    for scale in [1.0, 1e-3, 1e4] {
        for even in [|| gradient(0.5, 0.5), || picture([7, 5], vec![[0.5; 3]; 35])] {
            let bare = brightness(&in_environment(even(), scale).finish(), DVec3::ZERO, scale, 1024);
            assert_close(bare, 0.5, 2e-3, &format!("bare {scale}"));
            let mut builder = in_environment(even(), scale);
            let black = builder
                .add_material(Material::Silhouette { color: [0.0; 3] })
                .expect("a material");
            builder
                .add_sphere(Vec3::Z * (0.8 * scale), 0.45 * scale, black)
                .expect("a sphere");
            let found = brightness(&builder.finish(), DVec3::ZERO, scale, 1024);
            assert_close(
                found,
                0.5 * (1.0 - f64::from(0.45_f32 / 0.8).powi(2)),
                3e-3,
                &format!("{scale}"),
            );
        }
    }
}

#[test]
fn gradients_light_by_their_colours() {
    let found = brightness(
        &in_environment(gradient(0.0, 1.0), 1.0).finish(),
        DVec3::ZERO,
        1.0,
        1024,
    );
    assert_close(found, 5.0 / 6.0, 3e-3, "top");
    let found = brightness(
        &in_environment(gradient(1.0, 0.0), 1.0).finish(),
        DVec3::ZERO,
        1.0,
        1024,
    );
    assert_close(found, 1.0 / 6.0, 3e-3, "bottom");
}

/// The integral of a picture times the cosine over the upper half, by the midpoint rule.
fn irradiance_over_pi(environment: &Environment) -> f64 {
    let (rows, columns) = (1000, 2000);
    let mut sum = 0.0;
    for i in 0..rows / 2 {
        let polar = (f64::from(i) + 0.5) / f64::from(rows) * PI;
        for j in 0..columns {
            let azimuth = (f64::from(j) + 0.5) / f64::from(columns) * 2.0 * PI;
            let (sine, cosine) = polar.sin_cos();
            let direction = DVec3::new(sine * azimuth.cos(), sine * azimuth.sin(), cosine);
            sum += f64::from(environment.color(direction.as_vec3())[0]) * sine * cosine;
        }
    }
    sum * PI / f64::from(rows) * 2.0 * PI / f64::from(columns) / PI
}

/// Pictures with a sun and with noise: the mean is right, and importance sampling finds a sun at once.
#[test]
fn pictures_light_as_their_integral() {
    let mut random = fastrand::Rng::with_seed(7);
    let mut sun = vec![[0.01; 3]; 64 * 32];
    sun[9 * 64 + 20] = [900.0; 3];
    let noise: Vec<[f32; 3]> = (0..64 * 32).map(|_| [random.f32().powi(4); 3]).collect();
    for (name, texels) in [("sun", sun), ("noise", noise)] {
        let expected = irradiance_over_pi(&picture([64, 32], texels.clone()));
        let scene = in_environment(picture([64, 32], texels), 1.0).finish();
        let found = brightness(&scene, DVec3::ZERO, 1.0, 4096);
        assert_close(found / expected, 1.0, 1e-2, name);
        // 16 pixels of 64 samples.
        let few = brightness(&scene, DVec3::ZERO, 1.0, 64);
        assert_close(few / expected, 1.0, 5e-2, name);
    }
}

/// A sun of half a degree, 10,000 times as bright as the sky: every sample takes a ray to it, so that few are right, in its
/// light and in its shadow.
#[test]
fn suns_are_smooth_with_few_samples() {
    let (width, height) = (1024, 512);
    let mut texels = vec![[0.3; 3]; width * height];
    for i in [
        150 * width + 300,
        150 * width + 301,
        151 * width + 300,
        151 * width + 301,
    ] {
        texels[i] = [3000.0; 3];
    }
    let size = [width as u32, height as u32];
    let polar = 151.0 / height as f64 * PI;
    let azimuth = (0.5 - 301.0 / width as f64) * 2.0 * PI;
    let to_sun = DVec3::new(
        polar.sin() * azimuth.cos(),
        polar.sin() * azimuth.sin(),
        polar.cos(),
    );
    // The light of four texels arrives at 0.
    let solid_angle = 4.0 * (PI / height as f64).powi(2) * polar.sin();
    let expected = 0.3 + 2999.7 * solid_angle * polar.cos() / PI;
    let scene = in_environment(picture(size, texels.clone()), 1.0).finish();
    let lit = brightness(&scene, DVec3::ZERO, 1.0, 4);
    assert_close(lit / expected, 1.0, 3e-2, "lit");
    let mut builder = in_environment(picture(size, texels), 1.0);
    let black = builder
        .add_material(Material::Silhouette { color: [0.0; 3] })
        .expect("a material");
    builder
        .add_sphere(to_sun.as_vec3() * 4.0, 0.2, black)
        .expect("a sphere");
    let shadow = brightness(&builder.finish(), DVec3::ZERO, 1.0, 4);
    assert_close(shadow, 0.3, 2e-2, "shadow");
}

/// The middle of a picture is at +x, its right half at -y, its upper edge at +z; a turn is counterclockwise.
#[test]
fn pictures_are_seen_the_right_way_round() {
    let texels: Vec<[f32; 3]> = (0..32).map(|i| [(i % 8) as f32, (i / 8) as f32, 0.0]).collect();
    let seen = |degrees, direction: Vec3| {
        let picture = EnvironmentPicture::new([8, 4], texels.clone(), degrees, 2.0).expect("a picture");
        Environment::Picture(picture).color(direction).map(|c| c / 2.0)
    };
    for degrees in [0.0, 90.0, 360.0, -270.0] {
        let turn = glam::Mat3::from_rotation_z((degrees as f32).to_radians());
        for (direction, expected) in [
            (Vec3::X, [3.5, 1.5]),
            (Vec3::NEG_Y, [5.5, 1.5]),
            (Vec3::Y, [1.5, 1.5]),
            // The middle of the first column.
            (Vec3::new(-0.923_88, 0.382_68, 0.0), [0.0, 1.5]),
        ] {
            let [column, row, _] = seen(degrees, turn * direction.normalize());
            assert_close(column.into(), expected[0], 0.1, &format!("{degrees} {direction}"));
            assert_close(row.into(), expected[1], 1e-3, &format!("{degrees} {direction}"));
        }
        assert_close(seen(degrees, Vec3::Z)[1].into(), 0.0, 1e-3, "up");
        assert_close(seen(degrees, Vec3::NEG_Z)[1].into(), 3.0, 1e-3, "down");
    }
}

/// A turned picture is seen and lights from where its axes are.
#[test]
fn turned_pictures_light_from_their_axes() {
    let upper: Vec<[f32; 3]> = (0..64).map(|i| [if i < 32 { 1.0 } else { 0.0 }; 3]).collect();
    let half = |middle, up| {
        let picture = EnvironmentPicture::new([4, 16], upper.clone(), 0.0, 1.0).expect("a picture");
        Environment::Picture(picture.turned(middle, up))
    };
    let light = |environment| brightness(&in_environment(environment, 1.0).finish(), DVec3::ZERO, 1.0, 1024);
    let (above, below) = (light(half(Vec3::X, Vec3::Z)), light(half(Vec3::X, Vec3::NEG_Z)));
    assert!(above > 0.97, "{above}");
    assert_close(above + below, 1.0, 4e-3, "both halves");
    assert_close(light(half(Vec3::Z, Vec3::NEG_Y)), 0.5, 4e-3, "one side");
    // The middle is at -z, its right half at +x, its upper edge at +y.
    let texels: Vec<[f32; 3]> = (0..32).map(|i| [(i % 8) as f32, (i / 8) as f32, 0.0]).collect();
    let picture = EnvironmentPicture::new([8, 4], texels, 0.0, 1.0).expect("a picture");
    let turned = Environment::Picture(picture.turned(Vec3::NEG_Z, Vec3::Y * 3.0));
    for (direction, column, row) in [
        (Vec3::NEG_Z, 3.5, 1.5),
        (Vec3::X, 5.5, 1.5),
        (Vec3::NEG_X, 1.5, 1.5),
    ] {
        let [x, y, _] = turned.color(direction);
        assert_close(x.into(), column, 0.1, &format!("{direction}"));
        assert_close(y.into(), row, 1e-3, &format!("{direction}"));
    }
    assert_close(turned.color(Vec3::Y)[1].into(), 0.0, 1e-3, "up");
    // A sun, which has samples of its own.
    let sun = |degrees, middle| {
        let mut texels = vec![[0.1; 3]; 16 * 8];
        texels[2 * 16 + 9] = [300.0; 3];
        let picture = EnvironmentPicture::new([16, 8], texels, degrees, 1.0).expect("a picture");
        light(Environment::Picture(picture.turned(middle, Vec3::Z)))
    };
    let even = EnvironmentPicture::new([4, 2], vec![[30.0; 3]; 8], 0.0, 1.0).expect("a picture");
    let mean = light(Environment::Picture(even.with_mean(0.25)));
    assert_close(mean, 0.25, 2e-3, "a mean");
    let (rotated, turned) = (sun(90.0, Vec3::X), sun(0.0, Vec3::Y));
    assert!(turned > 1.0, "{turned}");
    assert_close(turned / rotated, 1.0, 4e-3, "a sun");
}

/// Odd pictures: one pixel, black, with values that are no light.
#[test]
fn odd_pictures() {
    let found = |environment| brightness(&in_environment(environment, 1.0).finish(), DVec3::ZERO, 1.0, 256);
    assert_close(found(picture([1, 1], vec![[0.25; 3]])), 0.25, 3e-3, "one pixel");
    assert_eq!(found(picture([2, 2], vec![[0.0; 3]; 4])), 0.0);
    // Suns alone: so dark that shares of their light vanish, and in the last row.
    let lone = |light: f32, at: usize| {
        let mut texels = vec![[0.0; 3]; 16 * 8];
        texels[at] = [light; 3];
        found(picture([16, 8], texels))
    };
    assert_close(lone(1e-42, 40), 0.0, 1e-30, "dark");
    assert_close(lone(1.0, 40), lone(1e6, 40) / 1e6, 1e-6, "bright");
    assert_eq!(lone(1.0, 127), 0.0);
    let odd = [f32::NAN, -1.0, f32::NEG_INFINITY, 0.5].map(|c| [c; 3]);
    let found = found(picture([4, 1], odd.to_vec()));
    assert!(found > 0.05 && found < 0.3, "{found}");
    let infinite = picture([1, 1], vec![[f32::INFINITY; 3]]);
    assert_eq!(infinite.color(Vec3::Z), [65504.0; 3]);
    for (degrees, intensity) in [
        (f64::NAN, 1.0),
        (f64::INFINITY, 1.0),
        (0.0, -1.0),
        (0.0, f32::NAN),
    ] {
        assert!(EnvironmentPicture::new([1, 1], vec![[0.0; 3]], degrees, intensity).is_err());
    }
    assert!(EnvironmentPicture::new([0, 1], Vec::new(), 0.0, 1.0).is_err());
    assert!(EnvironmentPicture::new([2, 1], vec![[0.0; 3]], 0.0, 1.0).is_err());
}
