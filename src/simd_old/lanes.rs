//! Vectors of lanes that kernels are generic over: 8, 16 or 32 rays, or 8 or 16 triangles.
//!
//! ```text
//! lanes   without AVX-512   with AVX-512
//!     8   F32x8             F32x8
//!    16   Pair<F32x8>       F32x16
//!    32   -                 Pair<F32x16>
//! ```
//! Kernels are compiled for each, and chosen when the program runs. A lane's arithmetic does not depend on how many
//! lanes there are: all give the same bits.

pub use super::column::{Column, Memory, WideColumn};
use super::{F32x8, LANES, Mask8, Vec3x8, ge, gt, le, lt, max, min, mul_add, mul_sub, pair::F32x8x2, splat};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Lanes of the widest register. A packet has at most as many, or twice as many in a [pair](super::pair).
pub const REGISTER_LANES: usize = 16;

/// One truth value a lane.
pub trait LaneMask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// Returns the mask as a bit a lane, lane 0 the lowest.
    fn bits(self) -> u32;
    /// Returns whether any lane is set.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    /// Creates the mask with the lanes of `bits`.
    fn from_bits(bits: u32) -> Self;
}

/// Eight, sixteen or thirty-two `f32`. Operations are those of the functions of the same names in [`simd`](super),
/// lane by lane.
#[expect(
    missing_docs,
    reason = "each is what its name says, and its twin in `simd` says more"
)]
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    type Mask: LaneMask;
    /// The memory that lanes are stored to.
    type Memory: Memory;
    /// [`REGISTER_LANES`] lanes: one per packet of a bundle, or per triangle of two leaves.
    type Packets: TriangleLanes<Packets = Self::Packets>;
    /// As many lanes as these, at most [`REGISTER_LANES`]: a lane a triangle.
    type Triangles: TriangleLanes<Packets = Self::Packets>;
    /// The number of lanes.
    const COUNT: usize;

    #[must_use]
    fn splat(a: f32) -> Self;
    #[must_use]
    fn load(from: &Self::Memory) -> Self;
    /// Joins vectors of eight lanes; those beyond the vector's lanes are left out. (Not by way of [`Memory`]: a load
    /// of what two stores have written waits for both.)
    #[must_use]
    fn of_eights(eights: [F32x8; 4]) -> Self;
    fn store(self, to: &mut Self::Memory);
    #[must_use]
    fn mul_add(self, b: Self, c: Self) -> Self;
    #[must_use]
    fn mul_sub(self, b: Self, c: Self) -> Self;
    #[must_use]
    fn min(self, b: Self) -> Self;
    #[must_use]
    fn max(self, b: Self) -> Self;
    #[must_use]
    fn abs(self) -> Self;
    #[must_use]
    fn sqrt(self) -> Self;
    /// Returns the sign bits alone.
    #[must_use]
    fn sign(self) -> Self;
    /// Returns the sign bits, a bit a lane.
    fn sign_bits(self) -> u32;
    /// Returns the lanes with signs flipped where `sign` is negative.
    #[must_use]
    fn turn(self, sign: Self) -> Self;
    fn lt(self, b: Self) -> Self::Mask;
    fn le(self, b: Self) -> Self::Mask;
    fn gt(self, b: Self) -> Self::Mask;
    fn ge(self, b: Self) -> Self::Mask;
    /// Returns those of `lanes` that are not less: NaN is not.
    fn not_lt(self, b: Self, lanes: Self::Mask) -> Self::Mask;
    /// Returns those of `lanes` that are not greater: NaN is not.
    fn not_gt(self, b: Self, lanes: Self::Mask) -> Self::Mask;
    /// Returns `if_true` where set, else `if_false`.
    #[must_use]
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// Returns in lane i the smallest of lanes i, i + 8 and so on.
    fn fold_min(self) -> F32x8;
    /// Returns in lane i the largest of lanes i, i + 8 and so on.
    fn fold_max(self) -> F32x8;
    /// Returns in lane i the smaller of lane i and, if there is one, lane i + 16.
    fn fold_min_to_16(self) -> Self::Triangles;
    /// Returns in lane i the larger of lane i and, if there is one, lane i + 16.
    fn fold_max_to_16(self) -> Self::Triangles;
    /// Returns the largest lane; none may be NaN.
    fn largest(self) -> f32;
    /// Returns an [`entry`] for each of the eight lanes in `chosen`, nearest last, and their count. What follows them
    /// is undefined.
    fn nearest_last(near: F32x8, chosen: u32) -> ([u32; 8], usize);
}

