//! Boxes against rays: the slab test (Kay and Kajiya 1986), padded so that it never loses a hit (Ize, *Robust BVH Ray
//! Traversal*, JCGT 2(2) 2013).
//!
//! `(plane - origin) * (1 / direction)` is monotone in the plane, rounding included: a box inside another has an
//! interval inside the other's. So a hit in its primitive's own interval lies in that of every node above it, and
//! nodes need no further margin.

use crate::{
    math::{Aabb, MIN_ABS_DIRECTION},
    simd::{F32x8, Mask8, Vec3x8, lanes::Lanes, le, lt, max, min, splat},
};

/// Primitives' boxes grow on all sides by this fraction of their largest absolute coordinate, so that a ray in the
/// plane of a face, and a flat box, are inside.
const GEOMETRIC_PAD: f32 = 1.0 / (1 << 22) as f32;

/// The interval's ends move apart by this factor: three roundings each (difference, reciprocal, product), and one to
/// spare.
const INTERVAL_PAD: f32 = 4.0 / (1 << 24) as f32;

/// Returns how far a primitive's box grows on all sides, given its largest absolute coordinate.
#[inline(always)]
#[must_use]
pub fn pad<V: Lanes>(max_abs: V) -> V {
    max_abs * V::splat(GEOMETRIC_PAD)
}

/// Returns the box of a primitive as nodes must contain it; scalar twin of [`pad`].
#[must_use]
pub fn padded(bounds: Aabb) -> Aabb {
    let pad = glam::Vec3::splat(bounds.max_abs() * GEOMETRIC_PAD);
    Aabb {
        lower: bounds.lower - pad,
        upper: bounds.upper + pad,
    }
}

/// The part of eight rays that the slab test reads.
#[derive(Clone, Copy, Debug)]
pub struct Slabs8 {
    /// Origins.
    pub origin: Vec3x8,
    /// `1 / direction`, finite: see [`MIN_ABS_DIRECTION`].
    pub inv_direction: Vec3x8,
}

impl Slabs8 {
    /// The factor on the interval's entry.
    pub const ENTRY_SCALE: f32 = 1.0 - INTERVAL_PAD;
    /// The factor on the interval's exit.
    pub const EXIT_SCALE: f32 = 1.0 + INTERVAL_PAD;

    /// Creates them from rays of unit direction.
    #[inline(always)]
    #[must_use]
    pub fn new(origin: Vec3x8, direction: Vec3x8) -> Self {
        let one = splat(1.0);
        let inv = |d8: F32x8| {
            let least = splat(MIN_ABS_DIRECTION);
            let clamped8 = lt(d8.abs(), least).select(least | (d8 & splat(-0.0)), d8);
            one / clamped8
        };
        let inv_direction = Vec3x8::new(inv(direction.x), inv(direction.y), inv(direction.z));
        Self {
            origin,
            inv_direction,
        }
    }

    /// Returns where the rays are inside the boxes: entry (at least 0) and exit distance. For a miss the entry is
    /// greater than the exit.
    #[inline(always)]
    #[must_use]
    pub fn interval(&self, lower: Vec3x8, upper: Vec3x8) -> (F32x8, F32x8) {
        let axis = |lower: F32x8, upper: F32x8, origin: F32x8, inv: F32x8| {
            let (t0, t1) = ((lower - origin) * inv, (upper - origin) * inv);
            (min(t0, t1), max(t0, t1))
        };
        let (o, inv) = (&self.origin, &self.inv_direction);
        let (near_x, far_x) = axis(lower.x, upper.x, o.x, inv.x);
        let (near_y, far_y) = axis(lower.y, upper.y, o.y, inv.y);
        let (near_z, far_z) = axis(lower.z, upper.z, o.z, inv.z);
        let near = max(max(near_x, near_y), max(near_z, splat(0.0)));
        let far = min(min(far_x, far_y), far_z);
        (near * splat(Self::ENTRY_SCALE), far * splat(Self::EXIT_SCALE))
    }

    /// Returns the rays that may hit something in the box up to `t_max`, and where they enter.
    #[inline(always)]
    #[must_use]
    pub fn enter(&self, lower: Vec3x8, upper: Vec3x8, t_max: F32x8) -> (Mask8, F32x8) {
        let (near, far) = self.interval(lower, upper);
        (le(near, min(far, t_max)), near)
    }
}
