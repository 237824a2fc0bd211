//! Glass against closed forms: shares, directions and absorption of light.

use crate::blending::see_through;
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    render::{Mode, Settings, render},
    scene::{Background, Camera, Material, MaterialId, Scene, SceneBuilder},
};
use std::ops::ControlFlow;

/// Under it, a ray's colour is half of its direction's z plus one half: it says where light comes from.
pub const GRADIENT: Background = Background {
    bottom: [0.0; 3],
    top: [1.0; 3],
};

/// [`GRADIENT`] along a direction with this z.
pub fn sky(z: f64) -> f64 {
    0.5 + 0.5 * z
}

fn glass(index: f32) -> Material {
    Material::Glass {
        index,
        tint: [1.0; 3],
        depth: 1.0,
    }
}

/// A scene under a background, and its glass.
pub fn under(background: Background, material: Material) -> (SceneBuilder, MaterialId) {
    let mut builder = SceneBuilder::new();
    builder.set_background(background).unwrap();
    let id = builder.add_material(material).unwrap();
    (builder, id)
}

/// Renders 12x9 pixels in both modes, which are equal, and returns them.
pub fn pixels(scene: &Scene, camera: &Camera, max_depth: u32) -> Vec<[f32; 3]> {
    let bvh = Bvh::build(scene);
    let picture = |mode| {
        let settings = Settings {
            width: 12,
            height: 9,
            max_depth,
            mode,
            ..Settings::default()
        };
        let frame = render(scene, &bvh, camera, &settings, &|_| ControlFlow::Continue(()));
        frame.unwrap().film.pixels().to_vec()
    };
    let made = picture(Mode::Packet);
    assert_eq!(made, picture(Mode::Scalar));
    made
}

/// The colour that a narrow view sees.
pub fn color(scene: &Scene, eye: DVec3, target: DVec3, max_depth: u32) -> [f64; 3] {
    let up = DVec3::new(0.1, 0.9, 0.2);
    let camera = Camera::look_at(eye, target, up, 1e-3).unwrap();
    pixels(scene, &camera, max_depth)[54].map(f64::from)
}

#[track_caller]
pub fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found}, not {expected}");
}

/// The share that is reflected, by Fresnel's equations in angles, and the angle of refraction.
fn fresnel(angle: f64, ratio: f64) -> (f64, f64) {
    let bent = (angle.sin() * ratio).asin();
    let across = (angle - bent).sin() / (angle + bent).sin();
    let along = (angle - bent).tan() / (angle + bent).tan();
    (0.5 * (across * across + along * along), bent)
}

/// A square about the origin that faces up, inside below it.
pub fn surface(builder: &mut SceneBuilder, z: f32, up: bool, glass: MaterialId) {
    let corner = |x: f32, y: f32| Vec3::new(x * 50.0, y * 50.0, z);
    let [a, b, c, d] = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    for [a, b, c] in [[a, b, c], [a, c, d]] {
        let corners = if up { [a, b, c] } else { [a, c, b] };
        builder.add_triangle(corners, glass).unwrap();
    }
}

/// With one hit, both branches take the background: the colour is their shares and directions.
#[test]
fn a_surface_reflects_and_refracts_by_fresnel_and_snell() {
    for index in [1.1_f32, 1.333, 1.5, 2.4, 3.0] {
        for degrees in [5.0_f64, 20.0, 40.0, 60.0, 80.0, 88.0] {
            for from_inside in [false, true] {
                let (mut builder, id) = under(GRADIENT, glass(index));
                surface(&mut builder, 0.0, !from_inside, id);
                let scene = builder.finish();
                let angle = degrees.to_radians();
                let eye = DVec3::new(angle.sin(), 0.0, angle.cos());
                let [found, ..] = color(&scene, eye, DVec3::ZERO, 1);
                let ratio = f64::from(if from_inside { index } else { 1.0 / index });
                let expected = if angle.sin() * ratio >= 1.0 {
                    // Total internal reflection.
                    sky(angle.cos())
                } else {
                    let (share, bent) = fresnel(angle, ratio);
                    share * sky(angle.cos()) + (1.0 - share) * sky(-bent.cos())
                };
                assert_near(found, expected, 1e-5);
            }
        }
    }
}

