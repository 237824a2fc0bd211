//! Up to 64 rays together: eight packets whose frustum is tested against eight boxes at once, then each box
//! left against the frusta of the eight packets at once (a lane a packet). Descends from packet tracing with
//! frusta (Boulos et al. 2006; Overbeck, Ramamoorthi and Mark, *Large Ray Packets for Real-time Whitted Ray
//! Tracing*, 2008); a mask of packets takes the place of their first-active index, as eight packets fit a byte.

use super::{
    BUNDLE, Tracer, frustum::BundleFrustum, leaf, leaf::for_each_bit, packet::enter_child,
    single::insert_nearest_last, state::PacketState,
};
use crate::{
    accel::{Child, Node8},
    simd::{F32x8, LANES, lane, le, splat},
};

/// A subtree still to visit, the packets that may hit something in it, and the least q of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    child: Child,
    packets: u32,
    q_near: f32,
}

/// With this many packets left in a subtree they go on one by one.
const FEW: u32 = 1;

impl Tracer<'_> {
    /// Traces the bundle of all states, as long as it holds together.
    pub(super) fn trace_bundle<const ANY: bool, const SHARED: bool>(&mut self) {
        let frustum = if self.states.len() > 1 {
            BundleFrustum::new(&self.states)
        } else {
            None
        };
        match frustum {
            Some(frustum) => self.traverse_bundle::<ANY, SHARED>(&frustum),
            None => {
                for p in 0..self.states.len() {
                    if let Some(frustum) = BundleFrustum::new(&self.states[p..=p]) {
                        self.traverse_packet::<ANY, SHARED, true>(p, Some(&frustum.all), self.bvh.root());
                    } else {
                        let live = self.states[p].live_bits();
                        for_each_bit(live, |i| self.trace_lane::<ANY>(p, i, self.bvh.root()));
                    }
                }
            }
        }
    }

    fn traverse_bundle<const ANY: bool, const SHARED: bool>(&mut self, frustum: &BundleFrustum) {
        let bvh = self.bvh;
        // Packets that can take hits, and up to where: -1 for those that are done.
        let mut q_limit8 = splat(-1.0);
        let mut all = 0;
        for p in 0..self.states.len().min(BUNDLE) {
            if self.states[p].live_bits() != 0 {
                all |= 1 << p;
                self.update_limit(frustum, &mut q_limit8, p);
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
            let packets = packets & le(splat(q_near), q_limit8).bits();
            if packets == 0 {
                continue;
            }
            if packets.count_ones() <= FEW {
                for_each_bit(packets, |p| {
                    self.traverse_packet::<ANY, SHARED, true>(p, Some(&frustum.packet(p)), child);
                    self.update_limit(frustum, &mut q_limit8, p);
                });
            } else if child.is_inner() {
                let node = &bvh.nodes()[child.index()];
                let exact = ANY || !SHARED;
                push_children(
                    node,
                    frustum,
                    packets,
                    q_limit8,
                    exact,
                    &self.states,
                    &mut self.bundle_stack,
                );
            } else if SHARED {
                leaf::shared_origin::<ANY>(bvh, child, &frustum.all, packets, &mut self.states);
                for_each_bit(packets, |p| self.update_limit(frustum, &mut q_limit8, p));
            } else {
                for_each_bit(packets, |p| {
                    leaf::packet::<ANY, SHARED>(bvh, child, None, &mut self.states[p]);
                    self.update_limit(frustum, &mut q_limit8, p);
                });
            }
        }
    }

    #[inline(always)]
    fn update_limit(&self, frustum: &BundleFrustum, q_limit8: &mut F32x8, p: usize) {
        q_limit8.as_mut_array()[p] = frustum.q_limit(p, self.states[p].farthest());
    }
}

/// Pushes the children that some of `packets` may hit, nearest last.
///
/// `exact`: rays spread wider than their frusta tell, so boxes are also tested ray by ray: a leaf for all its
/// packets, an inner node only until one packet is known to enter.
#[inline(always)]
fn push_children(
    node: &Node8,
    frustum: &BundleFrustum,
    packets: u32,
    q_limit8: F32x8,
    exact: bool,
    states: &[PacketState],
    stack: &mut Vec<Entry>,
) {
    let (candidates, seen) = frustum.all.children(node);
    let base = stack.len();
    for_each_bit(candidates, |c| {
        let mut packets = packets & frustum.packets_of(&seen, c, q_limit8);
        let child = node.child[c % LANES];
        if exact {
            packets = entering(node, c, child.is_inner(), packets, states);
        }
        if packets != 0 {
            let entry = Entry {
                child,
                packets,
                q_near: lane(&seen.q_near, c),
            };
            insert_nearest_last(stack, base, entry, |e| e.q_near);
        }
    });
}

/// Those of `packets` of which a ray enters box `c`; with `first_only` all from the first such packet on.
#[inline(always)]
fn entering(node: &Node8, c: usize, first_only: bool, packets: u32, states: &[PacketState]) -> u32 {
    let mut left = packets;
    let mut entering = 0;
    while left != 0 {
        let p = left.trailing_zeros() as usize;
        if enter_child(node, c, &states[p]).0 != 0 {
            if first_only {
                return left;
            }
            entering |= 1 << p;
        }
        left &= left - 1;
    }
    entering
}
