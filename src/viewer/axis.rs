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
mod tests {
    use super::*;

    const DIRECTIONS: [DVec3; 6] = [
        DVec3::X,
        DVec3::Y,
        DVec3::Z,
        DVec3::NEG_X,
        DVec3::NEG_Y,
        DVec3::NEG_Z,
    ];

    #[test]
    fn turns_are_rotations_from_axis_to_axis() {
        for from in DIRECTIONS.map(Axis::nearest) {
            for to in DIRECTIONS.map(Axis::nearest) {
                let turn = from.turn_to(to);
                assert_eq!(turn * from.vector(), to.vector());
                assert_eq!(turn.determinant(), 1.0);
                assert_eq!(turn * turn.transpose(), DMat3::IDENTITY);
                assert_eq!(turn * from.side(0), to.side(0));
            }
        }
    }

    #[test]
    fn up_cycles_through_all_axes() {
        for (first, expected) in [
            (DVec3::Y, ["z", "x", "-y", "-z", "-x"]),
            (DVec3::Z, ["y", "x", "-z", "-y", "-x"]),
            (DVec3::X, ["y", "z", "-x", "-y", "-z"]),
            (DVec3::NEG_Y, ["z", "x", "y", "-z", "-x"]),
        ] {
            let first = Axis::nearest(first);
            let names: Vec<&str> = first.next(first).map(Axis::name).collect();
            assert_eq!(names, expected);
            // One by one, all the way round.
            let mut axis = first;
            for name in expected.into_iter().chain([first.name()]) {
                axis = axis.next(first).next().unwrap();
                assert_eq!(axis.name(), name);
            }
        }
    }

    #[test]
    fn the_nearest_axis_has_the_sign_of_the_direction() {
        assert_eq!(Axis::nearest(DVec3::new(0.1, -0.9, 0.2)).name(), "-y");
        assert_eq!(Axis::nearest(DVec3::new(0.1, 0.3, 0.4)).vector(), DVec3::Z);
    }

    #[test]
    fn sides_look_from_around_above_and_below() {
        for up in DIRECTIONS {
            let axis = Axis::nearest(up);
            let heights: Vec<f64> = (0..6).map(|side| axis.side(side).dot(up)).collect();
            assert_eq!(heights[..4], [0.0; 4]);
            assert!(heights[4] > 0.999 && heights[5] < -0.999);
            // Seen from above, front, right, back and left follow each other anticlockwise.
            for side in 0..4 {
                let cross = axis.side(side).cross(axis.side((side + 1) % 4));
                assert_eq!(cross, up);
            }
        }
    }
}
