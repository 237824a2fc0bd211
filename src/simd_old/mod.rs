//! Eight lanes of `f32`, masks, and vectors of lanes; [`lanes`] has what kernels of any width share.
//!
//! The only module that names `wide`, which picks its instructions at compile time, by target feature. Every function
//! with a scalar twin in [`math`] does the same operations in the same order with the same rounding, in every build.

#[cfg(target_arch = "x86_64")]
#[allow(
    unsafe_code,
    reason = "intrinsics of an instruction set that is found at run time; see docs/lab-notes.md#avx512"
)]
pub mod avx512;
pub mod column;
mod compat;
pub mod lanes;
pub mod pair;

use crate::math;
use glam::Vec3;
use std::ops::{Add, BitAnd, BitOr, Mul, Neg, Not, Sub};

pub use crate::lanes::{F32x8, LANES, Vec3x8};

/// Returns the instruction set of this build on this CPU: what it was compiled for, or AVX-512 where kernels use it.
#[must_use]
pub fn isa() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    if avx512::is_available() {
        return "x86-64 AVX-512";
    }
    COMPILED_FOR
}

/// The instruction set that this build was compiled for, AVX-512 kernels aside.
pub const COMPILED_FOR: &str = if cfg!(all(target_feature = "avx2", target_feature = "fma")) {
    "x86-64 AVX2+FMA"
} else if cfg!(target_feature = "avx") {
    "x86-64 AVX"
} else if cfg!(target_arch = "x86_64") {
    "x86-64 SSE2"
} else if cfg!(target_arch = "aarch64") {
    "aarch64 NEON"
} else {
    "portable"
};

/// Returns `a * b + c`, fused in exactly the builds in which [`math::mul_add`] is fused.
#[inline(always)]
#[must_use]
pub fn mul_add(a: F32x8, b: F32x8, c: F32x8) -> F32x8 {
    if math::FUSED { a.mul_add(b, c) } else { a * b + c }
}

/// Returns in lane i the place of `from` that bits 4 i to 4 i + 3 of `places` name.
// Tuned: see docs/lab-notes.md#picked-lanes
#[inline(always)]
#[must_use]
pub fn picked8(from: &lanes::Column, places: u32) -> F32x8 {
    #[cfg(target_feature = "avx2")]
    {
        let places = wide::u32x8::splat(places) >> wide::u32x8::new([0, 4, 8, 12, 16, 20, 24, 28]);
        let [low, high] = from.halves().map(|half| {
            // Goes by the three lowest bits.
            let half = safe_arch::shuffle_av_f32_all_m256(bytemuck::cast(half), bytemuck::cast(places));
            bytemuck::cast::<_, F32x8>(half)
        });
        let is_high: F32x8 = bytemuck::cast((places & wide::u32x8::splat(8)).simd_eq(wide::u32x8::splat(8)));
        is_high.select(high, low)
    }
    #[cfg(not(target_feature = "avx2"))]
    F32x8::new(std::array::from_fn(|i| from.0[(places >> (4 * i)) as usize & 15]))
}

/// Returns `a * b - c`, rounded like [`mul_add`].
#[inline(always)]
#[must_use]
pub fn mul_sub(a: F32x8, b: F32x8, c: F32x8) -> F32x8 {
    if math::FUSED { a.mul_sub(b, c) } else { a * b - c }
}

/// Returns the larger of two lanes, by comparison: `b` if either is NaN (one `maxps` on x86-64). Twin of
/// [`math::max`].
#[inline(always)]
#[must_use]
pub fn max(a: F32x8, b: F32x8) -> F32x8 {
    if cfg!(target_arch = "x86_64") {
        a.fast_max(b)
    } else {
        a.simd_gt(b).select(a, b)
    }
}

/// Returns the smaller of two lanes, by comparison: `b` if either is NaN (one `minps` on x86-64). Twin of
/// [`math::min`].
#[inline(always)]
#[must_use]
pub fn min(a: F32x8, b: F32x8) -> F32x8 {
    if cfg!(target_arch = "x86_64") {
        a.fast_min(b)
    } else {
        a.simd_lt(b).select(a, b)
    }
}

/// Sets all lanes to one number.
#[inline(always)]
#[must_use]
pub fn splat(a: f32) -> F32x8 {
    F32x8::splat(a)
}

/// Returns lane `i` of `a`.
#[inline(always)]
#[must_use]
pub fn lane(a: &F32x8, i: usize) -> f32 {
    a.as_array()[i]
}

/// Returns lanes 4 to 7, then 0 to 3.
#[inline(always)]
#[must_use]
pub fn swap_halves(a: F32x8) -> F32x8 {
    let [low, high]: [wide::f32x4; 2] = bytemuck::cast(a);
    bytemuck::cast([high, low])
}

