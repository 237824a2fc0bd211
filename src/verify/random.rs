//! Random numbers for scenes and rays.

use glam::Vec3;
use oorandom::Rand32;

/// A stream of random numbers, the same on every machine: PCG (O'Neill 2014), by `oorandom`, whose output is fixed.
#[derive(Clone, Debug)]
pub struct Random(Rand32);

impl Random {
    /// Makes stream `stream` of `seed`.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(Rand32::new_inc(seed, stream))
    }

    /// Returns an integer, uniform in 0..`n`; `n` must be above 0.
    pub fn below(&mut self, n: u32) -> u32 {
        self.0.rand_range(0..n)
    }

    /// Returns an index below `length`, which must be from 1 to `u32::MAX`.
    pub fn index(&mut self, length: usize) -> usize {
        self.below(length as u32) as usize
    }

    /// Returns true with a probability of 1/`n`.
    pub fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    /// Returns one of `choices`.
    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.index(choices.len())]
    }

    /// Returns a number, uniform in [0, 1).
    pub fn unit(&mut self) -> f32 {
        self.0.rand_float()
    }

    /// Returns a number, uniform in [-1, 1).
    pub fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    /// Returns a point, uniform in the cube from -1 to 1.
    pub fn in_cube(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
}