/// At normal incidence `((n - 1) / (n + 1))^2` is reflected; at Brewster's angle, half of what one polarisation reflects.
#[test]
fn shares_at_normal_incidence_and_at_brewsters_angle() {
    for index in [0.5_f32, 1.5, 2.0] {
        let (mut builder, id) = under(GRADIENT, glass(index));
        surface(&mut builder, 0.0, true, id);
        let scene = builder.finish();
        let n = f64::from(index);
        let [found, ..] = color(&scene, DVec3::Z, DVec3::ZERO, 1);
        assert_near(found, ((n - 1.0) / (n + 1.0)).powi(2), 1e-6);
        let angle = n.atan();
        let eye = DVec3::new(angle.sin(), 0.0, angle.cos());
        let [found, ..] = color(&scene, eye, DVec3::ZERO, 1);
        let share = 0.5 * ((n * n - 1.0) / (n * n + 1.0)).powi(2);
        // Reflected and refracted rays are at right angles.
        let expected = share * sky(angle.cos()) + (1.0 - share) * sky(-angle.sin());
        assert_near(found, expected, 1e-5);
    }
}

/// A slab reflects `2 R / (1 + R)`, over all ways back and forth inside, and lets the rest through; two slabs
/// `4 R / (1 + 3 R)`.
#[test]
fn a_slab_sums_its_inner_reflections() {
    for index in [1.2_f32, 1.5] {
        for (slabs, gap) in [(1, 0.0), (2, 0.5), (2, 1e-3)] {
            let (mut builder, id) = under(GRADIENT, glass(index));
            for slab in 0..slabs {
                let top = slab as f32 * -(1.0 + gap);
                surface(&mut builder, top, true, id);
                surface(&mut builder, top - 1.0, false, id);
            }
            let scene = builder.finish();
            let n = f64::from(index);
            let share = ((n - 1.0) / (n + 1.0)).powi(2);
            let faces = 2.0 * f64::from(slabs);
            let expected = faces * share / (1.0 + (faces - 1.0) * share);
            let [found, ..] = color(&scene, DVec3::Z, DVec3::ZERO, 30);
            assert_near(found, expected, 6e-3 * f64::from(slabs) * share.sqrt());
        }
    }
}

/// Under an even white sky glass without tint is invisible, also where it touches or meets other glass.
#[test]
fn a_white_furnace_stays_white() {
    let white = Background::constant([1.0; 3]);
    let cube = |builder: &mut SceneBuilder, at: Vec3, id| {
        let corner = |i: usize| at + Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        for [a, b, c, d] in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            builder.add_triangle([a, b, c].map(corner), id).unwrap();
            builder.add_triangle([a, c, d].map(corner), id).unwrap();
        }
    };
    for index in [0.667_f32, 1.0, 1.5, 2.4] {
        for bodies in 0..5 {
            let (mut builder, id) = under(white, glass(index));
            match bodies {
                0 => builder.add_sphere(Vec3::ZERO, 1.0, id).unwrap(),
                1 => {
                    // Spheres that touch in a point, and the same sphere twice.
                    builder.add_sphere(Vec3::X * -0.5, 0.5, id).unwrap();
                    builder.add_sphere(Vec3::X * 0.5, 0.5, id).unwrap();
                    builder.add_sphere(Vec3::X * 0.5, 0.5, id).unwrap();
                }
                2 => cube(&mut builder, Vec3::splat(-0.5), id),
                3 => {
                    // Cubes that share a face.
                    cube(&mut builder, Vec3::new(-1.0, -0.5, -0.5), id);
                    cube(&mut builder, Vec3::new(0.0, -0.5, -0.5), id);
                }
                _ => {
                    // A sphere that stands on a block and one that cuts into it.
                    cube(&mut builder, Vec3::new(-0.5, -0.5, -1.0), id);
                    builder.add_sphere(Vec3::Z * 0.5, 0.5, id).unwrap();
                    builder.add_sphere(Vec3::Y * 0.5, 0.5, id).unwrap();
                }
            }
            let scene = builder.finish();
            for eye in [
                DVec3::new(2.0, -1.5, 0.9),
                DVec3::new(-0.3, 0.2, 0.1),
                DVec3::new(0.0, -3.0, 0.0),
            ] {
                let camera = Camera::look_at(eye, DVec3::new(0.05, 0.0, 0.0), DVec3::Z, 50.0).unwrap();
                for depth in [1, 2, 4, 40] {
                    for [r, g, b] in pixels(&scene, &camera, depth) {
                        assert!(r == g && g == b && (r - 1.0).abs() < 1e-5, "{r} {g} {b}");
                    }
                }
            }
        }
    }
}

