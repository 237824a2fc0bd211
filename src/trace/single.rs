//! One ray against eight boxes at a time (Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008).

use super::{
    Tracer, leaf,
    leaf::for_each_bit,
    state::{LaneHit, PacketState},
};
use crate::{
    accel::{Child, Node8},
    geometry::Slabs8,
    simd::{LANES, Vec3x8, lane},
};

/// A subtree still to visit, and where the ray enters it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    child: Child,
    near: f32,
}

/// One ray, in all lanes.
struct SingleRay {
    slabs: Slabs8,
    direction: Vec3x8,
}

impl Tracer<'_> {
    /// Traces all rays one by one.
    pub(super) fn trace_singles<const ANY: bool>(&mut self) {
        for p in 0..self.states.len() {
            let live = self.states[p].live_bits();
            for_each_bit(live, |i| self.trace_lane::<ANY>(p, i, self.bvh.root()));
        }
    }

    /// Traces lane `i` of packet `p` through the subtree of `start`.
    pub(super) fn trace_lane<const ANY: bool>(&mut self, p: usize, i: usize, start: Child) {
        let PacketState { slabs, direction, .. } = &self.states[p];
        let all_lanes = |v: &Vec3x8| Vec3x8::splat(v.lane(i));
        let ray = SingleRay {
            slabs: Slabs8 {
                origin: all_lanes(&slabs.origin),
                inv_direction: all_lanes(&slabs.inv_direction),
            },
            direction: all_lanes(direction),
        };
        let mut hit = self.states[p].lane_hit(i);
        self.traverse_single::<ANY>(&ray, &mut hit, start);
        self.states[p].set_lane_hit(i, &hit);
    }

    fn traverse_single<const ANY: bool>(&mut self, ray: &SingleRay, hit: &mut LaneHit, start: Child) {
        let bvh = self.bvh;
        let stack = &mut self.single_stack;
        stack.clear();
        stack.push(Entry {
            child: start,
            near: 0.0,
        });
        while let Some(Entry { child, near }) = stack.pop() {
            if near > hit.t {
                continue;
            }
            if child.is_inner() {
                push_children(&bvh.nodes()[child.index()], ray, hit.t, stack);
            } else {
                leaf::single::<ANY>(bvh, child, &ray.slabs, &ray.direction, hit);
                if ANY && hit.t <= 0.0 {
                    return;
                }
            }
        }
    }
}

/// Pushes the children that the ray enters, nearest last.
#[inline(always)]
fn push_children(node: &Node8, ray: &SingleRay, t_max: f32, stack: &mut Vec<Entry>) {
    let [lx, ly, lz] = node.lower;
    let [ux, uy, uz] = node.upper;
    let (lower, upper) = (Vec3x8::new(lx, ly, lz), Vec3x8::new(ux, uy, uz));
    let (entered, near) = ray.slabs.enter(lower, upper, crate::simd::splat(t_max));
    let base = stack.len();
    for_each_bit(entered.bits() & node.valid_bits(), |c| {
        let entry = Entry {
            child: node.child[c % LANES],
            near: lane(&near, c),
        };
        insert_nearest_last(stack, base, entry, |e| e.near);
    });
}

/// Pushes `entry` so that the entries from `base` on stay sorted, nearest last.
#[inline(always)]
pub(super) fn insert_nearest_last<E: Copy>(
    stack: &mut Vec<E>,
    base: usize,
    entry: E,
    near: impl Fn(&E) -> f32,
) {
    stack.push(entry);
    let mut at = stack.len() - 1;
    while at > base && near(&stack[at - 1]) < near(&entry) {
        stack[at] = stack[at - 1];
        at -= 1;
    }
    stack[at] = entry;
}
