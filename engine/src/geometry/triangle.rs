//! Rays against triangles: the scalar triple product form of Möller and Trumbore (Kensler and Shirley 2006), made
//! watertight.
//!
//!   edge function d . ((C - A) x (C + A)), A and C relative to the origin; reversing the edge negates it exactly
//!     |value| > f32 error bound  -> its sign decides (shared origin: 9 multiply-adds a triangle)
//!     else                       -> f64, where differences are exact; a filter as in Shewchuk 1997
//!     two within the f64 bound   -> inside if between two corners (near a vertex all could say "outside")
//!
//!   the side of the plane on which a ray starts is a sign too: within its error bound `f64` takes over, for t as well
//!
//! So no ray passes between triangles with equal corners, and triangles are not enlarged. t is that of `f32` unless the
//! side of the plane is in doubt; a ray that starts on the plane itself misses.
// Tried: see docs/lab-notes.md#edge-functions-in-f64

use super::{
    TriangleBlock,
    bounds::{Slabs, pad},
    doubt::meets,
};
use crate::{
    lanes::{F32x8, LANES},
    simd::{EightLanes, LaneMask, Lanes, Vec3Lanes},
};
use glam::Vec3;

/// Slack of the candidate filter at an edge, as a fraction of [`Edges::size`]: the bound on the rounding error of an
/// edge function, 11.5 half-ulps, and the rounding of everything it is made of.
pub(crate) const CANDIDATE_SLACK: f32 = 20.0 / (1 << 24) as f32;

/// Slack of [`may_hit`], whose edge functions are half of those of [`EdgeFunctions`]: half-ulps, as
/// fractions of 2 E (E + |A|), with E the longer of the edges from the first corner and A that corner relative to the
/// origin. The rounding of an edge function there is 8.5 (two vectors, a cross product, a dot product), 10.5 for the
/// one that the others leave of the determinant. [`meets`] accepts down to -11.5, itself wrong by up to
/// 11.5: 23, halved since these functions are half as large, and doubled since it goes by the longest edge, which may
/// have 2 E. Together 33.5.
const MAY_HIT: f32 = 40.0 / (1 << 24) as f32;

/// Where kernels leave the side on which a ray starts to [`meets`], as a fraction of [`Edges::permanent`] times the first
/// corner: the 9 half-ulps within which that decides it again, the same for the rounding here, and two.
// Tuned: see docs/lab-notes.md#side-of-the-plane
const PLANE_SLACK: f32 = 20.0 / (1 << 24) as f32;

/// Returns the candidates (a bit each) of eight triangles, given by their corners: those that a ray, the same in all
/// lanes, does not clearly miss. Two thirds of the operations of [`EdgeFunctions`], by edge functions in the form of
/// Möller and Trumbore 1997, without a division.
// Tuned: see docs/lab-notes.md#candidates-of-single-rays
#[inline(always)]
#[must_use]
pub(crate) fn may_hit<V: EightLanes>(
    [v0, v1, v2]: &[Vec3Lanes<V>; 3],
    origin: Vec3Lanes<V>,
    direction: Vec3Lanes<V>,
) -> u32 {
    let (e1, e2, a) = (*v1 - *v0, *v2 - *v0, *v0 - origin);
    // To the last bit those of `EdgeFunctions`, so that the same triangles are flipped.
    let normal = e1.cross(e2);
    let plane = normal.dot(a);
    let unknown = Edges::unknown_side(e1.permanent(e2), plane, a);
    let flip = plane.sign();
    let u = a.dot_about(direction.cross_about(e2));
    let v = direction.dot_about(a.cross_about(e1));
    let w = direction.dot_about(normal) - u - v;
    // At least 2 E (E + |a|), see `Edges::size`. Where it overflows nothing is missed.
    let least = u.all(f32::MIN_POSITIVE);
    let longest_squared = e1.dot_about(e1).max(e2.dot_about(e2)).max(least);
    let both_squared = longest_squared + a.dot_about(a);
    let size = (longest_squared * 8.0 * both_squared).max(least).sqrt();
    let smallest = u.flip_signs(flip).min(v.flip_signs(flip)).min(w.flip_signs(flip));
    (unknown.bits() | !smallest.lt(size * -MAY_HIT).bits()) & 0xff
}

