//! Numerical robustness at every scale and distance: surfaces do not shadow themselves (acne), light does not pass
//! through them (leaks), and mirrors that face each other sum correctly.

use glam::{DVec3, Vec3};
use image::RgbImage;
use octray::{
    accel::Bvh,
    render::{Mode, Settings, render},
    scene::{Background, Camera, Material, MaterialId, Scene, SceneBuilder, View},
};
use std::ops::ControlFlow;

/// The side of pictures, pixels.
pub const SIDE: u32 = 160;

pub fn picture_in(scene: &Scene, camera: &Camera, side: u32, mode: Mode, max_depth: u32) -> RgbImage {
    let settings = Settings {
        width: side,
        height: side,
        mode,
        max_depth,
        threads: Some(1),
        ..Settings::default()
    };
    let bvh = Bvh::build(scene);
    let frame = render(scene, &bvh, camera, &settings, &|_| ControlFlow::Continue(()));
    crate::images::to_image(&frame.expect("it renders").film)
}

pub fn picture(scene: &Scene, camera: &Camera) -> RgbImage {
    picture_in(scene, camera, SIDE, Mode::Packet, Settings::default().max_depth)
}

pub fn placed_view(view: &View, scale: f32, shift: Vec3) -> Camera {
    let place = |p: DVec3| p * f64::from(scale) + shift.as_dvec3();
    let (eye, target) = (place(view.eye), place(view.target));
    Camera::new(&View { eye, target, ..*view }).expect("a camera")
}

fn looking(eye: DVec3, target: DVec3, up: DVec3, fov: f64) -> View {
    Camera::look_at(eye, target, up, fov).expect("a view").view()
}

/// A square parallel to the plane z = 0, centred at `middle`.
fn square(builder: &mut SceneBuilder, middle: Vec3, half: f32, material: MaterialId) {
    quad(builder, middle, Vec3::X * half, Vec3::Y * half, material);
}

fn quad(builder: &mut SceneBuilder, middle: Vec3, u: Vec3, v: Vec3, material: MaterialId) {
    let [a, b, c, d] = [middle - u - v, middle + u - v, middle + u + v, middle - u + v];
    builder.add_triangle([a, b, c], material).unwrap();
    builder.add_triangle([a, c, d], material).unwrap();
}

/// Scales, and distances from the origin in units of the scene.
const PLACES: [(f32, f32); 6] = [
    (1.0, 0.0),
    (1e-4, 0.0),
    (0.3, 0.0),
    (1e5, 0.0),
    (1.0, 100.0),
    (1.0, 1e4),
];

fn byte(value: f64) -> u8 {
    (255.0 * value.clamp(0.0, 1.0)) as u8
}

/// The range of the red channel.
fn range(image: &RgbImage) -> (u8, u8) {
    let values = || image.pixels().map(|pixel| pixel[0]);
    (values().min().unwrap(), values().max().unwrap())
}

#[test]
fn grazing_light_makes_no_acne() {
    for (scale, far) in PLACES {
        let shift = Vec3::new(far, -0.7 * far, 0.4 * far);
        // The light moves down to just above the horizon.
        for height in [3.0, 0.3, 0.03, 0.003] {
            let mut builder = SceneBuilder::new();
            square(&mut builder, shift, 4.0 * scale, MaterialId(1));
            let light = Vec3::new(30.0, 10.0, height) * scale + shift;
            builder.add_light(light, 0.9).unwrap();
            let scene = builder.finish();
            // Across the floor, and almost along it.
            for eye in [DVec3::new(0.5, -0.3, 2.0), DVec3::new(0.0, 0.0, 0.02)] {
                let target = eye + DVec3::new(0.3, 0.1, -0.9 * eye.z);
                let view = looking(eye, target, DVec3::Z, 20.0);
                let image = picture(&scene, &placed_view(&view, scale, shift));
                let light = (light - shift).as_dvec3() / f64::from(scale);
                for (x, y, pixel) in image.enumerate_pixels() {
                    if *pixel == image::Rgb([255; 3]) {
                        continue;
                    }
                    // The range over the whole square.
                    let facing = |p: DVec3| (light - p).normalize().z;
                    let [a, b, c, d] = [(-4.0, -4.0), (4.0, -4.0), (-4.0, 4.0), (4.0, 4.0)]
                        .map(|(x, y)| 0.05 + 0.9 * facing(DVec3::new(x, y, 0.0)));
                    let least = byte(a.min(b).min(c).min(d)).saturating_sub(1);
                    let most = byte(a.max(b).max(c).max(d)).saturating_add(1);
                    assert!(
                        (least..=most).contains(&pixel[0]),
                        "scale {scale}, {far} away, light at {height}, eye at {eye}: ({x}, {y}) is {}, not {least} to {most}",
                        pixel[0]
                    );
                }
            }
        }
    }
}

