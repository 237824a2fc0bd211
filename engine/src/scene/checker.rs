//! Checkerboards in space, filtered analytically.

use super::{builder::usable, material::check_color};
use crate::error::SceneError;
use glam::{DVec3, Vec3};

/// A checkerboard that fills space: cubes along the axes of the scene, with two alternating colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checker {
    /// The colour of the cell from the scene's origin to (size, size, size), and that of its neighbours: linear RGB from 0
    /// to 1.
    pub colors: [[f32; 3]; 2],
    /// The side of a cell, scene units, above 0.
    pub size: f32,
}

/// Points are moved by this share of a cell along the normal, towards the positive side of its largest component, so that
/// a face between two layers of cells shows only one of them, however its points are rounded.
const NUDGE: f64 = 1.0 / 1024.0;

/// Footprints of more cells than this have the mean colour.
const MANY_CELLS: f64 = 1e6;

impl Checker {
    /// Rejects constants out of range.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        self.colors.into_iter().try_for_each(check_color)?;
        let (what, value) = ("size", self.size);
        usable(what, value)?;
        if value <= 0.0 {
            return Err(SceneError::NotPositive { what, value });
        }
        Ok(())
    }

    /// Returns the mean colour within a ray's cone at a point of the scene. `width`: of the cone there; `normal`: a unit normal
    /// of the surface.
    ///
    /// It is the product of the means over the footprint's extent along each axis, which is exact on a face across one of the
    /// axes (Quilez, *Filterable Procedurals*, 2017).
    pub(super) fn color(&self, point: DVec3, normal: Vec3, direction: Vec3, width: f32) -> [f32; 3] {
        let (normal, direction) = (normal.as_dvec3(), direction.as_dvec3());
        let size = f64::from(self.size);
        let [x, y, z] = normal.to_array();
        let largest = if x.abs() >= y.abs() && x.abs() >= z.abs() {
            x
        } else if y.abs() >= z.abs() {
            y
        } else {
            z
        };
        let point = point / size + normal * NUDGE.copysign(largest);
        let toward = x * direction.x + y * direction.y + z * direction.z;
        let width = f64::from(width) / size;
        let mut product = 1.0;
        for axis in 0..3 {
            // The footprint is the ray's disc, moved along the ray onto the surface.
            let slope = direction[axis] / toward;
            let square = 1.0 - 2.0 * normal[axis] * slope + slope * slope;
            // NaN passes: such rays run along the surface.
            let stretch = if square < 0.0 { 0.0 } else { square.sqrt() };
            product *= mean(point[axis], width * stretch);
        }
        let share = (0.5 - 0.5 * product) as f32;
        let [own, other] = self.colors;
        std::array::from_fn(|c| own[c] + (other[c] - own[c]) * share)
    }
}

/// Returns the mean over `width` around `at` of the function that is 1 in [0, 1), -1 in [1, 2), and so on.
fn mean(at: f64, width: f64) -> f64 {
    if !(width < MANY_CELLS && at.is_finite()) {
        return 0.0;
    }
    if width < 1e-6 {
        return if at.rem_euclid(2.0) < 1.0 { 1.0 } else { -1.0 };
    }
    let (from, to) = (at - 0.5 * width, at + 0.5 * width);
    // Near its start, so that the difference keeps its digits.
    let start = 2.0 * (from / 2.0).floor();
    (integral(to - start) - integral(from - start)) / width
}

/// Returns the integral from 0 on.
fn integral(at: f64) -> f64 {
    let within = at.rem_euclid(2.0);
    within.min(2.0 - within)
}

#[cfg(test)]
mod tests;