/// Eight or sixteen lanes, for triangles.
pub trait TriangleLanes: Lanes<Memory = Column, Triangles = Self> {
    /// Joins lanes 0 to 7 and, if there are sixteen, 8 to 15.
    #[inline(always)]
    #[must_use]
    fn join(low: F32x8, high: F32x8) -> Self {
        Self::of_eights([low, high, low, high])
    }
    /// Returns in lane i the place of `from` that bits 4 i to 4 i + 3 of `places` name.
    #[must_use]
    fn picked8(from: &Column, places: u32) -> F32x8;
    /// Does [`picked8`](Self::picked8) from the first column and, with sixteen lanes, from the second one.
    #[must_use]
    fn picked(from: [&Column; 2], places: [u32; 2]) -> Self;
    /// Returns in lane i the smallest lane of row i; none may be NaN.
    #[must_use]
    fn least_of_each(rows: &[Self; REGISTER_LANES]) -> Self::Packets;
    /// Returns in lane i the largest lane of row i; none may be NaN.
    #[must_use]
    fn largest_of_each(rows: &[Self; REGISTER_LANES]) -> Self::Packets;
}

/// Packs a distance of at least 0 and one of eight lanes, so that entries sort as their distances do: the lane
/// replaces the three lowest bits, which can only lower the distance.
#[inline(always)]
#[must_use]
pub fn entry(near: f32, lane: usize) -> u32 {
    near.to_bits() & !LANE_BITS | lane as u32
}

/// Unpacks an [`entry`].
#[inline(always)]
#[must_use]
pub fn unpack(entry: u32) -> (f32, usize) {
    (f32::from_bits(entry & !LANE_BITS), (entry & LANE_BITS) as usize)
}

/// The bits of an [`entry`] that hold the lane.
pub(super) const LANE_BITS: u32 = LANES as u32 - 1;

impl LaneMask for Mask8 {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.bits()
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self::from_bits(bits)
    }
}

impl TriangleLanes for F32x8 {
    #[inline(always)]
    fn picked8(from: &Column, places: u32) -> F32x8 {
        super::picked8(from, places)
    }
    #[inline(always)]
    fn picked([from, _]: [&Column; 2], [places, _]: [u32; 2]) -> Self {
        Self::picked8(from, places)
    }
    #[inline(always)]
    fn least_of_each(rows: &[Self; REGISTER_LANES]) -> F32x8x2 {
        of_each(rows, min)
    }
    #[inline(always)]
    fn largest_of_each(rows: &[Self; REGISTER_LANES]) -> F32x8x2 {
        of_each(rows, max)
    }
}

impl Lanes for F32x8 {
    type Mask = Mask8;
    type Memory = Column;
    type Packets = F32x8x2;
    type Triangles = Self;
    const COUNT: usize = 8;

