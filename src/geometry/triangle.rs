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
    bounds::{Slabs, pad},
    doubt::meets,
};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::PrimitiveId,
    simd::{EightLanes, LaneMask, Lanes, Simd, TriangleLanes, Vec3Eight, Vec3Lanes},
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
/// corner: the 9 half-ulps up to which that decides it anew, as much again for the rounding here, and two.
// Tuned: see docs/lab-notes.md#side-of-the-plane
const PLANE_SLACK: f32 = 20.0 / (1 << 24) as f32;

/// Up to eight triangles, an array per coordinate. Lanes past the last triangle repeat a point: they have no area and
/// are never hit.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// First corners.
    pub v0: Vec3x8,
    /// Second corners.
    pub v1: Vec3x8,
    /// Third corners.
    pub v2: Vec3x8,
    /// Ids, as raw values of [`PrimitiveId`].
    pub id: [u32; LANES],
}

/// A leaf block of up to eight triangles, in any layout.
pub(crate) trait TriangleLeaf: Sized {
    /// Returns first, second and third corners: of two blocks in vectors of sixteen lanes, else of the first.
    #[must_use]
    fn corners<V: TriangleLanes>(simd: V::Simd, blocks: [&Self; 2]) -> [Vec3Lanes<V>; 3];
    /// Returns the block as a structure of arrays, unpacked into `room` if necessary.
    #[must_use]
    fn whole<'a, S: Simd>(&'a self, simd: S, room: &'a mut Option<TriangleBlock>) -> &'a TriangleBlock;
    /// Returns the id of triangle `lane`, as the raw value of [`PrimitiveId`].
    #[must_use]
    fn id(&self, lane: usize) -> u32;
    /// Returns the corners of triangle `lane`.
    #[must_use]
    fn triangle(&self, lane: usize) -> [Vec3; 3];
}

impl TriangleLeaf for TriangleBlock {
    #[inline(always)]
    fn corners<V: TriangleLanes>(simd: V::Simd, [low, high]: [&Self; 2]) -> [Vec3Lanes<V>; 3] {
        [
            Vec3Lanes::join(simd, &low.v0, &high.v0),
            Vec3Lanes::join(simd, &low.v1, &high.v1),
            Vec3Lanes::join(simd, &low.v2, &high.v2),
        ]
    }

    #[inline(always)]
    fn whole<'a, S: Simd>(&'a self, _: S, _: &'a mut Option<TriangleBlock>) -> &'a TriangleBlock {
        self
    }

    #[inline(always)]
    fn id(&self, lane: usize) -> u32 {
        self.id[lane % LANES]
    }

    fn triangle(&self, lane: usize) -> [Vec3; 3] {
        [self.v0.lane(lane), self.v1.lane(lane), self.v2.lane(lane)]
    }
}

impl TriangleBlock {
    /// Creates a block of `triangles` (id and corners), at most eight.
    #[must_use]
    pub fn new(triangles: &[(PrimitiveId, [Vec3; 3])]) -> Self {
        let corner = |c: usize| {
            Vec3x8::from_lanes(std::array::from_fn(|i| {
                triangles.get(i).map_or(Vec3::ZERO, |t| t.1[c])
            }))
        };
        Self {
            v0: corner(0),
            v1: corner(1),
            v2: corner(2),
            id: std::array::from_fn(|i| triangles.get(i).map_or(PrimitiveId::NONE.0, |t| t.0.0)),
        }
    }

    /// Loads the corners.
    #[inline(always)]
    #[must_use]
    pub(crate) fn load<S: Simd>(&self, simd: S) -> [Vec3Eight<S>; 3] {
        [simd.load3(&self.v0), simd.load3(&self.v1), simd.load3(&self.v2)]
    }
}

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
    let smallest = u.turn(flip).min(v.turn(flip)).min(w.turn(flip));
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

/// Triangles relative to an origin, a lane per pair of triangle and origin. All vectors are flipped so that the
/// determinant of a ray that meets the plane ahead is positive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeFunctions<V> {
    /// d.u is the weight of the second corner, times twice the determinant.
    pub u: Vec3Lanes<V>,
    /// d.v is the weight of the third corner, times twice the determinant.
    pub v: Vec3Lanes<V>,
    /// d.w is the weight of the first corner, times twice the determinant.
    pub w: Vec3Lanes<V>,
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
        Self {
            u: edges.u.cross(c + a).turn(flip),
            v: edges.v.cross(a + b).turn(flip),
            w: edges.w.cross(b + c).turn(flip),
            normal: edges.normal.turn(flip),
            plane: plane.turn(flip),
            tolerance: V::select(unknown, plane.all(f32::INFINITY), tolerance),
        }
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

impl<V: EightLanes> EdgeFunctions<V> {
    /// Returns the barycentric weights of filter and canonical test: second corner, third, first; times twice the
    /// determinant.
    #[inline(always)]
    #[must_use]
    pub fn weights(&self, d: Vec3Lanes<V>) -> [V; 3] {
        [d.dot(self.u), d.dot(self.v), d.dot(self.w)]
    }

