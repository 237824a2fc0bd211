//! Bundle traversal: up to 16 packets descend the BVH together.
//!
//!   bundle (<= 16 packets)
//!      | bundle frustum x 8 child boxes
//!   surviving children
//!      | 1 child box x 16 packet frusta (separate origins: x rays, packet by packet)  -> pairs of child and packet
//!   stack of (child, packets, near)  -> leaves pass a ring of 4 while their memory arrives
//!   leaf block: 8 triangles x packets  -> hits
//!
//! After Boulos et al. 2006 and Overbeck et al. 2008 (*Large Ray Packets*), with a bit mask instead of a first active
//! packet.

use super::{
    PACKETS, Tracer, bits, bits64,
    frustum::{BundleFrustum, Seen},
    leaf::{self, Leaves},
    pairs::Pairs,
    rays::{NODE_PAD, Packet, PacketSlabs},
    room::RayLanes,
    sheared::{self, ShearedSpace},
    single::SingleRayTask,
};
use crate::{
    accel::{Child, LeafBlocks, Node8},
    geometry::TriangleLeaf,
    lanes::{F32x8, LANES},
    simd::{
        Eight, EightLanes, LaneMask, Lanes, Memory, REGISTER_LANES, Simd, TriangleLanes, Vec3Lanes, unpack,
    },
};
use glam::Vec3;

/// A subtree to visit, the packets that may hit something in it, and its least q (least t without a frustum).
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    child: Child,
    packets: u32,
    q_near: f32,
}

impl Entry {
    const NONE: Self = Self {
        child: Child::NONE,
        packets: 0,
        q_near: 0.0,
    };
}

/// This many leaves wait for their prefetch while other nodes and leaves are visited, where rays share their origin.
// Tuned: see docs/lab-notes.md#deferred-leaves
const DEFERRED_LEAVES: usize = 4;

/// How the rays of a bundle are culled.
pub(super) struct Culling<'a, V: Lanes> {
    pub frustum: Option<&'a BundleFrustum<V>>,
    /// Camera rays: the node to start at instead of the root.
    pub entry: Option<&'a Node8>,
    /// Whether boxes are also tested ray by ray.
    pub exact: bool,
    /// Whether few remaining rays become single-ray tasks.
    pub regroup: bool,
    /// The direction octant: by axis, 1 if all rays go down, 0 if up. `None` if they differ.
    pub octant: Option<[u8; 3]>,
    /// For rays with separate origins.
    pub space: ShearedSpace,
}

