//! The hits of a queue of rays, sorted by material, and the surfaces there.

use super::{
    SURFACE_OFFSET, TileColors,
    queue::{self, HitQueue, RayIndex, RayQueue},
    surface::{self, SurfacePacket},
    texture::{self, Textured},
    tint::{self, Tint8},
};
use crate::{
    lanes::{F32x8, LANES},
    math::{Aabb, max},
    ray::{Hit, HitPacket, InstanceId, PrimitiveId, Ray, RayPackets},
    scene::{RayCone, Scene, SceneHit, skipped},
    simd::{Level, Simd, at_level},
    trace::Tracer,
};
use glam::Vec3;
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
    skipped: Skipped,
    /// Whether the rays pass the backs of one-sided surfaces: those towards lights do not.
    pub passes_backs: bool,
}

/// The short rays of [`skipped`], and the rays that skip them.
#[derive(Debug, Default)]
struct Skipped {
    rays: Vec<Ray>,
    by: Vec<RayIndex>,
    packets: RayPackets,
    hits: Vec<HitPacket>,
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

    /// Returns the hit of lane `lane` of packet `p`.
    pub fn hit(&self, p: usize, lane: usize) -> SceneHit {
        SceneHit {
            hit: self.hits[p].hit(lane),
            instance: self
                .instances
                .get(p)
                .map_or(InstanceId::NONE, |instances| InstanceId(instances[lane])),
        }
    }

