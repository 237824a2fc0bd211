//! Single rays: each against eight boxes or primitives at a time, 32 in flight.
//!
//!   tasks -> 32 slots -> nodes: test 8 boxes -> next child -> blocks: candidate filter -> canonical test
//!                   ^------------- bit masks hold the next step of each slot -------------------'
//!
//! Each step is a loop without a branch on rays, since neither branches nor addresses can be predicted; while one ray
//! waits for memory, others proceed. After Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008, and Kocberber,
//! Falsafi and Grot, *Asynchronous Memory Access Chaining*, 2015.
// Tuned: see docs/lab-notes.md#single-rays

use super::{
    Tracer, bits,
    rays::Packet,
    scratch::RayLanes,
    slabs::{MOST_OFFSET, NODE_PAD, OFFSET_ERROR},
    slots::{SLOTS, Slot, Steps},
};
use crate::{
    accel::{Bvh, Child, Node8, Places, TriangleBlocks},
    geometry::{
        EdgeFunctions, Slabs, SphereBlock, TriangleBlock, TriangleHits, chord, may_hit, padded_sphere_boxes,
        sphere_exit, sphere_hits,
    },
    math::min_abs_direction,
    ray::Ray,
    simd::{EightLanes, LaneMask, Lanes, Memory, Simd, Vec3Lanes},
};
use glam::Vec3;

/// A single-ray task: a ray to trace through a subtree.
#[derive(Clone, Copy, Debug)]
pub(super) struct SingleRayTask {
    /// Packet times lanes plus lane.
    pub ray: u32,
    pub child: Child,
    /// A lower bound on where it enters the subtree; may be negative.
    pub near: f32,
}

/// Blocks are visited once at most this many rays are at nodes.
// Tuned: see docs/lab-notes.md#slots
const FEW: u32 = 8;

/// One ray.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SingleRay {
    packet: u32,
    lane: u32,
    pub(super) origin: Vec3,
    direction: Vec3,
    pub(super) inv: Vec3,
    /// Added to a lower and an upper plane times `inv`: `-origin * inv`, moved outwards by its error.
    lower_offset: Vec3,
    upper_offset: Vec3,
}

impl SingleRay {
    #[inline(always)]
    pub(super) fn new<M: Memory>(state: &Packet<M>, packet: usize, lane: usize) -> Self {
        let vector = |[x, y, z]: &[M; 3]| Vec3::new(x.place(lane), y.place(lane), z.place(lane));
        Self {
            packet: packet as u32,
            lane: lane as u32,
            ..Self::prepared(
                vector(&state.origin),
                vector(&state.direction),
                vector(&state.inv_direction),
            )
        }
    }

    /// From a valid ray.
    #[inline(always)]
    pub(super) fn of(ray: &Ray) -> Self {
        let d = ray.direction;
        let inv = |d: f32| 1.0 / min_abs_direction(d);
        Self::prepared(ray.origin, d, Vec3::new(inv(d.x), inv(d.y), inv(d.z)))
    }

    #[inline(always)]
    fn prepared(origin: Vec3, direction: Vec3, inv: Vec3) -> Self {
        let offset = origin * inv;
        // An overflow must not cull.
        let is_tame = offset.abs().cmplt(Vec3::splat(MOST_OFFSET));
        let error = Vec3::select(is_tame, offset.abs() * OFFSET_ERROR, Vec3::INFINITY);
        // Lower planes are the near ones if the direction is positive, else the far ones.
        let (offset, error) = (Vec3::select(is_tame, offset, Vec3::ZERO), error.copysign(inv));
        Self {
            packet: 0,
            lane: 0,
            origin,
            direction,
            inv,
            lower_offset: -offset - error,
            upper_offset: -offset + error,
        }
    }

    #[inline(always)]
    pub(super) fn slabs<S: Simd>(&self, simd: S) -> Slabs<S::V8> {
        Slabs {
            origin: simd.splat3(self.origin),
            inv_direction: simd.splat3(self.inv),
        }
    }

    /// Where the ray enters and leaves a node's children along an axis.
    #[inline(always)]
    fn planes<S: Simd>(&self, simd: S, node: &Node8, axis: usize) -> (S::V8, S::V8) {
        let inv = simd.splat(self.inv[axis]);
        let (lower, upper) = (simd.load(&node.planes[axis]), simd.load(&node.planes[axis + 3]));
        let lower = lower.mul_add_approx(inv, simd.splat(self.lower_offset[axis]));
        let upper = upper.mul_add_approx(inv, simd.splat(self.upper_offset[axis]));
        (lower.min(upper), lower.max(upper))
    }