impl Tracer<'_> {
    /// Traces `packets` through the whole tree; rays that part from the others become single-ray `tasks`.
    #[inline(always)]
    pub(super) fn traverse_bundle<B: TriangleLeaf, V: RayLanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        simd: V::Simd,
        blocks: LeafBlocks<'_, B>,
        packets: u32,
        culling: &Culling<'_, V>,
    ) {
        let bvh = self.bvh;
        // Where packets' rays end, a row a packet, then a lane a packet; -1 for packets that are done. All packets at
        // once.
        let mut ends = [V::Triangles::splat(simd, 0.0); REGISTER_LANES];
        let room = self.rooms.of::<V>();
        for p in bits(packets) {
            ends[p % REGISTER_LANES] = V::load(simd, &room.packets[p % PACKETS].t).fold_max_to_16();
        }
        let farthest = V::Triangles::largest_of_each(&ends);
        let can_hit = farthest.gt(V::Packets::splat(simd, 0.0));
        let all = can_hit.bits();
        let limits = match culling.frustum {
            Some(frustum) => frustum.q_limits(farthest),
            None => farthest,
        };
        let mut q_limit = V::Packets::select(can_hit, limits, V::Packets::splat(simd, -1.0));
        self.bundle_stack.clear();
        match culling.entry {
            Some(entry) if SHARED && !ANY => {
                self.push_children::<B, V, ANY, SHARED>(simd, blocks, entry, culling, all, q_limit);
            }
            _ => self.bundle_stack.push(Entry {
                child: bvh.root(),
                packets: all,
                q_near: 0.0,
            }),
        }
        // A ring of `held` leaves, oldest first.
        let mut deferred = [Entry::NONE; DEFERRED_LEAVES];
        let (mut held, mut oldest) = (0, 0);
        loop {
            let mut leaf = match self.bundle_stack.pop() {
                Some(Entry {
                    child,
                    packets,
                    q_near,
                }) => {
                    let packets = packets & V::Packets::splat(simd, q_near).le(q_limit).bits();
                    if packets == 0 {
                        continue;
                    }
                    if child.is_inner() {
                        self.push_children::<B, V, ANY, SHARED>(
                            simd,
                            blocks,
                            &bvh.nodes()[child.index()],
                            culling,
                            packets,
                            q_limit,
                        );
                        Entry::NONE
                    } else {
                        held += 1;
                        Entry {
                            child,
                            packets,
                            q_near,
                        }
                    }
                }
                None if held == 0 => break,
                None => Entry::NONE,
            };
            if SHARED {
                if leaf.packets != 0 {
                    deferred[(oldest + held - 1) % DEFERRED_LEAVES] = leaf;
                    if held < DEFERRED_LEAVES {
                        continue;
                    }
                }
                if held == 0 {
                    continue;
                }
                leaf = deferred[oldest % DEFERRED_LEAVES];
                oldest += 1;
                leaf.packets &= V::Packets::splat(simd, leaf.q_near).le(q_limit).bits();
            }
            if leaf.packets == 0 {
                // It was one of those held, or NONE.
                held -= usize::from(SHARED);
                continue;
            }
            held -= 1;
            let taken = if SHARED {
                // Together with another leaf if there is one.
                let mut second = (leaf.child, 0);
                let next = deferred[oldest % DEFERRED_LEAVES];
                if V::Triangles::COUNT > LANES
                    && held > 0
                    && leaf.child.is_triangles()
                    && next.child.is_triangles()
                {
                    held -= 1;
                    oldest += 1;
                    let packets = next.packets & V::Packets::splat(simd, next.q_near).le(q_limit).bits();
                    if packets != 0 {
                        second = (next.child, packets);
                    }
                }
                let leaves = Leaves {
                    child: [leaf.child, second.0],
                    packets: [leaf.packets, second.1],
                };
                let count = 1 + usize::from(second.1 != 0);
                let met = (leaf.packets.count_ones() + second.1.count_ones()) as usize;
                self.visits.add(count, met);
                let packets = &mut self.rooms.of_mut::<V>().packets;
                simd.call(
                    #[inline(always)]
                    || leaf::shared_origin::<B, V, ANY>(simd, blocks, leaves, culling, packets),
                )
            } else {
                let (child, packets) = (leaf.child, leaf.packets);
                let (room, candidates) = (self.rooms.of_mut::<V>(), &mut self.candidates);
                let (lines, states) = (&room.sheared, &mut room.packets);
                let leaf = (child, packets);
                simd.call(
                    #[inline(always)]
                    || {
                        sheared::separate_origins::<B, V, ANY>(
                            simd, blocks, leaf, culling, lines, candidates, states,
                        )
                    },
                )
            };
            if ANY {
                // Without a branch on which packets these are.
                let done = V::Packets::mask(simd, taken);
                q_limit = V::Packets::select(done, V::Packets::splat(simd, -1.0), q_limit);
                continue;
            }
            for p in bits(taken) {
                q_limit = self.with_limit(simd, culling, q_limit, p);
            }
        }
    }

    /// `q_limit` with the current limit of packet `p`. Returns a register: loading what was just stored in parts
    /// stalls.
    #[inline(always)]
    fn with_limit<V: RayLanes>(
        &self,
        simd: V::Simd,
        culling: &Culling<'_, V>,
        q_limit: V::Packets,
        p: usize,
    ) -> V::Packets {
        let t = self.rooms.of::<V>().packets[p % PACKETS].farthest::<V>(simd);
        let limit = match culling.frustum {
            Some(frustum) => frustum.q_limit(p, t),
            None => t,
        };
        let only = V::Packets::mask(simd, 1 << p);
        V::Packets::select(only, V::Packets::splat(simd, limit), q_limit)
    }

    /// Pushes the children that some of `packets` may hit, nearest last.
    #[inline(always)]
    fn push_children<B: TriangleLeaf, V: RayLanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        simd: V::Simd,
        blocks: LeafBlocks<'_, B>,
        node: &Node8,
        culling: &Culling<'_, V>,
        packets: u32,
        q_limit: V::Packets,
    ) {
        let (candidates, seen): (u32, Option<Seen<Eight<V>>>) = match culling.frustum {
            Some(frustum) => {
                let (candidates, seen) = frustum.children(node);
                (candidates, Some(seen))
            }
            None => (node.valid_bits(), None),
        };
        let mut pairs = Pairs::default();
        debug_assert!(SHARED || culling.exact, "pairs come from ray by ray");
        match (culling.frustum, &seen) {
            // `entering_by_packet` tests all of them.
            _ if !SHARED => {}
            // A packet on its own fills the bundle's frustum.
            (Some(frustum), Some(seen)) if culling.regroup => {
                for c in bits(candidates) {
                    pairs.put(c, packets & frustum.packets_of(seen, c, q_limit));
                }
            }
            _ => {
                for c in bits(candidates) {
                    pairs.put(c, packets);
                }
            }
        }
        let mut near8 = match seen {
            Some(seen) => seen.q_near,
            None => simd.splat(0.0),
        };
        let mut chosen = pairs.children();
        if culling.exact {
            let mut planes = in_order(node, culling.octant);
            if SHARED {
                for (i, plane) in planes.iter_mut().enumerate() {
                    *plane = (simd.load(plane) - simd.splat(self.origin[i % 3])).to8();
                }
            }
            let room = self.rooms.of::<V>();
            let (states, slabs) = (&room.packets, &room.slabs);
            let entering = match (SHARED, culling.octant.is_some()) {
                (true, true) => entering::<V, true>(simd, &planes, &pairs, states),
                (true, false) => entering::<V, false>(simd, &planes, &pairs, states),
                (false, true) => {
                    entering_by_packet::<V, true>(simd, &planes, candidates, packets, states, slabs)
                }
                (false, false) => {
                    entering_by_packet::<V, false>(simd, &planes, candidates, packets, states, slabs)
                }
            };
            pairs = entering.pairs;
            chosen = pairs.children();
            if culling.regroup {
                let few = chosen & !entering.more;
                chosen &= !few;
                if culling.octant.is_some() {
                    self.go_on_alone::<V, SHARED, true>(simd, node, &planes, few, &pairs);
                } else {
                    self.go_on_alone::<V, SHARED, false>(simd, node, &planes, few, &pairs);
                }
            }
            if culling.frustum.is_none() {
                near8 = nearest8::<V>(simd, node, &pairs, &self.rooms.of::<V>().packets);
            }
        }
        let places = self.bvh.places(blocks);
        let (order, count) = near8.nearest_last(chosen);
        for &entry in order.iter().take(count) {
            let (q_near, c) = unpack(entry);
            let child = node.child[c];
            places.prefetch(child);
            self.bundle_stack.push(Entry {
                child,
                packets: pairs.packets(c),
                q_near,
            });
        }
    }

    /// Makes single-ray tasks of the rays that enter the children `few`. They are few, so finding them again is
    /// cheaper than keeping all entering rays.
    #[inline(always)]
    fn go_on_alone<V: RayLanes, const SHARED: bool, const ONE_OCTANT: bool>(
        &mut self,
        simd: V::Simd,
        node: &Node8,
        planes: &[F32x8; 6],
        few: u32,
        pairs: &Pairs,
    ) {
        let room = self.rooms.of::<V>();
        for c in bits(few) {
            for p in bits(pairs.packets(c)) {
                let state = &room.packets[p % PACKETS];
                let live = state.live_bits::<V>(simd);
                let (near, lanes) = if SHARED {
                    enter::<V, ONE_OCTANT>(simd, planes, c, state)
                } else {
                    room.slabs[p % PACKETS]
                        .load::<V>(simd, state)
                        .enter::<ONE_OCTANT>(planes, c)
                };
                let mut nears = V::Memory::ZERO;
                near.store(&mut nears);
                for i in bits(lanes.bits() & live) {
                    self.tasks.push(SingleRayTask {
                        ray: (p * V::COUNT + i) as u32,
                        child: node.child[c % LANES],
                        near: nears.place(i),
                    });
                }
            }
        }
    }
}

