//! Up to sixteen packets of rays together: their frustum is tested against eight boxes at once, then each box left
//! against the frusta of all packets at once (a lane a packet), or, where rays have their own origins, against these
//! ray by ray. Descends from packet tracing with frusta (Boulos et al. 2006; Overbeck, Ramamoorthi and Mark, *Large Ray
//! Packets for Real-time Whitted Ray Tracing*, 2008); a mask of packets takes the place of their first-active index.
//!
//! What is to be done next depends on the rays in ways that no branch predictor learns, and a wrong guess costs as much
//! as testing a box against two packets. So pairs (of child and packet, of packet and triangle) are gathered as bits
//! first and then worked off in one loop, whose results are counted rather than branched upon; or loops are made whose
//! length stays the same for a while. The first took shadow rays from 12.4 to 15.3 Mrays/s on the terrain and from 14
//! to 18 on the spheres, and camera rays from 39 to 43 on the blobs.

use super::{
    PACKETS, Tracer, bits, bits64,
    frustum::{BundleFrustum, Seen},
    leaf::{self, Leaves},
    lines::{self, LineSpace},
    pairs::Pairs,
    rays::{NODE_PAD, Packet, PacketSlabs},
    room::RayLanes,
    single::Item,
};
use crate::{
    accel::{Child, LeafBlocks, Node8},
    geometry::TriangleLeaf,
    simd::{
        F32x8, LANES, lane,
        lanes::{LaneMask, Lanes, Memory, REGISTER_LANES, TriangleLanes, Vec3Lanes, unpack},
        splat,
    },
};
use glam::Vec3;

/// A subtree still to visit, the packets that may hit something in it, and the least q of it (the least t, without
/// a frustum).
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

/// Up to so many leaves wait for their memory while other nodes and leaves are visited, where rays share their origin.
/// (Camera rays of a million triangles +10 to +14 %, shadow rays +8 %; with one leaf half of that, with six less,
/// before [two were taken at a time](Leaves). Rays with their own origins: -1 to -4 %.)
///
/// In occlusion a node of a large tree waits as well, until there is another. (Shadow rays of the interior +8 %,
/// terrain +3 %. Figure: -3 %, so not in small trees. Camera rays: up to -15 %, for they then visit first what is
/// behind.)
const WAITING: usize = 4;

/// A leaf at which so many packets are done, all of their rays blocked, is what the next bundle visits first. (A
/// light's last occluder, as in Haines and Greenberg, *The Light Buffer: A Shadow-Testing Accelerator*, 1986; here it
/// is a leaf, or two, and serves a bundle. Zen 3, eight lanes, shadow rays: an interior of 60,000 triangles +8 %, of
/// 370,000 +1 %, others -1 to 0 %. With one packet in place of four: terrain -2 %. The last two, four or eight
/// leaves: -2 to -5 %. Children that are largest or farthest first: -4 to +1 %. For closest hits, the leaf that most
/// packets hit: mirror rays -1 to -8 %, camera rays -2 to -27 %.)
const BLOCKING: u32 = 4;

/// How the rays of a bundle are culled.
pub(super) struct Culling<'a, V: Lanes> {
    pub frustum: Option<&'a BundleFrustum<V>>,
    /// What to visit in place of the root, for camera rays.
    pub entry: Option<&'a Node8>,
    /// Boxes are also tested ray by ray.
    pub exact: bool,
    /// Few rays left go on one by one.
    pub regroup: bool,
    /// By axis, whether all rays go down: 1 or 0. `None` if they differ.
    pub down: Option<[u8; 3]>,
    /// For rays with their own origins.
    pub space: LineSpace,
}

