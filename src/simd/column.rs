//! Memory for the lanes of one vector.

use super::{F32x8, LANES, lanes::REGISTER_LANES};
use std::fmt::Debug;

/// Places for as many lanes as a vector has, or more.
pub trait Memory: Copy + Debug {
    /// All places 0.
    const ZERO: Self;
    /// What place `i` holds, counted around.
    fn place(&self, i: usize) -> f32;
    /// Place `i`, counted around.
    fn place_mut(&mut self, i: usize) -> &mut f32;
    /// Places 8 i to 8 i + 7, counted around.
    fn eight(&self, i: usize) -> F32x8;
}

/// Sixteen places; a vector of eight lanes uses the first eight.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct Column(pub [f32; REGISTER_LANES]);

impl Column {
    /// The same number in all places.
    #[inline(always)]
    #[must_use]
    pub fn splat(a: f32) -> Self {
        Self([a; REGISTER_LANES])
    }

    /// Places 0 to 7, then 8 to 15. (A cast of the numbers alone asks at each load whether they lie at a multiple of 32:
    /// kernels of eight lanes 1 to 4 % slower.)
    #[inline(always)]
    #[must_use]
    pub fn halves(&self) -> &[F32x8; 2] {
        bytemuck::must_cast_ref(self)
    }

    /// Places 0 to 7, then 8 to 15.
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
    fn eight(&self, i: usize) -> F32x8 {
        self.halves()[i % 2]
    }
}

/// Thirty-two places: two columns. (A type of its own, for packets of sixteen in such columns use half of a cache's sets:
/// in a prototype they were up to 10 % slower, whatever else it did to them included.)
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
    fn eight(&self, i: usize) -> F32x8 {
        self.0[i / (REGISTER_LANES / LANES) % 2].eight(i)
    }
}
