//! What a bundle has yet to visit: a stack of subtrees, and a ring of leaves that are being prefetched.

use super::PACKETS;
use crate::{
    accel::Child,
    simd::{LaneMask, Lanes},
};

/// A subtree to visit, the packets that may hit something in it, and its least q: the distance along the dominant axis, see
/// [`frustum`](super::frustum); without a frustum, its least t.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub child: Child,
    pub packets: u32,
    pub q_near: f32,
}

impl Entry {
    const NONE: Self = Self {
        child: Child::NONE,
        packets: 0,
        q_near: 0.0,
    };
}

/// Leaves that are deferred until their prefetch arrives, while other nodes and leaves are visited; only with a shared
/// origin.
// Tuned: see docs/lab-notes.md#deferred-leaves
const DEFERRED_LEAVES: usize = 4;

/// Deferred leaves, oldest first.
#[derive(Clone, Copy, Debug)]
pub(super) struct DeferredLeaves {
    ring: [Entry; DEFERRED_LEAVES],
    held: usize,
    oldest: usize,
}

impl DeferredLeaves {
    pub const EMPTY: Self = Self {
        ring: [Entry::NONE; DEFERRED_LEAVES],
        held: 0,
        oldest: 0,
    };

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.held == DEFERRED_LEAVES
    }

    /// Adds a leaf; there is room for it.
    #[inline(always)]
    pub fn push(&mut self, leaf: Entry) {
        debug_assert!(!self.is_full());
        self.ring[(self.oldest + self.held) % DEFERRED_LEAVES] = leaf;
        self.held += 1;
    }

    /// The leaf that has waited longest.
    #[inline(always)]
    pub fn oldest(&self) -> Option<Entry> {
        (self.held > 0).then(|| self.ring[self.oldest % DEFERRED_LEAVES])
    }

    /// Removes the oldest leaf and returns it.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<Entry> {
        let leaf = self.oldest()?;
        self.oldest += 1;
        self.held -= 1;
        Some(leaf)
    }
}

/// The q (t without a frustum) beyond which each packet takes no hit, a lane each; -1 for packets that are done.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits<V: Lanes>(V::Packets);

impl<V: Lanes> Limits<V> {
    /// Only the packets of `live` take hits, up to `farthest`.
    #[inline(always)]
    pub fn new(live: <V::Packets as Lanes>::Mask, farthest: V::Packets) -> Self {
        const { assert!(<V::Packets as Lanes>::COUNT == PACKETS, "a lane for each packet") }
        Self(V::Packets::select(live, farthest, farthest.all(-1.0)))
    }

    #[inline(always)]
    pub fn lanes(self) -> V::Packets {
        self.0
    }

    /// The packets of an entry that reach it.
    #[inline(always)]
    pub fn reached(self, entry: Entry) -> u32 {
        entry.packets & self.0.all(entry.q_near).le(self.0).bits()
    }

    /// These packets are done.
    #[inline(always)]
    pub fn end(&mut self, packets: u32) {
        let done = V::Packets::mask(self.0.simd(), packets);
        self.0 = V::Packets::select(done, self.0.all(-1.0), self.0);
    }

    /// Packet `p` now ends at `limit`. Stays in a register: loading what was just stored in parts stalls.
    #[inline(always)]
    pub fn set(&mut self, p: usize, limit: f32) {
        let only = V::Packets::mask(self.0.simd(), 1 << p);
        self.0 = V::Packets::select(only, self.0.all(limit), self.0);
    }
}

#[cfg(test)]
mod tests;