    /// Sorts the hits by material and gathers their surfaces; see [`queue::sort`] for `transparent` and `colors`. `cone` is
    /// that of the rays. Opaque surfaces replace others in the same place.
    pub fn gather(
        &mut self,
        scene: &Scene,
        (tracer, cone): (&mut Tracer<'_>, RayCone),
        (rays, transparent): (&RayQueue, bool),
        colors: &mut TileColors,
    ) {
        let level = tracer.level();
        self.gather_surfaces(scene, level, (rays, transparent, false), colors);
        let passes_backs = self.passes_backs && scene.has_one_sided();
        if passes_backs && self.pass_backs(scene, tracer, rays, colors) {
            self.gather_surfaces(scene, level, (rays, transparent, true), colors);
        }
        if scene.dims_light() {
            debug_assert!(rays.sets_colors(), "misses set their colours again");
            at_level!(level, |simd| self.skip(simd, scene, tracer, rays));
            tracer.passing_backs(passes_backs);
            let is_any = self.put_opaque_first(tracer);
            tracer.passing_backs(false);
            if is_any {
                self.gather_surfaces(scene, level, (rays, transparent, true), colors);
            }
        }
        let hits = &self.hits[..rays.rays.packets().len()];
        let (sorted, surfaces) = (&self.by_material, &mut self.surfaces[..]);
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

    fn gather_surfaces(
        &mut self,
        scene: &Scene,
        level: Level,
        (rays, transparent, again): (&RayQueue, bool, bool),
        colors: &mut TileColors,
    ) {
        let hits = &self.hits[..rays.rays.packets().len()];
        let (sorted, surfaces) = (&mut self.by_material, &mut self.surfaces);
        at_level!(level, |simd| {
            queue::sort(simd, scene, rays, hits, (transparent, again), sorted, colors);
            surface::gather(simd, scene, rays, hits, sorted, surfaces);
            if !self.instances.is_empty() {
                surface::place(simd, scene, (rays, hits), &self.instances, sorted, surfaces);
            }
        });
    }

    /// Replaces hits on the backs of one-sided surfaces with hits behind them, one ray at a time. Returns whether there were any.
    fn pass_backs(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        rays: &RayQueue,
        colors: &mut TileColors,
    ) -> bool {
        let level = tracer.level();
        let (mut surfaces, mut is_any) = (self.surfaces.iter(), false);
        let (hits, instances) = (&mut self.hits, &mut self.instances);
        self.by_material.for_each_packet(|ray_i| {
            let behind = surfaces.next().map_or(0, |s| s.active & s.from_behind);
            for lane in (0..LANES).filter(|lane| behind >> lane & 1 == 1) {
                let (p, from) = (ray_i[lane] as usize / LANES, ray_i[lane] as usize % LANES);
                if !scene.is_one_sided(PrimitiveId(hits[p].primitive[from])) {
                    continue;
                }
                let found = tracer.visible_hit(&rays.rays.ray(p, from));
                hits[p].set_hit(from, &found.hit);
                if let Some(instances) = instances.get_mut(p) {
                    instances[from] = found.instance.0;
                }
                if !found.is_hit() && !rays.sets_colors() {
                    at_level!(level, |simd| queue::add_background(
                        simd,
                        scene,
                        rays,
                        (p, from),
                        colors
                    ));
                }
                is_any = true;
            }
        });
        is_any
    }

    /// Collects the short rays of hits on surfaces that are not opaque, if anything opaque is near.
    // Cost: docs/lab-notes.md#opaque-first
    #[inline(always)]
    fn skip<S: Simd>(&mut self, simd: S, scene: &Scene, tracer: &Tracer<'_>, rays: &RayQueue) {
        let Skipped { rays: short, by, .. } = &mut self.skipped;
        short.clear();
        by.clear();
        for (id, range) in self.by_material.ranges() {
            if !scene.passes_light(id) {
                continue;
            }
            for s in &self.surfaces[range] {
                if !tracer.may_meet_opaque(simd, scene, &around(s), only_primitive(&self.hits, s)) {
                    continue;
                }
                for lane in (0..LANES).filter(|lane| s.active >> lane & 1 == 1) {
                    let (p, from) = (s.pixel[lane] as usize / LANES, s.pixel[lane] as usize % LANES);
                    let hit = self.hits[p].hit(from);
                    if scene.is_opaque(hit.primitive, [hit.u, hit.v]) {
                        continue;
                    }
                    let at = (s.point.lane(lane), s.geometric_normal.lane(lane));
                    let offset = s.magnitude.as_array()[lane] * SURFACE_OFFSET;
                    if let Some(ray) = skipped(simd, &rays.rays.ray(p, from), hit.t, at, offset) {
                        short.push(ray);
                        by.push(s.pixel[lane]);
                    }
                }
            }
        }
    }

    /// Replaces hits by opaque surfaces that the short rays hit. Returns whether there are any.
    fn put_opaque_first(&mut self, tracer: &mut Tracer<'_>) -> bool {
        let Skipped {
            rays,
            by,
            packets,
            hits,
        } = &mut self.skipped;
        if rays.is_empty() {
            return false;
        }
        packets.restart(None);
        for eight in rays.chunks(LANES) {
            packets.push_rays(&std::array::from_fn(|lane| {
                eight.get(lane).copied().unwrap_or(Ray {
                    t_max: 0.0,
                    ..eight[0]
                })
            }));
        }
        hits.resize(packets.packets().len(), HitPacket::miss(F32x8::ZERO));
        tracer.opaque_hit(packets.origins(), packets.packets(), hits);
        let mut is_any = false;
        for (i, &by) in by.iter().enumerate() {
            let found = tracer.scene_hit(hits, i / LANES, i % LANES);
            let (p, lane) = (by as usize / LANES, by as usize % LANES);
            let Hit { t, primitive, .. } = self.hits[p].hit(lane);
            if !found.is_hit() || found.primitive == primitive {
                continue;
            }
            self.hits[p].set_hit(lane, &Hit { t, ..found.hit });
            if let Some(instances) = self.instances.get_mut(p) {
                instances[lane] = found.instance.0;
            }
            is_any = true;
        }
        is_any
    }
}

/// A box around the short rays of a packet, with one offset to spare on each side.
fn around(s: &SurfacePacket) -> Aabb {
    let largest = s.magnitude.as_array().iter().fold(0.0, |a, &b| max(a, b));
    let reach = Vec3::splat(4.0 * SURFACE_OFFSET * largest);
    let points = Aabb::around((0..LANES).map(|lane| s.point.lane(lane)));
    Aabb {
        lower: points.lower - reach,
        upper: points.upper + reach,
    }
}

/// Returns the primitive that all rays of a packet hit, if it is one.
fn only_primitive(hits: &[HitPacket], s: &SurfacePacket) -> Option<PrimitiveId> {
    let id = |lane: usize| {
        let i = s.pixel[lane] as usize;
        PrimitiveId(hits[i / LANES].primitive[i % LANES])
    };
    let first = id(s.active.trailing_zeros() as usize);
    let mut active = (0..LANES).filter(|lane| s.active >> lane & 1 == 1);
    active.all(|lane| id(lane) == first).then_some(first)
}
