//! Transfer functions from linear channels to bytes.

use super::quantize;
use crate::math::srgb::decode;
use std::sync::OnceLock;

/// The transfer function from linear light to bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Transfer {
    /// trunc(255 x clamp(c)), as classic pictures have it.
    #[default]
    Linear,
    /// The sRGB curve (IEC 61966-2-1), rounded to nearest.
    Srgb,
}

impl Transfer {
    /// Encodes a linear colour.
    #[inline]
    #[must_use]
    pub fn encode(self, rgb: [f32; 3]) -> [u8; 3] {
        match self {
            Self::Linear => rgb.map(quantize),
            Self::Srgb => {
                let steps = srgb_steps();
                // A search instead of `powf`: as fast, and the same on every machine.
                rgb.map(|c| steps.partition_point(|&step| step <= c) as u8)
            }
        }
    }
}

/// Returns the smallest linear value of each byte except 0, ascending.
fn srgb_steps() -> &'static [f32; 255] {
    static STEPS: OnceLock<[f32; 255]> = OnceLock::new();
    STEPS.get_or_init(|| {
        let mut steps = [0.0; 255];
        for (i, step) in steps.iter_mut().enumerate() {
            *step = decode((i as f64 + 0.5) / 255.0) as f32;
        }
        steps
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_is_the_standards_curve() {
        let encode = |c: f32| Transfer::Srgb.encode([c; 3])[0];
        for (linear, byte) in [
            (-1.0, 0),
            (0.0, 0),
            (0.5, 188),
            (0.215_861, 128),
            (1.0, 255),
            (9.0, 255),
            (f32::NAN, 0),
        ] {
            assert_eq!(encode(linear), byte, "{linear}");
        }
        for byte in 0..=255 {
            assert_eq!(encode(decode(f64::from(byte) / 255.0) as f32), byte);
        }
        assert_eq!(Transfer::Linear.encode([0.5; 3]), [127; 3]);
    }
}
