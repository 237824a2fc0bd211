//! Smooth shadows: how far the smooth surface is above the points of triangles. The scalar version is `scene::lift`.

use super::{ALL_LANES, Corners, Hits8, SurfacePacket, is_zero};
use crate::{
    scene::Scene,
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes},
};

/// Finds how far the smooth surface is above the points of a surface packet.
// Not inlined: scenes without smooth shadows keep their code.
#[inline(never)]
pub(super) fn raise<S: Simd>(simd: S, scene: &Scene, hits: &Hits8, surface: &mut SurfacePacket) {
    if scene.vertices().normals.is_empty() {
        return;
    }
    // Lanes of spheres and planes compute on the first triangle.
    let triangle_count = scene.triangles().corners.len() as u32;
    let (mut ids, mut is_triangle) = (hits.primitive, 0);
    for (lane, id) in ids.iter_mut().enumerate() {
        if *id < triangle_count {
            is_triangle |= 1 << lane;
        } else {
            *id = 0;
        }
    }
    if is_triangle == 0 {
        return;
    }
    simd.call(
        #[inline(always)]
        || {
            let corners = if S::V8::equal_lanes(simd, &ids, ids[0]) == ALL_LANES {
                Corners::broadcast(simd, scene, ids[0] as usize)
            } else {
                Corners::gather(simd, scene, &ids)
            };
            let Some([n0, n1, n2]) = corners.normal else {
                return;
            };
            let from_behind = simd.mask(surface.from_behind);
            let facing = simd.load3(&surface.geometric_normal);
            let geometric = Vec3Lanes::select(from_behind, -facing, facing);
            let slopes = [
                slope::<S>(n0, geometric),
                slope::<S>(n1, geometric),
                slope::<S>(n2, geometric),
            ];
            let (u, v) = (simd.load(&hits.u), simd.load(&hits.v));
            let weights = [simd.splat(1.0) - u - v, u, v];
            let point = simd.load3(&surface.point);
            let above = rise(simd, (point, weights), corners.position, slopes, from_behind);
            let usable = simd.mask(is_triangle) & !(is_zero(n0) | is_zero(n1) | is_zero(n2));
            let above = S::V8::select(usable, above, simd.splat(0.0));
            surface.raised = above.gt(simd.splat(0.0)).bits();
            surface.rise = above.to8();
        },
    );
}

/// The vectors whose dot product with the way to a vertex is the height of the vertex's tangent plane, along `geometric`.
#[inline(always)]
fn slope<S: Simd>(normal: Vec3Eight<S>, geometric: Vec3Eight<S>) -> Vec3Eight<S> {
    let normal = normal * normal.max_abs().scale_to_one();
    let along = normal.dot(geometric);
    normal * (along.max(along.all(0.0)) / normal.dot(normal))
}

/// The mean height of the tangent planes that are above `point`, on the other side in the lanes `from_behind`.
#[inline(always)]
fn rise<S: Simd>(
    simd: S,
    (point, [w, u, v]): (Vec3Eight<S>, [S::V8; 3]),
    [p0, p1, p2]: [Vec3Eight<S>; 3],
    [s0, s1, s2]: [Vec3Eight<S>; 3],
    from_behind: <S::V8 as Lanes>::Mask,
) -> S::V8 {
    let (a, b, c) = ((p0 - point).dot(s0), (p1 - point).dot(s1), (p2 - point).dot(s2));
    let (a, b, c) = (
        above::<S>(simd, a, from_behind),
        above::<S>(simd, b, from_behind),
        above::<S>(simd, c, from_behind),
    );
    b.mul_add(u, c.mul_add(v, a * w))
}

/// A height on the viewer's side; 0 below the point.
#[inline(always)]
fn above<S: Simd>(simd: S, height: S::V8, from_behind: <S::V8 as Lanes>::Mask) -> S::V8 {
    S::V8::select(from_behind, -height, height).max(simd.splat(0.0))
}
