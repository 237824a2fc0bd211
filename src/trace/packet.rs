//! Eight rays together: their frustum against eight boxes, then the eight rays against each box that is left.

use super::{
    Tracer,
    frustum::{BundleFrustum, Frustum},
    leaf,
    leaf::for_each_bit,
    single::insert_nearest_last,
    state::PacketState,
};
use crate::{
    accel::{Child, Node8},
    simd::{LANES, Vec3x8, min_lane, splat},
};

/// A subtree still to visit, where the first ray enters it, and how many rays do.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    child: Child,
    near: f32,
    lanes: u32,
}

/// With this many rays left in a subtree they go on one by one.
const FEW: u32 = 2;

impl Tracer<'_> {
    /// Traces all packets one by one.
    pub(super) fn trace_packets<const ANY: bool, const SHARED: bool>(&mut self) {
        for p in 0..self.states.len() {
            let frustum = BundleFrustum::new(&self.states[p..=p]).map(|f| f.all);
            self.traverse_packet::<ANY, SHARED, false>(p, frustum.as_ref(), self.bvh.root());
        }
    }

    /// Traces packet `p` through the subtree of `start`. `SHARED`: its rays share their origin; `REGROUP`:
    /// few rays left go on one by one.
    pub(super) fn traverse_packet<const ANY: bool, const SHARED: bool, const REGROUP: bool>(
        &mut self,
        p: usize,
        frustum: Option<&Frustum>,
        start: Child,
    ) {
        let bvh = self.bvh;
        let live = self.states[p].live_bits();
        if live == 0 {
            return;
        }
        self.packet_stack.clear();
        self.packet_stack.push(Entry {
            child: start,
            near: 0.0,
            lanes: live,
        });
        let mut farthest = self.states[p].farthest();
        while let Some(Entry { child, near, lanes }) = self.packet_stack.pop() {
            if near > farthest {
                continue;
            }
            if REGROUP && lanes.count_ones() <= FEW {
                for_each_bit(lanes, |i| {
                    if self.states[p].live_bits() >> i & 1 == 1 {
                        self.trace_lane::<ANY>(p, i, child);
                    }
                });
                farthest = self.states[p].farthest();
            } else if child.is_inner() {
                let node = &bvh.nodes()[child.index()];
                push_children(node, frustum, &self.states[p], &mut self.packet_stack);
            } else {
                leaf::packet::<ANY, SHARED>(bvh, child, frustum, &mut self.states[p]);
                farthest = self.states[p].farthest();
            }
            if ANY && farthest <= 0.0 {
                return;
            }
        }
    }
}

/// Lanes of `state` that enter box `c` of `node`, and the nearest of their entries.
#[inline(always)]
pub(super) fn enter_child(node: &Node8, c: usize, state: &PacketState) -> (u32, f32) {
    let corner = |of: &[crate::simd::F32x8; 3]| {
        let [x, y, z] = [&of[0], &of[1], &of[2]].map(|v| splat(v.as_array()[c % LANES]));
        Vec3x8::new(x, y, z)
    };
    let (entered, near) = state
        .slabs
        .enter(corner(&node.lower), corner(&node.upper), state.t);
    (entered.bits(), min_lane(entered.select(near, splat(f32::MAX))))
}

#[inline(always)]
fn push_children(node: &Node8, frustum: Option<&Frustum>, state: &PacketState, stack: &mut Vec<Entry>) {
    let candidates = frustum.map_or(node.valid_bits(), |f| f.children(node).0);
    let base = stack.len();
    for_each_bit(candidates, |c| {
        let (lanes, near) = enter_child(node, c, state);
        if lanes != 0 {
            insert_nearest_last(
                stack,
                base,
                Entry {
                    child: node.child[c % LANES],
                    near,
                    lanes,
                },
                |e| e.near,
            );
        }
    });
}
