//! What a ray sees that leaves the scene.

use crate::math::{max, min, mul_add};
use glam::Vec3;

/// The background: one colour, or a gradient from straight down to straight up. It depends on a ray's direction
/// alone, so that mirrors show it as well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    /// Colour of a ray that goes straight down (-z), linear RGB.
    pub bottom: [f32; 3],
    /// Colour of a ray that goes straight up (+z), linear RGB.
    pub top: [f32; 3],
}

impl Background {
    /// One colour everywhere, linear RGB.
    #[must_use]
    pub const fn constant(color: [f32; 3]) -> Self {
        Self {
            bottom: color,
            top: color,
        }
    }

    /// Whether it is the same colour everywhere.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.rise() == [0.0; 3]
    }

    /// What is added to `bottom` on the way to straight up; 0 where there is one colour only.
    #[inline]
    #[must_use]
    pub fn rise(&self) -> [f32; 3] {
        std::array::from_fn(|channel| self.top[channel] - self.bottom[channel])
    }

    /// Colour of a ray along `direction`, a unit vector: `bottom + (z + 1) / 2 * (top - bottom)`.
    #[inline]
    #[must_use]
    pub fn color(&self, direction: Vec3) -> [f32; 3] {
        let share = min(max(mul_add(direction.z, 0.5, 0.5), 0.0), 1.0);
        let rise = self.rise();
        std::array::from_fn(|channel| mul_add(share, rise[channel], self.bottom[channel]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_colour_is_exact_in_every_direction() {
        let background = Background::constant([1.0, 0.3, 0.0]);
        for direction in [Vec3::Z, -Vec3::Z, Vec3::new(0.6, 0.0, 0.8)] {
            assert_eq!(background.color(direction), [1.0, 0.3, 0.0]);
        }
    }

    #[test]
    fn a_gradient_runs_from_below_to_above() {
        let background = Background {
            bottom: [0.0, 1.0, 0.25],
            top: [1.0, 0.0, 0.75],
        };
        assert_eq!(background.color(-Vec3::Z), [0.0, 1.0, 0.25]);
        assert_eq!(background.color(Vec3::X), [0.5, 0.5, 0.5]);
        assert_eq!(background.color(Vec3::Z), [1.0, 0.0, 0.75]);
    }
}
