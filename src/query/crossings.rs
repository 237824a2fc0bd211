//! Decides exactly which triangles a ray's line crosses where it meets an edge or a vertex: one of two at an edge, and an
//! even number of those of a closed mesh in total.
//!
//! The canonical test accepts all triangles that the ray touches. Here origin and direction are moved by infinitesimal
//! amounts, the same for all triangles, so that the line meets no edge: Edelsbrunner and Mücke, *Simulation of Simplicity*,
//! 1990. Differs: only the ray is moved, not the vertices, because several may have the same position.

use crate::{
    math::orientation::{Row, point, sign},
    ray::Ray,
};
use glam::Vec3;

/// The corners of a triangle that the line of a ray may pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing(pub [Vec3; 3]);

fn direction(d: Vec3) -> Row {
    [f64::from(d.x), f64::from(d.y), f64::from(d.z), 0.0]
}

fn axis(i: usize) -> Row {
    let mut row = [0.0; 4];
    row[i] = 1.0;
    row
}

/// The terms of the moved line's determinants in descending order: the axis along which the direction is moved, and that
/// of the origin. They are moved by e^1, e^2, e^4 and e^8, e^16, e^32 for an infinitesimal e. The ends of an edge differ
/// along some axis, so that some term is not 0.
const MOVES: [[Option<usize>; 2]; 13] = [
    [None, None],
    [Some(0), None],
    [Some(1), None],
    [Some(2), None],
    [None, Some(0)],
    [Some(1), Some(0)],
    [Some(2), Some(0)],
    [None, Some(1)],
    [Some(0), Some(1)],
    [Some(2), Some(1)],
    [None, Some(2)],
    [Some(0), Some(2)],
    [Some(1), Some(2)],
];

/// A ray's line, moved.
struct Line {
    origin: Row,
    direction: Row,
}

impl Line {
    /// The side of the line on which an edge passes: a number with that sign.
    fn side(&self, a: Row, b: Row) -> f64 {
        self.first_term(|[d, o]| sign([o, d, a, b]))
    }

    /// Whether the line passes through a triangle ahead of its origin.
    fn passes(&self, Crossing(corners): &Crossing) -> bool {
        let [a, b, c] = corners.map(point);
        let sides = [self.side(a, b), self.side(b, c), self.side(c, a)];
        let is_left = sides.iter().all(|&side| side > 0.0);
        let is_right = sides.iter().all(|&side| side < 0.0);
        if !is_left && !is_right {
            return false;
        }
        // Origin and direction are on different sides of the plane.
        let origin = self.first_term(|[_, o]| sign([a, b, c, o]));
        let along = self.first_term(|[d, _]| sign([a, b, c, d]));
        origin * along < 0.0
    }

    /// The first of the terms that is not 0, of direction and origin or what they are moved along.
    fn first_term(&self, term: impl Fn([Row; 2]) -> f64) -> f64 {
        let mut terms = MOVES
            .iter()
            .map(|&[d, o]| term([d.map_or(self.direction, axis), o.map_or(self.origin, axis)]));
        terms.find(|&sign| sign != 0.0).unwrap_or(0.0)
    }
}

/// Returns for each triangle whether the ray passes through it.
pub(super) fn decide(ray: &Ray, triangles: &[Crossing]) -> Vec<bool> {
    let line = Line {
        origin: point(ray.origin),
        direction: direction(ray.direction),
    };
    triangles.iter().map(|triangle| line.passes(triangle)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passed(ray: &Ray, triangles: &[Crossing]) -> usize {
        decide(ray, triangles)
            .into_iter()
            .filter(|&passes| passes)
            .count()
    }

    /// Fans around a vertex, and rays at it: one triangle is passed.
    #[test]
    fn one_triangle_of_a_fan_is_passed() {
        let mut random = fastrand::Rng::with_seed(11);
        for round in 0..2000 {
            let count = 3 + round % 6;
            let mut unit = || random.f32() * 2.0 - 1.0;
            let tip = Vec3::new(unit(), unit(), 5.0 + unit());
            let rim: Vec<Vec3> = (0..count)
                .map(|i| {
                    let angle = (i as f32) * std::f32::consts::TAU / count as f32;
                    Vec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 5.0 + unit())
                })
                .collect();
            let fan: Vec<Crossing> = (0..count)
                .map(|i| Crossing([tip, rim[i], rim[(i + 1) % count]]))
                .collect();
            let on_edge = tip.lerp(rim[0], 0.25);
            for to in [tip, on_edge] {
                assert_eq!(
                    passed(&Ray::new(Vec3::ZERO, to.normalize()), &fan),
                    1,
                    "{round} {to}"
                );
            }
        }
    }

    /// Closed meshes with corners on a grid, and rays along its lines: edges lie on the ray, vertices coincide.
    #[test]
    fn closed_meshes_on_a_grid_are_passed_evenly() {
        let mut random = fastrand::Rng::with_seed(12);
        for round in 0..3000 {
            let mut grid = || {
                Vec3::new(
                    random.i32(-2..=2) as f32,
                    random.i32(-2..=2) as f32,
                    random.i32(-2..=2) as f32,
                )
            };
            let mut triangles = Vec::new();
            for _ in 0..3 {
                let [a, b, c, d] = [grid(), grid(), grid(), grid()];
                let solid = [[a, c, b], [a, b, d], [b, c, d], [a, d, c]];
                if (b - a).cross(c - a).dot(d - a) != 0.0 {
                    triangles.extend(solid.map(Crossing));
                }
            }
            let origin = grid() - [Vec3::X, Vec3::ONE, Vec3::new(0.0, 3.0, 1.0)][round % 3] * 5.0;
            let way = [Vec3::X, Vec3::ONE, Vec3::new(0.0, 3.0, 1.0)][round % 3];
            assert_eq!(passed(&Ray::new(origin, way), &triangles) % 2, 0, "{round}");
        }
    }

    #[test]
    fn signs_are_those_of_whole_numbers() {
        let mut random = fastrand::Rng::with_seed(13);
        let mut zeros = 0;
        for round in 0..20_000 {
            let most = [2, 9, 4000, 1 << 37][round % 4];
            let mut rows = [[0_i128; 4]; 4];
            for (i, row) in rows.iter_mut().enumerate() {
                *row = std::array::from_fn(|_| i128::from(random.i64(-most..=most)));
                row[3] = i128::from(i != 1);
            }
            if round % 2 == 0 {
                // Nearly in one plane, far away.
                for row in &mut rows {
                    row[2] = row[0] + row[1] + row[3] * 100_000;
                }
                rows[3][0] += i128::from(random.i64(0..2));
            }
            let minor = |skip: usize| {
                let at: Vec<usize> = (0..4).filter(|&i| i != skip).collect();
                let m = |i: usize, j: usize| rows[at[i]][j];
                m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1))
                    - m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0))
                    + m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0))
            };
            let expected: i128 = (0..4)
                .map(|i| rows[i][3] * minor(i) * if i % 2 == 0 { -1 } else { 1 })
                .sum();
            let found = sign(rows.map(|row| row.map(|number| number as f64)));
            assert_eq!(found.partial_cmp(&0.0), Some(expected.cmp(&0)), "{rows:?}");
            zeros += u32::from(expected == 0);
        }
        assert!(zeros > 1000);
    }
}