impl Tracer<'_> {
    /// Traces `packets` through the whole tree; rays that are left to go on one by one are put into
    /// `items`.
    #[inline(always)]
    pub(super) fn traverse_bundle<B: TriangleLeaf, V: RayLanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        blocks: LeafBlocks<'_, B>,
        packets: u32,
        culling: &Culling<'_, V>,
    ) {
        let bvh = self.bvh;
        // Where packets' rays end, a row a packet; from that, packets that can take hits, and up to where: -1 for those
        // that are done. (All at once and not packet by packet: on Zen 5 +1 to +2 %.)
        let mut ends = [V::Triangles::splat(0.0); REGISTER_LANES];
        let room = self.rooms.of::<V>();
        for p in bits(packets) {
            ends[p % REGISTER_LANES] = V::load(&room.packets[p % PACKETS].t).fold_max_to_16();
        }
        let farthest = V::Triangles::largest_of_each(&ends);
        let can_hit = farthest.gt(V::Packets::splat(0.0));
        let all = can_hit.bits();
        let limits = match culling.frustum {
            Some(frustum) => frustum.q_limits(farthest),
            None => farthest,
        };
        let mut q_limit = V::Packets::select(can_hit, limits, V::Packets::splat(-1.0));
        self.bundle_stack.clear();
        match culling.entry {
            Some(entry) if SHARED && !ANY => {
                self.push_children::<B, V, ANY, SHARED>(blocks, entry, culling, all, q_limit);
            }
            _ => self.bundle_stack.push(Entry {
                child: bvh.root(),
                packets: all,
                q_near: 0.0,
            }),
        }
        // A ring of `held` leaves, in the order they came, and how many of them there are to be.
        let mut waiting = [Entry::NONE; WAITING];
        let (mut held, mut oldest) = (0, 0);
        let mut enough = WAITING;
        // What blocked the bundle before this one comes first, and at once.
        if ANY
            && SHARED
            && let Some([first, second]) = self.blockers.take()
        {
            enough = 1 + usize::from(second != first);
            for child in [second, first].into_iter().skip(2 - enough) {
                self.bundle_stack.push(Entry {
                    child,
                    packets: all,
                    q_near: 0.0,
                });
            }
        }
        // The node that waits, and whether nothing comes behind it.
        let (mut node, mut is_last) = (Entry::NONE, false);
        loop {
            let mut leaf = match self.bundle_stack.pop() {
                Some(Entry {
                    child,
                    packets,
                    q_near,
                }) => {
                    let packets = packets & V::Packets::splat(q_near).le(q_limit).bits();
                    if packets == 0 {
                        continue;
                    }
                    if child.is_inner() {
                        let (mut child, mut packets, mut q_near) = (child, packets, q_near);
                        // Field by field: a version that copied whole entries lost 1 to 13 % on shadow rays.
                        if ANY && SHARED && self.nodes_wait && !is_last {
                            std::mem::swap(&mut child, &mut node.child);
                            std::mem::swap(&mut packets, &mut node.packets);
                            std::mem::swap(&mut q_near, &mut node.q_near);
                            packets &= V::Packets::splat(q_near).le(q_limit).bits();
                            if packets == 0 {
                                continue;
                            }
                        }
                        is_last = false;
                        self.push_children::<B, V, ANY, SHARED>(
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
                None if ANY && SHARED && node.packets != 0 => {
                    self.bundle_stack.push(node);
                    node.packets = 0;
                    is_last = true;
                    continue;
                }
                None if held == 0 => break,
                None => Entry::NONE,
            };
            if SHARED {
                if leaf.packets != 0 {
                    waiting[(oldest + held - 1) % WAITING] = leaf;
                    if held < enough {
                        continue;
                    }
                    enough = WAITING;
                }
                if held == 0 {
                    continue;
                }
                leaf = waiting[oldest % WAITING];
                oldest += 1;
                leaf.packets &= V::Packets::splat(leaf.q_near).le(q_limit).bits();
            }
            if leaf.packets == 0 {
                // It was one of those held, or is none at all.
                held -= usize::from(SHARED);
                continue;
            }
            held -= 1;
            let taken = if SHARED {
                // Another one with it, where there is one.
                let mut second = (leaf.child, 0);
                let next = waiting[oldest % WAITING];
                if V::Triangles::COUNT > LANES
                    && held > 0
                    && leaf.child.is_triangles()
                    && next.child.is_triangles()
                {
                    held -= 1;
                    oldest += 1;
                    let packets = next.packets & V::Packets::splat(next.q_near).le(q_limit).bits();
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
                if !ANY && leaf.child.is_triangles() {
                    self.density.visits.add(count, met);
                }
                let packets = &mut self.rooms.of_mut::<V>().packets;
                let taken = leaf::shared_origin::<B, V, ANY>(blocks, leaves, culling, packets);
                if ANY && taken.count_ones() >= BLOCKING {
                    self.blockers = Some(leaves.child);
                }
                taken
            } else {
                let (child, packets) = (leaf.child, leaf.packets);
                let room = self.rooms.of_mut::<V>();
                lines::separate_origins::<B, V, ANY>(
                    blocks,
                    child,
                    culling,
                    packets,
                    &room.lines,
                    &mut self.looks,
                    &mut room.packets,
                )
            };
            if ANY {
                // Without a branch on which packets these are.
                let done = <V::Packets as Lanes>::Mask::from_bits(taken);
                q_limit = V::Packets::select(done, V::Packets::splat(-1.0), q_limit);
                continue;
            }
            for p in bits(taken) {
                q_limit = self.with_limit(culling, q_limit, p);
            }
        }
    }

    /// `q_limit` with the limit of packet `p` as it is now. (A vector of its own, not one in memory: to load what was
    /// just now written in parts waits for all of them.)
    #[inline(always)]
    fn with_limit<V: RayLanes>(&self, culling: &Culling<'_, V>, q_limit: V::Packets, p: usize) -> V::Packets {
        let t = self.rooms.of::<V>().packets[p % PACKETS].farthest::<V>();
        let limit = match culling.frustum {
            Some(frustum) => frustum.q_limit(p, t),
            None => t,
        };
        let only = <V::Packets as Lanes>::Mask::from_bits(1 << p);
        V::Packets::select(only, V::Packets::splat(limit), q_limit)
    }

    /// Pushes the children that some of `packets` may hit, nearest last.
    #[inline(always)]
    fn push_children<B: TriangleLeaf, V: RayLanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        blocks: LeafBlocks<'_, B>,
        node: &Node8,
        culling: &Culling<'_, V>,
        packets: u32,
        q_limit: V::Packets,
    ) {
        let (candidates, seen): (u32, Option<Seen<F32x8>>) = match culling.frustum {
            Some(frustum) => {
                let (candidates, seen) = frustum.children(node);
                (candidates, Some(seen))
            }
            None => (node.valid_bits(), None),
        };
        let mut pairs = Pairs::default();
        debug_assert!(SHARED || culling.exact, "pairs come from ray by ray");
        match (culling.frustum, &seen) {
            // `entering_by_packet` asks for all of them.
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
        let mut near8 = seen.map_or(splat(0.0), |seen| seen.q_near);
        let mut chosen = pairs.children();
        if culling.exact {
            let mut planes = in_order(node, culling.down);
            if SHARED {
                for (i, plane) in planes.iter_mut().enumerate() {
                    *plane -= splat(self.origin[i % 3]);
                }
            }
            let room = self.rooms.of::<V>();
            let (states, slabs) = (&room.packets, &room.slabs);
            let entering = match (SHARED, culling.down.is_some()) {
                (true, true) => entering::<V, true>(&planes, &pairs, states),
                (true, false) => entering::<V, false>(&planes, &pairs, states),
                (false, true) => entering_by_packet::<V, true>(&planes, candidates, packets, states, slabs),
                (false, false) => entering_by_packet::<V, false>(&planes, candidates, packets, states, slabs),
            };
            pairs = entering.pairs;
            chosen = pairs.children();
            if culling.regroup {
                let few = chosen & !entering.more;
                chosen &= !few;
                if culling.down.is_some() {
                    self.go_on_alone::<V, SHARED, true>(node, &planes, few, &pairs);
                } else {
                    self.go_on_alone::<V, SHARED, false>(node, &planes, few, &pairs);
                }
            }
            if culling.frustum.is_none() {
                near8 = nearest8::<V>(node, &pairs, &self.rooms.of::<V>().packets);
            }
        }
        let places = self.bvh.places(blocks);
        let (order, count) = V::nearest_last(near8, chosen);
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

    /// Puts the rays that enter children `few` into `items`. (They are few: to find them once more costs less than to
    /// keep all that enter any child.)
    #[inline(always)]
    fn go_on_alone<V: RayLanes, const SHARED: bool, const ONE_WAY: bool>(
        &mut self,
        node: &Node8,
        planes: &[F32x8; 6],
        few: u32,
        pairs: &Pairs,
    ) {
        let room = self.rooms.of::<V>();
        for c in bits(few) {
            for p in bits(pairs.packets(c)) {
                let state = &room.packets[p % PACKETS];
                let live = state.live_bits::<V>();
                let (near, lanes) = if SHARED {
                    enter::<V, ONE_WAY>(planes, c, state)
                } else {
                    room.slabs[p % PACKETS]
                        .load::<V>(state)
                        .enter::<ONE_WAY>(planes, c)
                };
                let mut nears = V::Memory::ZERO;
                near.store(&mut nears);
                for i in bits(lanes.bits() & live) {
                    self.items.push(Item {
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
    /// Packets with rays that do.
    pairs: Pairs,
    /// Children that two rays of one packet enter: into others the rays go on one by one. (Tried: 3/2 rays a packet,
    /// -7 % on shadow rays of small scenes; half a ray a packet, -20 % on mirror rays of large ones.)
    more: u32,
}

/// Those of the packets of which a ray enters a child, tested ray by ray. `planes` are a node's, [in order](in_order),
/// relative to the origin that the rays share.
#[inline(always)]
fn entering<V: Lanes, const ONE_WAY: bool>(
    planes: &[F32x8; 6],
    pairs: &Pairs,
    states: &[Packet<V::Memory>; PACKETS],
) -> Entering {
    let (low, more_low) = entering_of::<V, ONE_WAY>(planes, pairs.low, 0, states);
    let (high, more_high) = entering_of::<V, ONE_WAY>(planes, pairs.high, 4, states);
    let more = Pairs {
        low: more_low,
        high: more_high,
    };
    Entering {
        pairs: Pairs { low, high },
        more: more.children(),
    }
}

/// [`entering`] for one word of pairs, whose first child is `first`: the same word of pairs, and those of which at
/// least two rays enter.
#[inline(always)]
fn entering_of<V: Lanes, const ONE_WAY: bool>(
    planes: &[F32x8; 6],
    pairs: u64,
    first: usize,
    states: &[Packet<V::Memory>; PACKETS],
) -> (u64, u64) {
    let (mut entering, mut more) = (0, 0);
    for pair in bits64(pairs) {
        let (c, p) = (first + pair / PACKETS, pair % PACKETS);
        let lanes = enter::<V, ONE_WAY>(planes, c, &states[p]).1.bits();
        entering |= u64::from(lanes != 0) << pair;
        more |= u64::from(lanes & lanes.wrapping_sub(1) != 0) << pair;
    }
    (entering, more)
}

/// [`entering`] for rays with their own origins: of all candidates, packet by packet, whose numbers stay in registers.
/// `planes` are a node's, in order.
///
/// Frusta of packets with a box of origins each hold nearly all that the bundle's holds, so they are not asked for. All
/// packets test the same children, so that how many these are can be foreseen. (Mirror rays +1 to +6 %. Shadow rays the
/// same way, with half of the pairs in vain: -2 to -5 %. Pairs that frusta leave, child by child, in loops of a length
/// that cannot be foreseen: shadow rays -1 to -9 %, mirror rays -5 to +1 %.)
#[inline(always)]
fn entering_by_packet<V: Lanes, const ONE_WAY: bool>(
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
        let rays = slabs[p % PACKETS].load::<V>(&states[p % PACKETS]);
        let mut children = 0;
        for c in bits(candidates) {
            let lanes = rays.enter::<ONE_WAY>(planes, c).1.bits();
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

/// Where a packet's rays enter child `c`, at least, and which do; `planes` are as [`entering`] has them.
///
/// All rays are there that have a [canonical interval](Packet::interval), up to their end, in something in the box: the
/// entry alone is scaled, by [`NODE_PAD`], which is one half-ulp more than both canonical scales and the roundings take.
/// Distances may be below 0: boxes behind the origin, and rays that are done, may be there too. Frusta leave out the
/// former, and neither takes a hit. (One product and one maximum less: shadow rays +1 to +3 % on Zen 5.)
#[inline(always)]
pub(super) fn enter<V: Lanes, const ONE_WAY: bool>(
    planes: &[F32x8; 6],
    c: usize,
    state: &Packet<V::Memory>,
) -> (V, V::Mask) {
    let inv = Vec3Lanes::<V>::load(&state.inv_direction);
    let (first, last) = corners::<V>(planes, c);
    let (x0, x1) = (first.x * inv.x, last.x * inv.x);
    let (y0, y1) = (first.y * inv.y, last.y * inv.y);
    let (z0, z1) = (first.z * inv.z, last.z * inv.z);
    let t = V::load(&state.t);
    let (near, far) = if ONE_WAY {
        (x0.max(y0).max(z0), x1.min(y1).min(z1.min(t)))
    } else {
        let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1));
        (near, x0.max(x1).min(y0.max(y1)).min(z0.max(z1).min(t)))
    };
    let near = near * V::splat(1.0 - NODE_PAD);
    (near, near.le(far))
}

/// The node's planes: those through which rays that go one way come in, then those through which they leave; lower,
/// then upper ones if they do not go one way.
#[inline(always)]
pub(super) fn in_order(node: &Node8, down: Option<[u8; 3]>) -> [F32x8; 6] {
    let Some(down) = down else { return node.planes };
    let sides: &[[F32x8; 3]; 2] = bytemuck::cast_ref(&node.planes);
    let side = |turned: u8, axis: usize| sides[usize::from(down[axis] ^ turned) & 1][axis];
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
pub(super) fn corners<V: Lanes>(planes: &[F32x8; 6], c: usize) -> (Vec3Lanes<V>, Vec3Lanes<V>) {
    let [x0, y0, z0, x1, y1, z1] = planes;
    let lower = Vec3::new(lane(x0, c), lane(y0, c), lane(z0, c));
    let upper = Vec3::new(lane(x1, c), lane(y1, c), lane(z1, c));
    (Vec3Lanes::splat(lower), Vec3Lanes::splat(upper))
}

/// Where the first ray enters each child, at least: what the frustum tells where there is one.
#[inline(always)]
fn nearest8<V: Lanes>(node: &Node8, pairs: &Pairs, states: &[Packet<V::Memory>; PACKETS]) -> F32x8 {
    let mut nearest8 = splat(f32::MAX);
    for c in 0..LANES {
        for p in bits(pairs.packets(c)) {
            let state = &states[p % PACKETS];
            let o = Vec3Lanes::<V>::load(&state.origin);
            let (lower, upper) = corners(&node.planes, c);
            let (near, _) = state.interval(lower - o, upper - o);
            let least = -(-near).largest();
            let nearest = &mut nearest8.as_mut_array()[c];
            *nearest = nearest.min(least);
        }
    }
    nearest8
}

#[cfg(test)]
mod tests;
