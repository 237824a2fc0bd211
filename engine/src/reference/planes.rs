//! Infinite planes: the scalar version of `trace::planes`.

use super::Passing;
use crate::{
    math::{max, max_abs},
    ray::{Hit, Ray, SceneHit},
    scene::{Plane, Scene},
    simd::Simd,
};
use glam::Vec3;

const HORIZON: f32 = 1e9;

/// Returns where a ray hits a plane.
#[inline(always)]
fn intersect<S: Simd>(simd: S, plane: &Plane, ray: &Ray) -> Option<f32> {
    let t = simd.dot(plane.normal, plane.point - ray.origin) / simd.dot(plane.normal, ray.direction);
    (t > 0.0 && t < HORIZON).then_some(t)
}

/// Returns the nearest of the hits of planes and of `best`, the closest hit of everything else.
#[inline(always)]
pub(super) fn closest<S: Simd>(
    simd: S,
    (scene, passing): (&Scene, Passing<'_>),
    ray: &Ray,
    mut best: SceneHit,
) -> SceneHit {
    let ray = &ray.or_nothing();
    for (i, plane) in scene.planes().iter().enumerate() {
        if let Some(t) = intersect(simd, plane, ray)
            && best.loses_to(t, scene.plane_id(i))
        {
            let hit = Hit {
                t,
                u: 0.0,
                v: 0.0,
                primitive: scene.plane_id(i),
            };
            if passing.counts(ray, &hit) {
                best = hit.into();
            }
        }
    }
    best
}

/// Returns whether a plane is hit before the ray's end.
#[inline(always)]
pub(super) fn block<S: Simd>(simd: S, scene: &Scene, ray: &Ray) -> bool {
    let ray = &ray.or_nothing();
    let mut planes = scene.planes().iter().enumerate();
    planes.any(|(i, plane)| {
        intersect(simd, plane, ray).is_some_and(|t| t < ray.t_max)
            && !scene.lets_light_pass(scene.plane_id(i), [0.0; 2])
    })
}

/// Returns the point that is hit, both normals and the magnitude for offsets.
#[inline(always)]
pub(super) fn surface<S: Simd>(simd: S, plane: &Plane, ray: &Ray, hit: &Hit) -> (Vec3, Vec3, Vec3, f32) {
    let &Plane { point, normal, .. } = plane;
    let found = simd.mul_add3(ray.direction, hit.t, ray.origin);
    let off = simd.dot(normal, found - point);
    let found = simd.mul_add3(normal, -off, found);
    (found, normal, normal, max(max_abs(found), max_abs(point)))
}
