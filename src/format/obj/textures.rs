//! Texture coordinates.

use super::Obj;
use crate::{
    format::{budget::BudgetError, place::Words},
    scene::is_usable,
};

/// How a material places its textures, by the options `-s` and `-o`: coordinates are scaled, then offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shift {
    pub(super) scale: [f32; 2],
    pub(super) offset: [f32; 2],
}

impl Shift {
    pub(super) const NONE: Self = Self {
        scale: [1.0; 2],
        offset: [0.0; 2],
    };

    /// Moves coordinates whose origin is at the upper left corner; the options mean the lower left one.
    pub(super) fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let moved = [
            u * self.scale[0] + self.offset[0],
            1.0 - ((1.0 - v) * self.scale[1] + self.offset[1]),
        ];
        if moved.into_iter().all(is_usable) {
            moved
        } else {
            [0.0; 2]
        }
    }
}

impl Obj<'_> {
    /// Keeps how the material that is added next places its textures.
    pub(super) fn add_shift(&mut self, shift: Shift) -> Result<(), BudgetError> {
        // An entry of a map that is half empty.
        const ENTRY_BYTES: usize = 64;
        if shift != Shift::NONE {
            self.budget.take(ENTRY_BYTES)?;
            self.shifts.insert(self.surfaces.len() as u32, shift);
        }
        Ok(())
    }

    /// Texture coordinates with their origin at the upper left corner; the file's is the lower left one. Some programs write
    /// NaN where there is no texture.
    pub(super) fn uv(&mut self, mut words: Words<'_>) -> [f32; 2] {
        let mut number = || {
            let (word, _) = words.next()?;
            fast_float2::parse::<f32, _>(word).ok()
        };
        let [u, v] = [number(), number()].map(Option::unwrap_or_default);
        if is_usable(u) && is_usable(v) {
            [u, 1.0 - v]
        } else {
            self.odd_uvs += 1;
            [0.0, 0.0]
        }
    }
}
