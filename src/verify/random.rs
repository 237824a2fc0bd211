//! The random numbers that scenes and rays are made from.

use glam::Vec3;
use oorandom::Rand32;

/// A stream of random numbers, the same on every machine: PCG (O'Neill 2014), by `oorandom`, whose output is fixed.
#[derive(Clone, Debug)]
pub struct Random(Rand32);

impl Random {
    /// Stream `stream` of `seed`.
    #[must_use]
    pub fn new(seed: u64, stream: u64) -> Self {
        Self(Rand32::new_inc(seed, stream))
    }

    /// Evenly in 0..`n`, which must be above 0.
    pub fn below(&mut self, n: u32) -> u32 {
        self.0.rand_range(0..n)
    }

    /// An index into something of that length (at most `u32::MAX`), which must be above 0.
    pub fn index(&mut self, length: usize) -> usize {
        self.below(length as u32) as usize
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    /// One of `choices`.
    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.index(choices.len())]
    }

    /// Evenly in [0, 1).
    pub fn unit(&mut self) -> f32 {
        self.0.rand_float()
    }

    /// Evenly in [-1, 1).
    pub fn signed(&mut self) -> f32 {
        self.unit() * 2.0 - 1.0
    }

    /// Evenly in the cube from -1 to 1.
    pub fn in_cube(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
}
