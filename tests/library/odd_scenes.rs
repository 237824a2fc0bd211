//! Degenerate scenes: empty, coplanar or coincident primitives, very small, very large, eyes and lights exactly on
//! surfaces. They build quickly, and packets and the scalar reference draw the same picture.

use glam::{DVec3, Vec3};
use octray::{
    Level,
    accel::{BuildQuality, Bvh},
    lanes::{F32x8, LANES},
    ray::{HitPacket, Ray, RayPackets},
    render::{Mode, Settings, render},
    scene::{Camera, MaterialId, Scene, SceneBuilder, TriangleMesh},
    trace::{Method, Tracer},
};
use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

const MIRROR: MaterialId = MaterialId(3);

/// Mirrors, all scaled by `scale`.
fn scene(scale: f32, spheres: &[(Vec3, f32)], triangles: &[[Vec3; 3]], lights: &[Vec3]) -> Scene {
    let mut builder = SceneBuilder::new();
    for &light in lights {
        builder.add_light(light * scale, 0.5).expect("a light");
    }
    let corners = || triangles.as_flattened().iter().map(|&corner| corner * scale);
    let mesh = TriangleMesh {
        x: corners().map(|corner| corner.x).collect(),
        y: corners().map(|corner| corner.y).collect(),
        z: corners().map(|corner| corner.z).collect(),
        normals: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: (0..triangles.len() as u32)
            .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
            .collect(),
    };
    builder.add_mesh(mesh, MIRROR).expect("a mesh");
    for &(center, radius) in spheres {
        builder
            .add_sphere(center * scale, radius * scale, MIRROR)
            .expect("a sphere");
    }
    builder.finish()
}

fn camera(eye: DVec3, target: DVec3) -> Camera {
    Camera::look_at(eye, target, DVec3::new(0.1, 0.2, 1.0), 45.0).expect("a camera")
}

fn check(name: &str, scene: &Scene, camera: &Camera) {
    let bvh = Bvh::build(scene);
    let film = |mode| {
        let settings = Settings {
            width: 67,
            height: 45,
            mode,
            threads: Some(1),
            ..Settings::default()
        };
        let frame = render(scene, &bvh, camera, &settings, &|_| ControlFlow::Continue(()));
        frame.unwrap_or_else(|error| panic!("{name}: {error}")).film
    };
    let (packets, scalar) = (film(Mode::Packet), film(Mode::Scalar));
    for (i, (a, b)) in packets.pixels().iter().zip(scalar.pixels()).enumerate() {
        assert_eq!(
            a.map(f32::to_bits),
            b.map(f32::to_bits),
            "{name}: pixel {i}: {a:?} and {b:?}"
        );
    }
}

/// Random triangles from -1 to 1, the same in every call. `flat`: all in the plane z = 0.
fn soup(count: usize, flat: bool) -> Vec<[Vec3; 3]> {
    let mut random = fastrand::Rng::with_seed(9);
    let mut coordinate = || random.f32() * 2.0 - 1.0;
    (0..count)
        .map(|_| {
            [(); 3].map(|()| Vec3::new(coordinate(), coordinate(), if flat { 0.0 } else { coordinate() }))
        })
        .collect()
}

#[test]
fn both_modes_draw_the_same_picture() {
    let light = [Vec3::new(9.0, -4.0, 10.0)];
    let ball = [(Vec3::new(0.0, 0.0, 0.5), 0.5)];
    let eye = camera(DVec3::new(3.0, 1.5, 1.2), DVec3::ZERO);
    let equal = vec![soup(1, false)[0]; 200];
    let shells: Vec<_> = (0..200).map(|i| (Vec3::ZERO, 0.5 + i as f32 * 1e-6)).collect();
    for (name, scene) in [
        ("nothing", scene(1.0, &[], &[], &[])),
        ("light alone", scene(1.0, &[], &[], &light)),
        ("a sphere without light", scene(1.0, &ball, &[], &[])),
        ("a sphere", scene(1.0, &ball, &[], &light)),
        ("equal triangles", scene(1.0, &[], &equal, &light)),
        ("equal spheres", scene(1.0, &[ball[0]; 200], &[], &light)),
        ("concentric spheres", scene(1.0, &shells, &[], &light)),
        ("coplanar", scene(1.0, &ball, &soup(200, true), &light)),
        (
            "light on a surface and in a corner",
            scene(1.0, &ball, &soup(9, false), &[Vec3::Z, soup(1, false)[0][0]]),
        ),
    ] {
        check(name, &scene, &eye);
        // In the plane z = 0, inside the sphere, on the sphere.
        for (x, y, z) in [(3.0, 0.1, 0.0), (0.1, 0.2, 0.4), (0.0, 0.0, 1.0)] {
            check(
                name,
                &scene,
                &camera(DVec3::new(x, y, z), DVec3::new(0.3, 0.0, 0.0)),
            );
        }
    }
    for scale in [1e-18, 1e-10, 1e-5, 1e3, 1e6, 1e8] {
        let scene = scene(scale, &ball, &soup(100, false), &[Vec3::new(9.0, -4.0, 9.0)]);
        let eye = DVec3::new(3.0, 1.5, 1.2) * f64::from(scale);
        check(&format!("scale {scale:e}"), &scene, &camera(eye, DVec3::ZERO));
    }
}