    /// The children that the ray enters within `t_max`, a bit each, and where: infinite for those that it misses.
    #[inline(always)]
    pub(super) fn enter<S: Simd>(&self, simd: S, node: &Node8, t_max: f32) -> (u32, S::V8) {
        let (near_x, far_x) = self.planes(simd, node, 0);
        let (near_y, far_y) = self.planes(simd, node, 1);
        let (near_z, far_z) = self.planes(simd, node, 2);
        let near = near_x.max(near_y).max(near_z.max(simd.splat(0.0)));
        let far = far_x.min(far_y).min(far_z.min(simd.splat(t_max)));
        let near = near * (1.0 - NODE_PAD);
        let entered = near.le(far * (1.0 + NODE_PAD)).bits();
        // Empty lanes hold inverted boxes, which the minima and maxima have made valid.
        let entered = entered & node.valid_bits();
        let (at, missed) = (near.min(simd.splat(f32::MAX)), simd.splat(f32::INFINITY));
        (entered, S::V8::select(simd.mask(entered), at, missed))
    }
}

impl Tracer<'_> {
    /// Traces the rays of `tasks`, in packets of `V::COUNT`.
    #[inline(always)]
    pub(super) fn trace_tasks<V: RayLanes, const ANY: bool>(&mut self, simd: V::Simd) {
        let Self {
            bvh,
            scratch,
            tasks,
            slots,
            ..
        } = self;
        if tasks.is_empty() {
            return;
        }
        let packets = &mut scratch.of_mut::<V>().packets;
        let places = bvh.places();
        let mut left = tasks.iter();
        let mut steps = Steps::NONE;
        for (i, slot) in slots.iter_mut().enumerate() {
            if !start(slot, &places, packets, &mut left, V::COUNT) {
                break;
            }
            steps.clear(1 << i);
            steps.put(i, slot.child);
        }
        while steps.of(Child::EMPTY) != !0 {
            loop {
                let nodes = steps.of(Child::INNER);
                for i in bits(nodes) {
                    slots[i % SLOTS].enter_children::<_, ANY>(simd, bvh);
                }
                pop_all::<_, ANY>(simd, &mut steps, nodes, slots, bvh, &places);
                if steps.of(Child::INNER).count_ones() <= FEW {
                    break;
                }
            }
            let leaves = steps.of(Child::TRIANGLES);
            let mut candidates = 0;
            for i in bits(leaves) {
                candidates |= u32::from(may_hit_block(simd, &slots[i % SLOTS], bvh.triangle_blocks())) << i;
            }
            for i in bits(candidates) {
                triangles::<_, V::Memory, ANY>(simd, &mut slots[i % SLOTS], bvh.triangle_blocks(), packets);
            }
            pop_all::<_, ANY>(simd, &mut steps, leaves, slots, bvh, &places);
            let leaves = steps.of(Child::SPHERES);
            for i in bits(leaves) {
                spheres::<_, V::Memory, ANY>(simd, &mut slots[i % SLOTS], bvh.sphere_blocks(), packets);
            }
            pop_all::<_, ANY>(simd, &mut steps, leaves, slots, bvh, &places);
            if left.len() == 0 {
                continue;
            }
            for i in bits(steps.of(Child::EMPTY)) {
                let slot = &mut slots[i % SLOTS];
                if !start(slot, &places, packets, &mut left, V::COUNT) {
                    break;
                }
                steps.clear(1 << i);
                steps.put(i, slot.child);
            }
        }
        tasks.clear();
    }
}

/// Gives a slot the next ray that may still hit something; `false` if no task is left.
#[inline(always)]
fn start<M: Memory>(
    slot: &mut Slot,
    places: &Places,
    packets: &[Packet<M>; super::PACKETS],
    tasks: &mut std::slice::Iter<'_, SingleRayTask>,
    lanes: usize,
) -> bool {
    for &SingleRayTask { ray, child, near } in tasks {
        let (p, i) = (ray as usize / lanes, ray as usize % lanes);
        let state = &packets[p % super::PACKETS];
        let t = state.t.place(i);
        if near <= t {
            places.prefetch(child);
            slot.ray = SingleRay::new(state, p, i);
            slot.child = child;
            slot.t = t;
            slot.clear();
            return true;
        }
    }
    false
}