/// Returns the padded boxes of triangles, to which hits are held: lower and upper corners.
#[inline(always)]
#[must_use]
pub(crate) fn padded_boxes<V: Lanes>([v0, v1, v2]: &[Vec3Lanes<V>; 3]) -> (Vec3Lanes<V>, Vec3Lanes<V>) {
    let lower = v0.min(*v1).min(*v2);
    let upper = v0.max(*v1).max(*v2);
    let pad = pad(lower.max_abs().max(upper.max_abs()));
    (lower - pad, upper + pad)
}

/// The edges of triangles, a lane each, in the directions of their edge functions, and their normals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edges<V> {
    /// From the first corner to the third.
    pub u: Vec3Lanes<V>,
    /// From the second corner to the first.
    pub v: Vec3Lanes<V>,
    /// From the third corner to the second.
    pub w: Vec3Lanes<V>,
    /// Normals, twice the area long.
    pub normal: Vec3Lanes<V>,
    /// The same with all products taken as positive, to which rounding errors are relative.
    pub permanent: Vec3Lanes<V>,
}

impl<V: Lanes> Edges<V> {
    /// Creates them for triangles given by their corners.
    #[inline(always)]
    #[must_use]
    pub fn new([v0, v1, v2]: &[Vec3Lanes<V>; 3]) -> Self {
        let (e1, e2) = (*v1 - *v0, *v2 - *v0);
        Self {
            u: e2,
            v: *v0 - *v1,
            w: *v1 - *v2,
            normal: e1.cross(e2),
            permanent: e1.permanent(e2),
        }
    }

    /// Returns the lanes in which `plane`, the normal times `a`, the first corner relative to an origin, may have the
    /// wrong sign.
    #[inline(always)]
    #[must_use]
    pub fn unknown_side(permanent: Vec3Lanes<V>, plane: V, a: Vec3Lanes<V>) -> V::Mask {
        !plane.abs().gt(permanent.dot_about(a.abs()) * PLANE_SLACK)
    }

    /// Returns at least |C - A| (|C| + |A|) of every edge, corners relative to an origin whose squared distance from
    /// the first corner is given: the longest edge times twice its length and the distance. Where squares underflow,
    /// the least normal number is more than enough.
    #[inline(always)]
    #[must_use]
    pub fn size(&self, distance_squared: V) -> V {
        let Self { u, v, w, .. } = self;
        let least = distance_squared.all(f32::MIN_POSITIVE);
        let longest_squared = u
            .dot_about(*u)
            .max(v.dot_about(*v))
            .max(w.dot_about(*w).max(least));
        let both_squared = longest_squared + distance_squared;
        // The square of twice a sum is at most eight times the sum of squares.
        (longest_squared * 8.0 * both_squared).max(least).sqrt()
    }
}

/// Returns the edge functions of triangles, as vectors, given the edges in their directions and the corners relative to
/// an origin.
#[inline(always)]
#[must_use]
pub(crate) fn edge_functions<V: Lanes>(
    [u, v, w]: [Vec3Lanes<V>; 3],
    [a, b, c]: [Vec3Lanes<V>; 3],
) -> [Vec3Lanes<V>; 3] {
    [u.cross(c + a), v.cross(a + b), w.cross(b + c)]
}

/// Returns the barycentric weights of filter and canonical test: second corner, third, first; times twice the
/// determinant.
#[inline(always)]
#[must_use]
pub(crate) fn weights<V: Lanes>(d: Vec3Lanes<V>, [u, v, w]: [Vec3Lanes<V>; 3]) -> [V; 3] {
    [d.dot(u), d.dot(v), d.dot(w)]
}

