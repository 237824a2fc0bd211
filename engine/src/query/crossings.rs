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

fn axis(i: usize, way: f64) -> Row {
    let mut row = [0.0; 4];
    row[i] = way;
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
pub(super) struct Line {
    pub origin: Row,
    pub direction: Row,
    /// 1, or -1 to move it the opposite way.
    pub way: f64,
}

impl Line {
    /// The side of the line on which an edge passes: a number with that sign.
    fn side(&self, a: Row, b: Row) -> f64 {
        self.first_term(|[d, o]| sign([o, d, a, b]))
    }

    /// Whether the line passes through a triangle, ahead of its origin or behind. `sides` are those of the edges for the line as
    /// it was, or 0.
    pub(super) fn pierces(&self, corners: [Vec3; 3], mut sides: [f64; 3]) -> bool {
        let [a, b, c] = corners.map(point);
        let edges = [[a, b], [b, c], [c, a]];
        for (side, [from, to]) in sides.iter_mut().zip(edges) {
            if *side == 0.0 {
                *side = self.side(from, to);
            }
        }
        sides.iter().all(|&side| side > 0.0) || sides.iter().all(|&side| side < 0.0)
    }

    /// Whether the line passes through a triangle ahead of its origin.
    fn passes(&self, &Crossing(corners): &Crossing) -> bool {
        if !self.pierces(corners, [0.0; 3]) {
            return false;
        }
        let [a, b, c] = corners.map(point);
        // Origin and direction are on different sides of the plane.
        let origin = self.first_term(|[_, o]| sign([a, b, c, o]));
        let along = self.first_term(|[d, _]| sign([a, b, c, d]));
        origin * along < 0.0
    }

    /// The first of the terms that is not 0, of direction and origin or what they are moved along.
    fn first_term(&self, term: impl Fn([Row; 2]) -> f64) -> f64 {
        let moved = |row: Row, along: Option<usize>| along.map_or(row, |i| axis(i, self.way));
        let mut terms = MOVES
            .iter()
            .map(|&[d, o]| term([moved(self.direction, d), moved(self.origin, o)]));
        terms.find(|&sign| sign != 0.0).unwrap_or(0.0)
    }
}

/// Returns for each triangle whether the ray passes through it.
pub(super) fn decide(ray: &Ray, triangles: &[Crossing]) -> Vec<bool> {
    let line = Line {
        origin: point(ray.origin),
        direction: direction(ray.direction),
        way: 1.0,
    };
    triangles.iter().map(|triangle| line.passes(triangle)).collect()
}

#[cfg(test)]
mod tests;