/// Which packets enter the children of a node.
struct Entering {
    /// Packets with rays that enter.
    pairs: Pairs,
    /// Children that at least two rays of one packet enter; into others the rays go on alone.
    // Tuned: see docs/lab-notes.md#lone-rays
    more: u32,
}

/// Those of the pairs whose packet has a ray that enters the child, tested ray by ray. `planes` are a node's,
/// [in order](in_order), relative to the shared origin.
#[inline(always)]
fn entering<V: Lanes, const ONE_OCTANT: bool>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    pairs: &Pairs,
    states: &[Packet<V::Memory>; PACKETS],
) -> Entering {
    let (low, more_low) = entering_of::<V, ONE_OCTANT>(simd, planes, pairs.low, 0, states);
    let (high, more_high) = entering_of::<V, ONE_OCTANT>(simd, planes, pairs.high, 4, states);
    let more = Pairs {
        low: more_low,
        high: more_high,
    };
    Entering {
        pairs: Pairs { low, high },
        more: more.children(),
    }
}

/// [`entering`] for one word of pairs, whose first child is `first`: the same pairs, and those that two rays enter.
#[inline(always)]
fn entering_of<V: Lanes, const ONE_OCTANT: bool>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    pairs: u64,
    first: usize,
    states: &[Packet<V::Memory>; PACKETS],
) -> (u64, u64) {
    let (mut entering, mut more) = (0, 0);
    for pair in bits64(pairs) {
        let (c, p) = (first + pair / PACKETS, pair % PACKETS);
        let lanes = enter::<V, ONE_OCTANT>(simd, planes, c, &states[p]).1.bits();
        entering |= u64::from(lanes != 0) << pair;
        more |= u64::from(lanes & lanes.wrapping_sub(1) != 0) << pair;
    }
    (entering, more)
}

