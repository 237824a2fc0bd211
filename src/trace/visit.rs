//! Visits the leaf blocks that one ray meets, nearest first, and hands all hits in them to a sink: for queries that
//! bundles do not answer, and for rays that come one at a time.

use super::{
    bits::bits,
    single::{SingleRay, sphere_block, triangle_block},
};
use crate::{
    accel::{Bvh, Child, LeafBlocks, TriangleBlocks},
    geometry::TriangleLeaf,
    ray::{PrimitiveId, Ray},
    simd::{EightLanes, LaneMask, Lanes, Level, Simd, at_level, unpack},
};
use glam::Vec3;
use std::cell::Cell;

/// A hit by the canonical test, for a [`HitSink`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub t: f32,
    pub primitive: PrimitiveId,
    /// Edge functions of a triangle's second, third and first corner, not yet divided by their sum; negative means 0.
    pub weights: [f32; 3],
}

/// A triangle that a ray's line meets, or misses by less than rounding, for a [`HitSink`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// Whether that is certain in `f32`, or an edge passes nearer than rounding.
    pub is_sure: bool,
    pub corners: [Vec3; 3],
}

/// Says which hits count.
pub(crate) trait HitSink {
    /// Whether triangles near the line are wanted that the canonical test denies.
    const WANTS_NEAR: bool;
    /// The ray's end: hits beyond it are not wanted.
    fn end(&self) -> f32;
    /// Takes a hit; `near` where the sink wants it and it is a triangle.
    fn take(&mut self, found: Found, near: Option<Near>);
}

/// What is yet to visit: a lower bound on where the ray enters it, and a node or leaf.
type Stack = Vec<(f32, Child)>;

thread_local! {
    /// Kept from ray to ray.
    static STACK: Cell<Stack> = const { Cell::new(Vec::new()) };
}

/// Hands all hits of a ray before the sink's end to the sink, in no order that is promised. A ray that is not
/// [valid](Ray::is_valid) has none.
pub(crate) fn visit<K: HitSink>(level: Level, bvh: &Bvh, ray: &Ray, sink: &mut K) {
    if !ray.is_valid() {
        return;
    }
    let mut stack = STACK.take();
    stack.clear();
    let spheres = bvh.sphere_blocks();
    match bvh.triangle_blocks() {
        TriangleBlocks::Whole(triangles) => {
            let blocks = LeafBlocks { triangles, spheres };
            at_level!(level, |simd| visit_at(simd, bvh, blocks, ray, sink, &mut stack));
        }
        TriangleBlocks::Indexed(triangles) => {
            let blocks = LeafBlocks { triangles, spheres };
            at_level!(level, |simd| visit_at(simd, bvh, blocks, ray, sink, &mut stack));
        }
    }
    STACK.set(stack);
}

#[inline(always)]
fn visit_at<S: Simd, B: TriangleLeaf, K: HitSink>(
    simd: S,
    bvh: &Bvh,
    blocks: LeafBlocks<'_, B>,
    ray: &Ray,
    sink: &mut K,
    stack: &mut Stack,
) {
    let single = SingleRay::of(ray);
    let mut child = bvh.root();
    loop {
        if child.is_inner() {
            let node = &bvh.nodes()[child.index()];
            let (_, near) = single.enter(simd, node, sink.end());
            let entered = near.lt(simd.splat(f32::INFINITY));
            let (entries, count) = near.nearest_last(entered.bits());
            for &entry in entries.iter().take(count) {
                let (near, lane) = unpack(entry);
                stack.push((near, node.child[lane]));
            }
        } else if child.is_triangles() {
            triangles::<_, B, K>(simd, &single, &blocks.triangles[child.index()], child, sink);
        } else {
            let block = &blocks.spheres[child.index()];
            let (hit, enters, leaves) = sphere_block(simd, &single, block, child);
            for lane in bits(hit) {
                let found = Found {
                    t: enters.lane(lane),
                    primitive: PrimitiveId(block.id[lane]),
                    weights: [0.0, 0.0, 1.0],
                };
                sink.take(found, None);
                let t = leaves.lane(lane);
                if t > found.t {
                    sink.take(Found { t, ..found }, None);
                }
            }
        }
        loop {
            let Some((near, next)) = stack.pop() else { return };
            if near <= sink.end() {
                child = next;
                break;
            }
        }
    }
}

#[inline(always)]
fn triangles<S: Simd, B: TriangleLeaf, K: HitSink>(
    simd: S,
    ray: &SingleRay,
    leaf: &B,
    child: Child,
    sink: &mut K,
) {
    let mut room = None;
    let block = leaf.whole(simd, &mut room);
    let found = triangle_block(simd, ray, block, child);
    let (hit, sure) = (found.hit, found.sure);
    let wanted = if K::WANTS_NEAR { found.ahead } else { hit };
    if wanted == 0 {
        return;
    }
    let (t, [u, v, w]) = (found.t.to8(), found.weights);
    let (u, v, w) = (u.to8(), v.to8(), w.to8());
    for lane in bits(wanted) {
        let near = K::WANTS_NEAR.then(|| Near {
            is_sure: sure >> lane & 1 != 0,
            corners: block.triangle(lane),
        });
        let found = Found {
            t: t.as_array()[lane],
            primitive: PrimitiveId(block.id[lane]),
            weights: [u.as_array()[lane], v.as_array()[lane], w.as_array()[lane]],
        };
        sink.take(found, near);
    }
}
