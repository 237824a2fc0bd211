//! Leaf blocks of triangles.

use crate::{
    lanes::{LANES, Vec3x8},
    ray::PrimitiveId,
    simd::{Simd, TriangleLanes, Vec3Eight, Vec3Lanes},
};
use glam::Vec3;

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

impl TriangleBlock {
    /// Returns first, second and third corners: of two blocks in vectors of sixteen lanes, else of the first.
    #[inline(always)]
    #[must_use]
    pub(crate) fn corners<V: TriangleLanes>(simd: V::Simd, [low, high]: [&Self; 2]) -> [Vec3Lanes<V>; 3] {
        [
            Vec3Lanes::join(simd, &low.v0, &high.v0),
            Vec3Lanes::join(simd, &low.v1, &high.v1),
            Vec3Lanes::join(simd, &low.v2, &high.v2),
        ]
    }

    /// Returns the corners of triangle `lane`.
    #[must_use]
    pub fn triangle(&self, lane: usize) -> [Vec3; 3] {
        [self.v0.lane(lane), self.v1.lane(lane), self.v2.lane(lane)]
    }

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
