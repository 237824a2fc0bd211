//! One ray against eight boxes at a time (Wald, Benthin and Boulos, *Getting Rid of Packets*, 2008).
//!
//! A visit is bound by latency, so boxes are tested with one multiply-add a plane, near and far planes picked by
//! the direction's signs beforehand; and the most common outcomes, no child, one, or two, are handled without the
//! sorted insertion that more of them need.

use super::{
    Tracer, leaf,
    leaf::for_each_bit,
    state::{LaneHit, PacketState},
};
use crate::{
    accel::{Child, Node8},
    geometry::Slabs8,
    simd::{F32x8, LANES, Vec3x8, lane, le, max, min, mul_add, splat},
};

/// A subtree still to visit, and where the ray enters it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    child: Child,
    near: f32,
}

/// Bound on the rounding of `plane * inv - origin * inv` beyond that of its result, as a share of `origin * inv`: a
/// half-ulp for that product, one for the sum with this bound, one for the other product where multiply-add is not
/// fused, and one to spare.
const OFFSET_ERROR: f32 = 4.0 / (1 << 24) as f32;

/// Entry distances shrink and exit distances grow by this share: the canonical interval's own margin of 4
/// half-ulps and 3 roundings, and the rounding of the multiply-add here.
const INTERVAL_PAD: f32 = 12.0 / (1 << 24) as f32;

/// One ray, in all lanes.
struct SingleRay {
    slabs: Slabs8,
    direction: Vec3x8,
    inv: [F32x8; 3],
    /// What to add to plane x inv for a near plane and a far plane: `-origin * inv`, moved apart by its error.
    near_offset: [F32x8; 3],
    far_offset: [F32x8; 3],
    /// Whether the ray goes down an axis, so that the upper plane is the near one.
    down: [bool; 3],
}

impl SingleRay {
    fn new(state: &PacketState, i: usize) -> Self {
        let all_lanes = |v: &Vec3x8| Vec3x8::splat(v.lane(i));
        let origin = state.slabs.origin.lane(i);
        let inv = state.slabs.inv_direction.lane(i);
        let offset = origin * inv;
        let error = offset.abs() * OFFSET_ERROR;
        Self {
            slabs: Slabs8 {
                origin: Vec3x8::splat(origin),
                inv_direction: Vec3x8::splat(inv),
            },
            direction: all_lanes(&state.direction),
            inv: inv.to_array().map(splat),
            near_offset: (-offset - error).to_array().map(splat),
            far_offset: (-offset + error).to_array().map(splat),
            down: inv.to_array().map(|inv| inv < 0.0),
        }
    }

    /// The children that the ray enters not beyond `t_max`, a bit a child, and where.
    #[inline(always)]
    fn enter(&self, node: &Node8, t_max: F32x8) -> (u32, F32x8) {
        let planes = |axis: usize| {
            let (lower, upper) = (node.lower[axis], node.upper[axis]);
            let (near, far) = if self.down[axis] {
                (upper, lower)
            } else {
                (lower, upper)
            };
            (
                mul_add(near, self.inv[axis], self.near_offset[axis]),
                mul_add(far, self.inv[axis], self.far_offset[axis]),
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
        let ray = SingleRay::new(&self.states[p], i);
        let mut hit = self.states[p].lane_hit(i);
        self.traverse_single::<ANY>(&ray, &mut hit, start);
        self.states[p].set_lane_hit(i, &hit);
    }

    fn traverse_single<const ANY: bool>(&mut self, ray: &SingleRay, hit: &mut LaneHit, start: Child) {
        let bvh = self.bvh;
        let stack = &mut self.single_stack;
        stack.clear();
        let mut child = start;
        loop {
            if child.is_inner() {
                let node = &bvh.nodes()[child.index()];
                let (mut entered, near) = ray.enter(node, splat(hit.t));
                let entry = |c: usize| Entry {
                    child: node.child[c % LANES],
                    near: lane(&near, c % LANES),
                };
                if entered != 0 {
                    let first = entered.trailing_zeros() as usize;
                    entered &= entered - 1;
                    if entered == 0 {
                        child = node.child[first % LANES];
                        continue;
                    }
                    let (first, second) = (entry(first), entry(entered.trailing_zeros() as usize));
                    entered &= entered - 1;
                    let (nearer, farther) = if second.near < first.near {
                        (second, first)
                    } else {
                        (first, second)
                    };
                    if entered == 0 {
                        stack.push(farther);
                        child = nearer.child;
                        continue;
                    }
                    let base = stack.len();
                    stack.extend([farther, nearer]);
                    for_each_bit(entered, |c| {
                        insert_nearest_last(stack, base, entry(c), |e| e.near);
                    });
                }
            } else {
                leaf::single::<ANY>(bvh, child, &ray.slabs, &ray.direction, hit);
                if ANY && hit.t <= 0.0 {
                    return;
                }
            }
            loop {
                let Some(entry) = stack.pop() else { return };
                if entry.near <= hit.t {
                    child = entry.child;
                    break;
                }
            }
        }
    }
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
