//! A ring of displaced spheres with triangles smaller than pixels.

use super::{
    Content, Part, Shape, classic_lights,
    mesh::{MeshBuilder, on_sphere, side},
    random::{Noise, Random},
    view,
};
use glam::DVec3;
use std::f64::consts::TAU;

const BLOBS: usize = 12;
const RING_RADIUS: f64 = 1.15;
const BLOB_RADIUS: f64 = 0.3;

pub(super) fn make(seed: u64, count: usize) -> Content {
    let mut random = Random::new(seed);
    // 2 around (rows - 1) triangles a blob, around = 2 rows.
    let rows = side(count as f64 / (4.0 * BLOBS as f64), 4);
    let mut mesh = MeshBuilder::default();
    for i in 0..BLOBS {
        let noise = Noise::new(seed.wrapping_mul(31).wrapping_add(i as u64));
        let (sin, cos) = libm::sincos(TAU * i as f64 / BLOBS as f64);
        let rise = if i % 2 == 0 { 0.3 } else { 0.62 };
        let center = DVec3::new(RING_RADIUS * cos, RING_RADIUS * sin, rise);
        let grain = random.range(1.2, 2.6);
        mesh.closed(2 * rows, rows, |u, v| {
            let direction = on_sphere(u, v);
            let swell = 0.24 * noise.fractal(direction * grain, 6);
            center + direction * (BLOB_RADIUS * (1.0 + swell))
        });
    }
    Content {
        parts: vec![Part {
            name: "",
            material: 2,
            shape: Shape::Mesh(mesh.finish()),
        }],
        lights: classic_lights(),
        view: view([3.3, 1.6, 2.7], [0.0, 0.0, 0.38]),
    }
}
