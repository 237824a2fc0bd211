//! One ray per call: [`Geometry::closest_hit`] and [`Geometry::occluded`] against Embree's `rtcIntersect1` and
//! `rtcOccluded1`, alternating.

use octray::{
    Geometry, Level, Ray,
    bench::{Kind, RaySet},
    scene::Scene,
};
use std::time::Instant;

/// The scene's triangles as a geometry, and a set of rays.
pub struct Single {
    geometry: Geometry,
    rays: Vec<Ray>,
    kind: Kind,
}

impl Single {
    /// `None` for a scene with spheres, which Embree may have as its own.
    pub fn new(scene: &Scene, set: &RaySet, level: Level) -> Option<Self> {
        if !scene.spheres().radius.is_empty() {
            return None;
        }
        let vertices = scene.vertices();
        let positions: Vec<[f32; 3]> = (0..vertices.x.len())
            .map(|i| vertices.position(i as u32).to_array())
            .collect();
        let geometry = Geometry::from_triangles(&positions, &scene.triangles().corners).ok()?;
        let mut rays = Vec::new();
        for (_, group) in &set.groups {
            for packet_i in 0..group.packets().len() {
                for lane in 0..8 {
                    let ray = group.ray(packet_i, lane);
                    if ray.t_max > 0.0 {
                        rays.push(Ray {
                            t_max: ray.t_max,
                            ..Ray::new(ray.origin, ray.direction)
                        });
                    }
                }
            }
        }
        Some(Self {
            geometry: geometry.at_level(level),
            rays,
            kind: set.kind,
        })
    }

    /// Seconds for the set.
    pub fn time(&self) -> f64 {
        let start = Instant::now();
        let found = if self.kind.is_any_hit() {
            self.rays.iter().filter(|ray| self.geometry.occluded(ray)).count()
        } else {
            let hits = self.rays.iter().filter_map(|ray| self.geometry.closest_hit(ray));
            hits.count()
        };
        std::hint::black_box(found);
        start.elapsed().as_secs_f64()
    }
}
