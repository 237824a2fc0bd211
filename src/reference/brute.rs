//! Brute force, the test oracle: tests every primitive.

use super::{RaySlabs, intersect_shape};
use crate::{
    ray::{Hit, PrimitiveId, Ray},
    scene::{Primitive, Scene, Shape},
};

/// Returns every primitive that has an area.
fn targets(scene: &Scene) -> impl Iterator<Item = (PrimitiveId, Shape)> + '_ {
    (0..scene.primitive_count() as u32)
        .map(PrimitiveId)
        .filter(|&id| match scene.primitive(id) {
            Primitive::Triangle(i) => scene.has_area(i),
            Primitive::Sphere(_) => true,
        })
        .map(|id| (id, scene.shape(id)))
}

fn nearest(targets: impl Iterator<Item = (PrimitiveId, Shape)>, ray: &Ray) -> Hit {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    targets
        .filter_map(|(id, shape)| intersect_shape(id, &shape, ray, &slabs))
        .fold(Hit::miss(ray.t_max), |best, hit| {
            if best.loses_to(hit.t, hit.primitive) {
                hit
            } else {
                best
            }
        })
}

/// Returns the closest hit; at equal t the one with the lowest id.
#[must_use]
pub fn closest_hit(scene: &Scene, ray: &Ray) -> Hit {
    nearest(targets(scene), ray)
}

/// Returns whether anything is hit before the ray's end.
#[must_use]
pub fn occluded(scene: &Scene, ray: &Ray) -> bool {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    targets(scene)
        .filter_map(|(id, shape)| intersect_shape(id, &shape, ray, &slabs))
        .any(|hit| hit.t < ray.t_max)
}

/// The shapes of a scene, collected once for many rays.
#[derive(Clone, Debug)]
pub struct Shapes(Vec<(PrimitiveId, Shape)>);

impl Shapes {
    /// Collects the shapes of `scene`.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self(targets(scene).collect())
    }

    /// Returns what [`closest_hit`] returns.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Hit {
        nearest(self.0.iter().copied(), ray)
    }
}
