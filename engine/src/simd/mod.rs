//! Vectors of lanes for every instruction set, chosen when the program runs.
//!
//! ```text
//! level      eight lanes        sixteen                thirty-two
//! Portable   wide's f32x8       Pair of eights         -
//! Avx2       one register       Pair of eights         -
//! Avx512     one register       one register           Pair of sixteens
//! ```
//! A [`Level`] is an instruction set that this CPU has. It holds a token, a [`Simd`]: only this module makes one, after
//! checking the CPU, and vectors come only from tokens and other vectors. So safe code cannot run an instruction that the
//! CPU lacks. [`at_level!`] enters the code that is compiled for a level; below it everything is inlined.
//!
//! A lane's arithmetic depends neither on the level nor on the number of lanes: all give the same bits. Only culling may
//! use [`Lanes::mul_add_approx`].

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
mod column;
mod lanes;
mod level;
mod pair;
mod portable;
mod vec3;

use crate::lanes::{F32x8, Vec3x8};
use glam::Vec3;

#[cfg(target_arch = "x86_64")]
pub use avx2::Avx2;
#[cfg(target_arch = "x86_64")]
pub use avx512::Avx512;
pub use column::{Column, Memory, WideColumn};
pub use lanes::{EightLanes, LaneMask, Lanes, REGISTER_LANES, TriangleLanes, unpack};
#[doc(hidden)]
pub use level::at_level;
pub use level::{Level, LevelError, Token, isa};
pub use pair::Pair;
pub use portable::Portable;
pub use vec3::Vec3Lanes;

/// Eight lanes at the level of `V`.
pub type Eight<V> = <<V as Lanes>::Simd as Simd>::V8;

/// Eight vectors at a level.
pub type Vec3Eight<S> = Vec3Lanes<<S as Simd>::V8>;

/// An instruction set that this CPU has: a value proves it.
///
/// The functions on single numbers do the same operations in the same order as those on [`Lanes`].
pub trait Simd: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// Eight lanes.
    type V8: EightLanes<Simd = Self>;
    /// Sixteen lanes, in one register at AVX-512, in two elsewhere.
    type V16: TriangleLanes<Simd = Self>;

    /// Calls `f`, compiled for these instructions as far as it is inlined: mark closures `#[inline(always)]`.
    fn call<R>(self, f: impl FnOnce() -> R) -> R;

    /// Returns `a * b + c`, rounded once.
    #[must_use]
    fn mul_add(self, a: f32, b: f32, c: f32) -> f32;

    /// Sets eight lanes to one number.
    #[inline(always)]
    #[must_use]
    fn splat(self, a: f32) -> Self::V8 {
        Self::V8::splat(self, a)
    }

    /// Loads eight lanes.
    #[inline(always)]
    #[must_use]
    fn load(self, from: &F32x8) -> Self::V8 {
        Self::V8::load8(self, from)
    }

    /// Loads eight vectors.
    #[inline(always)]
    #[must_use]
    fn load3(self, from: &Vec3x8) -> Vec3Eight<Self> {
        Vec3Lanes::load8(self, from)
    }

    /// Sets eight lanes to one vector.
    #[inline(always)]
    #[must_use]
    fn splat3(self, v: Vec3) -> Vec3Eight<Self> {
        Vec3Lanes::splat(self, v)
    }

    /// Returns the lanes of `bits`, lane 0 the lowest.
    #[inline(always)]
    #[must_use]
    fn mask(self, bits: u32) -> <Self::V8 as Lanes>::Mask {
        Self::V8::mask(self, bits)
    }

    /// Returns the dot product `a.x b.x + (a.y b.y + a.z b.z)`; as [`Vec3Lanes::dot`].
    #[inline(always)]
    #[must_use]
    fn dot(self, a: Vec3, b: Vec3) -> f32 {
        self.mul_add(a.x, b.x, self.mul_add(a.y, b.y, a.z * b.z))
    }

    /// Returns the cross product, each component `a * b - c * d` with the first product fused; as [`Vec3Lanes::cross`].
    #[inline(always)]
    #[must_use]
    fn cross(self, a: Vec3, b: Vec3) -> Vec3 {
        Vec3::new(
            self.mul_add(a.y, b.z, -(a.z * b.y)),
            self.mul_add(a.z, b.x, -(a.x * b.z)),
            self.mul_add(a.x, b.y, -(a.y * b.x)),
        )
    }

    /// Returns `b * s + a`; as [`Vec3Lanes::mul_add`].
    #[inline(always)]
    #[must_use]
    fn mul_add3(self, b: Vec3, s: f32, a: Vec3) -> Vec3 {
        Vec3::new(
            self.mul_add(b.x, s, a.x),
            self.mul_add(b.y, s, a.y),
            self.mul_add(b.z, s, a.z),
        )
    }

    /// Returns `v * (1 / |v|)`, with one rounding more than `v / |v|` but a single division; NaN for a zero vector. As
    /// [`Vec3Lanes::normalize`].
    // Tuned: see docs/lab-notes.md#normalize
    #[inline(always)]
    #[must_use]
    fn normalize(self, v: Vec3) -> Vec3 {
        v * (1.0 / self.dot(v, v).sqrt())
    }
}

#[cfg(test)]
mod tests;
