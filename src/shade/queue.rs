//! Queues: rays on their way, and hits filed by material.

use super::{TileColors, material::background, surface::SurfacePacket};
use crate::{
    ray::{HitPacket, Origins, PrimitiveId, RayPacket, RayPackets},
    scene::{Material, MaterialId, Scene},
    simd::{F32x8, LANES, Vec3x8, equal_lanes, gt, run, splat},
};
use glam::Vec3;
use std::ops::Range;

/// Rays to trace: either a tile's camera rays, which share their origin, or mirrored ones.
#[derive(Debug, Default)]
pub struct RayQueue {
    /// The rays; lanes without one have `t_max` 0.
    pub rays: RayPackets,
    /// See [`Self::pixel`]. None for camera rays.
    pixel: Vec<[u32; LANES]>,
    /// See [`Self::weight`]. None for camera rays.
    weight: Vec<F32x8>,
}

impl RayQueue {
    /// Makes room for so many packets.
    pub fn reserve(&mut self, packets: usize) {
        self.rays.reserve(packets);
        self.pixel.reserve(packets);
        self.weight.reserve(packets);
    }

    /// Forgets all rays. Those to come start at `origin`, or each at its own point.
    pub fn restart(&mut self, origin: Option<Vec3>) {
        self.rays.restart(origin);
        self.pixel.clear();
        self.weight.clear();
    }

    /// Adds eight camera rays, of the next eight pixels.
    #[inline(always)]
    pub fn push(&mut self, rays: RayPacket) {
        self.rays.push(rays);
    }

    /// Adds eight rays that start at `origin`.
    #[inline(always)]
    pub fn push_from(&mut self, origin: Vec3x8, rays: RayPacket, pixel: [u32; LANES], weight: F32x8) {
        self.rays.push_from(origin, rays);
        self.pixel.push(pixel);
        self.weight.push(weight);
    }

    /// Whether these are camera rays.
    #[inline(always)]
    #[must_use]
    pub fn are_camera_rays(&self) -> bool {
        matches!(self.rays.origins(), Origins::Shared(_))
    }

    /// The places in [`TileColors`] of the pixels of packet `p`'s rays.
    #[inline(always)]
    #[must_use]
    pub fn pixel(&self, p: usize) -> [u32; LANES] {
        if self.are_camera_rays() {
            run((p * LANES) as u32)
        } else {
            self.pixel[p]
        }
    }

    /// What the colours of packet `p`'s rays count.
    #[inline(always)]
    #[must_use]
    pub fn weight(&self, p: usize) -> F32x8 {
        if self.are_camera_rays() {
            splat(1.0)
        } else {
            self.weight[p]
        }
    }

    /// How many lanes hold a ray.
    #[must_use]
    pub fn active_rays(&self) -> u64 {
        self.rays
            .packets()
            .iter()
            .map(|p| u64::from(gt(p.t_max, splat(0.0)).bits().count_ones()))
            .sum()
    }
}

/// The place of a ray in its queue: packet x 8 + lane.
pub type RayIndex = u32;

/// With this many lanes of a packet on one material they stay together, else they join others' in a new packet.
/// Whole packets keep the order of the rays, so that what follows from neighbours are neighbours, and nothing
/// moves between lanes.
///
/// Tried 1, 3, 5 and 8 on course scenes: 3 is the best by a few percent of shading, but all are close. (With 1 rays
/// that have lost their neighbours would go on in packets that are nearly empty.)
const STAY: u32 = 3;

/// The most packets that rays of so many pixels end up in at any level.
#[must_use]
pub fn most_packets(pixels: usize, materials: usize) -> usize {
    pixels / STAY as usize + materials.min(pixels)
}

/// Materials that get room for all pixels of a tile from the start; others when they are hit.
const EAGER_MATERIALS: usize = 64;

/// Lanes of one packet that hit the same material.
#[derive(Clone, Copy, Debug)]
pub struct PacketLanes {
    /// Index of the packet in its queue.
    pub packet: u32,
    /// A bit a lane.
    pub bits: u32,
}

/// The hits of one material, each kind in the order of the rays.
#[derive(Debug, Default)]
pub struct Bucket {
    /// Lanes that stay in their packet.
    pub in_place: Vec<PacketLanes>,
    /// Rays that are put together, eight to a packet.
    pub loose: Vec<RayIndex>,
}

impl Bucket {
    fn is_empty(&self) -> bool {
        self.in_place.is_empty() && self.loose.is_empty()
    }

    /// How many surface packets [`gather`](super::surface::gather) makes of it.
    fn packet_count(&self) -> usize {
        self.in_place.len() + self.loose.len().div_ceil(LANES)
    }
}

