//! Leaf blocks against bundles, packets and single rays.

use super::{
    frustum::Frustum,
    state::{LaneHit, PacketState},
};
use crate::{
    accel::{Bvh, Child},
    geometry::{EdgeFunctions, Slabs8, SphereBlock, TriangleBlock, intersect_spheres},
    simd::{Vec3x8, lane, splat},
};

/// Calls `f` with the index of each set bit, lowest first.
#[inline(always)]
pub(super) fn for_each_bit(mut bits: u32, mut f: impl FnMut(usize)) {
    while bits != 0 {
        f(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// A triangle against the eight rays of a packet.
#[inline(always)]
fn triangle<const ANY: bool>(edges: &EdgeFunctions, corners: &[Vec3x8; 3], id: u32, state: &mut PacketState) {
    let first_look = edges.first_look(&state.direction);
    if first_look != 0 {
        let found = edges.intersect(first_look, corners, &state.slabs, &state.direction);
        state.offer::<ANY>(found.hit, found.t, id, || found.weights);
    }
}

#[inline(always)]
fn sphere<const ANY: bool>(block: &SphereBlock, i: usize, state: &mut PacketState) {
    let (center, radius) = block.splat(i);
    let (hit, t) = intersect_spheres(center, radius, &state.slabs, &state.direction);
    if hit.any() {
        state.offer::<ANY>(hit, t, block.id[i], || [splat(0.0), splat(0.0), splat(1.0)]);
    }
}

/// A block against the packets of `packets` that share their origin. The block's edge functions are taken
/// once, and triangles that no ray of the frustum can hit are dropped eight at a time.
#[inline(always)]
pub(super) fn shared_origin<const ANY: bool>(
    bvh: &Bvh,
    leaf: Child,
    frustum: &Frustum,
    packets: u32,
    states: &mut [PacketState],
) {
    let count_bits = (1_u32 << leaf.count()) - 1;
    if !leaf.is_triangles() {
        let block = &bvh.sphere_blocks()[leaf.index()];
        for_each_bit(count_bits, |i| {
            for_each_bit(packets, |p| sphere::<ANY>(block, i, &mut states[p]));
        });
        return;
    }
    let block = &bvh.triangle_blocks()[leaf.index()];
    let edges8 = block.edge_functions(states[0].slabs.origin);
    let reachable = reachable(leaf, &edges8, Some(frustum));
    for_each_bit(reachable, |i| {
        let edges = edges8.splat(i);
        let corners = block.splat(i);
        for_each_bit(packets, |p| {
            triangle::<ANY>(&edges, &corners, block.id[i], &mut states[p]);
        });
    });
}

/// A block against one packet; `SHARED`: its rays share their origin.
#[inline(always)]
pub(super) fn packet<const ANY: bool, const SHARED: bool>(
    bvh: &Bvh,
    leaf: Child,
    frustum: Option<&Frustum>,
    state: &mut PacketState,
) {
    if !leaf.is_triangles() {
        let block = &bvh.sphere_blocks()[leaf.index()];
        for i in 0..leaf.count() {
            sphere::<ANY>(block, i, state);
        }
        return;
    }
    let block = &bvh.triangle_blocks()[leaf.index()];
    if SHARED {
        let edges8 = block.edge_functions(state.slabs.origin);
        let reachable = reachable(leaf, &edges8, frustum);
        for_each_bit(reachable, |i| {
            triangle::<ANY>(&edges8.splat(i), &block.splat(i), block.id[i], state);
        });
    } else {
        for i in 0..leaf.count() {
            let corners = block.splat(i);
            let [v0, v1, v2] = corners;
            let edges = EdgeFunctions::new(v0, v1, v2, state.slabs.origin);
            triangle::<ANY>(&edges, &corners, block.id[i], state);
        }
    }
}

/// The triangles of a block that some ray of the frustum may hit: those none of whose edges is wholly outside.
#[inline(always)]
fn reachable(leaf: Child, edges8: &EdgeFunctions, frustum: Option<&Frustum>) -> u32 {
    let count_bits = (1_u32 << leaf.count()) - 1;
    let Some(frustum) = frustum else { return count_bits };
    // The kernel's tolerance over |d_k|, which is above 0.3, and twice it for the rounding here.
    let margin = edges8.tolerance * splat(6.0);
    count_bits
        & frustum.may_reach_zero(&edges8.u, margin)
        & frustum.may_reach_zero(&edges8.v, margin)
        & frustum.may_reach_zero(&edges8.w, margin)
}

/// A block against one ray, in all lanes of `slabs` and `direction`.
#[inline(always)]
pub(super) fn single<const ANY: bool>(
    bvh: &Bvh,
    leaf: Child,
    slabs: &Slabs8,
    direction: &Vec3x8,
    hit: &mut LaneHit,
) {
    let count_bits = (1_u32 << leaf.count()) - 1;
    if leaf.is_triangles() {
        let block: &TriangleBlock = &bvh.triangle_blocks()[leaf.index()];
        let edges = block.edge_functions(slabs.origin);
        let first_look = edges.first_look(direction) & count_bits;
        if first_look != 0 {
            let corners = [block.v0, block.v1, block.v2];
            let found = edges.intersect(first_look, &corners, slabs, direction);
            let [u, v, sum] = &found.weights;
            for_each_bit(found.hit.bits(), |i| {
                hit.offer::<ANY>(
                    lane(&found.t, i),
                    block.id[i],
                    [lane(u, i), lane(v, i), lane(sum, i)],
                );
            });
        }
    } else {
        let block = &bvh.sphere_blocks()[leaf.index()];
        let (ahead, t) = intersect_spheres(block.center, block.radius, slabs, direction);
        for_each_bit(ahead.bits() & count_bits, |i| {
            hit.offer::<ANY>(lane(&t, i), block.id[i], [0.0, 0.0, 1.0]);
        });
    }
}