/// PLOC merges clusters that are each other's nearest neighbours. At equal distances all clusters choose the same side:
/// one pair merges per round, the time is quadratic and the tree becomes a chain.
#[test]
fn many_equal_primitives_build_quickly() {
    let limit = Duration::from_secs(5);
    let count = 20_000;
    let equal_spheres = vec![(Vec3::ZERO, 1.0); count];
    let concentric: Vec<_> = (0..count).map(|i| (Vec3::ZERO, 1.0 + i as f32 * 1e-4)).collect();
    let row: Vec<_> = (0..count).map(|i| (Vec3::X * i as f32, 0.25)).collect();
    let triangle = soup(1, false)[0];
    for (name, scene) in [
        (
            "equal triangles",
            scene(1.0, &[], &vec![triangle; 1_000_000], &[]),
        ),
        ("equal spheres", scene(1.0, &equal_spheres, &[], &[])),
        ("concentric spheres", scene(1.0, &concentric, &[], &[])),
        ("a row of spheres", scene(1.0, &row, &[], &[])),
    ] {
        for quality in [BuildQuality::Fast, BuildQuality::Best, BuildQuality::Ploc] {
            let start = Instant::now();
            let depth = Bvh::build_with(&scene, quality).stats().depth;
            let took = start.elapsed();
            println!("{name}, {}: {took:?}, depth {depth}", quality.name());
            assert!(took < limit, "{name}, {}: {took:?}", quality.name());
            assert!(depth < 64, "{name}, {}: depth {depth}", quality.name());
        }
    }
}

/// From so far away that products overflow, along a line exactly through the scene's centre: every tracing method finds what
/// single rays find.
#[test]
fn origins_at_the_end_of_all_numbers() {
    let mut random = fastrand::Rng::with_seed(31);
    let mut unit = move || random.f32() * 2.0 - 1.0;
    let mut vector = move || Vec3::new(unit(), unit(), unit());
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    let edge_on = [[0.0, 1e8, 0.0], [-7e8, -1e8, 7e8], [7e8, -1e8, -7e8]];
    builder.add_triangle(edge_on.map(Vec3::from), material).unwrap();
    for i in 0..200 {
        let size = [1.0, 1e3, 1e6, 1e8][i % 4];
        let corners = [(); 3].map(|()| vector() * size);
        builder.add_triangle(corners, material).unwrap();
    }
    builder.add_sphere(Vec3::ZERO, 1e3, material).unwrap();
    let scene = builder.finish();
    let bvh = Bvh::build(&scene);
    let mut hits_found = 0;
    for round in 0..32 {
        let way = if round % 3 == 0 {
            Vec3::new(0.577, 0.578, 0.577)
        } else {
            vector()
        };
        let direction = way.normalize();
        let far = 2_f32.powi([20, 50, 70, 85, 97, 110, 120, 126][round % 8]);
        let origin = -direction * far - scene.origin();
        let shared = round % 2 == 0;
        let mut rays = RayPackets::default();
        rays.restart(Some(origin).filter(|_| shared));
        for packet in 0..16 {
            rays.push_rays(&std::array::from_fn(|lane| {
                if (packet + lane) % 3 == 0 {
                    return Ray::new(origin, direction);
                }
                Ray::new(origin, (direction + vector() * 1e-6).normalize())
            }));
        }
        let traced = |method, level: Level| {
            let mut tracer = Tracer::with_method(&bvh, method).at_level(level);
            let count = rays.packets().len();
            let (mut hits, mut blocked) = (vec![HitPacket::miss(F32x8::ZERO); count], vec![0; count]);
            tracer.closest_hit(rays.origins(), rays.packets(), &mut hits);
            tracer.occluded(rays.origins(), rays.packets(), &mut blocked);
            let hits: Vec<_> = hits
                .iter()
                .flat_map(|hits| (0..LANES).map(|lane| hits.hit(lane)))
                .collect();
            (hits, blocked)
        };
        let expected = traced(Method::Single, Level::PORTABLE);
        hits_found += expected.0.iter().filter(|hit| hit.is_hit()).count();
        for level in Level::all() {
            for method in [Method::Adaptive, Method::Packet, Method::Single] {
                let found = traced(method, level);
                assert!(
                    found == expected,
                    "{method:?} {level} from {origin} along {direction}"
                );
            }
        }
    }
    assert!(hits_found > 60, "{hits_found}");
}
