//! Rays against triangles.
//!
//! Möller and Trumbore 1997 in its scalar-triple-product form (Kensler and Shirley 2006): with A, B, C the
//! corners seen from the origin, d.(CxA), d.(AxB) and d.(BxC) are the barycentric weights times d.N. Differs:
//! no back-face culling; the third weight is not taken from the others; and an edge counts as crossed only
//! beyond a **bound on the rounding error** of its edge function. So a ray that truly passes through a triangle
//! hits it, whatever the rounding: closed meshes are watertight without any agreement between neighbours. The
//! price is that a triangle is about 1.5e-6 of its distance wider than it is.
//!
//! Edge functions are taken as `edge x corner`, not `corner x corner`, which would cost small far triangles
//! their accuracy. As seen from a shared origin all of this but the products with d is hoisted: a triangle then
//! costs eight rays nine multiply-adds.

use super::bounds::{Slabs8, pad};
use crate::{
    ray::PrimitiveId,
    simd::{F32x8, LANES, Mask8, Vec3x8, gt, lane, le, max, min, mul_add, signs_clear, splat},
};
use glam::Vec3;

/// Bound on the rounding error of an edge function, as a share of (largest edge component) x (largest corner
/// component): 7 half-ulps of each component of the cross product from its inputs and products, 22 in all with
/// the dot product's three roundings; 24 leaves room for the roundings of the bound itself.
pub const EDGE_TOLERANCE: f32 = 24.0 / (1 << 24) as f32;

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
    /// d.u is the weight of the second corner, times the determinant.
    pub u: Vec3x8,
    /// d.v is the weight of the third corner, times the determinant.
    pub v: Vec3x8,
    /// d.w is the weight of the first corner, times the determinant.
    pub w: Vec3x8,
    /// d.normal is the determinant.
    pub normal: Vec3x8,
    /// normal.(v0 - origin), at least 0: t times the determinant.
    pub plane: F32x8,
    /// Added to each edge function: the bound on its rounding error.
    pub tolerance: F32x8,
}

impl EdgeFunctions {
    /// Of triangles with these corners as seen from these origins.
    #[inline(always)]
    #[must_use]
    pub fn new(v0: Vec3x8, v1: Vec3x8, v2: Vec3x8, origin: Vec3x8) -> Self {
        let (a, b) = (v0 - origin, v1 - origin);
        let (e1, e2, e3) = (v1 - v0, v2 - v0, v2 - v1);
        let normal = e1.cross(e2);
        let plane = normal.dot(a);
        let flip = plane & splat(-0.0);
        let turn = |v: Vec3x8| Vec3x8::new(v.x ^ flip, v.y ^ flip, v.z ^ flip);
        let longest = max(max(e1.max_abs(), e2.max_abs()), e3.max_abs());
        let farthest = max(a.max_abs(), b.max_abs());
        Self {
            u: turn(e2.cross(a)),
            v: turn(a.cross(e1)),
            w: turn(b.cross(e3)),
            normal: turn(normal),
            plane: plane ^ flip,
            tolerance: longest * farthest * splat(EDGE_TOLERANCE),
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

    /// The lanes whose rays pass on the inner side of all three edges (a bit a lane), and the weights of
    /// second, third and first corner, times the determinant.
    #[inline(always)]
    #[must_use]
    pub fn inside(&self, direction: &Vec3x8) -> (u32, [F32x8; 3]) {
        let edge = |e: &Vec3x8| {
            let z = mul_add(direction.z, e.z, self.tolerance);
            mul_add(direction.x, e.x, mul_add(direction.y, e.y, z))
        };
        let weights = [edge(&self.u), edge(&self.v), edge(&self.w)];
        (signs_clear(weights), weights)
    }

    /// Where the rays meet the planes, held to the triangles' own boxes, and the lanes where they do. Only
    /// lanes of [`EdgeFunctions::inside`] are hits.
    #[inline(always)]
    #[must_use]
    pub fn distance(&self, corners: &[Vec3x8; 3], slabs: &Slabs8, direction: &Vec3x8) -> (Mask8, F32x8) {
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
        (gt(determinant, splat(0.0)) & le(near, far) & gt(t, splat(0.0)), t)
    }

    /// The barycentric weights of second and third corner from those of [`EdgeFunctions::inside`]: at least
    /// 0, at most 1 together.
    #[inline(always)]
    #[must_use]
    pub fn barycentric([u, v, w]: [F32x8; 3]) -> (F32x8, F32x8) {
        let sum = u + v + w;
        (u / sum, v / sum)
    }
}