#[inline(always)]
fn smallest<V: Lanes>([u, v, w]: [V; 3]) -> V {
    u.min(v).min(w)
}

/// Triangles relative to an origin, a lane per pair of triangle and origin. All vectors are flipped so that the
/// determinant of a ray that meets the plane ahead is positive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeFunctions<V> {
    /// Their products with a direction are its [`weights`].
    pub functions: [Vec3Lanes<V>; 3],
    /// d.normal is the determinant.
    pub normal: Vec3Lanes<V>,
    /// normal.(v0 - origin), at least 0: t times the determinant.
    pub plane: V,
    /// How far below 0 a candidate's edge function may be: more than its rounding error. Infinite if the side on which
    /// the ray starts is [unknown](Edges::unknown_side).
    pub tolerance: V,
}

impl<V: Lanes> EdgeFunctions<V> {
    /// Creates them for triangles given by their corners, relative to `origin`.
    #[inline(always)]
    #[must_use]
    pub fn new(corners: &[Vec3Lanes<V>; 3], origin: Vec3Lanes<V>) -> Self {
        let edges = Edges::new(corners);
        let [v0, v1, v2] = corners;
        let (a, b, c) = (*v0 - origin, *v1 - origin, *v2 - origin);
        let plane = edges.normal.dot(a);
        let flip = plane.sign();
        let unknown = Edges::unknown_side(edges.permanent, plane, a);
        let tolerance = edges.size(a.dot_about(a)) * CANDIDATE_SLACK;
        let [u, v, w] = edge_functions([edges.u, edges.v, edges.w], [a, b, c]);
        Self {
            functions: [u.flip_signs(flip), v.flip_signs(flip), w.flip_signs(flip)],
            normal: edges.normal.flip_signs(flip),
            plane: plane.flip_signs(flip),
            tolerance: V::select(unknown, plane.all(f32::INFINITY), tolerance),
        }
    }

    /// Tests rays with these directions, given where they are in the triangles' padded boxes.
    #[inline(always)]
    #[must_use]
    pub fn test(&self, direction: Vec3Lanes<V>, interval: (V, V)) -> TriangleTest<V> {
        TriangleTest::new(
            weights(direction, self.functions),
            [-self.tolerance, self.tolerance],
            (self.plane, direction.dot(self.normal)),
            interval,
        )
    }
}

/// Where rays meet triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleHits<V: Lanes> {
    /// Lanes that hit, a bit each.
    pub hit: u32,
    /// Candidates, hit or not, that the line passes within their padded box, with an edge nearer than `f32` resolves. If their
    /// plane is ill-conditioned, they may seem to be behind the ray.
    pub unsure: u32,
    /// Distances.
    pub t: V,
    /// Weights of second corner, third and first, not yet divided by their sum. Negative means 0.
    pub weights: [V; 3],
}

/// The canonical test in `f32`, a lane per pair of ray and triangle; [`meets`] decides what it leaves open. Scalar twin:
/// `reference::primitive`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TriangleTest<V: Lanes> {
    /// See [`weights`].
    pub weights: [V; 3],
    /// Distances, within the interval.
    pub t: V,
    /// Where the rays are in the triangles' padded boxes.
    pub interval: (V, V),
    /// Lanes whose rays pass the boxes.
    pub within: V::Mask,
    /// Lanes whose rays may start on either side of the plane.
    unknown: V::Mask,
    smallest: V,
    /// Minus the [tolerance](EdgeFunctions::tolerance), then that.
    tolerance: [V; 2],
}

impl<V: Lanes> TriangleTest<V> {
    /// `tolerance`: negative, then positive. `plane`: see [`EdgeFunctions::plane`].
    #[inline(always)]
    #[must_use]
    pub fn new(
        weights: [V; 3],
        tolerance: [V; 2],
        (plane, determinant): (V, V),
        (near, far): (V, V),
    ) -> Self {
        Self {
            weights,
            t: (plane / determinant).max(near).min(far),
            interval: (near, far),
            within: near.le(far),
            unknown: tolerance[1].eq(plane.all(f32::INFINITY)),
            smallest: smallest(weights),
            tolerance,
        }
    }

