//! Rays against spheres.
//!
//! The quadratic of the unit direction, with the discriminant from the vector between the centre and the ray's
//! nearest point (Haines, Günther and Akenine-Möller, *Precision Improvements for Ray/Sphere Intersection*, Ray
//! Tracing Gems ch. 7, 2019), which keeps small far spheres round.

use super::bounds::{Slabs8, pad};
use crate::{
    ray::PrimitiveId,
    simd::{F32x8, LANES, Mask8, Vec3x8, ge, gt, lane, le, max, min, splat},
};
use glam::Vec3;

/// Up to eight spheres, a column a coordinate. Lanes past the last sphere have radius 0 at a far place.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct SphereBlock {
    /// Centres.
    pub center: Vec3x8,
    /// Radii.
    pub radius: F32x8,
    /// Ids, as raw values of [`PrimitiveId`].
    pub id: [u32; LANES],
}

impl SphereBlock {
    /// Creates a block of `spheres` (id, centre, radius), at most eight.
    #[must_use]
    pub fn new(spheres: &[(PrimitiveId, Vec3, f32)]) -> Self {
        let center = |i: usize| spheres.get(i).map_or(Vec3::splat(1e18), |s| s.1);
        Self {
            center: Vec3x8::from_lanes(std::array::from_fn(center)),
            radius: std::array::from_fn(|i| spheres.get(i).map_or(0.0, |s| s.2)).into(),
            id: std::array::from_fn(|i| spheres.get(i).map_or(PrimitiveId::NONE.0, |s| s.0.0)),
        }
    }

    /// Returns sphere `i` in all lanes.
    #[inline(always)]
    #[must_use]
    pub fn splat(&self, i: usize) -> (Vec3x8, F32x8) {
        (Vec3x8::splat(self.center.lane(i)), splat(lane(&self.radius, i)))
    }
}

/// Returns the lanes that hit, and the nearest t above 0, within the sphere's own box.
#[inline(always)]
#[must_use]
pub fn intersect_spheres(
    center: Vec3x8,
    radius: F32x8,
    slabs: &Slabs8,
    direction: &Vec3x8,
) -> (Mask8, F32x8) {
    let from_center = slabs.origin - center;
    let nearest = -from_center.dot(*direction);
    let aside = direction.mul_add(nearest, from_center);
    let discriminant = radius * radius - aside.dot(aside);
    let half_chord = max(discriminant, splat(0.0)).sqrt();
    let (t0, t1) = (nearest - half_chord, nearest + half_chord);
    let t = gt(t0, splat(0.0)).select(t0, t1);

    let size = Vec3x8::new(radius, radius, radius);
    let (lower, upper) = (center - size, center + size);
    let pad = pad(max(lower.max_abs(), upper.max_abs()));
    let pad = Vec3x8::new(pad, pad, pad);
    let (near, far) = slabs.interval(lower - pad, upper + pad);
    let held = min(max(t, near), far);
    let ahead = gt(t, splat(0.0)) & gt(held, splat(0.0));
    (ge(discriminant, splat(0.0)) & ahead & le(near, far), held)
}