/// Rays leave a sphere after k chords turned by `2 (i - t) + (k - 1) (pi - 2 t)`.
#[test]
fn rays_go_through_a_sphere_by_geometry() {
    for index in [1.333_f32, 1.5, 2.0] {
        for height in [0.0_f64, 0.3, 0.6, 0.9] {
            let (mut builder, id) = under(GRADIENT, glass(index));
            builder.add_sphere(Vec3::ZERO, 1.0, id).unwrap();
            let scene = builder.finish();
            let eye = DVec3::new(height + 1e-6, 0.0, 10.0);
            let target = DVec3::new(height + 1e-6, 0.0, 0.0);
            let [found, ..] = color(&scene, eye, target, 60);
            let angle = height.max(1e-6).asin();
            let (share, bent) = fresnel(angle, 1.0 / f64::from(index));
            let mut expected = share * sky((2.0 * angle).cos());
            for chords in 1..40_i32 {
                let inner = f64::from(chords - 1);
                let turn = 2.0 * (angle - bent) + inner * (std::f64::consts::PI - 2.0 * bent);
                expected += (1.0 - share).powi(2) * share.powi(chords - 1) * sky(-turn.cos());
            }
            // A branch that weighs too little takes the background.
            assert_near(found, expected, 2.5e-3);
        }
    }
}

/// Light enters a prism, is turned upwards by its slope alone, and leaves.
#[test]
fn a_prism_reflects_totally() {
    let (mut builder, id) = under(GRADIENT, glass(1.5));
    // A square's upper left half, cut along its diagonal, wide across.
    let side = |x: f32, z: f32| [Vec3::new(x, -9.0, z), Vec3::new(x, 9.0, z)];
    let [a, b, c] = [side(0.0, 1.0), side(0.0, 0.0), side(1.0, 1.0)];
    let mut face = |[p, q]: [Vec3; 2], [r, s]: [Vec3; 2]| {
        builder.add_triangle([p, q, s], id).unwrap();
        builder.add_triangle([p, s, r], id).unwrap();
    };
    // Left, below, above, each seen counterclockwise from outside.
    face(a, b);
    face(b, c);
    face(c, a);
    builder.add_triangle([a[0], b[0], c[0]], id).unwrap();
    builder.add_triangle([a[1], c[1], b[1]], id).unwrap();
    let scene = builder.finish();
    let eye = DVec3::new(-5.0, 0.0, 0.6);
    let [found, ..] = color(&scene, eye, DVec3::new(5.0, 0.0, 0.6), 30);
    // 0.04 is reflected at the entry, at the way out, and so on; what leaves by the entry is level.
    let (out, back) = (0.96 * 0.96, 0.96 * 0.04 * 0.96);
    let expected = 0.04 * sky(0.0) + (out + back * 0.04) * sky(1.0) + back * sky(0.0);
    assert_near(found, expected, 2e-3);
}

/// From the middle of a tinted sphere every ray meets it straight, again and again.
#[test]
fn tint_by_depth_follows_beer_and_lambert() {
    let tint = [0.5_f32, 0.81, 1.0];
    let depth = 3.0_f32;
    let material = Material::Glass {
        index: 1.5,
        tint,
        depth,
    };
    let (mut builder, id) = under(Background::constant([1.0; 3]), material);
    builder.add_sphere(Vec3::ZERO, 2.0, id).unwrap();
    let scene = builder.finish();
    let found = color(&scene, DVec3::ZERO, DVec3::new(1.0, 0.3, 0.2), 30);
    for (found, tint) in found.into_iter().zip(tint) {
        let passed = f64::from(tint).powf(2.0 / f64::from(depth));
        let expected = 0.96 * passed / (1.0 - 0.04 * passed * passed);
        assert_near(found, expected, 1e-3);
    }
}

