//! Thin pipes at random angles in a box: long thin triangles, whose loose bounding boxes make rays test many of them.

use super::{Content, Part, Shape, classic_lights, mesh::MeshBuilder, random::Random, view};
use glam::DVec3;
use std::f64::consts::TAU;

/// Sides of a pipe, two triangles each.
const SIDES: usize = 24;
/// Triangles of a pipe, which is open at both ends.
pub(super) const TRIANGLES_PER_PIPE: usize = 2 * SIDES;

const LOWER: DVec3 = DVec3::new(-1.0, -1.0, 0.2);
const UPPER: DVec3 = DVec3::new(1.0, 1.0, 1.6);
/// Range of lengths, scene units.
const LENGTHS: [f64; 2] = [0.2, 1.0];
/// Range of radii, scene units.
const RADII: [f64; 2] = [0.002, 0.01];

pub(super) fn make(seed: u64, count: usize) -> Content {
    let mut random = Random::new(seed);
    let mut mesh = MeshBuilder::default();
    for _ in 0..count / TRIANGLES_PER_PIPE {
        let center = DVec3::from_array([0, 1, 2].map(|axis| random.range(LOWER[axis], UPPER[axis])));
        let along = random.direction();
        let (across, over) = along.any_orthonormal_pair();
        let length = random.range(LENGTHS[0], LENGTHS[1]);
        let radius = random.range(RADII[0], RADII[1]);
        mesh.tube(SIDES, 1, |u, v| {
            let (sin, cos) = libm::sincos(TAU * u);
            center + along * ((v - 0.5) * length) + (across * cos + over * sin) * radius
        });
    }
    Content {
        parts: vec![Part {
            name: "",
            material: 2,
            shape: Shape::Mesh(mesh.finish()),
        }],
        lights: classic_lights(),
        view: view([3.4, 1.6, 2.6], [0.0, 0.0, 0.85]),
    }
}
