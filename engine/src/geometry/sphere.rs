//! Rays against spheres.
//!
//! The quadratic of the unit direction, with the discriminant from the vector between the centre and the ray's
//! nearest point (Haines, Günther and Akenine-Möller, *Precision Improvements for Ray/Sphere Intersection*, Ray
//! Tracing Gems ch. 7, 2019), which keeps small far spheres round.

use super::bounds::pad;
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::PrimitiveId,
    simd::{Lanes, Vec3Lanes},
};
use glam::Vec3;

/// Up to eight spheres, an array per coordinate. Lanes past the last sphere have radius 0 far away.
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
}

/// Returns where rays are nearest to spheres, and the square of half the chord, negative for a miss; `from_center`: the
/// origins relative to the centres.
#[inline(always)]
#[must_use]
pub(crate) fn chord<V: Lanes>(from_center: Vec3Lanes<V>, direction: Vec3Lanes<V>, radius: V) -> (V, V) {
    let nearest = -from_center.dot(direction);
    let aside = direction.mul_add(nearest, from_center);
    (nearest, radius * radius - aside.dot(aside))
}

/// Returns the padded boxes of spheres: lower and upper corners.
#[inline(always)]
#[must_use]
pub(crate) fn padded_sphere_boxes<V: Lanes>(center: Vec3Lanes<V>, radius: V) -> (Vec3Lanes<V>, Vec3Lanes<V>) {
    let size = Vec3Lanes::new(radius, radius, radius);
    let (lower, upper) = (center - size, center + size);
    let pad = pad(lower.max_abs().max(upper.max_abs()));
    (lower - pad, upper + pad)
}

/// Returns where the rays leave spheres, like [`sphere_hits`].
#[inline(always)]
#[must_use]
pub(crate) fn sphere_exit<V: Lanes>((nearest, discriminant): (V, V), (near, far): (V, V)) -> V {
    let half_chord = discriminant.max(nearest.all(0.0)).sqrt();
    (nearest + half_chord).max(near).min(far)
}

/// Returns the rays that hit, given their [`chord`] and their interval in the spheres' padded boxes, and the nearest t
/// above 0, within that.
#[inline(always)]
#[must_use]
pub(crate) fn sphere_hits<V: Lanes>((nearest, discriminant): (V, V), (near, far): (V, V)) -> (V::Mask, V) {
    let zero = nearest.all(0.0);
    let half_chord = discriminant.max(zero).sqrt();
    let (t0, t1) = (nearest - half_chord, nearest + half_chord);
    let t = V::select(t0.gt(zero), t0, t1);
    let held = t.max(near).min(far);
    let ahead = t.gt(zero) & held.gt(zero);
    (discriminant.ge(zero) & ahead & near.le(far), held)
}
