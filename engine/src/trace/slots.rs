//! The rays in flight of [`single`](super::single), each with its next child and its stack.

use super::single::SingleRay;
use crate::{
    accel::{Bvh, Child, Places},
    lanes::{F32x8, LANES},
    simd::{EightLanes, LaneMask, Lanes, Simd},
};

/// Rays in flight, a bit each in [`Steps`].
// Tuned: see docs/lab-notes.md#slots
pub(super) const SLOTS: usize = u32::BITS as usize;

/// Children of one node that a ray has yet to visit, nearest first. Finding the nearest each time needs half the
/// instructions of sorting all of them.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
struct Siblings {
    /// Where the ray enters them; infinite if it misses them or has visited them.
    near8: F32x8,
    child: [Child; LANES],
}

/// Children of one node that a ray has yet to visit, in the node's order: for any hit, where the nearest is not worth
/// finding.
// Tuned: see docs/lab-notes.md#single-rays
#[derive(Clone, Copy, Debug, Default)]
struct Unvisited {
    node: u32,
    /// A bit each.
    children: u32,
}

/// One of the rays in flight.
#[derive(Debug)]
pub(super) struct Slot {
    pub ray: SingleRay,
    /// What is visited next.
    pub child: Child,
    /// The ray's end as found here: another task of the same ray may have found a nearer one since.
    pub t: f32,
    /// Closest hit: what is yet to visit, above a [`Child::NONE`] that ends the ray; `len` entries.
    stack: Vec<Siblings>,
    /// Any hit: the same, above an entry without children.
    unvisited: Vec<Unvisited>,
    len: usize,
}

/// The slots, for trees of `depth`.
pub(super) fn slots(depth: usize) -> [Slot; SLOTS] {
    let end = Siblings {
        near8: F32x8::splat(f32::INFINITY),
        child: [Child::NONE; LANES],
    };
    std::array::from_fn(|_| Slot {
        ray: SingleRay::default(),
        child: Child::NONE,
        t: 0.0,
        stack: vec![end; depth + 3],
        unvisited: vec![Unvisited::default(); depth + 3],
        len: 1,
    })
}

impl Slot {
    /// Visits a node.
    #[inline(always)]
    pub fn enter_children<S: Simd, const ANY: bool>(&mut self, simd: S, bvh: &Bvh) {
        let node = &bvh.nodes()[self.child.index()];
        if ANY {
            let (children, _) = self.ray.enter(simd, node, self.t);
            self.unvisited[self.len] = Unvisited {
                node: self.child.index() as u32,
                children,
            };
            self.len += usize::from(children != 0);
            return;
        }
        // Before the test: loads of the ray before a bounds check are not fused into broadcasts.
        let next = &mut self.stack[self.len];
        let (entered, near) = self.ray.enter(simd, node, self.t);
        next.near8 = near.to8();
        next.child = node.child;
        self.len += usize::from(entered != 0);
    }

    /// Continues with the next child.
    #[inline(always)]
    pub fn pop<S: Simd, const ANY: bool>(&mut self, simd: S, bvh: &Bvh, places: &Places) {
        if ANY {
            self.pop_any(bvh);
        } else {
            self.pop_nearest(simd);
        }
        places.prefetch(self.child);
    }

    #[inline(always)]
    fn pop_any(&mut self, bvh: &Bvh) {
        let Unvisited { node, children } = self.unvisited[self.len - 1];
        let child = bvh.nodes().get(node as usize).map_or(Child::NONE, |node| {
            node.child[children.trailing_zeros() as usize % LANES]
        });
        self.child = if children == 0 { Child::NONE } else { child };
        let left = children & children.wrapping_sub(1);
        self.unvisited[self.len - 1].children = left;
        self.len -= usize::from(left == 0);
    }

    /// Continues with the nearest of the last siblings.
    #[inline(always)]
    fn pop_nearest<S: Simd>(&mut self, simd: S) {
        let siblings = &mut self.stack[self.len - 1];
        let (near, none) = (simd.load(&siblings.near8), simd.splat(f32::INFINITY));
        let nearest = near.eq(near.min_everywhere()).bits();
        self.child = siblings.child[nearest.trailing_zeros() as usize % LANES];
        // All lanes are stored, so that no later load waits for the address. See docs/lab-notes.md#single-rays
        let visited = simd.mask(nearest & nearest.wrapping_neg());
        siblings.near8 = S::V8::select(visited, none, near).to8();
        let left = near.lt(none).bits();
        self.len -= usize::from(left & left.wrapping_sub(1) == 0);
    }

    /// The ray now ends at `t`: drops what begins beyond, in occlusion everything.
    #[inline(always)]
    pub fn end_at<S: Simd, const ANY: bool>(&mut self, simd: S, t: f32) {
        if t >= self.t {
            return;
        }
        self.t = t;
        if ANY {
            return self.clear();
        }
        let mut kept = 1;
        for i in 1..self.len {
            let mut siblings = self.stack[i];
            let near = simd.load(&siblings.near8);
            let held = near.le(simd.splat(t));
            siblings.near8 = S::V8::select(held, near, simd.splat(f32::INFINITY)).to8();
            self.stack[kept] = siblings;
            kept += usize::from(held.any());
        }
        self.len = kept;
    }

    /// Only the end is left.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.len = 1;
    }
}

/// The next step of each slot: the [kind](Child::kind) of its child.
pub(super) struct Steps {
    /// The lower bits of the kinds, a bit per slot.
    low: u32,
    /// The upper bits.
    high: u32,
}

impl Steps {
    /// All slots are done.
    pub const NONE: Self = Self { low: !0, high: !0 };

    /// The slots whose child is of a kind.
    #[inline(always)]
    pub fn of(&self, kind: usize) -> u32 {
        let side = |bits: u32, is_set: usize| if is_set != 0 { bits } else { !bits };
        side(self.low, kind & 1) & side(self.high, kind >> 1)
    }

    /// Clears these slots' bits, for [`Self::put`] to set.
    #[inline(always)]
    pub fn clear(&mut self, slots: u32) {
        self.low &= !slots;
        self.high &= !slots;
    }

    #[inline(always)]
    pub fn put(&mut self, slot: usize, child: Child) {
        let kind = child.kind() as u32;
        self.low |= (kind & 1) << slot;
        self.high |= (kind >> 1) << slot;
    }
}
