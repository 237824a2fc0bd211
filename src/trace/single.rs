//! Rays one by one, each against eight boxes or primitives at a time (Wald, Benthin and Boulos, *Getting Rid of
//! Packets*, 2008), several in turn: while one waits for a node from memory, the others go on (asynchronous memory
//! access chaining: Kocberber, Falsafi and Grot 2015).
//!
//! Boxes are tested with one multiply-add a plane, near and far planes picked by the direction's signs beforehand.
//! With AVX-512 children are sorted without a branch, because branches that depend on rays in turn are hard to predict.

use super::{Tracer, bits, rays::Packet};
use crate::{
    accel::{Bvh, Child, Node8},
    geometry::{Slabs8, intersect_spheres},
    simd::{
        F32x8, LANES, Vec3x8, lane,
        lanes::{Column, Lanes, unpack},
        le, max, min, mul_add, splat,
    },
};
use glam::Vec3;

/// A ray that is to go on alone in a subtree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Item {
    /// Packet times lanes plus lane.
    pub ray: u32,
    pub child: Child,
    pub near: f32,
}

/// Rays in turn. (Terrain of a million triangles, mirror rays one by one: 1 in turn 2.6 Mrays/s, 4 in turn 3.9, 8 4.4,
/// 16 4.5; the figure, which fits a cache: 12.4, 16.4, 15.4, 15.6.)
pub(super) const SLOTS: usize = 16;

/// Bound on the rounding of `plane * inv - origin * inv` beyond that of its result, as a share of `origin * inv`: a
/// half-ulp for that product, one for the sum with this bound, one for the other product where multiply-add is not
/// fused, and one to spare.
const OFFSET_ERROR: f32 = 4.0 / (1 << 24) as f32;

/// Entry distances shrink and exit distances grow by this share: the canonical interval's own margin of 4
/// half-ulps and 3 roundings, and the rounding of the multiply-add here.
const INTERVAL_PAD: f32 = 12.0 / (1 << 24) as f32;

/// One ray.
#[derive(Clone, Copy, Debug, Default)]
struct SingleRay {
    packet: u32,
    lane: u32,
    origin: Vec3,
    direction: Vec3,
    inv: Vec3,
    /// What to add to plane x inv for a near plane and a far plane: `-origin * inv`, moved apart by its error.
    near_offset: Vec3,
    far_offset: Vec3,
    /// Which of a node's planes are the near ones, and which the far ones.
    near: [u8; 3],
    far: [u8; 3],
}

impl SingleRay {
    #[inline(always)]
    fn new(state: &Packet, packet: usize, lane: usize) -> Self {
        let vector = |[x, y, z]: &[Column; 3]| Vec3::new(x.0[lane & 15], y.0[lane & 15], z.0[lane & 15]);
        let (origin, inv) = (vector(&state.origin), vector(&state.inv_direction));
        let offset = origin * inv;
        let error = offset.abs() * OFFSET_ERROR;
        let down = [
            u8::from(inv.x < 0.0),
            u8::from(inv.y < 0.0),
            u8::from(inv.z < 0.0),
        ];
        Self {
            packet: packet as u32,
            lane: lane as u32,
            origin,
            direction: vector(&state.direction),
            inv,
            near_offset: -offset - error,
            far_offset: -offset + error,
            near: [3 * down[0], 1 + 3 * down[1], 2 + 3 * down[2]],
            far: [3 - 3 * down[0], 4 - 3 * down[1], 5 - 3 * down[2]],
        }
    }

    /// The children that the ray enters not beyond `t_max`, a bit a child, and where.
    #[inline(always)]
    fn enter(&self, node: &Node8, t_max: F32x8) -> (u32, F32x8) {
        let planes = |axis: usize| {
            let near = &node.planes[usize::from(self.near[axis])];
            let far = &node.planes[usize::from(self.far[axis])];
            let inv = splat(self.inv[axis]);
            (
                mul_add(*near, inv, splat(self.near_offset[axis])),
                mul_add(*far, inv, splat(self.far_offset[axis])),
            )
        };
        let ((near_x, far_x), (near_y, far_y), (near_z, far_z)) = (planes(0), planes(1), planes(2));
        let near = max(max(near_x, near_y), max(near_z, splat(0.0)));
        let far = min(min(far_x, far_y), min(far_z, t_max));
        let near = near * splat(1.0 - INTERVAL_PAD);
        let entered = le(near, far * splat(1.0 + INTERVAL_PAD)).bits();
        // Empty lanes are turned inside out, but an origin of 1e30 makes NaN of them.
        (entered & node.valid_bits(), near)
    }
}