/// Returns the lanes without their fractions; undefined where that does not fit an `i32`.
#[inline(always)]
#[must_use]
pub fn trunc(a: F32x8) -> [i32; LANES] {
    a.fast_trunc_int().to_array()
}

/// Returns the smallest lane.
#[inline]
#[must_use]
pub fn min_lane(a: F32x8) -> f32 {
    a.to_array().into_iter().fold(f32::INFINITY, math::min)
}

/// Returns the smallest lane, in all lanes; none may be NaN.
#[inline(always)]
#[must_use]
pub fn min_everywhere(a: F32x8) -> F32x8 {
    let [low, high]: [wide::f32x4; 2] = bytemuck::cast(a);
    let m = low.fast_min(high);
    let [m0, m1, m2, m3] = m.to_array();
    let m = m.fast_min(wide::f32x4::new([m2, m3, m0, m1]));
    let [m0, m1, ..] = m.to_array();
    splat(if m0 < m1 { m0 } else { m1 })
}

/// Returns the largest lane.
#[inline]
#[must_use]
pub fn max_lane(a: F32x8) -> f32 {
    a.to_array().into_iter().fold(f32::NEG_INFINITY, math::max)
}

/// One truth value a lane: all bits of a lane set, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mask8(F32x8);

impl Mask8 {
    /// The mask without lanes.
    pub const NONE: Self = Self(F32x8::ZERO);

    /// Returns the mask as a bit a lane, lane 0 the lowest.
    #[inline(always)]
    #[must_use]
    pub fn bits(self) -> u32 {
        self.0.to_bitmask()
    }

    /// Creates the mask with the lanes of `bits`.
    #[inline(always)]
    #[must_use]
    pub fn from_bits(bits: u32) -> Self {
        let lane_bit8 = wide::i32x8::new([1, 2, 4, 8, 16, 32, 64, 128]);
        let set8 = (wide::i32x8::splat(bits.cast_signed()) & lane_bit8).simd_eq(lane_bit8);
        Self(bytemuck::cast(set8))
    }

    /// Returns whether any lane is set.
    #[inline(always)]
    #[must_use]
    pub fn any(self) -> bool {
        self.bits() != 0
    }

    /// Returns `if_true` where set, else `if_false`.
    #[inline(always)]
    #[must_use]
    pub fn select(self, if_true: F32x8, if_false: F32x8) -> F32x8 {
        self.0.select(if_true, if_false)
    }
}

impl BitAnd for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Not for Mask8 {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

/// Returns the lanes with `a < b`.
#[inline(always)]
#[must_use]
pub fn lt(a: F32x8, b: F32x8) -> Mask8 {
    Mask8(a.simd_lt(b))
}

/// Returns the lanes with `a <= b`.
#[inline(always)]
#[must_use]
pub fn le(a: F32x8, b: F32x8) -> Mask8 {
    Mask8(a.simd_le(b))
}

/// Returns the lanes with `a > b`.
#[inline(always)]
#[must_use]
pub fn gt(a: F32x8, b: F32x8) -> Mask8 {
    Mask8(a.simd_gt(b))
}

/// Returns the lanes with `a >= b`.
#[inline(always)]
#[must_use]
pub fn ge(a: F32x8, b: F32x8) -> Mask8 {
    Mask8(a.simd_ge(b))
}

/// Returns the lanes with `a == b`.
#[inline(always)]
#[must_use]
pub fn eq(a: F32x8, b: F32x8) -> Mask8 {
    Mask8(a.simd_eq(b))
}

/// Returns the lanes whose sign bit is clear in all of `values` (so -0.0 counts as negative): one `or` and one
/// `movmskps` instead of comparisons.
#[inline(always)]
#[must_use]
pub fn signs_clear<const N: usize>(values: [F32x8; N]) -> u32 {
    let all8 = values.into_iter().fold(F32x8::ZERO, |a, b| a | b);
    !all8.to_bitmask() & 0xff
}

/// Raises lanes to a power; twin of [`math::powi`].
#[inline(always)]
#[must_use]
pub fn powi(x: F32x8, exponent: u32) -> F32x8 {
    let (mut result, mut square, mut bits) = (splat(1.0), x, exponent);
    loop {
        if bits & 1 == 1 {
            result *= square;
        }
        bits >>= 1;
        if bits == 0 {
            return result;
        }
        square = square * square;
    }
}

impl Vec3x8 {
    /// Returns the dot product; twin of [`math::dot`].
    #[inline(always)]
    #[must_use]
    pub fn dot(self, b: Self) -> F32x8 {
        mul_add(self.x, b.x, mul_add(self.y, b.y, self.z * b.z))
    }