/// Hits filed by material.
#[derive(Debug, Default)]
pub struct HitQueue {
    /// By material id.
    buckets: Vec<Bucket>,
    /// Materials with hits: those that need light first, then the others; ascending within each.
    used: Vec<MaterialId>,
}

/// Whether a material's colour depends on light.
fn needs_light(material: &Material) -> bool {
    !matches!(material, Material::Silhouette { .. })
}

impl HitQueue {
    /// Makes room for the hits of so many pixels, whatever they hit.
    pub fn reserve(&mut self, materials: usize, pixels: usize) {
        self.used.reserve(materials.min(pixels));
        self.buckets.resize_with(materials, Bucket::default);
        for bucket in self.buckets.iter_mut().take(EAGER_MATERIALS) {
            bucket.in_place.reserve(pixels / STAY as usize);
            bucket.loose.reserve(pixels);
        }
    }

    fn reset(&mut self, materials: usize) {
        self.buckets
            .resize_with(materials.max(self.buckets.len()), Bucket::default);
        for material in self.used.drain(..) {
            let bucket = &mut self.buckets[material.0 as usize];
            bucket.in_place.clear();
            bucket.loose.clear();
        }
    }

    /// Files the lanes of `bits`, which hit `material`.
    #[inline(always)]
    fn file(&mut self, material: MaterialId, packet: u32, bits: u32) {
        let bucket = &mut self.buckets[material.0 as usize];
        if bucket.is_empty() {
            self.used.push(material);
        }
        if bits.count_ones() >= STAY {
            bucket.in_place.push(PacketLanes { packet, bits });
        } else {
            let lanes = (0..LANES as u32).filter(|lane| bits >> lane & 1 == 1);
            bucket
                .loose
                .extend(lanes.map(|lane| packet * LANES as u32 + lane));
        }
    }

    /// Materials that were hit, and by what.
    pub fn buckets(&self) -> impl Iterator<Item = (MaterialId, &Bucket)> {
        self.used.iter().map(|&m| (m, &self.buckets[m.0 as usize]))
    }

    /// Materials that were hit, and the range of surface packets that [`gather`](super::surface::gather)
    /// made of each.
    pub fn ranges(&self) -> impl Iterator<Item = (MaterialId, Range<usize>)> {
        let mut start = 0;
        self.buckets().map(move |(material, bucket)| {
            let range = start..start + bucket.packet_count();
            start = range.end;
            (material, range)
        })
    }

    /// The surface packets whose colour depends on light: they come first.
    #[must_use]
    pub fn lit_surfaces<'a>(&self, scene: &Scene, surfaces: &'a [SurfacePacket]) -> &'a [SurfacePacket] {
        let lit = |m: &MaterialId| needs_light(&scene.materials()[m.0 as usize]);
        let end = self
            .ranges()
            .filter(|(m, _)| lit(m))
            .map(|(_, range)| range.end)
            .last();
        &surfaces[..end.unwrap_or(0)]
    }
}

/// Files the hits of `rays` by material; misses take the background at once, or nothing if they `see_through` it.
/// Camera rays put the first colours there are, others add theirs.
pub fn sort(
    scene: &Scene,
    rays: &RayQueue,
    hits: &[HitPacket],
    see_through: bool,
    by_material: &mut HitQueue,
    colors: &mut TileColors,
) {
    by_material.reset(scene.materials().len());
    let are_first = rays.are_camera_rays();
    for (packet_i, (packet, hits)) in rays.rays.packets().iter().zip(hits).enumerate() {
        let active = gt(packet.t_max, splat(0.0)).bits();
        let none = equal_lanes(&hits.primitive, PrimitiveId::NONE.0);
        let missed = active & none;
        let seen = if see_through { 0 } else { missed };
        if are_first {
            colors.put(packet_i, seen, background(scene, &packet.direction));
        } else if seen != 0 {
            let background = background(scene, &packet.direction);
            colors.add(seen, &rays.pixel(packet_i), rays.weight(packet_i), background);
        }
        // One round for each primitive that was hit, not for each lane; most often all lanes hit the same few.
        let mut left = active & !none;
        let mut filed = (MaterialId::default(), 0);
        while left != 0 {
            let id = hits.primitive[left.trailing_zeros() as usize];
            let bits = left & equal_lanes(&hits.primitive, id);
            left &= !bits;
            let material = scene.material_of(PrimitiveId(id));
            if filed.1 != 0 && material != filed.0 {
                by_material.file(filed.0, packet_i as u32, filed.1);
                filed.1 = 0;
            }
            filed = (material, filed.1 | bits);
        }
        if filed.1 != 0 {
            by_material.file(filed.0, packet_i as u32, filed.1);
        }
    }
    by_material
        .used
        .sort_unstable_by_key(|m| (!needs_light(&scene.materials()[m.0 as usize]), *m));
}
