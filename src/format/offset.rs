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
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_rounded_once() {
        let offset = Offset::new(DVec3::new(500_000.0, 4e6, 0.0));
        assert_eq!(offset.parse(0, b"500000.0009765625"), Ok(0.000_976_562_5));
        assert_eq!(offset.parse(1, b"3999999.9"), Ok((3_999_999.9_f64 - 4e6) as f32));
        assert_eq!(offset.parse(2, b"0.1"), Ok(0.1));
        assert!(offset.parse(0, b"x").is_err());
        // Unusable with an offset as without one.
        for word in [&b"nan"[..], b"1.0004e9", b"-inf", b"1e39"] {
            let [with, without] = [offset, Offset::NONE].map(|offset| offset.parse(0, word).unwrap());
            assert_eq!(with.to_bits(), without.to_bits());
        }
        assert!(Offset::new(DVec3::ZERO).is_none());
        // Rounding by way of f64 would give 1.
        let above_halfway = b"1.00000005960464477539062500001";
        assert_eq!(Offset::NONE.parse(0, above_halfway), Ok(1.0 + f32::EPSILON));
    }
}
