//! Lanes of vectors as a structure of arrays.

#[cfg(doc)]
use super::Simd;
use super::{EightLanes, Lanes, TriangleLanes};
use crate::lanes::Vec3x8;
use glam::Vec3;
use std::ops::{Add, Mul, Neg, Sub};

/// A vector per lane.
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
    /// Makes the vectors from their components.
    #[inline(always)]
    #[must_use]
    pub fn new(x: V, y: V, z: V) -> Self {
        Self { x, y, z }
    }

    /// Loads the vectors from memory.
    #[inline(always)]
    #[must_use]
    pub fn load(simd: V::Simd, [x, y, z]: &[V::Memory; 3]) -> Self {
        Self::new(V::load(simd, x), V::load(simd, y), V::load(simd, z))
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
    pub fn splat(simd: V::Simd, v: Vec3) -> Self {
        Self::new(V::splat(simd, v.x), V::splat(simd, v.y), V::splat(simd, v.z))
    }

    /// Joins vectors of eight lanes; see [`Lanes::of_eights`].
    #[inline(always)]
    #[must_use]
    pub fn of_eights(simd: V::Simd, [a, b, c, d]: [&Vec3x8; 4]) -> Self {
        Self {
            x: V::of_eights(simd, [&a.x, &b.x, &c.x, &d.x]),
            y: V::of_eights(simd, [&a.y, &b.y, &c.y, &d.y]),
            z: V::of_eights(simd, [&a.z, &b.z, &c.z, &d.z]),
        }
    }

    /// Returns the smaller components.
    #[inline(always)]
    #[must_use]
    pub fn min(self, b: Self) -> Self {
        Self::new(self.x.min(b.x), self.y.min(b.y), self.z.min(b.z))
    }

    /// Returns the larger components.
    #[inline(always)]
    #[must_use]
    pub fn max(self, b: Self) -> Self {
        Self::new(self.x.max(b.x), self.y.max(b.y), self.z.max(b.z))
    }

    /// Returns the largest absolute component; as [`math::max_abs`](crate::math::max_abs).
    #[inline(always)]
    #[must_use]
    pub fn max_abs(self) -> V {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Returns the vectors with signs flipped where `sign` is negative.
    #[inline(always)]
    #[must_use]
    pub fn flip_signs(self, sign: V) -> Self {
        Self::new(
            self.x.flip_signs(sign),
            self.y.flip_signs(sign),
            self.z.flip_signs(sign),
        )
    }

    /// Returns the dot product; as [`Simd::dot`].
    #[inline(always)]
    #[must_use]
    pub fn dot(self, b: Self) -> V {
        self.x.mul_add(b.x, self.y.mul_add(b.y, self.z * b.z))
    }

    /// Returns the cross product; as [`Simd::cross`].
    #[inline(always)]
    #[must_use]
    pub fn cross(self, b: Self) -> Self {
        Self {
            x: self.y.mul_sub(b.z, self.z * b.y),
            y: self.z.mul_sub(b.x, self.x * b.z),
            z: self.x.mul_sub(b.y, self.y * b.x),
        }
    }

    /// Returns the dot product, only for culling: see [`Lanes::mul_add_approx`].
    #[inline(always)]
    #[must_use]
    pub fn dot_about(self, b: Self) -> V {
        self.x
            .mul_add_approx(b.x, self.y.mul_add_approx(b.y, self.z * b.z))
    }

    /// Returns the cross product, only for culling: see [`Lanes::mul_add_approx`].
    #[inline(always)]
    #[must_use]
    pub fn cross_about(self, b: Self) -> Self {
        Self {
            x: self.y.mul_sub_approx(b.z, self.z * b.y),
            y: self.z.mul_sub_approx(b.x, self.x * b.z),
            z: self.x.mul_sub_approx(b.y, self.y * b.x),
        }
    }

    /// Returns the sums of the absolute products that [`cross`](Self::cross) takes the differences of.
    #[inline(always)]
    #[must_use]
    pub fn permanent(self, b: Self) -> Self {
        let (a, b) = (self.abs(), b.abs());
        Self {
            x: a.y.mul_add_approx(b.z, a.z * b.y),
            y: a.z.mul_add_approx(b.x, a.x * b.z),
            z: a.x.mul_add_approx(b.y, a.y * b.x),
        }
    }

    /// Returns the absolute values of all components.
    #[inline(always)]
    #[must_use]
    pub fn abs(self) -> Self {
        Self::new(self.x.abs(), self.y.abs(), self.z.abs())
    }

    /// Returns `self * s + a`; as [`Simd::mul_add3`].
    #[inline(always)]
    #[must_use]
    pub fn mul_add(self, s: V, a: Self) -> Self {
        Self::new(
            self.x.mul_add(s, a.x),
            self.y.mul_add(s, a.y),
            self.z.mul_add(s, a.z),
        )
    }

    /// Returns unit vectors; as [`Simd::normalize`].
    #[inline(always)]
    #[must_use]
    pub fn normalize(self) -> Self {
        self * (self.x.all(1.0) / self.dot(self).sqrt())
    }

    /// Returns `if_true` where `mask` is set, else `if_false`.
    #[inline(always)]
    #[must_use]
    pub fn select(mask: V::Mask, if_true: Self, if_false: Self) -> Self {
        Self {
            x: V::select(mask, if_true.x, if_false.x),
            y: V::select(mask, if_true.y, if_false.y),
            z: V::select(mask, if_true.z, if_false.z),
        }
    }
}

impl<V: TriangleLanes> Vec3Lanes<V> {
    /// Joins two vectors; see [`TriangleLanes::join`].
    #[inline(always)]
    #[must_use]
    pub fn join(simd: V::Simd, low: &Vec3x8, high: &Vec3x8) -> Self {
        Self::of_eights(simd, [low, high, low, high])
    }
}

impl<V: EightLanes> Vec3Lanes<V> {
    /// Loads eight vectors.
    #[inline(always)]
    #[must_use]
    pub fn load8(simd: V::Simd, from: &Vec3x8) -> Self {
        Self {
            x: V::load8(simd, &from.x),
            y: V::load8(simd, &from.y),
            z: V::load8(simd, &from.z),
        }
    }

    /// Returns the vectors as memory holds them.
    #[inline(always)]
    #[must_use]
    pub fn to8(self) -> Vec3x8 {
        Vec3x8::new(self.x.to8(), self.y.to8(), self.z.to8())
    }
}

impl<V: Lanes> Add for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}

impl<V: Lanes> Sub for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

impl<V: Lanes> Neg for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<V: Lanes> Mul<V> for Vec3Lanes<V> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, s: V) -> Self {
        Self::new(self.x * s, self.y * s, self.z * s)
    }
}
