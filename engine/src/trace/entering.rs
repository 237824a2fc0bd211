//! Which packets of a bundle enter which children of a node.

use super::{
    PACKETS, bits, bits64,
    pairs::Pairs,
    rays::Packet,
    slabs::{PacketSlabs, corners, enter},
};
use crate::{
    accel::Node8,
    lanes::{F32x8, LANES},
    simd::{Eight, LaneMask, Lanes, Simd, Vec3Lanes},
};

/// Which packets enter the children of a node.
pub(super) struct Entering {
    /// Packets with rays that enter.
    pub pairs: Pairs,
    /// Children that at least two rays of one packet enter; into others the rays continue as single-ray tasks.
    // Tuned: see docs/lab-notes.md#lone-rays
    pub more: u32,
}

/// Those of the pairs whose packet has a ray that enters the child, tested ray by ray. `planes` are a node's,
/// [in order](in_order), relative to the shared origin.
#[inline(always)]
pub(super) fn entering<V: Lanes, const ONE_OCTANT: bool>(
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
pub(super) fn entering_by_packet<V: Lanes, const ONE_OCTANT: bool>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    candidates: u32,
    packets: u32,
    states: &[Packet<V::Memory>; PACKETS],
    slabs: &[PacketSlabs<V::Memory>; PACKETS],
) -> Entering {
    // The children of eight packets, a byte per packet.
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

/// A lower bound on where the first ray enters each child, by the frustum if there is one.
#[inline(always)]
pub(super) fn nearest8<V: Lanes>(
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