/// [`entering`] for separate origins: all candidate children, packet by packet. `planes` are a node's, in order.
///
/// The frusta of packets with a box of origins each hold nearly all of the bundle's, so they are not tested. All
/// packets test the same children, so the loop's length is predictable.
// Tuned: see docs/lab-notes.md#boxes-ray-by-ray
#[inline(always)]
fn entering_by_packet<V: Lanes, const ONE_OCTANT: bool>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    candidates: u32,
    packets: u32,
    states: &[Packet<V::Memory>; PACKETS],
    slabs: &[PacketSlabs<V::Memory>; PACKETS],
) -> Entering {
    // The children of eight packets, a byte a packet.
    let (mut low, mut high) = (0, 0);
    let mut more = 0;
    for p in bits(packets) {
        let rays = slabs[p % PACKETS].load::<V>(simd, &states[p % PACKETS]);
        let mut children = 0;
        for c in bits(candidates) {
            let lanes = rays.enter::<ONE_OCTANT>(planes, c).1.bits();
            children |= u32::from(lanes != 0) << c;
            more |= u32::from(lanes & lanes.wrapping_sub(1) != 0) << c;
        }
        let byte = u64::from(children) << (p % 8 * 8);
        let is_high = u64::from(p >= 8).wrapping_neg();
        low |= byte & !is_high;
        high |= byte & is_high;
    }
    Entering {
        pairs: Pairs::of_packets(low, high),
        more,
    }
}

