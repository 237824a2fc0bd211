//! The offset of a mesh far from 0: it is subtracted from each coordinate in `f64`, before that is rounded to `f32`.

use crate::scene::is_usable;
use glam::DVec3;

/// What the coordinates of a file are read relative to; 0 for nearly all files.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Offset(Option<DVec3>);

impl Offset {
    /// Coordinates as they are in the file.
    pub(super) const NONE: Self = Self(None);

    pub(super) fn new(offset: DVec3) -> Self {
        Self(Some(offset).filter(|offset| *offset != DVec3::ZERO))
    }

    pub(super) fn is_none(self) -> bool {
        self.0.is_none()
    }

    /// The offset; 0 without one.
    #[cfg(any(feature = "gltf", feature = "threemf"))]
    pub(super) fn vector(self) -> DVec3 {
        self.0.unwrap_or_default()
    }

    /// A coordinate of a file. One that is NaN or too large stays so.
    #[inline]
    pub(super) fn relative(self, axis: usize, value: f64) -> f32 {
        match self.0 {
            Some(offset) if is_usable(value as f32) => (value - offset[axis]) as f32,
            _ => value as f32,
        }
    }

    /// The number that a word of a text is. Without an offset it is rounded to `f32` once.
    #[inline]
    pub(super) fn parse(self, axis: usize, word: &[u8]) -> Result<f32, fast_float2::Error> {
        if self.is_none() {
            return fast_float2::parse(word);
        }
        fast_float2::parse(word).map(|value| self.relative(axis, value))
    }
}

#[cfg(test)]
mod tests;
