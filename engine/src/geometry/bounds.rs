//! Boxes against rays: the slab test (Kay and Kajiya 1986), padded so that it never loses a hit (Ize, *Robust BVH Ray
//! Traversal*, JCGT 2(2) 2013).
//!
//! `(plane - origin) * (1 / direction)` is monotone in the plane, rounding included: a box inside another has an
//! interval inside the other's. So a hit in its primitive's own interval lies in that of every node above it, and
//! nodes need no further margin.

use crate::{
    math::Aabb,
    simd::{Lanes, Vec3Lanes},
};

/// Primitives' boxes grow on all sides by this fraction of their largest absolute coordinate, so that rays in the plane of
/// a face hit, and flat boxes have a volume.
const GEOMETRIC_PAD: f32 = 1.0 / (1 << 22) as f32;

/// The interval's ends move apart by this factor: three roundings each (difference, reciprocal, product), and one to
/// spare.
const INTERVAL_PAD: f32 = 4.0 / (1 << 24) as f32;

/// Returns how far a primitive's box grows on each axis, given its largest absolute coordinate.
#[inline(always)]
#[must_use]
pub(crate) fn pad<V: Lanes>(max_abs: V) -> Vec3Lanes<V> {
    let pad = max_abs * GEOMETRIC_PAD;
    Vec3Lanes::new(pad, pad, pad)
}

/// Returns the box of a primitive as nodes must contain it; the scalar version of `pad`.
#[must_use]
pub fn padded(bounds: Aabb) -> Aabb {
    let pad = glam::Vec3::splat(bounds.max_abs() * GEOMETRIC_PAD);
    Aabb {
        lower: bounds.lower - pad,
        upper: bounds.upper + pad,
    }
}

/// The part of rays that the slab test reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slabs<V> {
    /// Origins.
    pub origin: Vec3Lanes<V>,
    /// `1 / direction`, finite: see [`MIN_ABS_DIRECTION`](crate::math::MIN_ABS_DIRECTION).
    pub inv_direction: Vec3Lanes<V>,
}

/// The factor on an interval's entry.
pub(crate) const ENTRY_SCALE: f32 = 1.0 - INTERVAL_PAD;
/// The factor on an interval's exit.
pub(crate) const EXIT_SCALE: f32 = 1.0 + INTERVAL_PAD;

impl<V: Lanes> Slabs<V> {
    /// Returns where the rays are inside the boxes: entry (at least 0) and exit distance. For a miss the entry is
    /// greater than the exit.
    #[inline(always)]
    #[must_use]
    pub fn interval(&self, lower: Vec3Lanes<V>, upper: Vec3Lanes<V>) -> (V, V) {
        interval(&self.inv_direction, lower - self.origin, upper - self.origin)
    }
}

/// [`Slabs::interval`] of boxes that are given relative to the rays' origins.
#[inline(always)]
#[must_use]
pub(crate) fn interval<V: Lanes>(inv: &Vec3Lanes<V>, lower: Vec3Lanes<V>, upper: Vec3Lanes<V>) -> (V, V) {
    let (x0, x1) = (lower.x * inv.x, upper.x * inv.x);
    let (y0, y1) = (lower.y * inv.y, upper.y * inv.y);
    let (z0, z1) = (lower.z * inv.z, upper.z * inv.z);
    let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1).max(inv.x.all(0.0)));
    let far = x0.max(x1).min(y0.max(y1)).min(z0.max(z1));
    (near * ENTRY_SCALE, far * EXIT_SCALE)
}