    /// Returns the lanes whose rays do not clearly pass outside an edge (a bit per lane).
    #[inline(always)]
    #[must_use]
    pub fn candidates(&self, [u, v, w]: [V; 3]) -> u32 {
        u.min(v).min(w).ge(-self.tolerance).bits()
    }

    /// The canonical test of the candidates, one ray in all lanes of `slabs` and `direction`. Hits lie within the triangles'
    /// own boxes.
    #[inline(always)]
    #[must_use]
    pub fn intersect(
        &self,
        candidates: u32,
        weights: [V; 3],
        (block, corners): (&TriangleBlock, &[Vec3Lanes<V>; 3]),
        slabs: &Slabs<V>,
        direction: Vec3Lanes<V>,
    ) -> TriangleHits<V> {
        let [u, v, w] = weights;
        let (lower, upper) = padded_boxes(corners);
        let (near, far) = slabs.interval(lower, upper);
        let determinant = direction.dot(self.normal);
        let t = (self.plane / determinant).max(near).min(far);
        let within = near.le(far);
        let unknown = self.tolerance.eq(t.all(f32::INFINITY));
        let mut hit = (within & (t.gt(t.all(0.0)) | unknown)).bits() & candidates;
        let sure = u.min(v).min(w).gt(self.tolerance).bits();
        let unsure = within.bits() & candidates & !sure;
        let (mut t, mut weights) = (t, weights);
        if hit & unsure != 0 {
            let ray = [slabs.origin.to8().lane(0), direction.to8().lane(0)];
            let columns = [u, v, w, t, near, far].map(EightLanes::to8);
            let (passing, columns) = passing(hit & unsure, ray, block, columns);
            hit &= !unsure | passing;
            let [u, v, w, found, ..] = columns.map(|column8| V::load8(t.simd(), &column8));
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
mod tests {
    use super::*;
    use crate::simd::Portable;

    /// Rays at triangles of all shapes, slivers whose longest edge is opposite the first corner among them, near and
    /// far from where the rays start, which is sometimes the triangle's plane.
    #[test]
    fn may_hit_loses_no_ray_that_passes_through() {
        let mut random = fastrand::Rng::with_seed(17);
        let mut unit = move || random.f32() * 2.0 - 1.0;
        let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
        let (mut passing, mut elsewhere, mut in_vain) = (0, 0, 0);
        const ROUNDS: usize = 200_000;
        for round in 0..ROUNDS {
            let size = [1e-25, 1e-3, 1.0, 1e3, 1e15][round % 5];
            let around = vector([0.0, 1.0, 1e4][round % 3] * size);
            let part = vector(1.0);
            let corners = [(); 3].map(|()| around + vector(size));
            let [a, b, c] = corners;
            let corners = match round % 4 {
                0 => [a + (b - a) * part.x.abs(), a, b],
                1 => [a, b, a + (b - a) * part.x.abs()],
                _ => [a, b, c],
            };
            let [v0, v1, v2] = corners;
            let elsewhere_at = around + vector(4.0 * size);
            let start = around + vector(3.0 * size);
            // A point of the triangle's plane; on an edge if it is not `aside`.
            let mut in_plane = |aside: f32| {
                let part = vector(1.0);
                v0 + (v1 - v0) * part.x.abs() + (v2 - v0) * part.y * aside
            };
            let aim = round / 8 % 3;
            let at = [in_plane(0.0), in_plane(1.0), elsewhere_at][aim];
            let origin = if round % 7 == 0 { in_plane(3.0) } else { start };
            // Scaled first: squares of 1e-25 underflow.
            let to = at - origin;
            let direction = (to / to.abs().max_element()).normalize();
            if !direction.is_finite() {
                continue;
            }
            let block = TriangleBlock::new(&[(PrimitiveId(0), corners)]).load(Portable);
            let (origin8, direction8) = (Portable.splat3(origin), Portable.splat3(direction));
            let edges = EdgeFunctions::new(&block, origin8);
            let weights = edges.weights(direction8);
            let [u, v, w] = weights.map(|weight| weight.to8().as_array()[0]);
            let columns = [u, v, w, 1.0];
            let may_hit = may_hit(&block, origin8, direction8) & 1 != 0;
            let passes = edges.candidates(weights) & 1 != 0
                && meets(origin, direction, corners, columns, [0.0, f32::INFINITY]).0;
            assert!(
                may_hit || !passes,
                "round {round}: {corners:?} {origin} {direction}"
            );
            passing += u32::from(passes);
            let is_known = edges.tolerance.to8().as_array()[0] < f32::INFINITY;
            if aim == 2 && is_known && (1e-20..1e10).contains(&size) {
                elsewhere += 1;
                in_vain += u32::from(may_hit && !passes);
            }
        }
        assert!(passing > 20_000, "{passing} of {ROUNDS} pass through");
        assert!(
            in_vain * 20 < elsewhere,
            "{in_vain} of {elsewhere} rays that go elsewhere are not left out"
        );
    }
}
