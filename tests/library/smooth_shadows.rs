//! Smooth shadows: coarse meshes with smooth normals are lit like what they stand for; no light leaks; both modes agree.
//!
//! `OCTRAY_LONG=1` makes larger pictures.

use crate::{
    blending::see_through,
    long::rounds,
    sameness::{Sameness, sized},
};
use glam::{DVec3, Quat, Vec3};
use octray::{
    accel::Bvh,
    format::load_from_bytes,
    render::{Film, Settings, render},
    scene::{
        Background, Camera, CutOut, Environment, Image, Lens, Light, LightShape, Material, Projection, Scene,
        SceneBuilder, SurfaceTextures, Texture, TriangleMesh, View, Wrap,
    },
};
use std::{ops::ControlFlow, path::Path};

/// A sphere of 128 triangles around the origin, turned so that no edges run along the terminator, with its exact normals at
/// the vertices.
fn coarse_sphere(radius: f32) -> TriangleMesh {
    let turn = Quat::from_rotation_x(0.7) * Quat::from_rotation_y(0.5);
    let axes = [Vec3::X, Vec3::Y, -Vec3::X, -Vec3::Y].map(|axis| turn * axis);
    let pole = turn * Vec3::Z;
    let mut faces = Vec::new();
    for i in 0..4 {
        let (a, b) = (axes[i], axes[(i + 1) % 4]);
        faces.extend([[a, b, pole], [b, a, -pole]]);
    }
    for _ in 0..2 {
        let split = |[a, b, c]: [Vec3; 3]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(Vec3::normalize);
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    mesh(&faces, radius)
}

/// A mesh of triangles whose vertices, times `radius`, have themselves as normals.
fn mesh(faces: &[[Vec3; 3]], radius: f32) -> TriangleMesh {
    let corners = faces.as_flattened();
    TriangleMesh {
        x: corners.iter().map(|p| p.x * radius).collect(),
        y: corners.iter().map(|p| p.y * radius).collect(),
        z: corners.iter().map(|p| p.z * radius).collect(),
        normals: corners.to_vec(),
        triangles: (0..faces.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
        ..TriangleMesh::default()
    }
}

/// A black scene of one light.
fn lit(light: Light) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    builder.set_smooth_shadows(true);
    builder.set_ambient(0.0).unwrap();
    builder.set_background(Background::constant([0.0; 3])).unwrap();
    builder.add(light).unwrap();
    builder
}

fn white(builder: &mut SceneBuilder) -> octray::scene::MaterialId {
    builder.add_material(Material::Matte { color: [1.0; 3] }).unwrap()
}

fn film(scene: &Scene, camera: &Camera, settings: &Settings) -> Film {
    let frame = render(scene, &Bvh::build(scene), camera, settings, &|_| {
        ControlFlow::Continue(())
    });
    frame.unwrap().film
}

/// A view along -z, from outside a sphere.
fn front(scale: f32) -> Camera {
    let scale = f64::from(scale);
    let view = View {
        eye: DVec3::new(0.0, 0.0, 4.0) * scale,
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 2.0 * scale },
        ..View::classic(1).unwrap()
    };
    Camera::new(&view).unwrap()
}

/// Lights from the right, so that the terminator runs through the middle of the picture or beside it.
fn lights(scale: f32) -> Vec<(&'static str, Light, u32)> {
    let at = Vec3::new(30.0, 3.0, 2.0) * scale;
    let rectangle = LightShape::Rectangle {
        center: at,
        edges: [Vec3::Z * scale, Vec3::Y * scale],
    };
    let sphere = LightShape::Sphere {
        center: at,
        radius: 2.0 * scale,
    };
    let sun = LightShape::directional(DVec3::new(10.0, 1.0, -1.0), 0.0).unwrap();
    let close = LightShape::Point {
        position: Vec3::new(3.0, 0.4, 0.5) * scale,
    };
    vec![
        ("point", Light::new(LightShape::Point { position: at }), 1),
        ("close point", Light::new(close), 1),
        ("sun", Light::new(sun), 1),
        ("sphere", Light::new(sphere), 64),
        ("rectangle", Light::new(rectangle), 64),
    ]
}