    /// Lanes that hit if their weights allow it: those ahead of the ray with a distance that `counts`, and those that
    /// may be ahead.
    #[inline(always)]
    #[must_use]
    pub fn ahead(&self, counts: V::Mask) -> V::Mask {
        self.within & ((self.t.gt(self.t.all(0.0)) & counts) | self.unknown)
    }

    /// Lanes whose rays do not clearly pass outside an edge.
    #[inline(always)]
    #[must_use]
    pub fn candidates(&self) -> V::Mask {
        self.smallest.ge(self.tolerance[0])
    }

    /// Candidates whose rays clearly pass inside all edges.
    #[inline(always)]
    #[must_use]
    pub fn sure(&self) -> V::Mask {
        self.smallest.gt(self.tolerance[1])
    }
}

impl<V: EightLanes> EdgeFunctions<V> {
    /// The canonical test of the triangles of `lanes`, with one ray in all lanes of `slabs` and `direction`. Hits lie
    /// within the triangles' own boxes.
    #[inline(always)]
    #[must_use]
    pub fn intersect(
        &self,
        lanes: u32,
        (block, corners): (&TriangleBlock, &[Vec3Lanes<V>; 3]),
        slabs: &Slabs<V>,
        direction: Vec3Lanes<V>,
    ) -> TriangleHits<V> {
        let weights = weights(direction, self.functions);
        let candidates = smallest(weights).ge(-self.tolerance).bits() & lanes;
        // Tuned: see docs/lab-notes.md#one-ray-a-call
        if candidates == 0 {
            return TriangleHits {
                hit: 0,
                unsure: 0,
                t: self.plane,
                weights,
            };
        }
        let (lower, upper) = padded_boxes(corners);
        let test = self.test(direction, slabs.interval(lower, upper));
        let simd = self.plane.simd();
        let mut hit = test.ahead(V::mask(simd, u32::MAX)).bits() & candidates;
        let unsure = test.within.bits() & candidates & !test.sure().bits();
        let (mut t, mut weights) = (test.t, test.weights);
        if hit & unsure != 0 {
            let ray = [slabs.origin.to8().lane(0), direction.to8().lane(0)];
            let ([u, v, w], (near, far)) = (weights, test.interval);
            let columns = [u, v, w, t, near, far].map(EightLanes::to8);
            let (passing, columns) = passing(hit & unsure, ray, block, columns);
            hit &= !unsure | passing;
            let [u, v, w, found, ..] = columns.map(|column8| V::load8(simd, &column8));
            (t, weights) = (found, [u, v, w]);
        }
        TriangleHits {
            hit,
            unsure,
            t,
            weights,
        }
    }
}

/// Returns those of `lanes` whose triangles a ray (origin, direction) [meets](meets), and their columns: weights, t, and
/// the interval of the box.
#[cold]
fn passing(
    lanes: u32,
    [origin, direction]: [Vec3; 2],
    block: &TriangleBlock,
    mut columns: [F32x8; 6],
) -> (u32, [F32x8; 6]) {
    let mut passing = 0;
    for i in (0..LANES).filter(|i| lanes >> i & 1 != 0) {
        let at = |column: usize| columns[column].as_array()[i];
        let (found, interval) = ([at(0), at(1), at(2), at(3)], [at(4), at(5)]);
        let (is_met, found) = meets(origin, direction, block.triangle(i), found, interval);
        passing |= u32::from(is_met) << i;
        for (column8, value) in columns.iter_mut().zip(found) {
            column8.as_mut_array()[i] = value;
        }
    }
    (passing, columns)
}

#[cfg(test)]
mod tests;
