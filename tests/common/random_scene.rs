//! Random scenes and rays of the kinds that break ray tracers: slivers, huge and tiny triangles, coplanar,
//! duplicated and axis-aligned ones; rays along axes, through vertices and edges, in the planes of boxes,
//! from surfaces and from far away.

use glam::Vec3;
use octray::{
    ray::{Ray, T_MAX},
    scene::{MaterialId, MeshColumns, Scene, SceneBuilder},
};

/// A small generator of our own would do as well; what matters is that a seed repeats a case.
pub type Random = fastrand::Rng;

fn signed(random: &mut Random) -> f32 {
    random.f32() * 2.0 - 1.0
}

fn anywhere(random: &mut Random) -> Vec3 {
    Vec3::new(signed(random), signed(random), signed(random))
}

/// A point on a coarse grid, so that coordinates coincide.
fn on_grid(random: &mut Random) -> Vec3 {
    (anywhere(random) * 2.0).round() * 0.5
}

fn point(random: &mut Random) -> Vec3 {
    if random.bool() {
        on_grid(random)
    } else {
        anywhere(random)
    }
}

fn corners(random: &mut Random, earlier: &[[Vec3; 3]]) -> [Vec3; 3] {
    let a = point(random);
    match random.u32(0..9) {
        // A sliver.
        0 => {
            let b = a + anywhere(random) * 2.0;
            [a, b, a + (b - a) * random.f32() + anywhere(random) * 1e-6]
        }
        // Tiny.
        1 => [a, a + anywhere(random) * 1e-4, a + anywhere(random) * 1e-4],
        // Huge.
        2 => [a, a + anywhere(random) * 1e4, a + anywhere(random) * 1e4],
        // Axis-aligned.
        3 => {
            let axis = random.usize(0..3);
            [(); 3].map(|()| {
                let mut p = point(random);
                p[axis] = a[axis];
                p
            })
        }
        // The same again, perhaps turned round.
        4 if !earlier.is_empty() => {
            let [a, b, c] = earlier[random.usize(0..earlier.len())];
            if random.bool() { [a, b, c] } else { [c, b, a] }
        }
        // A neighbour across an edge.
        5 if !earlier.is_empty() => {
            let [a, b, _] = earlier[random.usize(0..earlier.len())];
            [b, a, point(random)]
        }
        // No area.
        6 if random.u32(0..4) == 0 => [a, a + (point(random) - a) * 0.5, a],
        // Sub-pixel, far from the origin.
        7 => {
            let far = a + Vec3::splat(100.0);
            [far, far + anywhere(random) * 1e-3, far + anywhere(random) * 1e-3]
        }
        _ => [a, point(random), point(random)],
    }
}

/// A scene of `count` primitives, about a quarter of them spheres.
pub fn scene(random: &mut Random, count: usize) -> Scene {
    let scale = [1.0, 1.0, 1.0, 1e-3, 1e4][random.usize(0..5)];
    let shift = if random.u32(0..5) == 0 {
        anywhere(random) * 100.0 * scale
    } else {
        Vec3::ZERO
    };
    let mut builder = SceneBuilder::new();
    let mut triangles: Vec<[Vec3; 3]> = Vec::new();
    for _ in 0..count {
        let material = MaterialId(random.u32(0..4));
        if random.u32(0..4) == 0 {
            let radius = [1.0, 0.3, 1e-4, 1e3][random.usize(0..4)] * (random.f32() + 1e-3);
            builder
                .add_sphere(point(random) * scale + shift, radius * scale, material)
                .unwrap();
        } else {
            let corners = corners(random, &triangles);
            triangles.push(corners);
            builder
                .add_mesh(mesh(corners.map(|c| c * scale + shift)), material)
                .unwrap();
        }
    }
    for _ in 0..random.u32(0..3) {
        builder
            .add_light(anywhere(random) * 10.0 * scale + shift, random.f32())
            .unwrap();
    }
    builder.finish()
}

fn mesh(corners: [Vec3; 3]) -> MeshColumns {
    MeshColumns {
        x: corners.map(|c| c.x).to_vec(),
        y: corners.map(|c| c.y).to_vec(),
        z: corners.map(|c| c.z).to_vec(),
        normals: Vec::new(),
        triangles: vec![[0, 1, 2]],
    }
}

/// A point in or on `scene`: a vertex, a point of an edge, of a triangle, or of a sphere.
fn point_of(random: &mut Random, scene: &Scene) -> Vec3 {
    let triangles = scene.triangles().corners.len();
    let spheres = scene.spheres().radius.len();
    if triangles > 0 && (spheres == 0 || random.bool()) {
        let [a, b, c] = scene.triangle(random.usize(0..triangles));
        match random.u32(0..4) {
            0 => a,
            1 => a + (b - a) * random.f32(),
            2 => (a + b) * 0.5,
            _ => {
                let (u, v) = (random.f32(), random.f32());
                a + (b - a) * u + (c - a) * (v * (1.0 - u))
            }
        }
    } else if spheres > 0 {
        let i = random.usize(0..spheres);
        let direction = if random.bool() {
            Vec3::X
        } else {
            anywhere(random).normalize_or(Vec3::Z)
        };
        scene.spheres().center(i) + direction * scene.spheres().radius[i]
    } else {
        anywhere(random)
    }
}

/// A ray that has to do with `scene`.
pub fn ray(random: &mut Random, scene: &Scene) -> Ray {
    let size = scene.bounds().diagonal().max(1e-6);
    let target = point_of(random, scene);
    let origin = match random.u32(0..6) {
        0 => point_of(random, scene),
        1 => target + Vec3::AXES[random.usize(0..3)] * size * signed(random),
        2 => target + anywhere(random) * size * 1e3,
        3 => {
            let mut origin = anywhere(random) * size;
            let axis = random.usize(0..3);
            origin[axis] = target[axis];
            origin
        }
        _ => scene.bounds().lower + anywhere(random) * size,
    };
    let mut direction = (target - origin).normalize_or(Vec3::AXES[random.usize(0..3)]);
    if random.u32(0..8) == 0 {
        direction = Vec3::AXES[random.usize(0..3)] * if random.bool() { 1.0 } else { -1.0 };
    }
    let t_max = if random.u32(0..3) == 0 {
        (target - origin).length()
    } else {
        T_MAX
    };
    Ray {
        origin,
        direction,
        t_max,
    }
}
