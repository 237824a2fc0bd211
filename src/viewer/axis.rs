//! Which axis points up, and the six sides of a mesh that stands on it.

use super::orbit::MAX_ELEVATION_DEGREES;
use crate::format::mesh::UpAxis;
use glam::{DMat3, DVec3};

/// The names of the six sides, in the order of their keys.
pub const SIDES: [&str; 6] = ["front", "right", "back", "left", "top", "bottom"];

/// The axis closest to a direction.
#[must_use]
pub fn nearest(direction: DVec3) -> UpAxis {
    let towards = |axis: &UpAxis| axis.vector().dot(direction);
    let nearest = UpAxis::ALL
        .into_iter()
        .max_by(|a, b| towards(a).total_cmp(&towards(b)));
    nearest.unwrap_or_default()
}

/// The axis that follows `now` when up is turned, which began at `first`. Of `y` and `z` the other one comes next: these two
/// are what files get wrong.
#[must_use]
pub fn next(now: UpAxis, first: UpAxis) -> UpAxis {
    let [second, third] = match first {
        UpAxis::X | UpAxis::MinusX => [UpAxis::Y, UpAxis::Z],
        UpAxis::Y | UpAxis::MinusY => [UpAxis::Z, UpAxis::X],
        UpAxis::Z | UpAxis::MinusZ => [UpAxis::Y, UpAxis::X],
    };
    let half = [first, second, third];
    let all = [half, half.map(UpAxis::opposite)];
    let all = all.as_flattened();
    let position = all.iter().position(|&axis| axis == now).unwrap_or(0);
    all[(position + 1) % all.len()]
}

/// The rotation that turns a mesh standing on one axis so that it stands on another, its front forwards. Its entries are 0, 1
/// and -1.
#[must_use]
pub fn turn(from: UpAxis, to: UpAxis) -> DMat3 {
    sides_of(to) * sides_of(from).transpose()
}

/// Right, up and front as columns.
fn sides_of(up: UpAxis) -> DMat3 {
    DMat3::from_cols(up.right(), up.vector(), up.front())
}

/// The direction from a mesh towards the viewer of side 0 to 5 of [`SIDES`], where `up` points up.
#[must_use]
pub fn side(up: UpAxis, side: usize) -> DVec3 {
    let (sin, cos) = libm::sincos(MAX_ELEVATION_DEGREES.to_radians());
    let sides = [
        DVec3::Z,
        DVec3::X,
        DVec3::NEG_Z,
        DVec3::NEG_X,
        DVec3::new(0.0, sin, cos),
        DVec3::new(0.0, -sin, cos),
    ];
    sides_of(up) * sides[side.min(sides.len() - 1)]
}

#[cfg(test)]
mod tests;
