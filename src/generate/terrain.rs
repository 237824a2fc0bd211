//! Mountains: a height field over a square.

use super::{
    Content, Part, Shape, classic_lights,
    mesh::{MeshBuilder, side},
    random::{Noise, lerp, smoothstep},
    view,
};
use glam::DVec3;

const HALF_WIDTH: f64 = 1.55;
const OCTAVES: u32 = 9;

pub(super) fn make(seed: u64, count: usize) -> Content {
    let noise = Noise::new(seed);
    let quads = side(count as f64 / 2.0, 1);
    let mut mesh = MeshBuilder::default();
    mesh.sheet(quads, quads, |u, v| {
        let (x, y) = (lerp(u, -HALF_WIDTH, HALF_WIDTH), lerp(v, -HALF_WIDTH, HALF_WIDTH));
        DVec3::new(x, y, height(&noise, x, y))
    });
    Content {
        parts: vec![Part {
            name: "",
            material: 1,
            shape: Shape::Mesh(mesh.finish()),
        }],
        lights: classic_lights(),
        view: view([3.3, 1.6, 1.75], [0.0, 0.0, 0.2]),
    }
}

/// Returns the height of mountains and plains, 0 to about 1.
fn height(noise: &Noise, x: f64, y: f64) -> f64 {
    let p = DVec3::new(x, y, 0.5);
    let bend = DVec3::new(noise.at(p * 1.7), noise.at(p * 1.7 + DVec3::splat(40.5)), 0.0);
    let land = smoothstep(-0.35, 0.4, noise.fractal(p * 0.8 + DVec3::splat(9.2), 3));
    let ridges = noise.ridged(p * 1.3 + bend * 0.35, OCTAVES) - 0.6;
    let hills = noise.fractal(p * 4.0, 5) * 0.04;
    (0.1 + hills + land * 0.46 * ridges).max(0.0)
}
