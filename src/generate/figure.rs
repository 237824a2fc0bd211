//! A draped statue on a slab, one closed smooth surface: many small triangles in a part of the picture, like a scan.

use super::{
    Content, Part, Shape, classic_lights,
    mesh::{MeshBuilder, side},
    random::{Noise, Random, smoothstep},
    view,
};
use glam::DVec3;
use std::f64::consts::TAU;

/// Height and radius of the figure from foot to head.
const PROFILE: [[f64; 2]; 14] = [
    [0.00, 0.0],
    [0.00, 0.30],
    [0.06, 0.37],
    [0.25, 0.31],
    [0.50, 0.24],
    [0.66, 0.21],
    [0.85, 0.27],
    [0.98, 0.27],
    [1.07, 0.13],
    [1.12, 0.09],
    [1.19, 0.13],
    [1.30, 0.15],
    [1.40, 0.10],
    [1.43, 0.0],
];

pub(super) fn make(seed: u64, count: usize) -> Content {
    let mut random = Random::new(seed);
    let noise = Noise::new(seed);
    let twist = random.range(-1.2, 1.2);
    let folds = 9.0 + (random.unit() * 5.0).floor();
    let lean = random.range(-0.08, 0.08);

    // The slab has 12 triangles; the figure has 2 around (rows - 1), around = 5/4 rows.
    let rows = side((count as f64 - 12.0) / 2.5, 8);
    let mut figure = MeshBuilder::default();
    figure.closed(rows * 5 / 4, rows, |u, v| {
        let [z, radius] = profile(1.0 - v);
        let robe = 1.0 - smoothstep(0.55, 1.0, z);
        let angle = TAU * u;
        let fold = libm::sin(folds * (angle + twist * z)) * 0.5 + libm::sin(2.0 * angle + 3.0 * z) * 0.5;
        let (sin, cos) = libm::sincos(angle);
        let position = DVec3::new(radius * cos, radius * sin, z);
        let rough = noise.fractal(position * 3.0, 6) * (0.05 + 0.12 * robe);
        let r = radius * (1.0 + 0.16 * fold * robe + rough);
        // Wider than deep, and twisted about the vertical axis.
        let (x, y) = (r * cos * 1.15, r * sin * 0.85);
        let (sin_t, cos_t) = libm::sincos(twist * 0.7 * z);
        DVec3::new(x * cos_t - y * sin_t + lean * z, x * sin_t + y * cos_t, z)
    });

    let mut slab = MeshBuilder::default();
    slab.cuboid(DVec3::new(-1.4, -1.4, -0.25), DVec3::new(1.4, 1.4, 0.0));
    Content {
        parts: vec![
            Part {
                name: "slab",
                material: 3,
                shape: Shape::Mesh(slab.finish()),
            },
            Part {
                name: "",
                material: 1,
                shape: Shape::Mesh(figure.finish()),
            },
        ],
        lights: classic_lights(),
        view: view([3.2, -1.6, 1.7], [0.0, 0.0, 0.62]),
    }
}

/// Returns height and radius at `t` in [0, 1]: a Catmull-Rom spline through [`PROFILE`].
fn profile(t: f64) -> [f64; 2] {
    let last = PROFILE.len() - 1;
    let s = t * last as f64;
    let i = (s.floor() as usize).min(last - 1);
    let f = s - i as f64;
    let point = |k: usize| PROFILE[k.min(last)];
    let (p0, p1, p2, p3) = (point(i.saturating_sub(1)), point(i), point(i + 1), point(i + 2));
    let blend = |axis: usize| {
        let (a, b, c, d) = (p0[axis], p1[axis], p2[axis], p3[axis]);
        let bend = (2.0 * a - 5.0 * b + 4.0 * c - d) + (3.0 * b - a - 3.0 * c + d) * f;
        b + 0.5 * f * (c - a + f * bend)
    };
    // The spline may overshoot the ends.
    [blend(0).max(0.0), blend(1).max(0.0)]
}
