//! The queues: rays to trace, and hits sorted by material.

use super::{TileColors, glass::Branch8, material::background, surface::SurfacePacket};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, Origins, PrimitiveId, RayPacket, RayPackets},
    scene::{Material, MaterialId, Scene},
    simd::{EightLanes, LaneMask, Lanes, Simd},
};
use glam::Vec3;
use std::ops::Range;

/// The rays to trace: a tile's camera rays, which share their origin unless they are parallel, or secondary rays.
#[derive(Debug, Default)]
pub struct RayQueue {
    /// The rays; lanes without one have `t_max` 0.
    pub rays: RayPackets,
    /// See [`Self::pixel`]; empty for camera rays.
    pixel: Vec<[u32; LANES]>,
    /// See [`Self::weight`]; empty for camera rays.
    weight: Vec<F32x8>,
    /// See [`Self::travelled`]; empty for camera rays, and in scenes without textures.
    travelled: Vec<F32x8>,
    /// See [`Self::are_camera_rays`].
    are_camera_rays: bool,
    /// The tinted glass that camera rays start in.
    pub(super) medium: Option<MaterialId>,
    /// See [`Self::sets_colors`].
    sets_colors: bool,
    /// See [`Branch8`]; one for each packet, or empty.
    pub(super) branches: Vec<Branch8>,
}

impl RayQueue {
    /// Reserves memory for this many packets.
    pub fn reserve(&mut self, packets: usize) {
        self.rays.reserve(packets);
        self.pixel.reserve(packets);
        self.weight.reserve(packets);
        self.travelled.reserve(packets);
    }

    /// Removes all rays. The next ones are secondary, and have separate origins.
    pub fn restart(&mut self) {
        self.rays.restart(None);
        self.pixel.clear();
        self.weight.clear();
        self.travelled.clear();
        self.branches.clear();
        (self.are_camera_rays, self.sets_colors) = (false, false);
        self.medium = None;
    }

    /// Removes all rays. The next ones are camera rays that start at `origin`, or at separate origins if `None`.
    pub fn restart_camera(&mut self, origin: Option<Vec3>) {
        self.restart();
        self.rays.restart(origin);
        (self.are_camera_rays, self.sets_colors) = (true, true);
    }

    /// Removes all rays. The next ones have separate origins, and a colour each.
    pub fn restart_branches(&mut self) {
        self.restart();
        self.sets_colors = true;
    }

    /// Adds the camera rays of the next eight pixels, with a shared origin.
    #[inline(always)]
    pub fn push(&mut self, rays: RayPacket) {
        self.rays.push(rays);
    }

    /// Adds the camera rays of the next eight pixels, with separate origins.
    #[inline(always)]
    pub fn push_apart(&mut self, origin: Vec3x8, rays: RayPacket) {
        self.rays.push_from(origin, rays);
    }

    /// Adds eight secondary rays.
    #[inline(always)]
    pub fn push_from(&mut self, origin: Vec3x8, rays: RayPacket, pixel: [u32; LANES], weight: F32x8) {
        self.rays.push_from(origin, rays);
        self.pixel.push(pixel);
        self.weight.push(weight);
    }

    /// Sets the [`Self::travelled`] of the last packet.
    #[inline(always)]
    pub fn push_travelled(&mut self, travelled: F32x8) {
        self.travelled.push(travelled);
    }

    /// Returns whether these are camera rays.
    #[inline(always)]
    #[must_use]
    pub fn are_camera_rays(&self) -> bool {
        self.are_camera_rays
    }

    /// Returns whether all rays start at one point.
    #[inline(always)]
    #[must_use]
    pub fn share_origin(&self) -> bool {
        matches!(self.rays.origins(), Origins::Shared(_))
    }

    /// Returns whether each ray has its own colour, which it sets: camera rays, and all rays of a scene with glass.
    #[inline(always)]
    #[must_use]
    pub fn sets_colors(&self) -> bool {
        self.sets_colors
    }

    /// Returns the indices in [`TileColors`] of the colours that the rays of packet `p` continue.
    #[inline(always)]
    #[must_use]
    pub fn parent(&self, p: usize) -> [u32; LANES] {
        self.pixel[p]
    }

    /// Returns the factors by which packet `p` was pushed.
    #[inline(always)]
    #[must_use]
    pub fn share(&self, p: usize) -> F32x8 {
        self.weight[p]
    }

    /// Returns the indices in [`TileColors`] of the pixels of packet `p`.
    #[inline(always)]
    #[must_use]
    pub fn pixel(&self, p: usize) -> [u32; LANES] {
        if self.sets_colors {
            let mut pixels = [(p * LANES) as u32; LANES];
            for (pixel, lane) in pixels.iter_mut().zip(0..) {
                *pixel += lane;
            }
            pixels
        } else {
            self.pixel[p]
        }
    }

