//! Memory for the lanes of one vector.

use super::REGISTER_LANES;
use crate::lanes::{F32x8, LANES};
use std::fmt::Debug;

/// Memory for as many lanes as a vector has, or more.
pub trait Memory: Copy + Debug {
    /// All places 0.
    const ZERO: Self;
    /// Returns place `i`, which wraps around.
    fn place(&self, i: usize) -> f32;
    /// Returns place `i`, which wraps around, to be changed.
    fn place_mut(&mut self, i: usize) -> &mut f32;
    /// Returns places 8 i to 8 i + 7, which wrap around.
    fn eight(&self, i: usize) -> &F32x8;
}

/// Sixteen places; a vector of eight lanes uses the first eight.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct Column(pub [f32; REGISTER_LANES]);

impl Column {
    /// Creates one with equal numbers.
    #[inline(always)]
    #[must_use]
    pub fn splat(a: f32) -> Self {
        Self([a; REGISTER_LANES])
    }

    /// Returns places 0 to 7, then 8 to 15. (Casting only the numbers would check alignment at each load:
    /// docs/lab-notes.md#packet-memory)
    #[inline(always)]
    #[must_use]
    pub fn halves(&self) -> &[F32x8; 2] {
        bytemuck::must_cast_ref(self)
    }

    /// Returns places 0 to 7, then 8 to 15, to be changed.
    #[inline(always)]
    pub fn halves_mut(&mut self) -> &mut [F32x8; 2] {
        bytemuck::must_cast_mut(self)
    }
}

impl Memory for Column {
    const ZERO: Self = Self([0.0; REGISTER_LANES]);

    #[inline(always)]
    fn place(&self, i: usize) -> f32 {
        self.0[i % REGISTER_LANES]
    }
    #[inline(always)]
    fn place_mut(&mut self, i: usize) -> &mut f32 {
        &mut self.0[i % REGISTER_LANES]
    }
    #[inline(always)]
    fn eight(&self, i: usize) -> &F32x8 {
        &self.halves()[i % 2]
    }
}

/// Thirty-two places: two columns. A separate type, because packets of sixteen in it would use only half of a cache's
/// sets.
#[derive(Clone, Copy, Debug)]
pub struct WideColumn(pub [Column; 2]);

impl Memory for WideColumn {
    const ZERO: Self = Self([Column::ZERO; 2]);

    #[inline(always)]
    fn place(&self, i: usize) -> f32 {
        self.0[i / REGISTER_LANES % 2].place(i)
    }
    #[inline(always)]
    fn place_mut(&mut self, i: usize) -> &mut f32 {
        self.0[i / REGISTER_LANES % 2].place_mut(i)
    }
    #[inline(always)]
    fn eight(&self, i: usize) -> &F32x8 {
        self.0[i / (REGISTER_LANES / LANES) % 2].eight(i)
    }
}
