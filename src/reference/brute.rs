//! Brute force, the test oracle: tests every primitive. Rays pass where surfaces are cut out.

use super::{RaySlabs, counts, intersect_shape, planes};
use crate::{
    ray::{Hit, PrimitiveId, Ray},
    scene::{Primitive, Scene, Shape},
    simd::{Level, Simd, at_level},
};

/// Returns every primitive that has an area.
pub(super) fn targets(scene: &Scene) -> impl Iterator<Item = (PrimitiveId, Shape)> + '_ {
    (0..scene.primitive_count() as u32)
        .map(PrimitiveId)
        .filter(|&id| match scene.primitive(id) {
            Primitive::Triangle(i) => scene.has_area(i),
            Primitive::Sphere(_) | Primitive::Plane(_) => true,
        })
        .map(|id| (id, scene.shape(id)))
}

#[inline(always)]
pub(super) fn nearest<S: Simd>(
    simd: S,
    targets: impl Iterator<Item = (PrimitiveId, Shape)>,
    ray: &Ray,
    cut_outs: Option<&Scene>,
) -> Hit {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut best = Hit::miss(ray.t_max);
    for (id, shape) in targets {
        if let Some(hit) = intersect_shape(simd, id, &shape, ray, &slabs)
            && best.loses_to(hit.t, id)
            && counts(cut_outs, &hit)
        {
            best = hit;
        }
    }
    best
}

/// Returns the closest hit; at equal t the one with the lowest id.
#[must_use]
pub fn closest_hit(scene: &Scene, ray: &Ray) -> Hit {
    at_level!(Level::current(), |simd| {
        let best = nearest(simd, targets(scene), ray, Some(scene));
        planes::closest(simd, scene, ray, best)
    })
}

/// Returns whether anything is hit before the ray's end.
#[must_use]
pub fn occluded(scene: &Scene, ray: &Ray) -> bool {
    at_level!(Level::current(), |simd| any(simd, scene, ray))
}

#[inline(always)]
pub(super) fn any<S: Simd>(simd: S, scene: &Scene, ray: &Ray) -> bool {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    for (id, shape) in targets(scene) {
        let hit = intersect_shape(simd, id, &shape, ray, &slabs);
        if hit.is_some_and(|hit| hit.t < ray.t_max && counts(Some(scene), &hit)) {
            return true;
        }
    }
    planes::block(simd, scene, ray)
}

/// Returns all hits of triangles and spheres before the ray's end, by id; a sphere's nearest alone.
#[must_use]
pub fn all_hits(scene: &Scene, ray: &Ray) -> Vec<Hit> {
    at_level!(Level::current(), |simd| all(simd, scene, ray))
}

#[inline(always)]
fn all<S: Simd>(simd: S, scene: &Scene, ray: &Ray) -> Vec<Hit> {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut hits = Vec::new();
    for (id, shape) in targets(scene) {
        if let Some(hit) = intersect_shape(simd, id, &shape, ray, &slabs)
            && hit.t < ray.t_max
            && counts(Some(scene), &hit)
        {
            hits.push(hit);
        }
    }
    hits
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

    /// Returns what [`closest_hit`] returns if surfaces are whole.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Hit {
        at_level!(Level::current(), |simd| nearest(
            simd,
            self.0.iter().copied(),
            ray,
            None
        ))
    }
}
