//! Infinite planes and checkerboards.

use crate::sameness::{check, sized};
use glam::{DVec3, Vec3};
use octray::{
    accel::Bvh,
    ray::Ray,
    reference::brute,
    render::{Film, Mode, Pattern, Renderer, Settings, render},
    scene::{
        Background, Camera, Checker, Material, MaterialId, Projection, Scene, SceneBuilder, SurfaceTextures,
        View,
    },
};
use std::ops::ControlFlow;

fn checkered(builder: &mut SceneBuilder, material: Material, size: f32) -> MaterialId {
    let checker = Some(Checker {
        colors: [[0.9, 0.8, 0.7], [0.2, 0.3, 0.4]],
        size,
    });
    let textures = SurfaceTextures {
        checker,
        ..SurfaceTextures::NONE
    };
    builder.add_textured_material(material, textures).unwrap()
}

/// Planes of all materials across each other, checkered, in each other's mirrors, before and behind glass and other
/// primitives, in all kinds of light.
fn planes_scene(is_far: bool) -> Scene {
    let shift = if is_far {
        Vec3::new(5000.0, -3000.0, 700.0)
    } else {
        Vec3::ZERO
    };
    let mut builder = SceneBuilder::new();
    builder
        .add_light(shift + Vec3::new(-2.0, -3.0, 4.0), 0.3)
        .unwrap();
    builder
        .add_sphere_light(shift + Vec3::new(3.0, -4.0, 6.0), 0.5, 0.4, [1.0, 0.9, 0.8])
        .unwrap();
    builder.set_ambient_reach(Some(1.0)).unwrap();
    let white = [1.0; 3];
    let ground = checkered(&mut builder, Material::Matte { color: white }, 0.5);
    let mirror = Material::Reflection {
        color: white,
        mirror_share: 0.6,
    };
    let mirror = checkered(&mut builder, mirror, 0.3);
    let [matte, shiny] = [1, 2].map(|number| builder.classic_material(number).unwrap());
    let glass = builder.add_material(Material::GLASS).unwrap();
    let planes = [
        (Vec3::ZERO, Vec3::Z, ground),
        (Vec3::Y * 3.0, Vec3::new(0.2, -1.0, 0.1), mirror),
        (Vec3::X * -4.0, Vec3::X, matte),
        (Vec3::X * -4.5, Vec3::new(1.0, 0.3, 0.2), shiny),
        (Vec3::Z * -0.1, Vec3::Z, matte),
    ];
    for (point, normal, material) in planes {
        builder.add_plane(shift + point, normal, material).unwrap();
    }
    for (i, material) in [glass, ground, shiny, matte, mirror].into_iter().enumerate() {
        let at = shift + Vec3::new(i as f32 * 0.5 - 1.2, (i % 2) as f32 * 0.7, 0.3);
        builder.add_sphere(at, 0.35, material).unwrap();
        let corners = [at + Vec3::X, at + Vec3::Y, at + Vec3::new(0.5, 0.5, 1.0)];
        builder.add_triangle(corners, material).unwrap();
    }
    builder.finish()
}

#[test]
fn infinite_planes() {
    for (name, is_far) in [("planes", false), ("far planes", true)] {
        let scene = planes_scene(is_far);
        let shift = scene.origin().as_dvec3();
        for (i, (width, height, samples)) in [(149, 97, 1), (33, 21, 4)].into_iter().enumerate() {
            let mut views = [2, 5].map(|number| View::classic(number + i as u32).expect("a view"));
            for view in &mut views {
                (view.eye, view.target) = (view.eye + shift, view.target + shift);
                for projection in [Projection::DEFAULT, Projection::Orthographic { height: 3.0 }] {
                    let camera = Camera::new(&View { projection, ..*view }).expect("a view");
                    for max_depth in [1, 5] {
                        let settings = Settings {
                            max_depth,
                            ..sized(width, height, samples)
                        };
                        check(name, &scene, &camera, &settings);
                    }
                }
            }
        }
    }
    // Output variables, too.
    let scene = planes_scene(false);
    let bvh = Bvh::build(&scene);
    let camera = Camera::classic_view(1).expect("views are 1 to 6");
    let [packet, scalar] = [Mode::Packet, Mode::Scalar].map(|mode| {
        let settings = Settings {
            mode,
            ..sized(64, 48, 1)
        };
        let aovs =
            Renderer::new(&scene, &bvh).aovs(&camera, &settings, false, &|_| ControlFlow::Continue(()));
        aovs.expect("AOVs").pixels
    });
    assert_eq!(packet, scalar);
    assert!(packet.iter().any(|pixel| pixel.primitive == scene.plane_id(0)));
}