#[test]
fn spheres_do_not_shadow_themselves() {
    for (scale, far) in PLACES {
        let shift = Vec3::new(far, -0.7 * far, 0.4 * far);
        let light = DVec3::new(3.0, -1.0, 2.0);
        let mut builder = SceneBuilder::new();
        builder.add_sphere(shift, scale, MaterialId(1)).unwrap();
        builder.add_light(light.as_vec3() * scale + shift, 0.8).unwrap();
        let scene = builder.finish();
        let eye = DVec3::new(2.0, -4.0, 0.5);
        let view = looking(eye, DVec3::ZERO, DVec3::Z, 20.0);
        let camera = placed_view(&view, scale, shift);
        let image = picture(&scene, &camera);
        let forward = -eye.normalize();
        let right = forward.cross(DVec3::Z).normalize();
        let up = right.cross(forward);
        let (mut compared, mut worst) = (0, 0);
        for (x, y, pixel) in image.enumerate_pixels() {
            let half = 10.0_f64.to_radians().tan();
            let across = |at: u32| ((f64::from(at) + 0.5) / f64::from(SIDE) * 2.0 - 1.0) * half;
            let direction = (forward + right * across(x) - up * across(y)).normalize();
            let along = -eye.dot(direction);
            let discriminant = 1.0 - (eye.length_squared() - along * along);
            // Rounding decides at the outline.
            if discriminant < 0.03 {
                continue;
            }
            let normal = eye + direction * (along - discriminant.sqrt());
            let expected = byte(0.05 + 0.8 * normal.dot((light - normal).normalize()).max(0.0));
            compared += 1;
            worst = worst.max(expected.abs_diff(pixel[0]));
        }
        assert!(
            compared > 5_000 && worst <= 2,
            "scale {scale}, {far} away: {worst}/255 off in {compared} pixels"
        );
    }
}

#[test]
fn no_light_leaks_in_or_out() {
    for (scale, far) in PLACES {
        let shift = Vec3::new(far, -0.7 * far, 0.4 * far);
        let place = |p: Vec3| p * scale + shift;
        // A closed box on a floor with its lights inside, or with its lights outside and the eye inside.
        for is_light_inside in [true, false] {
            let mut builder = SceneBuilder::new();
            let side = Vec3::splat(scale);
            for axis in 0..3 {
                let (u, v) = (
                    Vec3::AXES[(axis + 1) % 3] * side,
                    Vec3::AXES[(axis + 2) % 3] * side,
                );
                for sign in [-1.0, 1.0] {
                    let middle = place(Vec3::Z + Vec3::AXES[axis] * sign);
                    quad(&mut builder, middle, u, v, MaterialId(1));
                }
            }
            if is_light_inside {
                square(&mut builder, shift, 9.0 * scale, MaterialId(1));
            }
            // In the middle and in a corner.
            for inside in [Vec3::new(0.1, -0.2, 0.9), Vec3::new(0.9, 0.9, 1.9)] {
                let light = if is_light_inside {
                    inside
                } else {
                    inside * Vec3::new(9.0, 9.0, 4.0)
                };
                builder.add_light(place(light), 0.5).unwrap();
            }
            let scene = builder.finish();
            let (eye, target) = if is_light_inside {
                (DVec3::new(4.0, -3.0, 2.5), DVec3::new(0.0, 0.0, 0.6))
            } else {
                (DVec3::new(-0.8, -0.7, 0.4), DVec3::new(0.3, 0.2, 1.0))
            };
            let view = looking(eye, target, DVec3::Z, 60.0);
            let image = picture(&scene, &placed_view(&view, scale, shift));
            let lit = image
                .pixels()
                .filter(|pixel| pixel[0] != 12 && pixel[0] != 255)
                .count();
            assert!(
                lit == 0,
                "scale {scale}, {far} away, light inside: {is_light_inside}: {lit} lit pixels"
            );
        }
    }
}

