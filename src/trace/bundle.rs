//! Up to eight packets of rays together: their frustum is tested against eight boxes at once, then each box left
//! against the frusta of the eight packets at once (a lane a packet). Descends from packet tracing with
//! frusta (Boulos et al. 2006; Overbeck, Ramamoorthi and Mark, *Large Ray Packets for Real-time Whitted Ray
//! Tracing*, 2008); a mask of packets takes the place of their first-active index, as eight packets fit a byte.

use super::{
    PACKETS, Tracer, bits, bits64,
    frustum::{BundleFrustum, Seen},
    leaf,
    rays::Packet,
    single::Item,
};
use crate::{
    accel::{Child, Node8},
    simd::{
        F32x8, LANES, lane,
        lanes::{Column, LaneMask, Lanes, Vec3Lanes, unpack},
        splat,
    },
};

/// A subtree still to visit, the packets that may hit something in it, and the least q of it (the least t, without
/// a frustum).
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    child: Child,
    packets: u32,
    q_near: f32,
}

/// With so many rays left in a subtree they go on one by one: this many, and half as many again as packets they are in.
/// (Tried: 3 whatever the packets, -5 % on the terrain's mirror rays; 5/2 a packet, -10 % on shadow rays of small scenes.)
const FEW: u32 = 1;

/// How the rays of a bundle are culled.
pub(super) struct Culling<'a, V> {
    pub frustum: Option<&'a BundleFrustum<V>>,
    /// Boxes are also tested ray by ray.
    pub exact: bool,
    /// Few rays left go on one by one.
    pub regroup: bool,
    /// See [`first_look_reach`](crate::geometry::first_look_reach).
    pub reach: f32,
}

impl Tracer<'_> {
    /// Traces the first `count` packets through the whole tree; rays that are left to go on one by one are put into
    /// `items`.
    #[inline(always)]
    pub(super) fn traverse_bundle<V: Lanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        packets: u32,
        culling: &Culling<'_, V>,
    ) {
        let bvh = self.bvh;
        // Packets that can take hits, and up to where: -1 for those that are done.
        let mut q_limit = Column::splat(-1.0);
        let mut all = 0;
        for p in bits(packets) {
            if self.packets[p % PACKETS].live_bits::<V>() != 0 {
                all |= 1 << p;
                self.update_limit::<V>(culling, &mut q_limit, p);
            }
        }
        self.bundle_stack.clear();
        self.bundle_stack.push(Entry {
            child: bvh.root(),
            packets: all,
            q_near: 0.0,
        });
        while let Some(Entry {
            child,
            packets,
            q_near,
        }) = self.bundle_stack.pop()
        {
            let packets = packets & V::splat(q_near).le(V::load(&q_limit)).bits();
            if packets == 0 {
                continue;
            }
            if child.is_inner() {
                self.push_children::<V, ANY, SHARED>(&bvh.nodes()[child.index()], culling, packets, V::load(&q_limit));
                continue;
            }
            let (reach, states) = (culling.reach, &mut self.packets);
            let taken = if SHARED {
                leaf::shared_origin::<V, ANY>(bvh, child, culling.frustum, reach, packets, states)
            } else {
                leaf::separate_origins::<V, ANY>(bvh, child, reach, packets, states)
            };
            for p in bits(taken) {
                self.update_limit::<V>(culling, &mut q_limit, p);
            }
        }
    }

    #[inline(always)]
    fn update_limit<V: Lanes>(&self, culling: &Culling<'_, V>, q_limit: &mut Column, p: usize) {
        let t = self.packets[p % PACKETS].farthest::<V>();
        q_limit.0[p % PACKETS] = match culling.frustum {
            _ if t <= 0.0 => -1.0,
            Some(frustum) => frustum.q_limit(p, t),
            None => t,
        };
    }

    /// Pushes the children that some of `packets` may hit, nearest last.
    #[inline(always)]
    fn push_children<V: Lanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        node: &Node8,
        culling: &Culling<'_, V>,
        packets: u32,
        q_limit: V,
    ) {
        let (candidates, seen): (u32, Option<Seen<F32x8>>) = match culling.frustum {
            Some(frustum) => {
                let (candidates, seen) = frustum.children(node);
                (candidates, Some(seen))
            }
            None => (node.valid_bits(), None),
        };
        // A child's packets: 16 bits of a word, four children a word.
        let mut pairs = [0_u64; 2];
        match (culling.frustum, &seen) {
            (Some(frustum), Some(seen)) => {
                for c in bits(candidates) {
                    let packets = packets & frustum.packets_of(seen, c, q_limit);
                    pairs[c / 4 % 2] |= u64::from(packets) << (c % 4 * 16);
                }
            }
            _ => {
                for c in bits(candidates) {
                    pairs[c / 4 % 2] |= u64::from(packets) << (c % 4 * 16);
                }
            }
        }
        let near8 = seen.map_or(splat(0.0), |seen| seen.q_near);
        let mut chosen = 0;
        if culling.exact {
            let entering = entering::<V, SHARED>(node, pairs, &self.packets);
            pairs = entering.pairs;
            let mut few = 0;
            for c in 0..LANES {
                let packets = packets_of(&pairs, c);
                let rays = entering.rays[c];
                let go_on = rays > FEW + 3 * packets.count_ones() / 2 || !culling.regroup;
                chosen |= u32::from(rays != 0 && go_on) << c;
                few |= u32::from(rays != 0 && !go_on) << c;
            }
            for c in bits(few) {
                let child = node.child[c % LANES];
                for p in bits(packets_of(&pairs, c)) {
                    for i in bits(u32::from(entering.lanes[c % LANES][p % PACKETS])) {
                        self.items.push(Item {
                            ray: (p * V::COUNT + i) as u32,
                            child,
                            near: 0.0,
                        });
                    }
                }
            }
        } else {
            for c in 0..LANES {
                chosen |= u32::from(packets_of(&pairs, c) != 0) << c;
            }
        }
        let mut order = [0; LANES];
        let count = V::push_nearest_last(&mut order, near8, &[0, 1, 2, 3, 4, 5, 6, 7], chosen);
        for &entry in order.iter().take(count) {
            let (q_near, c) = unpack(entry);
            let c = c as usize % LANES;
            let child = node.child[c];
            self.bvh.prefetch(child);
            self.bundle_stack.push(Entry {
                child,
                packets: packets_of(&pairs, c),
                q_near,
            });
        }
    }
}

