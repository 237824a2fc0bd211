//! The hits of a queue of rays, sorted by material, and the surfaces there.

use super::{
    TileColors,
    queue::{self, HitQueue, RayQueue},
    surface::{self, SurfacePacket},
    texture::{self, Textured},
    tint::{self, Tint8},
};
use crate::{
    lanes::{F32x8, LANES},
    ray::HitPacket,
    scene::{RayCone, Scene},
    simd::{Level, at_level},
    trace::Tracer,
};
use std::time::{Duration, Instant};

/// The scratch memory of hits and surfaces.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// One for each packet of the queue; there may be more.
    pub hits: Vec<HitPacket>,
    /// The instances of the hits; empty if the scene has none.
    instances: Vec<[u32; LANES]>,
    pub by_material: HitQueue,
    pub surfaces: Vec<SurfacePacket>,
    /// As many as `surfaces`, or none.
    pub tints: Vec<Tint8>,
    pub textured: Textured,
}

impl Found {
    /// Reserves memory for tiles of `pixels` pixels of `scene`, which fill up to `packets` packets.
    pub fn reserve(&mut self, scene: &Scene, pixels: usize, packets: usize) {
        self.hits.resize(packets, HitPacket::miss(F32x8::ZERO));
        self.surfaces.reserve(packets);
        if scene.has_colors() || scene.has_textures() {
            self.tints.reserve(packets);
        }
        if scene.has_textures() {
            self.textured.reserve(packets);
        }
        self.by_material.reserve(scene.materials().len(), pixels);
    }

    /// Traces the rays of a queue, and returns the time.
    pub fn trace(&mut self, tracer: &mut Tracer<'_>, rays: &RayQueue) -> Duration {
        let packets = rays.rays.packets();
        if self.hits.len() < packets.len() {
            self.hits.resize(packets.len(), HitPacket::miss(F32x8::ZERO));
        }
        let start = Instant::now();
        tracer.closest_hit(rays.rays.origins(), packets, &mut self.hits[..packets.len()]);
        let time = start.elapsed();
        self.instances.clear();
        self.instances.extend_from_slice(tracer.instances_hit());
        time
    }

    /// Returns the hits of the queue that was traced last.
    pub fn hits_of(&self, rays: &RayQueue) -> &[HitPacket] {
        &self.hits[..rays.rays.packets().len()]
    }

    /// Sorts the hits by material and gathers their surfaces; see [`queue::sort`] for `transparent` and `colors`. `cone` is
    /// that of the rays.
    pub fn gather(
        &mut self,
        scene: &Scene,
        (level, cone): (Level, RayCone),
        (rays, transparent): (&RayQueue, bool),
        colors: &mut TileColors,
    ) {
        let hits = &self.hits[..rays.rays.packets().len()];
        let (sorted, surfaces) = (&mut self.by_material, &mut self.surfaces);
        at_level!(level, |simd| {
            queue::sort(simd, scene, rays, hits, transparent, sorted, colors);
            surface::gather(simd, scene, rays, hits, sorted, surfaces);
            if !self.instances.is_empty() {
                surface::place(simd, scene, (rays, hits), &self.instances, sorted, surfaces);
            }
        });
        let tints = &mut self.tints;
        tints.clear();
        if scene.has_colors() {
            at_level!(level, |simd| tint::gather(simd, scene, hits, sorted, tints));
        }
        if scene.has_textures() {
            let traced = (rays, hits, &self.instances[..]);
            texture::pass(scene, traced, (sorted, surfaces), cone, tints, &mut self.textured);
        }
    }
}
