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
    /// Returns a linear colour that is encoded as these bytes.
    #[must_use]
    pub fn decode(self, bytes: [u8; 3]) -> [f32; 3] {
        match self {
            // The middle of the interval, because fractions are cut off.
            Self::Linear => bytes.map(|byte| ((f32::from(byte) + 0.5) / 255.0).min(1.0)),
            Self::Srgb => bytes.map(|byte| decode(f64::from(byte) / 255.0) as f32),
        }
    }

    /// Encodes a linear colour.
    #[inline]
    #[must_use]
    pub fn encode(self, rgb: [f32; 3]) -> [u8; 3] {
        match self {
            Self::Linear => rgb.map(quantize),
            Self::Srgb => {
                let curve = srgb_curve();
                rgb.map(|c| curve.encode(c))
            }
        }
    }
}

/// The sRGB curve as a table: faster than `powf`, and the same on every machine.
struct Curve {
    /// The smallest linear value of the byte after each.
    steps: [f32; 256],
    /// The byte of the lowest value of each interval. Intervals are so narrow that they hold at most one step.
    bytes: [u8; INTERVALS],
}

/// Below it every value is byte 0.
const LOWEST: f32 = 1.0 / 8192.0;
/// Low bits of a float that do not select its interval: 128 intervals have the same exponent.
const SHIFT: u32 = 16;
/// Those from [`LOWEST`] to 1.
const INTERVALS: usize = ((1.0_f32.to_bits() - LOWEST.to_bits()) >> SHIFT) as usize + 1;

impl Curve {
    #[inline(always)]
    fn encode(&self, channel: f32) -> u8 {
        // The comparison is false for NaN.
        let c = if channel > LOWEST {
            channel.min(1.0)
        } else {
            LOWEST
        };
        let interval = (c.to_bits() - LOWEST.to_bits()) >> SHIFT;
        let byte = self.bytes[interval as usize];
        byte + u8::from(c >= self.steps[usize::from(byte)])
    }
}

fn srgb_curve() -> &'static Curve {
    static CURVE: OnceLock<Curve> = OnceLock::new();
    CURVE.get_or_init(|| {
        let mut steps = [f32::INFINITY; 256];
        for (i, step) in steps[..255].iter_mut().enumerate() {
            *step = decode((i as f64 + 0.5) / 255.0) as f32;
        }
        let mut bytes = [0; INTERVALS];
        for (i, byte) in (0..).zip(&mut bytes) {
            let lowest = f32::from_bits(LOWEST.to_bits() + (i << SHIFT));
            *byte = steps.partition_point(|&step| step <= lowest) as u8;
        }
        Curve { steps, bytes }
    })
}

#[cfg(test)]
mod tests;
