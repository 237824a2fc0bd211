//! Which axis points up, and the six sides of a mesh that stands on it.

use super::orbit::MAX_ELEVATION_DEGREES;
use glam::{DMat3, DVec3};

/// An axis of the scene, or its opposite.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    index: usize,
    is_negative: bool,
}

/// The names of the six sides, in the order of their keys.
pub const SIDES: [&str; 6] = ["front", "right", "back", "left", "top", "bottom"];

impl Axis {
    /// The axis closest to a direction.
    #[must_use]
    pub fn nearest(direction: DVec3) -> Self {
        let index = direction.abs().max_position();
        Self {
            index,
            is_negative: direction[index] < 0.0,
        }
    }

    /// The unit vector.
    #[must_use]
    pub fn vector(self) -> DVec3 {
        let positive = DVec3::AXES[self.index];
        if self.is_negative { -positive } else { positive }
    }

    /// The name as `--up-axis` takes it.
    #[must_use]
    pub fn name(self) -> &'static str {
        [["x", "y", "z"], ["-x", "-y", "-z"]][usize::from(self.is_negative)][self.index]
    }

    /// The axes that follow this one when up is turned, which began at `first`. Of `y` and `z` the other one comes
    /// next: these two are what files get wrong.
    pub fn next(self, first: Self) -> impl Iterator<Item = Self> {
        let others = match first.index {
            0 => [1, 2],
            1 => [2, 0],
            _ => [1, 0],
        };
        let axis = |index, is_negative| Self { index, is_negative };
        let opposite = !first.is_negative;
        let all = [
            first,
            axis(others[0], false),
            axis(others[1], false),
            axis(first.index, opposite),
            axis(others[0], true),
            axis(others[1], true),
        ];
        let position = all.iter().position(|&axis| axis == self).unwrap_or(0);
        all.into_iter().cycle().skip(position + 1).take(all.len() - 1)
    }

    /// The rotation that turns a mesh standing on this axis so that it stands on another.
    #[must_use]
    pub fn turn_to(self, other: Self) -> DMat3 {
        other.turn_from_y() * self.turn_from_y().transpose()
    }

    /// The rotation that turns a mesh with `y` up and its front towards `z`. Its entries are 0, 1 and -1.
    fn turn_from_y(self) -> DMat3 {
        use DVec3 as V;
        match (self.index, self.is_negative) {
            (0, false) => DMat3::from_cols(V::NEG_Y, V::X, V::Z),
            (0, true) => DMat3::from_cols(V::Y, V::NEG_X, V::Z),
            (1, false) => DMat3::IDENTITY,
            (1, true) => DMat3::from_cols(V::X, V::NEG_Y, V::NEG_Z),
            (_, false) => DMat3::from_cols(V::X, V::Z, V::NEG_Y),
            (_, true) => DMat3::from_cols(V::X, V::NEG_Z, V::Y),
        }
    }

    /// The direction from a mesh towards the viewer of side 0 to 5 of [`SIDES`], where this axis points up.
    #[must_use]
    pub fn side(self, side: usize) -> DVec3 {
        let (sin, cos) = libm::sincos(MAX_ELEVATION_DEGREES.to_radians());
        let sides = [
            DVec3::Z,
            DVec3::X,
            DVec3::NEG_Z,
            DVec3::NEG_X,
            DVec3::new(0.0, sin, cos),
            DVec3::new(0.0, -sin, cos),
        ];
        self.turn_from_y() * sides[side.min(sides.len() - 1)]
    }
}

#[cfg(test)]
mod tests;
