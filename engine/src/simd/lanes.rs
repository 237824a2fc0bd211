//! The vector traits of generic kernels: 8, 16 or 32 rays, or 8 or 16 triangles.

use super::{Column, Memory, Pair, Simd};
use crate::lanes::{F32x8, LANES};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Lanes of the widest register. A packet has at most as many, or twice as many in a [`Pair`].
pub const REGISTER_LANES: usize = 16;

/// One truth value per lane.
pub trait LaneMask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Returns the mask as a bit per lane, lane 0 the lowest.
    fn bits(self) -> u32;
    /// Returns whether any lane is set.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

/// Eight, sixteen or thirty-two `f32` in registers.
pub trait Lanes:
    Copy
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Mul<f32, Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The level: each vector holds its token.
    type Simd: Simd;
    type Mask: LaneMask;
    /// The memory that lanes are stored to.
    type Memory: Memory;
    /// [`REGISTER_LANES`] lanes: one per packet of a bundle, or per triangle of two leaves.
    type Packets: TriangleLanes<Simd = Self::Simd, Packets = Self::Packets>;
    /// As many lanes as these, at most [`REGISTER_LANES`]: a lane per triangle.
    type Triangles: TriangleLanes<Simd = Self::Simd, Packets = Self::Packets>;
    /// The number of lanes.
    const COUNT: usize;

    fn simd(self) -> Self::Simd;
    #[must_use]
    fn splat(simd: Self::Simd, a: f32) -> Self;
    /// Returns `a` in all lanes.
    #[inline(always)]
    #[must_use]
    fn all(self, a: f32) -> Self {
        Self::splat(self.simd(), a)
    }
    /// Returns the lanes of `bits`, lane 0 the lowest.
    fn mask(simd: Self::Simd, bits: u32) -> Self::Mask;
    #[must_use]
    fn load(simd: Self::Simd, from: &Self::Memory) -> Self;
    /// Joins vectors of eight lanes; those beyond the vector's lanes are left out. (Not by way of [`Memory`]: a load
    /// of what two stores have written waits for both.)
    #[must_use]
    fn of_eights(simd: Self::Simd, eights: [&F32x8; 4]) -> Self;
    fn store(self, to: &mut Self::Memory);
    /// Returns `self * b + c`, rounded once.
    #[must_use]
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// Returns `self * b - c`, rounded once.
    #[must_use]
    fn mul_sub(self, b: Self, c: Self) -> Self;
    /// Returns `self * b + c`, rounded once or twice, whichever is faster on the CPU. Only for culling.
    #[must_use]
    fn mul_add_approx(self, b: Self, c: Self) -> Self;
    /// Returns `self * b - c`, like [`mul_add_approx`](Self::mul_add_approx).
    #[must_use]
    fn mul_sub_approx(self, b: Self, c: Self) -> Self;
    /// Returns the smaller of two lanes, by comparison: `b` if either is NaN. See [`math::min`](crate::math::min).
    #[must_use]
    fn min(self, b: Self) -> Self;
    /// Returns the larger of two lanes, by comparison: `b` if either is NaN. See [`math::max`](crate::math::max).
    #[must_use]
    fn max(self, b: Self) -> Self;
    #[must_use]
    fn abs(self) -> Self;
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns only the sign bits.
    #[must_use]
    fn sign(self) -> Self;
    /// Returns the sign bits, a bit per lane.
    fn sign_bits(self) -> u32;
    /// Returns the lanes with signs flipped where `sign` is negative; `sign` has only sign bits.
    #[must_use]
    fn flip_signs(self, sign: Self) -> Self;
    fn lt(self, b: Self) -> Self::Mask;
    fn le(self, b: Self) -> Self::Mask;
    fn gt(self, b: Self) -> Self::Mask;
    fn ge(self, b: Self) -> Self::Mask;
    fn eq(self, b: Self) -> Self::Mask;
    /// Returns which of `lanes` are not less than `b`; NaN counts as not less.
    fn not_lt(self, b: Self, lanes: Self::Mask) -> Self::Mask;
    /// Returns which of `lanes` are not greater than `b`; NaN counts as not greater.
    fn not_gt(self, b: Self, lanes: Self::Mask) -> Self::Mask;
    /// Returns `if_true` where set, else `if_false`.
    #[must_use]
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// Returns in lane i the smallest of lanes i, i + 8 and so on.
    fn fold_min(self) -> super::Eight<Self>;
    /// Returns in lane i the largest of lanes i, i + 8 and so on.
    fn fold_max(self) -> super::Eight<Self>;
    /// Returns in lane i the smaller of lane i and, if there is one, lane i + 16.
    fn fold_min_to_16(self) -> Self::Triangles;
    /// Returns in lane i the larger of lane i and, if there is one, lane i + 16.
    fn fold_max_to_16(self) -> Self::Triangles;
    /// Returns the largest lane; none may be NaN.
    #[inline(always)]
    fn largest(self) -> f32 {
        self.fold_max().largest_of_eight()
    }
}

/// Eight or sixteen lanes, for triangles.
pub trait TriangleLanes: Lanes<Memory = Column, Triangles = Self> {
    /// Joins lanes 0 to 7 and, if there are sixteen, 8 to 15.
    #[inline(always)]
    #[must_use]
    fn join(simd: Self::Simd, low: &F32x8, high: &F32x8) -> Self {
        Self::of_eights(simd, [low, high, low, high])
    }
    /// [`EightLanes::picked8`] from the first column and, with sixteen lanes, from the second one.
    #[must_use]
    fn picked(simd: Self::Simd, from: [&Column; 2], places: [u32; 2]) -> Self;
    /// Returns in lane i the smallest lane of row i; none may be NaN.
    #[must_use]
    fn least_of_each(rows: &[Self; REGISTER_LANES]) -> Self::Packets;
    /// Returns in lane i the largest lane of row i; none may be NaN.
    #[must_use]
    fn largest_of_each(rows: &[Self; REGISTER_LANES]) -> Self::Packets;
}

