//! A flat cloud of small spheres of three materials.

use super::{Content, Part, Shape, Sphere, classic_lights, random::Random, view};
use glam::DVec3;

const LOWER: DVec3 = DVec3::new(-1.5, -1.5, 0.0);
const UPPER: DVec3 = DVec3::new(1.5, 1.5, 0.9);

pub(super) fn make(seed: u64, count: usize) -> Content {
    let mut random = Random::new(seed);
    // The cloud has the same density at any count.
    let scale = libm::cbrt(100_000.0 / count as f64).min(8.0);
    let mut by_material: [Vec<Sphere>; 3] = Default::default();
    for _ in 0..count {
        let [x, y, z] = [0, 1, 2].map(|axis| random.range(LOWER[axis], UPPER[axis]));
        let radius = scale * random.range(0.004, 0.016);
        let material = (random.unit() * 3.0) as usize;
        by_material[material.min(2)].push(Sphere {
            center: DVec3::new(x, y, z).as_vec3(),
            radius: radius as f32,
        });
    }
    let mut material = 0;
    let parts = by_material
        .map(|spheres| {
            material += 1;
            Part {
                name: "spheres",
                material,
                shape: Shape::Spheres(spheres),
            }
        })
        .into();
    Content {
        parts,
        lights: classic_lights(),
        view: view([3.6, 1.7, 2.4], [0.0, 0.0, 0.35]),
    }
}