/// A lower bound on where a packet's rays enter child `c`, and the rays that do; `planes` as for [`entering`].
///
/// Includes every ray with a [canonical interval](Packet::interval), up to its end, in something in the box. Only the
/// entry is scaled, by [`NODE_PAD`]: one half-ulp more than both canonical scales and the roundings. Distances may be
/// negative: boxes behind the origin and finished rays may pass; frusta drop the former, and neither takes a hit.
// Tuned: see docs/lab-notes.md#node-slabs
#[inline(always)]
pub(super) fn enter<V: Lanes, const ONE_OCTANT: bool>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    c: usize,
    state: &Packet<V::Memory>,
) -> (V, V::Mask) {
    let inv = Vec3Lanes::<V>::load(simd, &state.inv_direction);
    let (first, last) = corners::<V>(simd, planes, c);
    let (x0, x1) = (first.x * inv.x, last.x * inv.x);
    let (y0, y1) = (first.y * inv.y, last.y * inv.y);
    let (z0, z1) = (first.z * inv.z, last.z * inv.z);
    let t = V::load(simd, &state.t);
    let (near, far) = if ONE_OCTANT {
        (x0.max(y0).max(z0), x1.min(y1).min(z1.min(t)))
    } else {
        let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1));
        (near, x0.max(x1).min(y0.max(y1)).min(z0.max(z1).min(t)))
    };
    let near = near * (1.0 - NODE_PAD);
    (near, near.le(far))
}

/// The node's planes ordered for the direction octant: entry planes, then exit planes; without an octant, lower then
/// upper.
#[inline(always)]
pub(super) fn in_order(node: &Node8, octant: Option<[u8; 3]>) -> [F32x8; 6] {
    let Some(octant) = octant else { return node.planes };
    let sides: &[[F32x8; 3]; 2] = bytemuck::cast_ref(&node.planes);
    let side = |turned: u8, axis: usize| sides[usize::from(octant[axis] ^ turned) & 1][axis];
    [
        side(0, 0),
        side(0, 1),
        side(0, 2),
        side(1, 0),
        side(1, 1),
        side(1, 2),
    ]
}

/// The box of child `c` in all lanes: lower and upper corner.
#[inline(always)]
pub(super) fn corners<V: Lanes>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    c: usize,
) -> (Vec3Lanes<V>, Vec3Lanes<V>) {
    let plane = |i: usize| planes[i].as_array()[c % LANES];
    let lower = Vec3::new(plane(0), plane(1), plane(2));
    let upper = Vec3::new(plane(3), plane(4), plane(5));
    (Vec3Lanes::splat(simd, lower), Vec3Lanes::splat(simd, upper))
}

/// A lower bound on where the first ray enters each child, by the frustum if there is one.
#[inline(always)]
fn nearest8<V: Lanes>(
    simd: V::Simd,
    node: &Node8,
    pairs: &Pairs,
    states: &[Packet<V::Memory>; PACKETS],
) -> Eight<V> {
    let mut nearest8 = F32x8::splat(f32::MAX);
    for c in 0..LANES {
        for p in bits(pairs.packets(c)) {
            let state = &states[p % PACKETS];
            let o = Vec3Lanes::<V>::load(simd, &state.origin);
            let (lower, upper) = corners(simd, &node.planes, c);
            let (near, _) = state.interval(lower - o, upper - o);
            let least = -(-near).largest();
            let nearest = &mut nearest8.as_mut_array()[c];
            *nearest = nearest.min(least);
        }
    }
    simd.load(&nearest8)
}

#[cfg(test)]
mod tests;
