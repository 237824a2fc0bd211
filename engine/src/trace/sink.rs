//! Result sinks: where hits and occlusion bits are written, in the order of the rays.

use super::rays::Packet;
use crate::{
    accel::prefetch,
    lanes::LANES,
    ray::{HitPacket, RayPacket},
    simd::{Memory, Simd},
};

/// In long runs of results, memory is prefetched ahead by this many packets.
// Tuned: see docs/lab-notes.md#prefetch-hits
pub(super) const AHEAD: usize = 16;

/// Receives the results of rays that come in packets of eight.
pub(super) trait ResultSink {
    /// Prefetches result `i`, which will be written.
    fn prefetch(&self, i: usize);
    /// Writes result `i`: those of eight lanes of a packet.
    fn put<S: Simd, M: Memory>(&mut self, simd: S, i: usize, packet: &Packet<M>, eight: usize);
    /// Writes result `i`: eight lanes without a hit.
    fn put_none(&mut self, i: usize, rays: &RayPacket);
    /// Writes the results of a packet of sorted rays: member m goes to result `base` + m / 8, lane m % 8, still empty.
    fn scatter<S: Simd, M: Memory>(&mut self, simd: S, base: usize, packet: &Packet<M>, members: &[u16]);
}

/// Closest hits.
impl ResultSink for &mut [HitPacket] {
    #[inline(always)]
    fn prefetch(&self, i: usize) {
        prefetch(&self[i]);
    }
    #[inline(always)]
    fn put<S: Simd, M: Memory>(&mut self, simd: S, i: usize, packet: &Packet<M>, eight: usize) {
        self[i] = packet.hits(simd, eight);
    }
    #[inline(always)]
    fn put_none(&mut self, i: usize, rays: &RayPacket) {
        self[i] = HitPacket::miss(rays.t_max);
    }
    #[inline(always)]
    fn scatter<S: Simd, M: Memory>(&mut self, simd: S, base: usize, packet: &Packet<M>, members: &[u16]) {
        for (eight, members) in members.chunks(LANES).enumerate() {
            let hits = packet.hits(simd, eight);
            for (lane, &member) in members.iter().enumerate() {
                let (i, to) = (base + usize::from(member) / LANES, usize::from(member) % LANES);
                let result = &mut self[i];
                result.t.as_mut_array()[to] = hits.t.as_array()[lane];
                result.u.as_mut_array()[to] = hits.u.as_array()[lane];
                result.v.as_mut_array()[to] = hits.v.as_array()[lane];
                result.primitive[to] = hits.primitive[lane];
            }
        }
    }
}

/// Occlusion: a bit per lane.
impl ResultSink for &mut [u8] {
    #[inline(always)]
    fn prefetch(&self, _: usize) {}
    #[inline(always)]
    fn put<S: Simd, M: Memory>(&mut self, simd: S, i: usize, packet: &Packet<M>, eight: usize) {
        self[i] = packet.blocked_bits(simd, eight) as u8;
    }
    #[inline(always)]
    fn put_none(&mut self, i: usize, _: &RayPacket) {
        self[i] = 0;
    }
    #[inline(always)]
    fn scatter<S: Simd, M: Memory>(&mut self, simd: S, base: usize, packet: &Packet<M>, members: &[u16]) {
        for (eight, members) in members.chunks(LANES).enumerate() {
            let blocked = packet.blocked_bits(simd, eight);
            for (lane, &member) in members.iter().enumerate() {
                let (i, to) = (base + usize::from(member) / LANES, usize::from(member) % LANES);
                self[i] |= ((blocked >> lane & 1) << to) as u8;
            }
        }
    }
}
