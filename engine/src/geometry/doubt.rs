//! Decides in `f64`, where differences of corners are exact, what `f32` cannot: whether rays meet triangles.

use crate::math::orientation::{self, point};
use glam::{DVec3, Vec3};
use std::cell::Cell;

/// Bound on the rounding error of an edge function, as a fraction of |C - A| (|C| + |A|): one half-ulp each for the
/// two vectors, two for corners that the sum sees rounded and the difference does not, 3.5 for the cross product, 3
/// for the dot product, and one to spare.
const EDGE_ERROR: f64 = 11.5 / (1 << 24) as f64;

/// [`EDGE_ERROR`] of edge functions in `f64`.
const EDGE_ERROR_64: f64 = 11.5 / (1_u64 << 53) as f64;

/// Bound on the rounding error of the side on which a ray starts in `f32`, as a fraction of
/// [`Edges::permanent`](super::Edges::permanent) times the first corner: two half-ulps for the edges, two for the cross
/// product, one for the corner, three for the dot product, and one to spare.
const PLANE_ERROR: f64 = 9.0 / (1 << 24) as f64;

/// [`PLANE_ERROR`] in `f64`.
const PLANE_ERROR_64: f64 = 9.0 / (1_u64 << 53) as f64;

/// More than the rounding error of a product of two corners' offsets from a ray in `f64`, as a fraction of their
/// distances from its origin: four half-ulps an offset, three for the product, and as many to spare.
const ASIDE_ERROR_64: f64 = 22.0 / (1_u64 << 53) as f64;

thread_local! {
    static ON_PLANES: Cell<u64> = const { Cell::new(0) };
}

/// How often a ray that this thread traced started exactly on the plane of a triangle. It grows whenever a query that was
/// not ended by a hit before meets such a triangle.
pub(crate) fn starts_on_planes() -> u64 {
    ON_PLANES.get()
}

/// Decides in `f64` whether a ray meets a triangle, edges included. Also returns weights and t: those of `f32`, unless
/// `f32` does not determine the side of the plane on which the ray starts.
///
/// `direction` is of unit length. The columns are the edge functions, flipped towards the ray, t, and the interval of the
/// triangle's box, which t is held to.
#[cold]
#[inline(never)]
#[must_use]
pub(crate) fn meets(
    origin: Vec3,
    direction: Vec3,
    corners: [Vec3; 3],
    columns: [f32; 4],
    [near, far]: [f32; 2],
) -> (bool, [f32; 4]) {
    // Not `map` of arrays: it is not inlined here.
    let [v0, v1, v2] = [
        corners[0].as_dvec3(),
        corners[1].as_dvec3(),
        corners[2].as_dvec3(),
    ];
    let (d, start) = (direction.as_dvec3(), origin.as_dvec3());
    let (e1, e2, a) = (v1 - v0, v2 - v0, v0 - start);
    let normal = e1.cross(e2);
    let plane = normal.dot(a);
    let (e1, e2) = (e1.abs(), e2.abs());
    let permanent = DVec3::new(
        e1.y * e2.z + e1.z * e2.y,
        e1.z * e2.x + e1.x * e2.z,
        e1.x * e2.y + e1.y * e2.x,
    );
    let size = permanent.dot(a.abs());
    let edges = LineAndEdges::new(d, [a, v1 - start, v2 - start], [v2 - v0, v0 - v1, v1 - v2]);
    if plane.abs() > size * PLANE_ERROR {
        let [u, v, w, t] = columns;
        return (
            t > 0.0 && edges.pass([u, v, w].map(f64::from), EDGE_ERROR),
            columns,
        );
    }
    let is_known = plane.abs() > size * PLANE_ERROR_64;
    // The ray starts on the plane and meets it nowhere else, unless it lies in the plane and meets neighbouring triangles.
    if !is_known && orientation::sign([corners[0], corners[1], corners[2], origin].map(point)) == 0.0 {
        ON_PLANES.set(ON_PLANES.get().wrapping_add(1));
        return (false, columns);
    }
    let side = if is_known {
        plane
    } else {
        edges.weights.iter().sum()
    };
    let sign = 1.0_f64.copysign(side);
    let weights = [
        edges.weights[0] * sign,
        edges.weights[1] * sign,
        edges.weights[2] * sign,
    ];
    let t = ((plane / normal.dot(d)) as f32).max(near).min(far);
    let error = if is_known { EDGE_ERROR_64 } else { f64::INFINITY };
    let [u, v, w] = [weights[0] as f32, weights[1] as f32, weights[2] as f32];
    (t > 0.0 && edges.pass(weights, error), [u, v, w, t])
}

/// The line of a ray and the edges of a triangle, in `f64`.
struct LineAndEdges {
    direction: DVec3,
    /// Corners relative to the origin.
    corners: [DVec3; 3],
    /// The edge functions, not flipped: weights of second corner, third, first.
    weights: [f64; 3],
    /// Sizes that their rounding errors are relative to.
    sizes: [f64; 3],
}

impl LineAndEdges {
    /// Edges in the order of the weights.
    fn new(direction: DVec3, corners: [DVec3; 3], edges: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let sums = [c + a, a + b, b + c];
        let lengths = [a.length(), b.length(), c.length()];
        Self {
            direction,
            corners,
            weights: [
                direction.dot(edges[0].cross(sums[0])),
                direction.dot(edges[1].cross(sums[1])),
                direction.dot(edges[2].cross(sums[2])),
            ],
            sizes: [
                edges[0].length() * (lengths[2] + lengths[0]),
                edges[1].length() * (lengths[0] + lengths[1]),
                edges[2].length() * (lengths[1] + lengths[2]),
            ],
        }
    }

    /// Whether the line passes through the triangle, edges included. `flipped`: weights that are positive where the
    /// triangle is ahead; what is negative beyond their error, as a fraction of the largest size, is behind.
    fn pass(&self, flipped: [f64; 3], error: f64) -> bool {
        let largest = self.sizes.into_iter().fold(0.0, f64::max);
        if flipped.iter().any(|&weight| weight < -error * largest) {
            return false;
        }
        let (mut left, mut right, mut small) = (true, true, 0);
        for (weight, size) in self.weights.into_iter().zip(self.sizes) {
            left &= weight >= 0.0;
            right &= weight <= 0.0;
            small += u32::from(weight.abs() <= EDGE_ERROR_64 * size);
        }
        if small < 2 {
            return left || right;
        }
        // At a vertex, or a triangle that is a line for the ray: between two corners?
        let (d, lengths) = (self.direction, self.corners.map(DVec3::length));
        let aside = self
            .corners
            .map(|corner| corner - d * (corner.dot(d) / d.length_squared()));
        [[0, 1], [1, 2], [2, 0]]
            .into_iter()
            .any(|[p, q]| aside[p].dot(aside[q]) <= lengths[p] * lengths[q] * ASIDE_ERROR_64)
    }
}