/// An opaque body in tinted glass is seen through it, twice in a mirror: once each way.
#[test]
fn bodies_in_tinted_glass_are_tinted() {
    let material = Material::Glass {
        index: 1.5,
        tint: [0.5, 0.7, 1.0],
        depth: 1.0,
    };
    let (mut builder, id) = under(Background::constant([0.0; 3]), material);
    builder.add_sphere(Vec3::ZERO, 2.0, id).unwrap();
    let body = builder
        .add_material(Material::Silhouette { color: [1.0; 3] })
        .unwrap();
    builder.add_sphere(Vec3::ZERO, 0.5, body).unwrap();
    let scene = builder.finish();
    let found = color(&scene, DVec3::Z * 9.0, DVec3::ZERO, 30);
    for (found, tint) in found.into_iter().zip([0.5_f64, 0.7, 1.0]) {
        assert_near(found, 0.96 * tint.powf(1.5), 1e-4);
    }
}

/// A camera in tinted glass sees everything through it: bodies, mirrors and what is behind half-transparent sheets. A camera in
/// air beside it, or in a bubble of air, sees what is in the air as it is.
#[test]
fn a_camera_in_tinted_glass_sees_all_of_it_tinted() {
    const TINT: [f32; 3] = [0.5, 0.7, 1.0];
    let made = |with: &dyn Fn(&mut SceneBuilder, MaterialId)| {
        let material = Material::Glass {
            index: 1.5,
            tint: TINT,
            depth: 1.0,
        };
        let (mut builder, id) = under(Background::constant([0.0; 3]), material);
        let white = Material::Silhouette { color: [1.0; 3] };
        let white = builder.add_material(white).unwrap();
        builder.add_sphere(Vec3::X * -3.0, 0.5, white).unwrap();
        // The middle of the scene is elsewhere.
        builder
            .add_sphere(Vec3::new(60.0, 45.0, -50.0), 2.0, white)
            .unwrap();
        with(&mut builder, id);
        builder.finish()
    };
    let seen = |scene: &Scene, target: DVec3, passed: f64, distance: f64| {
        let found = color(scene, DVec3::ZERO, target, 30);
        for (found, tint) in found.into_iter().zip(TINT) {
            assert_near(found, passed * f64::from(tint).powf(distance), 1e-4);
        }
    };
    let [left, right] = [DVec3::NEG_X, DVec3::X];
    let ball = |builder: &mut SceneBuilder, id| {
        builder.add_sphere(Vec3::ZERO, 9.0, id).unwrap();
    };
    seen(&made(&ball), left, 1.0, 2.5);
    // Water up to a plane, above which there is air.
    seen(
        &made(&|builder, id| surface(builder, 4.0, true, id)),
        left,
        1.0,
        2.5,
    );
    seen(
        &made(&|builder, id| surface(builder, -4.0, true, id)),
        left,
        1.0,
        0.0,
    );
    let beside = made(&|builder, id| {
        builder.add_sphere(Vec3::X * 30.0, 9.0, id).unwrap();
    });
    seen(&beside, left, 1.0, 0.0);
    let mirror = made(&|builder, id| {
        ball(builder, id);
        let mirror = Material::Reflection {
            color: [0.0; 3],
            mirror_share: 0.8,
        };
        let mirror = builder.add_material(mirror).unwrap();
        let corners = [[1.0, -9.0, -9.0], [1.0, 9.0, -9.0], [1.0, 0.0, 20.0]];
        builder.add_triangle(corners.map(Vec3::from), mirror).unwrap();
    });
    seen(&mirror, right, 0.8, 1.0 + 1.0 + 2.5);
    let sheet = made(&|builder, id| {
        ball(builder, id);
        let black = Material::Silhouette { color: [0.0; 3] };
        let sheet = see_through(builder, black, 0.25);
        let corners = [[-1.0, -9.0, -9.0], [-1.0, 9.0, -9.0], [-1.0, 0.0, 20.0]];
        builder.add_triangle(corners.map(Vec3::from), sheet).unwrap();
    });
    seen(&sheet, left, 0.75, 2.5);
}

/// A weak tint in a large body is that of the same scene in other units.
#[test]
fn weak_tints_count_in_large_bodies() {
    let (mut builder, id) = under(
        Background::constant([1.0; 3]),
        Material::Glass {
            index: 1.0,
            tint: [0.99; 3],
            depth: 4e5,
        },
    );
    builder.add_sphere(Vec3::ZERO, 2e7, id).unwrap();
    let found = color(&builder.finish(), DVec3::Z * 6e7, DVec3::ZERO, 5);
    assert_near(found[0], 0.99_f64.powi(100), 1e-3);
}