/// Along a row of pixels, the brightness of a coarse sphere is that of a round one, and falls towards the dark side.
#[test]
fn a_coarse_sphere_is_lit_like_a_round_one() {
    const SIZE: usize = 96;
    for scale in [1.0, 1e-4, 1e5] {
        for (name, light, samples) in lights(scale) {
            let sphere = |is_coarse, smooth_shadows| {
                let mut builder = lit(light);
                builder.set_smooth_shadows(smooth_shadows);
                let white = white(&mut builder);
                if is_coarse {
                    builder.add_mesh(coarse_sphere(scale), white).unwrap();
                } else {
                    builder.add_sphere(Vec3::ZERO, scale, white).unwrap();
                }
                film(
                    &builder.finish(),
                    &front(scale),
                    &sized(SIZE as u32, SIZE as u32, samples),
                )
            };
            let (coarse, flat, round) = (sphere(true, true), sphere(true, false), sphere(false, true));
            let mut without: f32 = 0.0;
            let mut largest: f32 = 0.0;
            for row in SIZE / 4..SIZE * 3 / 4 {
                // Within both outlines.
                let at = |film: &Film, x: usize| film.pixels()[row * SIZE + x][0];
                let mut brightest: f32 = 0.0;
                for x in SIZE / 6..SIZE * 3 / 4 {
                    let found = at(&coarse, x);
                    let expected = at(&round, x);
                    // Brighter light is far from the terminator.
                    if expected < 0.35 {
                        largest = largest.max((found - expected).abs());
                        without = without.max((at(&flat, x) - expected).abs());
                    }
                    // From left, the dark side, to right.
                    brightest = brightest.max(found);
                    assert!(
                        brightest - found < 0.02,
                        "{name} {scale}: a step down at {x} {row}"
                    );
                }
            }
            assert!(
                largest < 0.05 && without > 0.1,
                "{name} {scale}: {largest}, {without}"
            );
        }
    }
}

/// Neither from outside into a closed mesh nor from inside out, whatever its normals.
#[test]
fn no_light_passes_a_closed_mesh() {
    let cube = |a: Vec3| {
        let (b, c) = (Vec3::new(a.y, a.z, a.x), Vec3::new(a.z, a.x, a.y));
        let [p, q, r, s] = [a - b - c, a + b - c, a + b + c, a - b + c];
        [[p, q, r], [p, r, s]]
    };
    let axes = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::X, -Vec3::Y, -Vec3::Z];
    let cube: Vec<_> = axes.into_iter().flat_map(cube).collect();
    let inside_out = |mut mesh: TriangleMesh| {
        mesh.normals.iter_mut().for_each(|normal| *normal = -*normal);
        mesh
    };
    let outside = Light::new(LightShape::Point {
        position: Vec3::new(3.0, 2.0, 2.5),
    });
    let inside = Light::new(LightShape::Point {
        position: Vec3::new(0.3, 0.1, -0.2),
    });
    for mesh in [coarse_sphere(1.0), mesh(&cube, 1.0)] {
        for mesh in [inside_out(mesh.clone()), mesh] {
            for (light, eye) in [
                (outside, Vec3::new(-0.4, 0.1, 0.0)),
                (inside, Vec3::new(-2.0, 3.0, 3.0)),
            ] {
                let mut builder = lit(light);
                let white = white(&mut builder);
                builder.add_mesh(mesh.clone(), white).unwrap();
                let camera = Camera::look_at(eye.as_dvec3(), DVec3::ZERO, DVec3::Z, 90.0).unwrap();
                let film = film(&builder.finish(), &camera, &sized(64, 64, 1));
                assert!(film.pixels().iter().all(|pixel| *pixel == [0.0; 3]), "from {eye}");
            }
        }
    }
}

/// A sphere that rests on a floor is not lit from below the floor, though its smooth surface is partly there.
#[test]
fn no_light_passes_a_floor_that_a_mesh_touches() {
    let mesh = coarse_sphere(1.0);
    let lowest = mesh.z.iter().copied().fold(0.0, f32::min);
    for below in [Vec3::new(0.0, 0.0, -3.0), Vec3::new(0.0, -2.0, -1.5)] {
        let mut builder = lit(Light::new(LightShape::Point { position: below }));
        let white = white(&mut builder);
        builder.add_mesh(mesh.clone(), white).unwrap();
        builder
            .add_plane(Vec3::Z * (lowest - 1e-3), Vec3::Z, white)
            .unwrap();
        let (eye, target) = (DVec3::new(0.0, -6.0, -0.9), DVec3::Z * -0.7);
        let camera = Camera::look_at(eye, target, DVec3::Z, 20.0).unwrap();
        let film = film(&builder.finish(), &camera, &sized(128, 128, 1));
        assert!(film.pixels().iter().all(|pixel| *pixel == [0.0; 3]), "{below}");
    }
}