    /// Returns the weights of packet `p`: the factors of its colours in the pixels.
    #[inline(always)]
    #[must_use]
    pub fn weight(&self, p: usize) -> F32x8 {
        if self.sets_colors {
            F32x8::splat(1.0)
        } else {
            self.weight[p]
        }
    }

    /// Returns the number of half-transparent surfaces on the path of a ray.
    #[inline(always)]
    pub(super) fn layers(&self, p: usize, lane: usize) -> u8 {
        self.branches.get(p).map_or(0, |branch| branch.layers[lane])
    }

    /// Returns the lanes of packet `p` whose path is straight from the camera.
    #[inline(always)]
    fn straight(&self, p: usize) -> u32 {
        let of_camera = if self.are_camera_rays { u32::MAX } else { 0 };
        self.branches.get(p).map_or(of_camera, |branch| branch.straight)
    }

    /// Returns the lengths of the paths from the camera to the origins of packet `p`, scene units; 0 in scenes without
    /// textures.
    #[inline(always)]
    #[must_use]
    pub fn travelled(&self, p: usize) -> F32x8 {
        self.travelled.get(p).copied().unwrap_or(F32x8::ZERO)
    }

    /// Returns the number of lanes that hold a ray.
    #[must_use]
    pub fn active_rays(&self) -> u64 {
        self.rays
            .packets()
            .iter()
            .map(|p| p.t_max.as_array().iter().filter(|&&t| t > 0.0).count() as u64)
            .sum()
    }
}

/// The index of a ray in its queue: packet x 8 + lane.
pub type RayIndex = u32;

/// Lanes of a packet on one material that stay in place. Fewer are compacted into new packets, which keeps packets
/// full but costs coherence and moves between lanes.
// Tuned: see docs/lab-notes.md#min-lanes-in-place
const MIN_LANES_IN_PLACE: u32 = 3;

/// Returns the most packets that the rays of `pixels` pixels can occupy at a depth.
#[must_use]
pub fn max_packets(pixels: usize, materials: usize) -> usize {
    pixels / MIN_LANES_IN_PLACE as usize + materials.min(pixels)
}

/// Number of materials whose buckets are reserved in advance for all pixels of a tile; others grow when they are hit.
const EAGER_MATERIALS: usize = 64;

/// Lanes of one packet that hit the same material.
#[derive(Clone, Copy, Debug)]
pub struct PacketLanes {
    /// Index of the packet in its queue.
    pub packet: u32,
    /// One bit per lane.
    pub bits: u32,
}

/// The hits of one material, in the order of the rays.
#[derive(Debug, Default)]
pub struct Bucket {
    /// Lanes that stay in their packet.
    pub in_place: Vec<PacketLanes>,
    /// Rays that are compacted, eight to a packet.
    pub compacted: Vec<RayIndex>,
}

impl Bucket {
    fn is_empty(&self) -> bool {
        self.in_place.is_empty() && self.compacted.is_empty()
    }

    /// Returns the number of surface packets that [`gather`](super::surface::gather) makes of the bucket.
    fn packet_count(&self) -> usize {
        self.in_place.len() + self.compacted.len().div_ceil(LANES)
    }
}

/// Hits sorted by material.
#[derive(Debug, Default)]
pub struct HitQueue {
    /// By material id.
    buckets: Vec<Bucket>,
    /// Materials with hits: first those that need light; ascending ids within each group.
    used: Vec<MaterialId>,
}

fn needs_light(material: &Material) -> bool {
    !matches!(material, Material::Silhouette { .. } | Material::Glass { .. })
}

impl HitQueue {
    /// Reserves memory for the hits of `pixels` pixels.
    pub fn reserve(&mut self, materials: usize, pixels: usize) {
        self.used.reserve(materials.min(pixels));
        self.buckets.resize_with(materials, Bucket::default);
        for bucket in self.buckets.iter_mut().take(EAGER_MATERIALS) {
            bucket.in_place.reserve(pixels / MIN_LANES_IN_PLACE as usize);
            bucket.compacted.reserve(pixels);
        }
    }

    fn reset(&mut self, materials: usize) {
        self.buckets
            .resize_with(materials.max(self.buckets.len()), Bucket::default);
        for material in self.used.drain(..) {
            let bucket = &mut self.buckets[material.0 as usize];
            bucket.in_place.clear();
            bucket.compacted.clear();
        }
    }

