//! Rays against triangles.
//!
//! Möller and Trumbore 1997 in its scalar-triple-product form (Kensler and Shirley 2006): with A, B, C the
//! corners as seen from the origin, d.(CxA), d.(AxB) and d.(BxC) are the barycentric weights times d.N. Differs:
//! no back-face culling, and **watertight**:
//!
//! - An edge function is `d . ((C - A) x (C + A))`, twice d.(CxA). Swapping A and C negates it exactly, fused or
//!   not, so of two triangles that share an edge at least one has the ray on its inner side. (The form is that of
//!   Embree's robust mode. It also cancels before it multiplies, which keeps small far triangles accurate.)
//! - Near a vertex the signs of the edges that meet there may contradict each other: each is right only up to
//!   rounding, and around a fan all of them could say "outside". So where two edge functions are within the bound
//!   on their rounding error, both may be negative up to that bound.
//!
//! So no ray passes between triangles whose corners are equal, and triangles are no wider than they are but for
//! about a millionth of their distance around their vertices. (Tried: a tolerance along whole edges, which needs
//! no agreement between neighbours. It blocked a thousand in a million shadow rays along the silhouettes of tiny
//! triangles 18 units from their light.)
//!
//! As seen from a shared origin all of this but the products with d is hoisted: a triangle then costs eight rays
//! nine multiply-adds.

use super::bounds::{Slabs8, pad};
use crate::{
    ray::PrimitiveId,
    simd::{F32x8, LANES, Mask8, Vec3x8, ge, gt, lane, le, max, min, mul_add, signs_clear, splat},
};
use glam::Vec3;

/// Bound on the rounding error of an edge function, as a share of |C - A| |C + A|: one half-ulp each for the two
/// vectors, 3.5 for the cross product, 3 for the dot product, and one to spare.
pub const EDGE_ERROR: f32 = 9.5 / (1 << 24) as f32;

/// What the first look at an edge allows for: the bound above, and the rounding of adding it.
const FIRST_LOOK: f32 = 16.0 / (1 << 24) as f32;

/// Up to eight triangles, a column a coordinate. Lanes past the last triangle repeat a point: they have no
/// area and are never hit.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct TriangleBlock {
    /// First corners.
    pub v0: Vec3x8,
    /// Second corners.
    pub v1: Vec3x8,
    /// Third corners.
    pub v2: Vec3x8,
    /// Ids, as the raw value of [`PrimitiveId`].
    pub id: [u32; LANES],
}

impl TriangleBlock {
    /// A block of `triangles` (id and corners), at most eight.
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

    /// The edge functions of all eight triangles as seen from one origin (all lanes of `origin` the same).
    #[inline(always)]
    #[must_use]
    pub fn edge_functions(&self, origin: Vec3x8) -> EdgeFunctions {
        EdgeFunctions::new(self.v0, self.v1, self.v2, origin)
    }

    /// Triangle `i` in all lanes.
    #[inline(always)]
    #[must_use]
    pub fn splat(&self, i: usize) -> [Vec3x8; 3] {
        [&self.v0, &self.v1, &self.v2].map(|v| Vec3x8::splat(v.lane(i)))
    }
}

/// Triangles as seen from an origin, a lane a pair of triangle and origin. All vectors are turned so that the
/// determinant of a ray that meets the plane ahead is positive.
#[derive(Clone, Copy, Debug)]
pub struct EdgeFunctions {
    /// d.u is the weight of the second corner, times twice the determinant.
    pub u: Vec3x8,
    /// d.v is the weight of the third corner, times twice the determinant.
    pub v: Vec3x8,
    /// d.w is the weight of the first corner, times twice the determinant.
    pub w: Vec3x8,
    /// d.normal is the determinant.
    pub normal: Vec3x8,
    /// normal.(v0 - origin), at least 0: t times the determinant.
    pub plane: F32x8,
    /// Added to each edge function at first look: more than its rounding error.
    pub tolerance: F32x8,
}

/// Where rays meet triangles.
#[derive(Clone, Copy, Debug)]
pub struct TriangleHits {
    /// Lanes that hit.
    pub hit: Mask8,
    /// Distances.
    pub t: F32x8,
    /// Weights of second and third corner, and the sum of all three; at least 0, not yet divided by that sum.
    pub weights: [F32x8; 3],
}

/// Edge and sum of the two corners of an edge, as seen from the origin.
#[inline(always)]
fn edge(from: Vec3x8, to: Vec3x8) -> (Vec3x8, Vec3x8) {
    (to - from, to + from)
}

