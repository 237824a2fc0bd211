//! The background: the colour of rays that leave the scene.

use super::{Environment, Scene};
use crate::{
    math::{max, min},
    simd::{Portable, Simd},
};
use glam::Vec3;

/// A constant colour, or a vertical gradient. It depends only on a ray's direction, so mirrors show it as well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    /// Colour straight down (-z), linear RGB.
    pub bottom: [f32; 3],
    /// Colour straight up (+z), linear RGB.
    pub top: [f32; 3],
}

impl Background {
    /// Makes a background of one colour, linear RGB.
    #[must_use]
    pub const fn constant(color: [f32; 3]) -> Self {
        Self {
            bottom: color,
            top: color,
        }
    }

    /// Returns whether the colour is the same in all directions.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        self.difference() == [0.0; 3]
    }

    /// Returns `top - bottom`.
    #[inline]
    #[must_use]
    pub fn difference(&self) -> [f32; 3] {
        let ([top_r, top_g, top_b], [r, g, b]) = (self.top, self.bottom);
        [top_r - r, top_g - g, top_b - b]
    }

    /// Returns the colour along `direction`, a unit vector: `bottom + (z + 1) / 2 * (top - bottom)`.
    #[inline]
    #[must_use]
    pub fn color(&self, direction: Vec3) -> [f32; 3] {
        self.color_at(Portable, direction)
    }

    /// [`Self::color`] at a level.
    #[inline(always)]
    pub(crate) fn color_at<S: Simd>(&self, simd: S, direction: Vec3) -> [f32; 3] {
        let share = min(max(simd.mul_add(direction.z, 0.5, 0.5), 0.0), 1.0);
        let mut color = self.bottom;
        for (channel, difference) in color.iter_mut().zip(self.difference()) {
            *channel = simd.mul_add(share, difference, *channel);
        }
        color
    }
}

impl Scene {
    /// Returns the colour of a ray that leaves the scene along `direction`, a unit vector.
    #[inline(always)]
    #[doc(hidden)]
    pub fn background_color<S: Simd>(&self, simd: S, direction: Vec3) -> [f32; 3] {
        match &self.environment {
            Some(environment @ Environment::Picture(_)) => environment.color(direction),
            _ => self.background.color_at(simd, direction),
        }
    }

    /// Returns whether all rays that leave the scene have one colour.
    #[must_use]
    pub(crate) fn has_constant_background(&self) -> bool {
        !matches!(self.environment, Some(Environment::Picture(_))) && self.background.is_constant()
    }
}

#[cfg(test)]
mod tests;