    /// Returns the cross product; twin of [`math::cross`].
    #[inline(always)]
    #[must_use]
    pub fn cross(self, b: Self) -> Self {
        Self {
            x: mul_sub(self.y, b.z, self.z * b.y),
            y: mul_sub(self.z, b.x, self.x * b.z),
            z: mul_sub(self.x, b.y, self.y * b.x),
        }
    }

    /// Returns `self * s + a`; twin of [`math::mul_add3`].
    #[inline(always)]
    #[must_use]
    pub fn mul_add(self, s: F32x8, a: Self) -> Self {
        Self {
            x: mul_add(self.x, s, a.x),
            y: mul_add(self.y, s, a.y),
            z: mul_add(self.z, s, a.z),
        }
    }

    /// Returns unit vectors; twin of [`math::normalize`].
    #[inline(always)]
    #[must_use]
    pub fn normalize(self) -> Self {
        self * (splat(1.0) / self.dot(self).sqrt())
    }

    /// Returns the largest absolute component; twin of [`math::max_abs`].
    #[inline(always)]
    #[must_use]
    pub fn max_abs(self) -> F32x8 {
        max(max(self.x.abs(), self.y.abs()), self.z.abs())
    }

    /// Returns `if_true` where `mask8` is set, else `if_false`.
    #[inline(always)]
    #[must_use]
    pub fn select(mask8: Mask8, if_true: Self, if_false: Self) -> Self {
        Self {
            x: mask8.select(if_true.x, if_false.x),
            y: mask8.select(if_true.y, if_false.y),
            z: mask8.select(if_true.z, if_false.z),
        }
    }
}

impl Add for Vec3x8 {
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

impl Sub for Vec3x8 {
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

impl Neg for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            x: -self.x,
            y: -self.y,
            z: -self.z,
        }
    }
}

impl Mul<F32x8> for Vec3x8 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: F32x8) -> Self {
        Self {
            x: self.x * s,
            y: self.y * s,
            z: self.z * s,
        }
    }
}

/// Returns a bit for each lane of `a` that equals `b`.
#[inline(always)]
#[must_use]
pub fn equal_lanes(a: &[u32; LANES], b: u32) -> u32 {
    let equal8 = wide::u32x8::from(*a).simd_eq(wide::u32x8::splat(b));
    bytemuck::cast::<_, F32x8>(equal8).to_bitmask()
}

/// Packs three numbers below 256 a lane, two lanes in the lowest 48 bits of one: the first lane's first is lowest.
#[inline(always)]
#[must_use]
pub fn pack_pairs(numbers: [[u32; LANES]; 3]) -> [u64; LANES / 2] {
    let [a, b, c] = numbers.map(wide::u32x8::from);
    let packed: wide::u32x8 = a | (b << 8_u32) | (c << 16_u32);
    let mut pairs: wide::u64x4 = bytemuck::cast(packed);
    if cfg!(target_endian = "big") {
        pairs = (pairs << 32_u32) | (pairs >> 32_u32);
    }
    let second = (pairs >> 32_u32) << 24_u32;
    ((pairs & wide::u64x4::splat(0xff_ffff)) | second).to_array()
}

/// Returns the scale that brings lanes near 1; twin of [`math::scale_to_one`].
#[inline(always)]
#[must_use]
pub fn scale_to_one(size: F32x8) -> F32x8 {
    let bits: wide::u32x8 = bytemuck::cast(size);
    bytemuck::cast(wide::u32x8::splat(254 << 23) - (bits & wide::u32x8::splat(math::EXPONENT)))
}

/// Creates a vector by lane.
// Not `array::from_fn`: see docs/lab-notes.md#array-map
#[inline(always)]
#[must_use]
pub fn from_lanes(lane: impl Fn(usize) -> f32) -> F32x8 {
    F32x8::from([
        lane(0),
        lane(1),
        lane(2),
        lane(3),
        lane(4),
        lane(5),
        lane(6),
        lane(7),
    ])
}

/// Converts lanes to integers, fractions cut off; they must be 0 or more, and fit.
#[inline(always)]
#[must_use]
pub fn truncate(a: F32x8) -> [u32; LANES] {
    bytemuck::cast(a.fast_trunc_int())
}

const OFFSETS: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7];

/// Returns `first`, `first + 1`, ...
#[inline(always)]
#[must_use]
pub fn run(first: u32) -> [u32; LANES] {
    (wide::u32x8::splat(first) + wide::u32x8::new(OFFSETS)).to_array()
}

/// Returns whether the lanes are `first`, `first + 1`, ...
#[inline(always)]
#[must_use]
pub fn is_run(a: &[u32; LANES], first: u32) -> bool {
    let offset8 = wide::u32x8::new(OFFSETS);
    let from_first8 = wide::u32x8::from(*a) - offset8;
    equal_lanes(&from_first8.to_array(), first) == (1 << LANES) - 1
}