/// Takes the next children of `which` slots.
#[inline(always)]
fn pop_all<S: Simd, const ANY: bool>(
    simd: S,
    steps: &mut Steps,
    which: u32,
    slots: &mut [Slot; SLOTS],
    bvh: &Bvh,
    places: &Places,
) {
    steps.clear(which);
    for i in bits(which) {
        let slot = &mut slots[i % SLOTS];
        slot.pop::<_, ANY>(simd, bvh, places);
        steps.put(i, slot.child);
    }
}

/// Whether a ray may hit something in its block of triangles: the candidate filter.
#[inline(always)]
fn may_hit_block<S: Simd>(simd: S, slot: &Slot, blocks: &TriangleBlocks) -> bool {
    let (ray, leaf) = (&slot.ray, slot.child);
    let mut unpacked = None;
    let corners = blocks.whole(simd, leaf.index(), &mut unpacked).load(simd);
    let candidates = may_hit(&corners, simd.splat3(ray.origin), simd.splat3(ray.direction));
    candidates & leaf.count_bits() != 0
}

/// The canonical test of a block of triangles.
#[inline(always)]
pub(super) fn triangle_block<S: Simd>(
    simd: S,
    ray: &SingleRay,
    block: &TriangleBlock,
    leaf: Child,
) -> TriangleHits<S::V8> {
    let (slabs, direction) = (ray.slabs(simd), simd.splat3(ray.direction));
    let corners = block.load(simd);
    let edges = EdgeFunctions::new(&corners, slabs.origin);
    edges.intersect(leaf.count_bits(), (block, &corners), &slabs, direction)
}

/// The canonical test of a block of spheres: lanes that hit, a bit each, distances, and where the ray leaves.
#[inline(always)]
pub(super) fn sphere_block<S: Simd>(
    simd: S,
    ray: &SingleRay,
    block: &SphereBlock,
    leaf: Child,
) -> (u32, S::V8, S::V8) {
    let (center, radius) = (simd.load3(&block.center), simd.load(&block.radius));
    let slabs = ray.slabs(simd);
    let (lower, upper): (Vec3Lanes<S::V8>, _) = padded_sphere_boxes(center, radius);
    let chord = chord(slabs.origin - center, simd.splat3(ray.direction), radius);
    let interval = slabs.interval(lower, upper);
    let (hit, t) = sphere_hits(chord, interval);
    (hit.bits() & leaf.count_bits(), t, sphere_exit(chord, interval))
}

/// A block of triangles against a ray.
#[inline(always)]
fn triangles<S: Simd, M: Memory, const ANY: bool>(
    simd: S,
    slot: &mut Slot,
    blocks: &TriangleBlocks,
    packets: &mut [Packet<M>; super::PACKETS],
) {
    let (ray, leaf) = (&slot.ray, slot.child);
    let (state, i) = (
        &mut packets[ray.packet as usize % super::PACKETS],
        ray.lane as usize,
    );
    let mut unpacked = None;
    let block = blocks.whole(simd, leaf.index(), &mut unpacked);
    let found = triangle_block(simd, ray, block, leaf);
    let [u, v, w] = found.weights;
    for c in bits(found.hit) {
        state.offer_lane::<ANY>(i, found.t.lane(c), block.id[c], [u.lane(c), v.lane(c), w.lane(c)]);
    }
    slot.end_at::<S, ANY>(simd, state.t.place(i));
}

/// A block of spheres against a ray.
#[inline(always)]
fn spheres<S: Simd, M: Memory, const ANY: bool>(
    simd: S,
    slot: &mut Slot,
    blocks: &[SphereBlock],
    packets: &mut [Packet<M>; super::PACKETS],
) {
    let (ray, leaf) = (&slot.ray, slot.child);
    let (state, i) = (
        &mut packets[ray.packet as usize % super::PACKETS],
        ray.lane as usize,
    );
    let block = &blocks[leaf.index()];
    let (hit, t, _) = sphere_block(simd, ray, block, leaf);
    for c in bits(hit) {
        state.offer_lane::<ANY>(i, t.lane(c), block.id[c], [0.0, 0.0, 1.0]);
    }
    slot.end_at::<S, ANY>(simd, state.t.place(i));
}