    /// Adds the lanes of `bits`, which hit `material`.
    #[inline(always)]
    fn push(&mut self, material: MaterialId, packet: u32, bits: u32) {
        let bucket = &mut self.buckets[material.0 as usize];
        if bucket.is_empty() {
            self.used.push(material);
        }
        if bits.count_ones() >= MIN_LANES_IN_PLACE {
            bucket.in_place.push(PacketLanes { packet, bits });
        } else {
            let lanes = (0..LANES as u32).filter(|lane| bits >> lane & 1 == 1);
            bucket
                .compacted
                .extend(lanes.map(|lane| packet * LANES as u32 + lane));
        }
    }

    /// Returns the materials that were hit, with their hits.
    pub fn buckets(&self) -> impl Iterator<Item = (MaterialId, &Bucket)> {
        self.used.iter().map(|&m| (m, &self.buckets[m.0 as usize]))
    }

    /// Returns the materials that were hit, with the range of their surface packets in the result of
    /// `surface::gather`.
    pub fn ranges(&self) -> impl Iterator<Item = (MaterialId, Range<usize>)> {
        let mut start = 0;
        self.buckets().map(move |(material, bucket)| {
            let range = start..start + bucket.packet_count();
            start = range.end;
            (material, range)
        })
    }

    /// Visits the rays of each surface packet, in the order of [`gather`](super::surface::gather); lanes without one repeat
    /// another.
    #[inline(always)]
    pub fn for_each_packet(&self, mut visit: impl FnMut(&[RayIndex; LANES])) {
        for (_, bucket) in self.buckets() {
            for &PacketLanes { packet, bits } in &bucket.in_place {
                let (base, first) = (packet * LANES as u32, bits.trailing_zeros());
                visit(&std::array::from_fn(|lane| {
                    let is_active = bits >> lane & 1 == 1;
                    base + if is_active { lane as u32 } else { first }
                }));
            }
            for chunk in bucket.compacted.chunks(LANES) {
                visit(&std::array::from_fn(|lane| chunk[lane.min(chunk.len() - 1)]));
            }
        }
    }

    /// Returns the surface packets whose colour depends on light: the first ones.
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

/// Adds the background to the colour that a ray adds to, lane `lane` of packet `p`.
#[inline(always)]
pub(super) fn add_background<S: Simd>(
    simd: S,
    scene: &Scene,
    rays: &RayQueue,
    (p, lane): (usize, usize),
    colors: &mut TileColors,
) {
    let background = background(simd, scene, &rays.rays.packets()[p].direction);
    let weight = simd.load(&rays.weight(p));
    colors.add(simd, 1 << lane, &rays.pixel(p), weight, background);
}

/// Sorts the hits of `rays` by material. Misses take the background, or nothing if `transparent` and straight from the
/// camera: rays that [set colours](RayQueue::sets_colors) set those of the tile, others add to them, but not `again`.
#[inline(always)]
pub(super) fn sort<S: Simd>(
    simd: S,
    scene: &Scene,
    rays: &RayQueue,
    hits: &[HitPacket],
    (transparent, again): (bool, bool),
    by_material: &mut HitQueue,
    colors: &mut TileColors,
) {
    by_material.reset(scene.materials().len());
    let sets_colors = rays.sets_colors();
    for (packet_i, packet) in rays.rays.packets().iter().enumerate() {
        let hits = &hits[packet_i];
        let active = simd.load(&packet.t_max).gt(simd.splat(0.0)).bits();
        let none = S::V8::equal_lanes(simd, &hits.primitive, PrimitiveId::NONE.0);
        let missed = active & none;
        let visible = if transparent {
            missed & !rays.straight(packet_i)
        } else {
            missed
        };
        if sets_colors {
            let background = if visible == 0 {
                [simd.splat(0.0); 3]
            } else {
                background(simd, scene, &packet.direction)
            };
            colors.set(simd, packet_i, visible, background);
        } else if visible != 0 && !again {
            let background = background(simd, scene, &packet.direction);
            let weight = simd.load(&rays.weight(packet_i));
            colors.add(simd, visible, &rays.pixel(packet_i), weight, background);
        }
        // One iteration per primitive instead of per lane: most packets hit few primitives.
        let mut remaining = active & !none;
        let (mut last_material, mut last_bits) = (MaterialId::default(), 0);
        while remaining != 0 {
            let id = hits.primitive[remaining.trailing_zeros() as usize];
            let bits = remaining & S::V8::equal_lanes(simd, &hits.primitive, id);
            remaining &= !bits;
            let material = scene.material_of(PrimitiveId(id));
            if last_bits != 0 && material != last_material {
                by_material.push(last_material, packet_i as u32, last_bits);
                last_bits = 0;
            }
            (last_material, last_bits) = (material, last_bits | bits);
        }
        if last_bits != 0 {
            by_material.push(last_material, packet_i as u32, last_bits);
        }
    }
    by_material
        .used
        .sort_unstable_by_key(|m| (!needs_light(&scene.materials()[m.0 as usize]), *m));
}
