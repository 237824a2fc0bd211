//! Eight numbers or vectors in memory, for rays, hits and queues: plain arrays, aligned for loads, the same on every CPU.

use glam::Vec3;

/// The numbers of a [`F32x8`].
pub const LANES: usize = 8;

/// Eight `f32`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(32))]
pub struct F32x8([f32; LANES]);

impl F32x8 {
    /// Eight zeros.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// Makes the numbers from an array.
    #[inline(always)]
    #[must_use]
    pub const fn new(numbers: [f32; LANES]) -> Self {
        Self(numbers)
    }

    /// Sets all lanes to one number.
    #[inline(always)]
    #[must_use]
    pub const fn splat(a: f32) -> Self {
        Self([a; LANES])
    }

    /// Returns the numbers.
    #[inline(always)]
    #[must_use]
    pub const fn to_array(self) -> [f32; LANES] {
        self.0
    }

    /// Returns the numbers.
    #[inline(always)]
    #[must_use]
    pub const fn as_array(&self) -> &[f32; LANES] {
        &self.0
    }

    /// Returns the numbers, to be changed.
    #[inline(always)]
    pub const fn as_mut_array(&mut self) -> &mut [f32; LANES] {
        &mut self.0
    }
}

impl From<[f32; LANES]> for F32x8 {
    #[inline(always)]
    fn from(numbers: [f32; LANES]) -> Self {
        Self(numbers)
    }
}

/// Eight vectors, an array per axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Vec3x8 {
    /// First components.
    pub x: F32x8,
    /// Second components.
    pub y: F32x8,
    /// Third components.
    pub z: F32x8,
}

impl Vec3x8 {
    /// Eight zero vectors.
    pub const ZERO: Self = Self::splat(Vec3::ZERO);

    /// Makes the vectors from their components.
    #[inline(always)]
    #[must_use]
    pub const fn new(x: F32x8, y: F32x8, z: F32x8) -> Self {
        Self { x, y, z }
    }

    /// Sets all lanes to one vector.
    #[inline(always)]
    #[must_use]
    pub const fn splat(v: Vec3) -> Self {
        Self {
            x: F32x8::splat(v.x),
            y: F32x8::splat(v.y),
            z: F32x8::splat(v.z),
        }
    }

    /// Makes the vectors, one per lane.
    #[inline]
    #[must_use]
    pub fn from_lanes(v: [Vec3; LANES]) -> Self {
        Self {
            x: v.map(|v| v.x).into(),
            y: v.map(|v| v.y).into(),
            z: v.map(|v| v.z).into(),
        }
    }

    /// Returns lane `i`.
    #[inline(always)]
    #[must_use]
    pub fn lane(&self, i: usize) -> Vec3 {
        Vec3::new(self.x.0[i], self.y.0[i], self.z.0[i])
    }

    /// Sets lane `i`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        (self.x.0[i], self.y.0[i], self.z.0[i]) = (v.x, v.y, v.z);
    }
}
