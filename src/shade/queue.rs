//! Queues: rays on their way, and hits filed by material.

use super::{TileColors, surface::SurfacePacket};
use crate::{
    ray::{HitPacket, PrimitiveId, RayPacket},
    scene::{Material, MaterialId, Scene},
    simd::{F32x8, LANES, gt, splat},
};
use std::ops::Range;

/// Rays to trace: for each packet the pixels (indices within the tile) and weights of its lanes.
#[derive(Debug, Default)]
pub struct RayQueue {
    /// The rays; lanes without one have `t_max` 0.
    pub packets: Vec<RayPacket>,
    /// Pixels within the tile.
    pub pixel: Vec<[u32; LANES]>,
    /// What a ray's colour counts.
    pub weight: Vec<F32x8>,
}

impl RayQueue {
    /// Forgets all rays.
    pub fn clear(&mut self) {
        self.packets.clear();
        self.pixel.clear();
        self.weight.clear();
    }

    /// Adds eight rays.
    #[inline(always)]
    pub fn push(&mut self, rays: RayPacket, pixel: [u32; LANES], weight: F32x8) {
        self.packets.push(rays);
        self.pixel.push(pixel);
        self.weight.push(weight);
    }

    /// How many lanes hold a ray.
    #[must_use]
    pub fn active_rays(&self) -> u64 {
        self.packets
            .iter()
            .map(|p| u64::from(gt(p.t_max, splat(0.0)).bits().count_ones()))
            .sum()
    }
}

/// The place of a ray in its queue: packet x 8 + lane.
pub type RayIndex = u32;

/// Hits filed by material, in the order of the rays.
#[derive(Debug, Default)]
pub struct HitQueue {
    /// By material id.
    buckets: Vec<Vec<RayIndex>>,
    /// Materials with hits: those that need light first, then the others; ascending within each.
    used: Vec<MaterialId>,
}

/// Whether a material's colour depends on light.
fn needs_light(material: &Material) -> bool {
    !matches!(material, Material::Silhouette { .. })
}

impl HitQueue {
    fn reset(&mut self, materials: usize) {
        self.buckets
            .resize_with(materials.max(self.buckets.len()), Vec::new);
        for material in self.used.drain(..) {
            self.buckets[material.0 as usize].clear();
        }
    }

    /// Materials that were hit, and the rays that did.
    pub fn buckets(&self) -> impl Iterator<Item = (MaterialId, &[RayIndex])> {
        self.used.iter().map(|&m| (m, &self.buckets[m.0 as usize][..]))
    }

    /// Materials that were hit, and the range of surface packets that [`gather`](super::surface::gather)
    /// made of each.
    pub fn ranges(&self) -> impl Iterator<Item = (MaterialId, Range<usize>)> {
        let mut start = 0;
        self.buckets().map(move |(material, rays)| {
            let range = start..start + rays.len().div_ceil(LANES);
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

/// Files the hits of `rays` by material; misses take the background at once.
pub fn sort(
    scene: &Scene,
    rays: &RayQueue,
    hits: &[HitPacket],
    by_material: &mut HitQueue,
    colors: &mut TileColors,
) {
    by_material.reset(scene.materials().len());
    let background = scene.background().map(splat);
    for (packet_i, (packet, hits)) in rays.packets.iter().zip(hits).enumerate() {
        let active = gt(packet.t_max, splat(0.0)).bits();
        let mut missed = 0;
        for (lane, &id) in hits.primitive.iter().enumerate() {
            if active >> lane & 1 == 0 {
                continue;
            }
            if id == PrimitiveId::NONE.0 {
                missed |= 1 << lane;
                continue;
            }
            let material = scene.material_of(PrimitiveId(id));
            let bucket = &mut by_material.buckets[material.0 as usize];
            if bucket.is_empty() {
                by_material.used.push(material);
            }
            bucket.push((packet_i * LANES + lane) as RayIndex);
        }
        if missed != 0 {
            colors.add(missed, &rays.pixel[packet_i], rays.weight[packet_i], background);
        }
    }
    by_material
        .used
        .sort_unstable_by_key(|m| (!needs_light(&scene.materials()[m.0 as usize]), *m));
}