impl EdgeFunctions {
    /// Of triangles with these corners as seen from these origins.
    #[inline(always)]
    #[must_use]
    pub fn new(v0: Vec3x8, v1: Vec3x8, v2: Vec3x8, origin: Vec3x8) -> Self {
        let (a, b, c) = (v0 - origin, v1 - origin, v2 - origin);
        let normal = (v1 - v0).cross(v2 - v0);
        let plane = normal.dot(a);
        let flip = plane & splat(-0.0);
        let turn = |v: Vec3x8| Vec3x8::new(v.x ^ flip, v.y ^ flip, v.z ^ flip);
        let ((e_u, s_u), (e_v, s_v), (e_w, s_w)) = (edge(a, c), edge(b, a), edge(c, b));
        let longest = max(max(e_u.dot(e_u), e_v.dot(e_v)), e_w.dot(e_w));
        let farthest = max(max(s_u.dot(s_u), s_v.dot(s_v)), s_w.dot(s_w));
        Self {
            u: turn(e_u.cross(s_u)),
            v: turn(e_v.cross(s_v)),
            w: turn(e_w.cross(s_w)),
            normal: turn(normal),
            plane: plane ^ flip,
            // One root of the product: where that underflows, the least normal number is more than enough.
            tolerance: max(longest * farthest, splat(f32::MIN_POSITIVE)).sqrt() * splat(FIRST_LOOK),
        }
    }

    /// Lane `i` in all lanes.
    #[inline(always)]
    #[must_use]
    pub fn splat(&self, i: usize) -> Self {
        let vector = |v: &Vec3x8| Vec3x8::splat(v.lane(i));
        Self {
            u: vector(&self.u),
            v: vector(&self.v),
            w: vector(&self.w),
            normal: vector(&self.normal),
            plane: splat(lane(&self.plane, i)),
            tolerance: splat(lane(&self.tolerance, i)),
        }
    }

    /// The first look, which most rays do not survive: lanes whose rays do not clearly pass outside an edge (a
    /// bit a lane).
    #[inline(always)]
    #[must_use]
    pub fn first_look(&self, direction: &Vec3x8) -> u32 {
        let edge = |e: &Vec3x8| {
            let z = mul_add(direction.z, e.z, self.tolerance);
            mul_add(direction.x, e.x, mul_add(direction.y, e.y, z))
        };
        signs_clear([edge(&self.u), edge(&self.v), edge(&self.w)])
    }

    /// The canonical test of the lanes that survived the first look. Distances are held to the triangles' own
    /// boxes.
    #[inline(always)]
    #[must_use]
    pub fn intersect(
        &self,
        first_look: u32,
        corners: &[Vec3x8; 3],
        slabs: &Slabs8,
        direction: &Vec3x8,
    ) -> TriangleHits {
        let zero = splat(0.0);
        let weights = [
            direction.dot(self.u),
            direction.dot(self.v),
            direction.dot(self.w),
        ];
        let [u, v, w] = weights;
        let inside = ge(min(min(u, v), w), zero);
        let mut hit = inside & Mask8::from_bits(first_look);
        if inside.bits() & first_look != first_look {
            hit = hit | near_vertex(weights, corners, slabs.origin) & Mask8::from_bits(first_look);
        }

        let determinant = direction.dot(self.normal);
        let [v0, v1, v2] = corners;
        let low = |a, b, c| min(min(a, b), c);
        let high = |a, b, c| max(max(a, b), c);
        let lower = Vec3x8::new(
            low(v0.x, v1.x, v2.x),
            low(v0.y, v1.y, v2.y),
            low(v0.z, v1.z, v2.z),
        );
        let upper = Vec3x8::new(
            high(v0.x, v1.x, v2.x),
            high(v0.y, v1.y, v2.y),
            high(v0.z, v1.z, v2.z),
        );
        let pad = pad(max(lower.max_abs(), upper.max_abs()));
        let pad = Vec3x8::new(pad, pad, pad);
        let (near, far) = slabs.interval(lower - pad, upper + pad);
        let t = min(max(self.plane / determinant, near), far);
        let [u, v, w] = weights.map(|weight| max(weight, zero));
        let sum = max(u + v + w, splat(f32::MIN_POSITIVE));
        TriangleHits {
            hit: hit & le(near, far) & gt(t, zero),
            t,
            weights: [u, v, sum],
        }
    }
}

/// The lanes whose rays pass so near a vertex that the signs of its edges mean nothing: no edge function is
/// below its error bound, and two are within it.
#[cold]
#[inline(never)]
fn near_vertex(weights: [F32x8; 3], corners: &[Vec3x8; 3], origin: Vec3x8) -> Mask8 {
    let [a, b, c] = corners.map(|v| v - origin);
    let bound = |(e, s): (Vec3x8, Vec3x8)| e.dot(e).sqrt() * s.dot(s).sqrt() * splat(EDGE_ERROR);
    let bounds = [bound(edge(a, c)), bound(edge(b, a)), bound(edge(c, b))];
    let [u, v, w] = [0, 1, 2].map(|i| ge(weights[i], -bounds[i]));
    let [small_u, small_v, small_w] = [0, 1, 2].map(|i| le(weights[i].abs(), bounds[i]));
    u & v & w & (small_u & small_v | small_v & small_w | small_w & small_u)
}
