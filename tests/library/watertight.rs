//! Watertightness: every ray from inside a closed mesh hits it, at edges and vertices too.
//!
//! `OCTRAY_LONG=1` traces hundreds of times as many rays.

use crate::long::rounds;
use glam::{DVec3, Mat3, Vec3};
use octray::{
    Level,
    accel::{BuildQuality, Bvh, Layout},
    lanes::{F32x8, LANES},
    ray::{HitPacket, Ray, RayPackets},
    reference::brute,
    scene::{Scene, SceneBuilder, Transform, TriangleMesh},
    trace::{BUNDLE, Method, Tracer},
    verify::Random,
};

/// Bundles of rays in each mesh: a tracer of each lower level gets one of either kind, shared origins and separate ones.
const BUNDLES: usize = 12;

/// A closed mesh: corners and the triangles that index them.
struct Closed {
    corners: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

fn octahedron() -> Closed {
    let corners = vec![Vec3::X, -Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z, -Vec3::Z];
    let triangles = vec![
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    Closed { corners, triangles }
}

/// The cube from -1 to 1.
fn cube() -> Closed {
    let corner = |i: u32| Vec3::from([0, 1, 2].map(|axis| (i >> axis & 1) as f32 * 2.0 - 1.0));
    let sides = [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ];
    Closed {
        corners: (0..8).map(corner).collect(),
        triangles: sides
            .into_iter()
            .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

/// A cube whose sides are fans around a point close to a corner, so that each has a needle.
fn needles(share: f32) -> Closed {
    let mut mesh = cube();
    let mut triangles = Vec::new();
    for pair in mesh.triangles.chunks(2) {
        let ([a, b, c], [_, _, d]) = (pair[0], pair[1]);
        let middle = mesh.corners.len() as u32;
        let (from, to) = (mesh.corners[b as usize], mesh.corners[d as usize]);
        mesh.corners.push(from + (to - from) * share);
        triangles.extend([[a, b, middle], [b, c, middle], [c, d, middle], [d, a, middle]]);
    }
    mesh.triangles = triangles;
    mesh
}

/// Each triangle in four, new corners moved by `place`.
fn subdivided(mesh: &Closed, place: impl Fn(Vec3) -> Vec3) -> Closed {
    let mut corners = mesh.corners.clone();
    let mut middles = std::collections::HashMap::new();
    let mut triangles = Vec::new();
    for &[a, b, c] in &mesh.triangles {
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                corners.push(place((corners[a as usize] + corners[b as usize]) * 0.5));
                corners.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    Closed { corners, triangles }
}

/// A scene of the mesh. `split`: each triangle has corners of its own, as many files store them.
fn scene(mesh: &Closed, split: bool, place: impl Fn(Vec3) -> Vec3) -> Scene {
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    builder.add_mesh(arrays(mesh, split, place), material).unwrap();
    builder.finish()
}

/// The mesh in place, and as an instance, once the only one and once among others.
fn instanced(mesh: &Closed, split: bool, transform: &Transform) -> (Scene, [Scene; 2]) {
    let mut builder = SceneBuilder::new();
    let material = builder.classic_material(1).unwrap();
    let mut placed = arrays(mesh, split, |p| p);
    transform.apply(&mut placed);
    builder.add_mesh(placed, material).unwrap();
    let instanced = [0, 20].map(|others| {
        let mut builder = SceneBuilder::new();
        let stored = builder.add_prototype(|builder| builder.add_mesh(arrays(mesh, split, |p| p), material));
        let stored = stored.unwrap();
        builder.add_instance(stored, transform).unwrap();
        for i in 0..others {
            let aside = transform.then_translate(DVec3::new(3.0, 1.0, -2.0) * f64::from(i - 10));
            builder.add_instance(stored, &aside).unwrap();
        }
        builder.finish()
    });
    (builder.finish(), instanced)
}

fn arrays(mesh: &Closed, split: bool, place: impl Fn(Vec3) -> Vec3) -> TriangleMesh {
    let corners: Vec<Vec3> = mesh.corners.iter().map(|&c| place(c)).collect();
    let (corners, triangles) = if split {
        let all = mesh
            .triangles
            .iter()
            .flatten()
            .map(|&i| corners[i as usize])
            .collect::<Vec<_>>();
        let triangles = (0..mesh.triangles.len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect();
        (all, triangles)
    } else {
        (corners, mesh.triangles.clone())
    };
    let column = |axis: usize| corners.iter().map(|c| c[axis]).collect();
    TriangleMesh {
        x: column(0),
        y: column(1),
        z: column(2),
        triangles,
        ..TriangleMesh::default()
    }
}

/// A target for rays: a vertex, the middle of an edge, a point of an edge or of a triangle.
fn target_point(random: &mut Random, scene: &Scene) -> Vec3 {
    let [a, b, c] = scene.triangle(random.index(scene.triangles().corners.len()));
    match random.below(4) {
        0 => a,
        1 => (a + b) * 0.5,
        2 => a + (b - a) * random.unit(),
        _ => a + ((b - a) * random.unit() + (c - a) * random.unit()) * 0.5,
    }
}

fn shoot(random: &mut Random, name: &str, scene: &Scene, center: Vec3, size: f32, bundles: usize) {
    shoot_at(random, name, (scene, scene), (center, size), bundles);
}

/// The same at points of the mesh that is `placed`.
fn shoot_at(
    random: &mut Random,
    name: &str,
    (scene, placed): (&Scene, &Scene),
    (center, size): (Vec3, f32),
    bundles: usize,
) {
    let layout = random.pick(&[Layout::Whole, Layout::Indexed]);
    let bvh = Bvh::build_as(scene, BuildQuality::Best, layout);
    let center = center - scene.origin();
    let moved = placed.origin() - scene.origin();
    // The methods at the best level, and another one at each lower level; bundles of either kind take these in turn.
    let methods = [Method::Adaptive, Method::Packet, Method::Single];
    let mut tracers = methods.map(|method| Tracer::with_method(&bvh, method).with_instances(scene));
    let mut lower: Vec<Tracer> = Level::all()
        .rev()
        .skip(1)
        .flat_map(|level| {
            methods.map(|method| {
                Tracer::with_method(&bvh, method)
                    .at_level(level)
                    .with_instances(scene)
            })
        })
        .collect();
    for bundle in 0..bundles {
        let shared = bundle % 2 == 0;
        let inside = |random: &mut Random| {
            center + Vec3::new(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5) * size
        };
        let origin = inside(random);
        let near = moved + target_point(random, placed);
        let mut rays = RayPackets::default();
        rays.restart(Some(origin).filter(|_| shared));
        for _ in 0..BUNDLE {
            rays.push_rays(&std::array::from_fn(|_| {
                let origin = if shared { origin } else { inside(random) };
                let target = if random.one_in(2) {
                    near
                } else {
                    moved + target_point(random, placed)
                };
                Ray::new(origin, (target - origin).normalize())
            }));
        }
        let count = lower.len().max(1);
        let in_turn = lower.iter_mut().skip(bundle / 2 % count).take(1);
        for tracer in tracers.iter_mut().chain(in_turn) {
            let mut hits = vec![HitPacket::miss(F32x8::ZERO); BUNDLE];
            tracer.closest_hit(rays.origins(), rays.packets(), &mut hits);
            for (packet_i, hits) in hits.iter().enumerate() {
                for lane in 0..LANES {
                    let (ray, hit) = (rays.ray(packet_i, lane), hits.hit(lane));
                    assert!(
                        hit.is_hit(),
                        "{name}: {ray:?} leaves the mesh; brute force: {:?}",
                        brute::closest_hit(scene, &ray)
                    );
                }
            }
        }
    }
}

#[test]
fn no_ray_leaves_a_closed_mesh() {
    let bundles = rounds(BUNDLES, 20_000);
    let mut random = Random::new(7, 0);
    let turn = Mat3::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    for size in [10.0, 1e3, 1e5] {
        // Edges much longer than their distance: seen from between the ends, their sum is almost 0.
        let wide = |p: Vec3| p * Vec3::new(size, size, 0.5);
        let as_is = scene(&cube(), false, wide);
        shoot(&mut random, "wide", &as_is, Vec3::ZERO, 0.5, bundles);
        let turned = scene(&cube(), false, |p| turn * wide(p));
        shoot(&mut random, "wide, turned", &turned, Vec3::ZERO, 0.5, bundles);
    }
    for (share, size) in [(1e-6, 100.0), (1e-5, 1e3), (1e-4, 1e3)] {
        let needles = scene(&needles(share), false, |p| {
            turn * (p * Vec3::new(size, size, 1.0))
        });
        shoot(&mut random, "needles", &needles, Vec3::ZERO, 1.0, bundles);
    }
    let mut mesh = octahedron();
    for level in 0..5 {
        for split in [false, true] {
            let name = |what| format!("{what}, level {level}, split {split}");
            let as_is = scene(&mesh, split, |p| p);
            shoot(&mut random, &name("octahedron"), &as_is, Vec3::ZERO, 0.5, bundles);
            let turned = scene(&mesh, split, |p| turn * p);
            shoot(&mut random, &name("turned"), &turned, Vec3::ZERO, 0.5, bundles);
            let flat = scene(&mesh, split, |p| turn * (p * Vec3::new(1.0, 1e-3, 1.0)));
            shoot(&mut random, &name("flat"), &flat, Vec3::ZERO, 1e-4, bundles);
            let shift = Vec3::new(1e3, -2e3, 5e2);
            let far = scene(&mesh, split, |p| p + shift);
            shoot(&mut random, &name("far"), &far, shift, 0.5, bundles);
            let tiny = scene(&mesh, split, |p| turn * p * 1e-4);
            shoot(&mut random, &name("tiny"), &tiny, Vec3::ZERO, 5e-5, bundles);
        }
        mesh = subdivided(&mesh, Vec3::normalize);
    }
}

#[test]
fn no_ray_leaves_a_closed_instance() {
    let bundles = rounds(BUNDLES, 6_000);
    let mut random = Random::new(9, 0);
    let none = Transform::IDENTITY;
    let turned = none.then_rotate(DVec3::new(1.0, 2.0, 3.0), 40.0);
    let far = DVec3::new(1e3, -2e3, 5e2);
    let needles = needles(1e-4);
    let wide = turned
        .then_scale(DVec3::new(1e3, 1e3, 0.5))
        .then_transform(&turned);
    for &level in rounds(&[0, 1, 4][..], &[0, 1, 2, 3, 4]) {
        let mesh = (0..level).fold(octahedron(), |mesh, _| subdivided(&mesh, Vec3::normalize));
        for (name, transform, center, size) in [
            ("as it is", none, DVec3::ZERO, 0.5),
            ("turned", turned, DVec3::ZERO, 0.5),
            ("mirrored", turned.then_scale(DVec3::NEG_ONE), DVec3::ZERO, 0.5),
            (
                "flat",
                none.then_scale(DVec3::new(1.0, 1e-3, 1.0))
                    .then_transform(&turned),
                DVec3::ZERO,
                1e-4,
            ),
            ("far", turned.then_translate(far), far, 0.5),
            ("tiny", turned.then_scale(DVec3::splat(1e-6)), DVec3::ZERO, 5e-7),
            ("huge", turned.then_scale(DVec3::splat(1e6)), DVec3::ZERO, 5e5),
        ] {
            let (placed, instanced) = instanced(&mesh, level % 2 == 0, &transform);
            for scene in &instanced {
                let name = format!("{name}, level {level}, {} instances", scene.instances().len());
                let inside = (center.as_vec3(), size);
                shoot_at(&mut random, &name, (scene, &placed), inside, bundles);
            }
        }
    }
    for (name, mesh) in [("needles", &needles), ("wide", &cube())] {
        let (placed, instanced) = instanced(mesh, false, &wide);
        for scene in &instanced {
            shoot_at(&mut random, name, (scene, &placed), (Vec3::ZERO, 0.05), bundles);
        }
    }
}
