//! Closest hits and occlusion over bundles (up to 64 rays), packets (8) and single rays.
//!
//! All ways give the same hits, bit for bit: they differ only in which boxes they skip, and what they skip has
//! no hit in it. A [`Tracer`] chooses among them by what its rays do: bundles as long as one frustum holds the
//! rays of several packets, packets as long as several lanes enter a box, single rays where coherence is gone.

mod bundle;
mod frustum;
mod leaf;
mod packet;
mod single;
mod state;

use crate::{
    accel::Bvh,
    ray::{HitPacket, RayPacket},
};
use state::PacketState;

/// Packets of a bundle.
pub const BUNDLE: usize = 8;

/// Which way of tracing to use; all give the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// What fits the rays: bundles, packets or single rays.
    #[default]
    Adaptive,
    /// Packets of eight on their own, never bundles or single rays.
    Packet,
    /// One ray against eight boxes, eight primitives at a time.
    Single,
}

/// Whether rays of a bundle start at one point: then what depends on the origin alone is shared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origins {
    /// All lanes of all packets hold the same origin.
    Shared,
    /// Each ray has its own.
    Separate,
}

/// Traces rays through one BVH. Holds the memory of traversal: one for each thread, reused for all its rays.
#[derive(Debug)]
pub struct Tracer<'a> {
    bvh: &'a Bvh,
    method: Method,
    states: Vec<PacketState>,
    bundle_stack: Vec<bundle::Entry>,
    packet_stack: Vec<packet::Entry>,
    single_stack: Vec<single::Entry>,
}

impl<'a> Tracer<'a> {
    /// A tracer that chooses its way by itself.
    #[must_use]
    pub fn new(bvh: &'a Bvh) -> Self {
        Self::with_method(bvh, Method::Adaptive)
    }

    /// A tracer that is held to one way, to compare them.
    #[must_use]
    pub fn with_method(bvh: &'a Bvh, method: Method) -> Self {
        let size = bvh.stack_size();
        Self {
            bvh,
            method,
            states: Vec::with_capacity(BUNDLE),
            bundle_stack: Vec::with_capacity(size),
            packet_stack: Vec::with_capacity(size),
            single_stack: Vec::with_capacity(size),
        }
    }

    /// The nearest hits of all rays; of several equally near, the one with the lowest id. Neighbours in `rays`
    /// should be neighbours in space: eight packets make a bundle.
    ///
    /// # Panics
    /// If `rays` and `hits` differ in length.
    pub fn closest_hit(&mut self, origins: Origins, rays: &[RayPacket], hits: &mut [HitPacket]) {
        assert_eq!(rays.len(), hits.len(), "a hit packet for each ray packet");
        for (rays, hits) in rays.chunks(BUNDLE).zip(hits.chunks_mut(BUNDLE)) {
            self.trace::<false>(origins, rays);
            for (state, hit) in self.states.iter().zip(hits) {
                *hit = state.hits();
            }
        }
    }

    /// Whether anything is hit before the rays' ends: a bit a lane.
    ///
    /// # Panics
    /// If `rays` and `occluded` differ in length.
    pub fn occluded(&mut self, origins: Origins, rays: &[RayPacket], occluded: &mut [u8]) {
        assert_eq!(rays.len(), occluded.len(), "eight bits for each ray packet");
        for (rays, occluded) in rays.chunks(BUNDLE).zip(occluded.chunks_mut(BUNDLE)) {
            self.trace::<true>(origins, rays);
            for (state, bits) in self.states.iter().zip(occluded) {
                *bits = state.hit_bits() as u8;
            }
        }
    }

    fn trace<const ANY: bool>(&mut self, origins: Origins, rays: &[RayPacket]) {
        self.states.clear();
        self.states.extend(rays.iter().map(PacketState::new));
        match (self.method, origins) {
            (Method::Adaptive, Origins::Shared) => self.trace_bundle::<ANY, true>(),
            (Method::Adaptive, Origins::Separate) => self.trace_bundle::<ANY, false>(),
            (Method::Packet, Origins::Shared) => self.trace_packets::<ANY, true>(),
            (Method::Packet, Origins::Separate) => self.trace_packets::<ANY, false>(),
            (Method::Single, _) => self.trace_singles::<ANY>(),
        }
    }
}
