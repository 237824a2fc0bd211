//! Boxes, and scalar versions of operations on lanes.
//!
//! Code that decides hits or colours uses these functions, because glam does not specify the order and rounding of its
//! own. The lane versions in `simd` do the same operations in the same order.

pub(crate) mod expansion;
pub(crate) mod fused;
pub(crate) mod orientation;
#[doc(hidden)]
pub mod srgb;

use glam::{DVec3, Vec3};

/// Returns a power of two that scales `size` to near 1, so that squares stay in the range of `f32`. Products with it are
/// exact. `size` must be from 0 to below 2^127.
#[inline(always)]
#[must_use]
pub fn scale_to_one(size: f32) -> f32 {
    f32::from_bits((254_u32 << 23).wrapping_sub(size.to_bits() & EXPONENT))
}

/// Returns a direction whose squares stay in the range of `f64`: the vector itself, unless it is extremely long or short.
#[must_use]
pub fn moderate(vector: DVec3) -> DVec3 {
    let size = vector.abs().max_element();
    if size == 0.0 || (1e-100..1e100).contains(&size) {
        vector
    } else {
        vector / size
    }
}

/// The exponent bits of an `f32`.
pub(crate) const EXPONENT: u32 = 0xff << 23;

/// Returns the larger number, or `b` if either is NaN, like `Lanes::max`.
#[inline(always)]
#[must_use]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the smaller number, or `b` if either is NaN, like `Lanes::min`.
#[inline(always)]
#[must_use]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns `d` with its magnitude raised to at least [`MIN_ABS_DIRECTION`]. The slab test divides by it, so its
/// reciprocals are finite, and 0 times one of them is 0.
#[inline(always)]
#[must_use]
pub fn min_abs_direction(d: f32) -> f32 {
    if d.abs() < MIN_ABS_DIRECTION {
        MIN_ABS_DIRECTION.copysign(d)
    } else {
        d
    }
}

/// The least magnitude of a direction component in the slab test.
pub const MIN_ABS_DIRECTION: f32 = 1e-18;

/// Both directions of each axis.
pub(crate) const AXES: [Vec3; 6] = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z];

/// Returns unit vectors that are spread evenly over a sphere, on a Fibonacci spiral (Vogel 1979).
#[must_use]
pub(crate) fn spread_directions<const N: usize>() -> [Vec3; N] {
    let golden_angle = std::f64::consts::TAU * (1.0 - 0.5 * (5.0_f64.sqrt() - 1.0));
    std::array::from_fn(|i| {
        let height = 1.0 - (2.0 * i as f64 + 1.0) / N as f64;
        let (sin, cos) = libm::sincos(golden_angle * i as f64);
        let out = (1.0 - height * height).sqrt();
        Vec3::new((out * cos) as f32, (out * sin) as f32, height as f32)
    })
}

/// Returns the largest absolute component.
#[inline(always)]
#[must_use]
pub fn max_abs(v: Vec3) -> f32 {
    max(max(v.x.abs(), v.y.abs()), v.z.abs())
}

/// Returns `x` to an integer power, by repeated squaring.
#[inline(always)]
#[must_use]
pub fn powi(x: f32, exponent: u32) -> f32 {
    let (mut result, mut square, mut bits) = (1.0, x, exponent);
    loop {
        if bits & 1 == 1 {
            result *= square;
        }
        bits >>= 1;
        if bits == 0 {
            return result;
        }
        square *= square;
    }
}

/// Coefficients of sin(pi/4 x) / x in powers of x^2, and of cos(pi/4 x) in [`COS`], Taylor's: from -1 to 1 within 4e-8.
pub(crate) const SIN: [f32; 5] = [
    std::f32::consts::FRAC_PI_4,
    -0.080_745_51,
    0.002_490_394_6,
    -3.657_620_4e-5,
    3.133_616_2e-7,
];

/// Those of cos(pi/4 x).
pub(crate) const COS: [f32; 5] = [1.0, -0.308_425_14, 0.015_854_344, -3.259_919_8e-4, 3.590_860_4e-6];

/// An axis-aligned box, closed on all sides. The empty box has `lower > upper`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The smallest coordinate on each axis.
    pub lower: Vec3,
    /// The largest coordinate on each axis.
    pub upper: Vec3,
}

impl Aabb {
    /// The empty box, the neutral element of [`Aabb::union`]. Finite, so that arithmetic on it stays finite.
    pub const EMPTY: Self = Self {
        lower: Vec3::splat(1e30),
        upper: Vec3::splat(-1e30),
    };

    /// Returns the bounding box of `points`.
    #[must_use]
    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self {
            lower: b.lower.min(p),
            upper: b.upper.max(p),
        })
    }

    /// Returns the bounding box of both.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        Self {
            lower: self.lower.min(other.lower),
            upper: self.upper.max(other.upper),
        }
    }

    /// Returns whether the box contains no point.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.lower.cmpgt(self.upper).any()
    }

    /// Returns the length of the diagonal; 0 for the empty box.
    #[must_use]
    pub fn diagonal(self) -> f32 {
        if self.is_empty() {
            0.0
        } else {
            (self.upper - self.lower).length()
        }
    }

    /// Returns the largest absolute coordinate; 0 for the empty box.
    #[must_use]
    pub fn max_abs(self) -> f32 {
        if self.is_empty() {
            0.0
        } else {
            max(max_abs(self.lower), max_abs(self.upper))
        }
    }
}