fn picture(scene: &Scene, camera: &Camera, settings: &Settings) -> Film {
    let frame = render(scene, &Bvh::build(scene), camera, settings, &|_| {
        ControlFlow::Continue(())
    });
    frame.expect("a small picture").film
}

/// A ground with one light above it looks the same when scaled by `scale` and far away: no acne, no leaks.
#[test]
fn the_ground_does_not_shadow_itself() {
    for (scale, shift) in [
        (1.0, Vec3::ZERO),
        (1e-3, Vec3::ZERO),
        (1e5, Vec3::ZERO),
        (1.0, Vec3::new(1e5, -7e4, 3e4)),
    ] {
        for normal in [Vec3::Z, Vec3::new(0.3, -0.2, 1.0)] {
            for radius in [0.0, 0.3] {
                let mut builder = SceneBuilder::new();
                builder.set_ambient(0.0).unwrap();
                builder
                    .set_background(Background::constant([0.0, 0.0, 1.0]))
                    .unwrap();
                let above = normal.normalize() * (3.0 * scale);
                builder
                    .add_sphere_light(shift + above, radius * scale, 1.0, [1.0; 3])
                    .unwrap();
                let white = Material::Matte { color: [1.0; 3] };
                let white = builder.add_material(white).unwrap();
                builder.add_plane(shift, normal, white).unwrap();
                // Far objects are stored relative to their middle.
                builder.add_sphere(shift - above, scale, white).unwrap();
                let eye = (shift + above * 0.4).as_dvec3() + DVec3::Y * f64::from(-4.0 * scale);
                let camera = Camera::look_at(eye, shift.as_dvec3(), DVec3::Z, 20.0).unwrap();
                let film = picture(&builder.finish(), &camera, &sized(64, 64, 1));
                for (i, [red, _, blue]) in film.pixels().iter().enumerate() {
                    let is_sky = *blue == 1.0 && *red == 0.0;
                    assert!(is_sky || *red > 0.05, "{scale} {shift} {normal} {radius}: {i}");
                }
                assert!(film.pixels()[64 * 32 + 32][0] > 0.9);
            }
        }
    }
}

/// A plane is seen up to the horizon, half of the picture, and in any direction below it.
#[test]
fn the_horizon_is_level() {
    let mut builder = SceneBuilder::new();
    let red = Material::Silhouette {
        color: [1.0, 0.0, 0.0],
    };
    let red = builder.add_material(red).unwrap();
    builder.add_plane(Vec3::Z * -1.0, Vec3::Z, red).unwrap();
    let scene = builder.finish();
    for target in [DVec3::X, DVec3::new(-3.0, 5.0, 0.0)] {
        let camera = Camera::look_at(DVec3::ZERO, target, DVec3::Z, 60.0).unwrap();
        let film = picture(&scene, &camera, &sized(40, 40, 1));
        for (i, pixel) in film.pixels().iter().enumerate() {
            let expected = if i / 40 < 20 { [1.0; 3] } else { [1.0, 0.0, 0.0] };
            assert_eq!(*pixel, expected, "{i}");
        }
    }
    let ray = Ray::new(Vec3::ZERO, Vec3::new(0.6, 0.0, -0.8));
    let hit = brute::closest_hit(&scene, &ray);
    assert_eq!((hit.primitive, hit.t), (scene.plane_id(0), 1.25));
    let to = |t_max| Ray { t_max, ..ray };
    assert!(brute::occluded(&scene, &to(1.26)) && !brute::occluded(&scene, &to(1.25)));
}

/// One sample of a filtered checkerboard is near the mean of many of an unfiltered one.
#[test]
fn checkerboards_are_filtered() {
    let mut builder = SceneBuilder::new();
    let ground = checkered(&mut builder, Material::Silhouette { color: [1.0; 3] }, 0.7);
    builder.add_plane(Vec3::ZERO, Vec3::Z, ground).unwrap();
    let scene = builder.finish();
    let camera = Camera::look_at(
        DVec3::new(0.3, 0.2, 1.0),
        DVec3::new(9.0, 4.0, -0.5),
        DVec3::Z,
        50.0,
    )
    .unwrap();
    let one = picture(&scene, &camera, &sized(96, 96, 1));
    let many = Settings {
        pattern: Pattern::Sobol,
        ..sized(96, 96, 256)
    };
    let many = picture(&scene, &camera, &many);
    let (mut sum, mut most) = (0.0, 0.0_f32);
    for (i, (one, many)) in one.pixels().iter().zip(many.pixels()).enumerate() {
        // The horizon's row is half sky.
        let difference = (one[0] - many[0]).abs();
        if many[2] < 0.72 && i / 96 > 0 {
            sum += difference;
            most = most.max(difference);
        }
    }
    assert!(sum / 9216.0 < 0.03 && most < 0.4, "{} {most}", sum / 9216.0);
}