/// Eight lanes: boxes of a node's children, pixels, points.
pub trait EightLanes: TriangleLanes<Packets = Pair<Self>> + super::pair::Half<Whole = Column> {
    #[must_use]
    fn load8(simd: Self::Simd, from: &F32x8) -> Self;
    #[must_use]
    fn to8(self) -> F32x8;
    /// Transposes: lane i of result j is lane j of row i.
    #[must_use]
    fn transposed(rows: [Self; LANES]) -> [Self; LANES];
    /// Returns in lane i the place of `from` that bits 4 i to 4 i + 3 of `places` name.
    #[must_use]
    fn picked8(simd: Self::Simd, from: &Column, places: u32) -> Self;
    /// Returns the largest lane; none may be NaN.
    fn largest_of_eight(self) -> f32;
    /// Returns the smallest lane, in all lanes; none may be NaN.
    #[must_use]
    fn min_everywhere(self) -> Self;
    /// Returns lanes 4 to 7, then 0 to 3.
    #[must_use]
    fn swap_halves(self) -> Self;
    /// Returns the lanes of equal bits, a bit each.
    fn same_bits(self, b: Self) -> u32;
    /// Returns the lanes without their fractions; undefined where that does not fit an `i32`.
    fn trunc(self) -> [i32; LANES];
    /// Truncates three numbers per lane, from 0 to below 256, and packs them, two lanes in the lowest 48 bits of a word: the
    /// first lane's first number is lowest.
    fn byte_pairs(numbers: [Self; 3]) -> [u64; LANES / 2];
    /// Returns the scale that brings lanes near 1; as [`math::scale_to_one`](crate::math::scale_to_one).
    #[must_use]
    fn scale_to_one(self) -> Self;
    /// Returns an `entry` for each of the eight lanes in `chosen`, nearest last, and their count. What follows them
    /// is undefined.
    fn nearest_last(self, chosen: u32) -> ([u32; LANES], usize);

    /// Returns lane `i`, by way of memory.
    #[inline(always)]
    fn lane(self, i: usize) -> f32 {
        self.to8().as_array()[i % LANES]
    }
    /// Returns lane 0.
    #[inline(always)]
    fn first(self) -> f32 {
        self.lane(0)
    }
    /// Returns the sum of the lanes, in an unspecified order.
    #[inline(always)]
    fn sum(self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.to8().to_array();
        ((a + b) + (c + d)) + ((e + f) + (g + h))
    }
    /// Returns the smallest lane, by comparison.
    #[inline(always)]
    fn min_lane(self) -> f32 {
        self.to8()
            .to_array()
            .into_iter()
            .fold(f32::INFINITY, crate::math::min)
    }
    /// Returns the largest lane, by comparison.
    #[inline(always)]
    fn max_lane(self) -> f32 {
        self.to8()
            .to_array()
            .into_iter()
            .fold(f32::NEG_INFINITY, crate::math::max)
    }
    /// Raises lanes to a power; as [`math::powi`](crate::math::powi).
    #[inline(always)]
    #[must_use]
    fn powi(self, exponent: u32) -> Self {
        let (mut result, mut square, mut bits) = (self.all(1.0), self, exponent);
        loop {
            if bits & 1 == 1 {
                result = result * square;
            }
            bits >>= 1;
            if bits == 0 {
                return result;
            }
            square = square * square;
        }
    }
    /// Returns the lanes of `a` that equal `b`, a bit each.
    #[inline(always)]
    fn equal_lanes(simd: Self::Simd, a: &[u32; LANES], b: u32) -> u32 {
        let a = Self::load8(simd, &F32x8::new(bytemuck::cast(*a)));
        a.same_bits(a.all(f32::from_bits(b)))
    }
}

/// Packs a distance of at least 0 and one of eight lanes, so that entries sort as their distances do: the lane
/// replaces the three lowest bits, which can only lower the distance.
#[inline(always)]
#[must_use]
pub fn entry(near: f32, lane: usize) -> u32 {
    near.to_bits() & !LANE_BITS | lane as u32
}

/// Unpacks an `entry`.
#[inline(always)]
#[must_use]
pub fn unpack(entry: u32) -> (f32, usize) {
    (f32::from_bits(entry & !LANE_BITS), (entry & LANE_BITS) as usize)
}

/// The bits of an `entry` that hold the lane.
pub(super) const LANE_BITS: u32 = LANES as u32 - 1;

/// [`EightLanes::nearest_last`] by insertion.
#[inline(always)]
pub(super) fn nearest_last(near: [f32; LANES], chosen: u32) -> ([u32; LANES], usize) {
    let (mut entries, mut count, mut left) = ([0; LANES], 0, chosen & 0xff);
    while left != 0 {
        let i = left.trailing_zeros() as usize;
        left &= left - 1;
        let new = entry(near[i % LANES], i % LANES);
        let mut at = count;
        while at > 0 && entries[(at - 1) % LANES] < new {
            entries[at % LANES] = entries[(at - 1) % LANES];
            at -= 1;
        }
        entries[at % LANES] = new;
        count += 1;
    }
    (entries, count)
}