    #[inline(always)]
    fn splat(a: f32) -> Self {
        splat(a)
    }
    #[inline(always)]
    fn load(from: &Column) -> Self {
        from.halves()[0]
    }
    #[inline(always)]
    fn of_eights([eight, ..]: [F32x8; 4]) -> Self {
        eight
    }
    #[inline(always)]
    fn store(self, to: &mut Column) {
        to.halves_mut()[0] = self;
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        mul_add(self, b, c)
    }
    #[inline(always)]
    fn mul_sub(self, b: Self, c: Self) -> Self {
        mul_sub(self, b, c)
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        min(self, b)
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        max(self, b)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn sign(self) -> Self {
        self & splat(-0.0)
    }
    #[inline(always)]
    fn sign_bits(self) -> u32 {
        self.to_bitmask()
    }
    #[inline(always)]
    fn turn(self, sign: Self) -> Self {
        self ^ sign
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask8 {
        lt(self, b)
    }
    #[inline(always)]
    fn le(self, b: Self) -> Mask8 {
        le(self, b)
    }
    #[inline(always)]
    fn gt(self, b: Self) -> Mask8 {
        gt(self, b)
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask8 {
        ge(self, b)
    }
    #[inline(always)]
    fn not_lt(self, b: Self, lanes: Mask8) -> Mask8 {
        lanes & !lt(self, b)
    }
    #[inline(always)]
    fn not_gt(self, b: Self, lanes: Mask8) -> Mask8 {
        lanes & !gt(self, b)
    }
    #[inline(always)]
    fn select(mask: Mask8, if_true: Self, if_false: Self) -> Self {
        mask.select(if_true, if_false)
    }
    #[inline(always)]
    fn fold_min(self) -> F32x8 {
        self
    }
    #[inline(always)]
    fn fold_max(self) -> F32x8 {
        self
    }
    #[inline(always)]
    fn fold_min_to_16(self) -> Self {
        self
    }
    #[inline(always)]
    fn fold_max_to_16(self) -> Self {
        self
    }
    #[inline(always)]
    fn largest(self) -> f32 {
        let [a, b]: [wide::f32x4; 2] = bytemuck::cast(self);
        let four = a.fast_max(b).to_array();
        let of = |a: f32, b: f32| if a > b { a } else { b };
        of(of(four[0], four[1]), of(four[2], four[3]))
    }
    #[inline(always)]
    fn nearest_last(near: F32x8, chosen: u32) -> ([u32; 8], usize) {
        let near = near.to_array();
        let (mut entries, mut count, mut left) = ([0; 8], 0, chosen & 0xff);
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            let new = entry(near[i % 8], i % 8);
            let mut at = count;
            while at > 0 && entries[(at - 1) % 8] < new {
                entries[at % 8] = entries[(at - 1) % 8];
                at -= 1;
            }
            entries[at % 8] = new;
            count += 1;
        }
        (entries, count)
    }
}

/// Returns in lane i all lanes of row i reduced to one.
#[inline(always)]
fn of_each(rows: &[F32x8; REGISTER_LANES], reduce: impl Fn(F32x8, F32x8) -> F32x8) -> F32x8x2 {
    let mut halves = [[F32x8::ZERO; LANES]; 2];
    for (i, row) in rows.iter().enumerate() {
        halves[i / LANES][i % LANES] = *row;
    }
    let [low, high] = halves;
    let of_eight = |rows| F32x8::transpose(rows).into_iter().reduce(&reduce);
    F32x8x2::join(
        of_eight(low).unwrap_or_default(),
        of_eight(high).unwrap_or_default(),
    )
}

/// A vector a lane, a column an axis.
#[derive(Clone, Copy, Debug)]
pub struct Vec3Lanes<V> {
    /// First components.
    pub x: V,
    /// Second components.
    pub y: V,
    /// Third components.
    pub z: V,
}

impl<V> From<[V; 3]> for Vec3Lanes<V> {
    #[inline(always)]
    fn from([x, y, z]: [V; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<V: Lanes> Vec3Lanes<V> {
    /// Loads the vectors from memory.
    #[inline(always)]
    #[must_use]
    pub fn load(from: &[V::Memory; 3]) -> Self {
        let [x, y, z] = [V::load(&from[0]), V::load(&from[1]), V::load(&from[2])];
        Self { x, y, z }
    }

    /// Stores the vectors to memory.
    #[inline(always)]
    pub fn store(self, to: &mut [V::Memory; 3]) {
        let [x, y, z] = to;
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    /// Sets all lanes to one vector.
    #[inline(always)]
    #[must_use]
    pub fn splat(v: glam::Vec3) -> Self {
        let [x, y, z] = [V::splat(v.x), V::splat(v.y), V::splat(v.z)];
        Self { x, y, z }
    }

    /// Joins vectors of eight lanes; see [`Lanes::of_eights`].
    #[inline(always)]
    #[must_use]
    pub fn of_eights([a, b, c, d]: [&Vec3x8; 4]) -> Self {
        Self {
            x: V::of_eights([a.x, b.x, c.x, d.x]),
            y: V::of_eights([a.y, b.y, c.y, d.y]),
            z: V::of_eights([a.z, b.z, c.z, d.z]),
        }
    }

    /// Returns the smaller components.
    #[inline(always)]
    #[must_use]
    pub fn min(self, b: Self) -> Self {
        Self {
            x: self.x.min(b.x),
            y: self.y.min(b.y),
            z: self.z.min(b.z),
        }
    }

    /// Returns the larger components.
    #[inline(always)]
    #[must_use]
    pub fn max(self, b: Self) -> Self {
        Self {
            x: self.x.max(b.x),
            y: self.y.max(b.y),
            z: self.z.max(b.z),
        }
    }

    /// Returns the largest absolute component.
    #[inline(always)]
    #[must_use]
    pub fn max_abs(self) -> V {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Returns the vectors with signs flipped where `sign` is negative.
    #[inline(always)]
    #[must_use]
    pub fn turn(self, sign: V) -> Self {
        Self {
            x: self.x.turn(sign),
            y: self.y.turn(sign),
            z: self.z.turn(sign),
        }
    }

    /// Returns the dot product; twin of [`math::dot`](crate::math::dot).
    #[inline(always)]
    #[must_use]
    pub fn dot(self, b: Self) -> V {
        self.x.mul_add(b.x, self.y.mul_add(b.y, self.z * b.z))
    }

    /// Returns the cross product; twin of [`math::cross`](crate::math::cross).
    #[inline(always)]
    #[must_use]
    pub fn cross(self, b: Self) -> Self {
        Self {
            x: self.y.mul_sub(b.z, self.z * b.y),
            y: self.z.mul_sub(b.x, self.x * b.z),
            z: self.x.mul_sub(b.y, self.y * b.x),
        }
    }
}

impl<V: TriangleLanes> Vec3Lanes<V> {
    /// Joins two vectors; see [`TriangleLanes::join`].
    #[inline(always)]
    #[must_use]
    pub fn join(low: &Vec3x8, high: &Vec3x8) -> Self {
        Self::of_eights([low, high, low, high])
    }
}

impl<V: Lanes> Add for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self {
            x: self.x + b.x,
            y: self.y + b.y,
            z: self.z + b.z,
        }
    }
}

impl<V: Lanes> Sub for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self {
            x: self.x - b.x,
            y: self.y - b.y,
            z: self.z - b.z,
        }
    }
}

#[cfg(test)]
mod tests;