/// The packets of child `c`.
#[inline(always)]
fn packets_of(pairs: &[u64; 2], c: usize) -> u32 {
    (pairs[c / 4 % 2] >> (c % 4 * 16)) as u32 & 0xffff
}

/// Which rays enter the children of a node.
struct Entering {
    /// Packets with such rays, as they came.
    pairs: [u64; 2],
    /// How many rays, by child.
    rays: [u32; LANES],
    /// By child and packet.
    lanes: [[u16; PACKETS]; LANES],
}

/// Those of the packets of which a ray enters a child: the canonical test, ray by ray.
#[inline(always)]
fn entering<V: Lanes, const SHARED: bool>(node: &Node8, pairs: [u64; 2], states: &[Packet; PACKETS]) -> Entering {
    let mut entering = Entering {
        pairs: [0; 2],
        rays: [0; LANES],
        lanes: [[0; PACKETS]; LANES],
    };
    let mut planes = node.planes;
    if SHARED {
        for (i, plane) in planes.iter_mut().enumerate() {
            *plane = *plane - splat(states[0].origin[i % 3].0[0]);
        }
    }
    for (word, pairs) in pairs.into_iter().enumerate() {
        for pair in bits64(pairs) {
            let (c, p) = ((word * 4 + pair / 16) % LANES, pair % PACKETS);
            let state = &states[p];
            let [x0, y0, z0, x1, y1, z1] = &planes;
            let mut lower = Vec3Lanes { x: V::splat(lane(x0, c)), y: V::splat(lane(y0, c)), z: V::splat(lane(z0, c)) };
            let mut upper = Vec3Lanes { x: V::splat(lane(x1, c)), y: V::splat(lane(y1, c)), z: V::splat(lane(z1, c)) };
            if !SHARED {
                let o = Vec3Lanes::<V>::load(&state.origin);
                (lower, upper) = (lower - o, upper - o);
            }
            let (near, far) = state.interval(lower, upper);
            let lane_bits = near.le(far.min(V::load(&state.t))).bits();
            entering.pairs[word] |= u64::from(lane_bits != 0) << pair;
            entering.rays[c] += lane_bits.count_ones();
            entering.lanes[c][p] = lane_bits as u16;
        }
    }
    entering
}