/// One of the rays in turn.
#[derive(Debug)]
pub(super) struct Slot {
    ray: SingleRay,
    child: Child,
    /// [`entry`](crate::simd::lanes::entry)s of subtrees still to visit; `len` of them, and room for eight more.
    stack: Vec<u64>,
    len: usize,
}

/// As many as take turns, with room for `size` entries on each stack.
pub(super) fn slots(size: usize) -> [Slot; SLOTS] {
    std::array::from_fn(|_| Slot {
        ray: SingleRay::default(),
        child: Child::NONE,
        stack: vec![0; size + LANES],
        len: 0,
    })
}

impl Tracer<'_> {
    /// Traces the rays of `items`, in packets of `lanes`.
    #[inline(always)]
    pub(super) fn trace_items<V: Lanes, const ANY: bool>(&mut self, reach: f32) {
        let lanes = V::COUNT;
        let Self {
            bvh,
            packets,
            items,
            slots,
            ..
        } = self;
        let mut active = 0;
        while active < SLOTS && start(&mut slots[active], bvh, packets, items, lanes) {
            active += 1;
        }
        while active > 0 {
            let mut i = 0;
            while i < active {
                let slot = &mut slots[i % SLOTS];
                if step::<V, ANY>(slot, bvh, packets, reach) || start(slot, bvh, packets, items, lanes) {
                    i += 1;
                } else {
                    active -= 1;
                    slots.swap(i % SLOTS, active % SLOTS);
                }
            }
        }
    }
}

/// Gives a slot the next ray that may still hit something; `false` if none is left.
#[inline(always)]
fn start(
    slot: &mut Slot,
    bvh: &Bvh,
    packets: &[Packet; super::PACKETS],
    items: &mut Vec<Item>,
    lanes: usize,
) -> bool {
    while let Some(Item { ray, child, near }) = items.pop() {
        let (p, i) = (ray as usize / lanes, ray as usize % lanes);
        let state = &packets[p % super::PACKETS];
        if near <= state.t.0[i & 15] {
            bvh.prefetch(child);
            slot.ray = SingleRay::new(state, p, i);
            slot.child = child;
            slot.len = 0;
            return true;
        }
    }
    false
}

/// Visits one node or block; `false` when the ray is through.
#[inline(always)]
fn step<V: Lanes, const ANY: bool>(
    slot: &mut Slot,
    bvh: &Bvh,
    packets: &mut [Packet; super::PACKETS],
    reach: f32,
) -> bool {
    let Slot {
        ray,
        child,
        stack,
        len,
    } = slot;
    let state = &mut packets[ray.packet as usize % super::PACKETS];
    let i = ray.lane as usize & 15;
    if child.is_inner() {
        let node = &bvh.nodes()[child.index()];
        let (entered, near) = ray.enter(node, splat(state.t.0[i]));
        if let Some(top) = stack[*len..].first_chunk_mut() {
            *len += V::push_nearest_last(top, near, &node.child_bits(), entered);
        }
    } else {
        block::<ANY>(bvh, *child, ray, reach, state);
    }
    let t = state.t.0[i];
    if ANY && t <= 0.0 {
        return false;
    }
    while *len > 0 {
        *len -= 1;
        let (near, next) = unpack(stack[*len]);
        if near <= t {
            *child = Child::from_bits(next);
            bvh.prefetch(*child);
            return true;
        }
    }
    false
}

/// A block against one ray.
#[inline(always)]
fn block<const ANY: bool>(bvh: &Bvh, leaf: Child, ray: &SingleRay, reach: f32, state: &mut Packet) {
    let i = ray.lane as usize & 15;
    let count_bits = (1_u32 << leaf.count()) - 1;
    let direction = Vec3x8::splat(ray.direction);
    let slabs = Slabs8 {
        origin: Vec3x8::splat(ray.origin),
        inv_direction: Vec3x8::splat(ray.inv),
    };
    if leaf.is_triangles() {
        let block = &bvh.triangle_blocks()[leaf.index()];
        let edges = block.edge_functions(slabs.origin, splat(reach));
        let weights = edges.weights(&direction);
        let first_look = edges.first_look(weights) & count_bits;
        if first_look != 0 {
            let found = edges.intersect(first_look, weights, block, &slabs, &direction);
            let [u, v, sum] = &found.weights;
            for c in bits(found.hit.bits()) {
                let weights = [lane(u, c), lane(v, c), lane(sum, c)];
                state.offer_lane::<ANY>(i, lane(&found.t, c), block.id[c], weights);
            }
        }
    } else {
        let block = &bvh.sphere_blocks()[leaf.index()];
        let (ahead, t) = intersect_spheres(block.center, block.radius, &slabs, &direction);
        for c in bits(ahead.bits() & count_bits) {
            state.offer_lane::<ANY>(i, lane(&t, c), block.id[c], [0.0, 0.0, 1.0]);
        }
    }
}
