//! Points of infinite planes.

use super::{Hits8, Points, finite, select};
use crate::{
    lanes::{LANES, Vec3x8},
    scene::{Plane, Scene},
    simd::{Lanes, Simd, Vec3Eight},
};

/// Evaluates different primitives and planes.
// Only scenes with planes need it, so it is not inlined; it therefore enters the level again.
#[inline(never)]
pub(super) fn with_planes<S: Simd>(simd: S, scene: &Scene, hits: &Hits8) -> Points<S> {
    simd.call(
        #[inline(always)]
        || mixed(simd, scene, hits),
    )
}

#[inline(always)]
fn mixed<S: Simd>(simd: S, scene: &Scene, hits: &Hits8) -> Points<S> {
    let first_plane = scene.plane_id(0).0;
    let first = |is_plane: bool| {
        let mut ids = hits.primitive.iter();
        ids.find(|&&id| (id >= first_plane) == is_plane).copied()
    };
    let (Some(any_finite), Some(any_plane)) = (first(false), first(true)) else {
        return match first(true) {
            None => finite(simd, scene, hits, &hits.primitive),
            Some(_) => distinct_planes(simd, scene, hits, &hits.primitive),
        };
    };
    // Lanes of the other kind compute on any primitive or plane.
    let (mut finite_ids, mut plane_ids, mut plane_bits) = (hits.primitive, hits.primitive, 0);
    for lane in 0..LANES {
        if hits.primitive[lane] >= first_plane {
            plane_bits |= 1 << lane;
            finite_ids[lane] = any_finite;
        } else {
            plane_ids[lane] = any_plane;
        }
    }
    let planes = distinct_planes(simd, scene, hits, &plane_ids);
    let finite = finite(simd, scene, hits, &finite_ids);
    select(simd, plane_bits, &planes, &finite)
}

/// Evaluates a plane per lane.
#[inline(always)]
fn distinct_planes<S: Simd>(simd: S, scene: &Scene, hits: &Hits8, id: &[u32; LANES]) -> Points<S> {
    let first = scene.plane_id(0).0;
    let (mut point, mut normal) = (Vec3x8::ZERO, Vec3x8::ZERO);
    for (lane, &id) in id.iter().enumerate() {
        let plane: &Plane = &scene.planes()[(id - first) as usize];
        point.set(lane, plane.point);
        normal.set(lane, plane.normal);
    }
    plane(simd, hits, simd.load3(&point), simd.load3(&normal))
}

/// Evaluates planes, given a point and the normal of each.
#[inline(always)]
pub(super) fn plane<S: Simd>(simd: S, hits: &Hits8, point: Vec3Eight<S>, normal: Vec3Eight<S>) -> Points<S> {
    let (origin, t) = (simd.load3(&hits.origin), simd.load(&hits.t));
    let found = simd.load3(&hits.direction).mul_add(t, origin);
    // Back onto the plane: far away, t is rounded in large steps.
    let off = normal.dot(found - point);
    let found = normal.mul_add(-off, found);
    Points {
        point: found,
        geometric: normal,
        normal,
        magnitude: found.max_abs().max(point.max_abs()),
    }
}
