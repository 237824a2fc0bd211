//! Checkerboards in space, filtered analytically.

use super::material::check_color;
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
        if !value.is_finite() {
            return Err(SceneError::NotUsable { what, value });
        }
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
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_many_points() {
        for (at, width) in [
            (0.3, 0.2),
            (0.9, 0.5),
            (-0.1, 0.7),
            (-7.3, 3.1),
            (1e6 + 0.2, 1.3),
            (5.5, 40.3),
        ] {
            const COUNT: u32 = 100_000;
            let sum: f64 = (0..COUNT)
                .map(|i| at + width * ((f64::from(i) + 0.5) / f64::from(COUNT) - 0.5))
                .map(|at| mean(at, 0.0))
                .sum();
            let found = mean(at, width);
            assert!(
                (found - sum / f64::from(COUNT)).abs() < 1e-4,
                "{at} {width}: {found}"
            );
        }
        for (at, width) in [
            (f64::NAN, 1.0),
            (0.5, f64::NAN),
            (0.5, f64::INFINITY),
            (f64::INFINITY, 0.0),
        ] {
            assert_eq!(mean(at, width), 0.0);
        }
    }

    const CHECKER: Checker = Checker {
        colors: [[1.0, 0.5, 0.0], [0.0, 0.5, 1.0]],
        size: 0.25,
    };

    #[test]
    fn cells_alternate_along_every_axis() {
        for i in -3..4_i32 {
            for axis in 0..3 {
                let mut point = DVec3::new(0.1, 0.05, 0.2);
                point[axis] += 0.25 * f64::from(i);
                let color = CHECKER.color(point, Vec3::Z, Vec3::new(0.0, 0.6, -0.8), 0.0);
                assert_eq!(
                    color,
                    CHECKER.colors[usize::from(i.rem_euclid(2) == 1)],
                    "{i} {axis}"
                );
            }
        }
    }

    /// On a face between two layers rounding changes nothing, from either side.
    #[test]
    fn faces_between_cells_show_one_of_them() {
        for normal in [Vec3::Z, Vec3::NEG_Z] {
            for z in [0.75 - 1e-8, 0.75, 0.75 + 1e-8] {
                let color = CHECKER.color(DVec3::new(0.1, 0.1, z), normal, -normal, 1e-9);
                assert_eq!(color, CHECKER.colors[1]);
            }
        }
    }

    #[test]
    fn far_away_there_is_the_mean() {
        let grazing = Vec3::new(1.0, 0.0, -1e-4).normalize();
        for (direction, width) in [(grazing, 0.01), (Vec3::X, 0.01), (Vec3::NEG_Z, 100.0)] {
            let color = CHECKER.color(DVec3::new(3.1, 0.125, 0.0), Vec3::Z, direction, width);
            assert!(color.iter().all(|c| (c - 0.5).abs() < 0.01), "{color:?}");
        }
    }
}
