//! A sphere flake on a square floor: every sphere has nine children of a third of its radius, six around its equator and
//! three above (after Haines, *A Proposal for Standard Graphics Environments*, 1987).

use super::{Content, Part, Shape, Sphere, classic_lights, mesh::MeshBuilder, random::Random, view};
use glam::DVec3;
use std::f64::consts::TAU;

const CHILDREN: usize = 9;
const RATIO: f64 = 1.0 / 3.0;
const ROOT_RADIUS: f64 = 0.42;
const ROOT_CENTER: DVec3 = DVec3::new(0.0, 0.0, 0.72);
const FLOOR_HALF_WIDTH: f64 = 1.8;

/// A sphere and the direction in which it grows.
#[derive(Clone, Copy)]
struct Bud {
    center: DVec3,
    radius: f64,
    axis: DVec3,
}

impl Bud {
    /// Returns child `i` of nine; `turn` rotates all of them about the axis.
    fn child(&self, i: usize, turn: f64) -> Self {
        let (angle, height) = if i < 6 {
            (i as f64 / 6.0, 0.0)
        } else {
            // The height at which the three touch neither the six nor each other.
            ((i as f64 - 6.0) / 3.0 + 1.0 / 12.0, 0.816_496_580_927_726)
        };
        let (sin, cos) = libm::sincos(TAU * (angle + turn));
        let (right, forward) = self.axis.any_orthonormal_pair();
        let level = (1.0_f64 - height * height).sqrt();
        let axis = (right * cos + forward * sin) * level + self.axis * height;
        let radius = self.radius * RATIO;
        Self {
            center: self.center + axis * (self.radius + radius),
            radius,
            axis,
        }
    }
}

pub(super) fn make(seed: u64, count: usize) -> Content {
    let mut random = Random::new(seed);
    let mut buds = vec![Bud {
        center: ROOT_CENTER,
        radius: ROOT_RADIUS,
        axis: DVec3::Z,
    }];
    buds.reserve(count);
    let mut parents = 0..1;
    while buds.len() < count {
        // The whole next level, or the rest of the count spread evenly over the parents.
        let level = (parents.len() * CHILDREN).min(count - buds.len());
        let turn = random.unit();
        for (i, parent_i) in parents.clone().enumerate() {
            let parent = buds[parent_i];
            let due = |parents_done: usize| level * parents_done / parents.len();
            for child_i in 0..due(i + 1) - due(i) {
                buds.push(parent.child(child_i, turn));
            }
        }
        parents = parents.end..buds.len();
    }
    let spheres = buds
        .iter()
        .map(|bud| Sphere {
            center: bud.center.as_vec3(),
            radius: bud.radius as f32,
        })
        .collect();
    Content {
        parts: vec![
            Part {
                name: "",
                material: 1,
                shape: Shape::Mesh(floor()),
            },
            Part {
                name: "spheres",
                material: 3,
                shape: Shape::Spheres(spheres),
            },
        ],
        lights: classic_lights(),
        view: view([3.0, 1.5, 2.0], [0.0, 0.0, 0.5]),
    }
}

fn floor() -> crate::scene::TriangleMesh {
    let mut mesh = MeshBuilder::default();
    let w = FLOOR_HALF_WIDTH;
    mesh.quad([(-w, -w), (w, -w), (w, w), (-w, w)].map(|(x, y)| DVec3::new(x, y, -0.15)));
    mesh.finish()
}
