//! The oracle: every primitive is tested.

use super::{RaySlabs, intersect_shape};
use crate::{
    ray::{Hit, PrimitiveId, Ray},
    scene::{Primitive, Scene},
};

fn candidates<'a>(scene: &'a Scene, ray: &'a Ray) -> impl Iterator<Item = Hit> + 'a {
    let slabs = RaySlabs::new(ray);
    (0..scene.primitive_count() as u32)
        .map(PrimitiveId)
        .filter_map(move |id| {
            if let Primitive::Triangle(i) = scene.primitive(id)
                && !scene.has_area(i)
            {
                return None;
            }
            intersect_shape(id, &scene.shape(id), ray, &slabs)
        })
}

/// The nearest hit; of several equally near, the one with the lowest id.
#[must_use]
pub fn closest_hit(scene: &Scene, ray: &Ray) -> Hit {
    candidates(scene, ray).fold(Hit::miss(ray.t_max), |best, hit| {
        if best.loses_to(hit.t, hit.primitive) {
            hit
        } else {
            best
        }
    })
}

/// Whether anything is hit before the ray's end.
#[must_use]
pub fn occluded(scene: &Scene, ray: &Ray) -> bool {
    candidates(scene, ray).any(|hit| hit.t < ray.t_max)
}
