//! Texture coordinates.

use super::Obj;
use crate::{format::place::Words, scene::is_usable};

impl Obj<'_> {
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