/// Cards, cut-outs, glass and half-transparent surfaces with wild normals, or none, in every kind of light.
fn wild_scene(shift: Vec3) -> Scene {
    let mut random = fastrand::Rng::with_seed(77);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = move || Vec3::new(unit(), unit(), unit());
    let mut builder = SceneBuilder::new();
    builder.set_smooth_shadows(true);
    builder.set_ambient_reach(Some(1.0)).unwrap();
    for (_, light, _) in lights(0.1) {
        builder
            .add(Light {
                intensity: 0.2,
                ..light
            })
            .unwrap();
    }
    builder
        .set_environment(Environment::Background(Background::constant([0.3, 0.2, 0.1])))
        .unwrap();
    let texels = (0_u8..64).map(|i| [255, 255, 255, i.wrapping_mul(37)]).collect();
    let image = builder.add_image(Image::new([8, 8], texels).unwrap()).unwrap();
    let texture = Texture {
        image,
        wrap: [Wrap::Repeat; 2],
        nearest: false,
    };
    let cut = SurfaceTextures {
        cut_out: Some(CutOut {
            texture,
            channel: 3,
            limit: 0.5,
        }),
        ..SurfaceTextures::NONE
    };
    let matte = Material::Matte { color: [0.7; 3] };
    let materials = [
        builder.classic_material(2).unwrap(),
        builder.classic_material(3).unwrap(),
        builder.add_material(Material::GLASS).unwrap(),
        see_through(&mut builder, matte, 0.4),
        builder.add_textured_material(matte, cut).unwrap(),
        builder.add_material(matte).unwrap(),
    ];
    for i in 0..60 {
        let at = vector() * 1.2 + shift;
        let corners = [(); 3].map(|()| at + vector() * 0.6);
        let normals = [0, 1, 2].map(|k| {
            if i % 7 == 0 && k == 1 {
                Vec3::ZERO
            } else {
                vector() * 3.0
            }
        });
        let mesh = TriangleMesh {
            x: corners.map(|p| p.x).to_vec(),
            y: corners.map(|p| p.y).to_vec(),
            z: corners.map(|p| p.z).to_vec(),
            normals: normals.to_vec(),
            uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            triangles: vec![[0, 1, 2]],
            ..TriangleMesh::default()
        };
        builder.add_mesh(mesh, materials[i % 6]).unwrap();
    }
    let mut ball = coarse_sphere(0.7);
    for (numbers, by) in [
        (&mut ball.x, shift.x),
        (&mut ball.y, shift.y),
        (&mut ball.z, shift.z),
    ] {
        for number in numbers {
            *number += by;
        }
    }
    builder.add_mesh(ball, materials[5]).unwrap();
    builder.add_sphere(shift - Vec3::X, 0.5, materials[0]).unwrap();
    builder
        .add_plane(shift - Vec3::Z * 0.7, Vec3::Z, materials[5])
        .unwrap();
    builder.finish()
}

#[test]
fn both_modes_lift_alike() {
    for (name, shift) in [
        ("wild", Vec3::ZERO),
        ("far and wild", Vec3::new(900.0, -700.0, 50.0)),
    ] {
        let scene = wild_scene(shift);
        let sameness = Sameness::of(name, &scene);
        let at = shift.as_dvec3();
        let view = View {
            eye: at + DVec3::new(2.0, -3.0, 1.5),
            target: at,
            ..View::classic(1).unwrap()
        };
        let lens = Lens {
            aperture: 0.1,
            focus: None,
        };
        for (view, samples) in [(view, 1), (View { lens, ..view }, 4)] {
            let camera = Camera::new(&view).unwrap();
            sameness.check(&camera, &sized(rounds(65, 119), rounds(43, 91), samples));
        }
    }
}

/// Scenes have them only on request, once.
#[test]
fn scenes_turn_them_on() {
    let load = |text: &str| load_from_bytes(text.as_bytes(), Path::new("a.scn"), &mut |_| Ok(Vec::new()));
    assert!(!load("sphere 0 0 0 1\n").unwrap().smooth_shadows());
    assert!(load("sphere 0 0 0 1\nsmooth_shadows\n").unwrap().smooth_shadows());
}
