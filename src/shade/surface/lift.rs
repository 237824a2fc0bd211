//! Smooth shadows: how far the smooth surface is above the points of triangles. The scalar version is `scene::lift`.

use crate::simd::{EightLanes, Lanes, Simd, Vec3Eight};

/// The vectors whose dot product with the way to a vertex is the height of the vertex's tangent plane, along `geometric`.
#[inline(always)]
pub(super) fn slope<S: Simd>(normal: Vec3Eight<S>, geometric: Vec3Eight<S>) -> Vec3Eight<S> {
    let normal = normal * normal.max_abs().scale_to_one();
    let along = normal.dot(geometric);
    normal * (along.max(along.all(0.0)) / normal.dot(normal))
}

/// The mean height of the tangent planes that are above `point`, on the other side in the lanes `from_behind`.
#[inline(always)]
pub(super) fn rise<S: Simd>(
    simd: S,
    (point, [w, u, v]): (Vec3Eight<S>, [S::V8; 3]),
    [p0, p1, p2]: [Vec3Eight<S>; 3],
    [s0, s1, s2]: [Vec3Eight<S>; 3],
    from_behind: <S::V8 as Lanes>::Mask,
) -> S::V8 {
    let (a, b, c) = ((p0 - point).dot(s0), (p1 - point).dot(s1), (p2 - point).dot(s2));
    let [a, b, c] = [a, b, c].map(
        #[inline(always)]
        |above| S::V8::select(from_behind, -above, above).max(simd.splat(0.0)),
    );
    b.mul_add(u, c.mul_add(v, a * w))
}
