//! Up to eight packets of rays together: their frustum is tested against eight boxes at once, then each box left
//! against the frusta of the eight packets at once (a lane a packet). Descends from packet tracing with
//! frusta (Boulos et al. 2006; Overbeck, Ramamoorthi and Mark, *Large Ray Packets for Real-time Whitted Ray
//! Tracing*, 2008); a mask of packets takes the place of their first-active index, as eight packets fit a byte.

use super::{
    PACKETS, Tracer, bits,
    frustum::{BundleFrustum, Seen},
    leaf,
    rays::Packet,
    single::{Item, insert_nearest_last},
};
use crate::{
    accel::{Child, Node8},
    simd::{
        F32x8, LANES, lane,
        lanes::{Column, LaneMask, Lanes, Vec3Lanes},
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
        let base = self.bundle_stack.len();
        let (candidates, seen): (u32, Option<Seen<F32x8>>) = match culling.frustum {
            Some(frustum) => {
                let (candidates, seen) = frustum.children(node);
                (candidates, Some(seen))
            }
            None => (node.valid_bits(), None),
        };
        for c in bits(candidates) {
            let child = node.child[c % LANES];
            let (mut packets, mut q_near) = (packets, 0.0);
            if let (Some(frustum), Some(seen)) = (culling.frustum, &seen) {
                packets &= frustum.packets_of(seen, c, q_limit);
                q_near = lane(&seen.q_near, c);
            }
            if culling.exact && packets != 0 {
                let entering = entering::<V, SHARED>(node, c, packets, &self.packets);
                packets = entering.packets;
                if culling.frustum.is_none() {
                    q_near = entering.near;
                }
                if culling.regroup && entering.rays <= FEW + 3 * packets.count_ones() / 2 {
                    for p in bits(packets) {
                        for i in bits(entering.lanes[p % PACKETS]) {
                            self.items.push(Item {
                                ray: (p * V::COUNT + i) as u32,
                                child,
                                near: entering.near,
                            });
                        }
                    }
                    continue;
                }
            }
            if packets != 0 {
                self.bvh.prefetch(child);
                let entry = Entry {
                    child,
                    packets,
                    q_near,
                };
                insert_nearest_last(&mut self.bundle_stack, base, entry, |e| e.q_near);
            }
        }
    }
}

/// Which rays enter a box.
struct Entering {
    /// Packets with such rays.
    packets: u32,
    /// How many rays.
    rays: u32,
    /// By packet.
    lanes: [u32; PACKETS],
    /// Where the first one does, at least.
    near: f32,
}

/// Those of `packets` of which a ray enters box `c`: the canonical test, ray by ray.
#[inline(always)]
fn entering<V: Lanes, const SHARED: bool>(
    node: &Node8,
    c: usize,
    packets: u32,
    states: &[Packet; PACKETS],
) -> Entering {
    let (lower, upper) = node.corners(c);
    let mut entering = Entering {
        packets: 0,
        rays: 0,
        lanes: [0; PACKETS],
        near: f32::MAX,
    };
    let mut nearest = V::splat(f32::MAX);
    let [x, y, z] = &states[0].origin;
    let shared = Vec3::new(x.0[0], y.0[0], z.0[0]);
    let seen = (
        Vec3Lanes::<V>::splat(lower - shared),
        Vec3Lanes::<V>::splat(upper - shared),
    );
    for p in bits(packets) {
        let state = &states[p % PACKETS];
        let (lower, upper) = if SHARED {
            seen
        } else {
            let o = Vec3Lanes::<V>::load(&state.origin);
            (Vec3Lanes::splat(lower) - o, Vec3Lanes::splat(upper) - o)
        };
        let (near, far) = state.interval(lower, upper);
        let lanes = near.le(far.min(V::load(&state.t)));
        let lane_bits = lanes.bits();
        if lane_bits != 0 {
            entering.packets |= 1 << p;
            entering.rays += lane_bits.count_ones();
            entering.lanes[p % PACKETS] = lane_bits;
            nearest = nearest.min(V::select(lanes, near, V::splat(f32::MAX)));
        }
    }
    entering.near = -(-nearest).largest();
    entering
}