#[test]
fn a_sphere_seen_from_inside_is_uniform() {
    for (scale, far) in PLACES {
        let shift = Vec3::new(far, -0.7 * far, 0.4 * far);
        let view = looking(
            DVec3::new(0.3, 0.2, -0.1),
            DVec3::new(1.0, 0.1, 0.0),
            DVec3::Z,
            90.0,
        );
        for (light, expected) in [
            // A light outside does not reach the inside; one in the centre meets every point head-on.
            (Vec3::new(5.0, 1.0, 2.0), 0.05),
            (Vec3::ZERO, 0.65),
        ] {
            let mut builder = SceneBuilder::new();
            builder.add_sphere(shift, scale, MaterialId(1)).unwrap();
            builder.add_light(light * scale + shift, 0.6).unwrap();
            let image = picture(&builder.finish(), &placed_view(&view, scale, shift));
            let (least, most) = range(&image);
            let off = [least, most].map(|value| value.abs_diff(byte(expected)));
            assert!(
                off[0] <= 1 && off[1] <= 1,
                "scale {scale}, {far} away: {least} to {most}, not {expected}"
            );
        }
    }
}

#[test]
fn mirrors_that_face_each_other_sum_to_the_series() {
    const MIRROR: f64 = 0.25;
    for (scale, far) in PLACES {
        let shift = Vec3::new(far, -0.7 * far, 0.4 * far);
        for depth in [1, 2, 3, 40] {
            // Between two parallel mirrors and inside a mirror sphere every pixel has the same colour.
            for is_sphere in [false, true] {
                let mut builder = SceneBuilder::new();
                builder.set_ambient(0.4).unwrap();
                builder.set_background(Background::constant([0.9; 3])).unwrap();
                let mirror = builder
                    .add_material(Material::Reflection {
                        color: [1.0; 3],
                        mirror_share: MIRROR as f32,
                    })
                    .unwrap();
                if is_sphere {
                    builder.add_sphere(shift, scale, mirror).unwrap();
                } else {
                    for z in [-0.5, 0.5] {
                        square(&mut builder, shift + Vec3::Z * z * scale, 1e3 * scale, mirror);
                    }
                }
                let view = looking(
                    DVec3::new(0.1, 0.2, 0.1),
                    DVec3::new(0.3, 0.1, 1.0),
                    DVec3::Y,
                    30.0,
                );
                // The ray after `depth` hits returns the background.
                let hits = i32::try_from(depth).unwrap();
                let share = MIRROR.powi(hits);
                let expected = 0.4 * (1.0 - MIRROR) * (1.0 - share) / (1.0 - MIRROR) + 0.9 * share;
                let scene = builder.finish();
                for mode in [Mode::Packet, Mode::Scalar] {
                    let camera = placed_view(&view, scale, shift);
                    let image = picture_in(&scene, &camera, SIDE / 4, mode, depth);
                    let (least, most) = range(&image);
                    let off = [least, most].map(|value| value.abs_diff(byte(expected)));
                    assert!(
                        off[0] <= 1 && off[1] <= 1,
                        "scale {scale}, {far} away, depth {depth}, sphere {is_sphere}, {mode:?}: {least} to {most}, not {expected}"
                    );
                }
            }
        }
    }
}

#[test]
fn eyes_and_lights_on_surfaces() {
    for (scale, far) in PLACES {
        let shift = Vec3::new(far, -0.7 * far, 0.4 * far);
        let mut builder = SceneBuilder::new();
        square(&mut builder, shift, 3.0 * scale, MaterialId(1));
        // A light in the plane of the floor adds nothing visible to it.
        builder
            .add_light(Vec3::new(0.5, 0.25, 0.0) * scale + shift, 0.9)
            .unwrap();
        let scene = builder.finish();
        let view = looking(
            DVec3::new(-0.5, 0.25, 1.0),
            DVec3::new(0.2, 0.1, 0.0),
            DVec3::Z,
            40.0,
        );
        let (least, most) = range(&picture(&scene, &placed_view(&view, scale, shift)));
        assert!(
            least >= 12 && most <= 14,
            "scale {scale}, {far} away: {least} to {most}"
        );

        // An eye in the plane of the floor sees background or floor.
        let view = looking(
            DVec3::new(-0.5, 0.25, 0.0),
            DVec3::new(0.5, 0.1, 0.0),
            DVec3::Z,
            40.0,
        );
        let image = picture(&scene, &placed_view(&view, scale, shift));
        assert!(
            image.pixels().all(|pixel| pixel[0] == 255 || pixel[0] <= 14),
            "scale {scale}, {far} away"
        );
    }
}
