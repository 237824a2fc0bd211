//! Instances: a ray that meets an instance's box is transformed into the prototype's space (its image) and traced through
//! the prototype's BVH. Scenes without instances never run this.
//!
//! An instance is hit only within its padded box, whose planes are computed as for primitives: so culled boxes hold no hit,
//! and all tracing methods find the same hits.

mod groups;
mod images;
mod visit;
mod waves;

pub(crate) use visit::{FoundThere, InstanceSink, visit_instances};

use super::{Method, Tracer, bits::bits, run::invalid};
use crate::{
    accel::{Bvh, Instanced},
    lanes::LANES,
    ray::{Hit, HitPacket, InstanceId, Origins, RayPacket, SceneHit, T_MAX},
    scene::{ImageRay, Scene},
    simd::{LaneMask, Lanes, Level, Simd},
};
use glam::Vec3;

/// A child of a node: the node's index times eight, plus the child's index.
type Slot = u32;

/// What tracing needs of a scene with instances.
#[derive(Debug)]
pub(super) struct Instances<'a> {
    scene: &'a Scene,
    instanced: &'a Instanced,
    method: Method,
    /// The instances that the last call's closest hits are in.
    found: Vec<[u32; LANES]>,
    group: groups::Group,
    waves: waves::Waves,
    images: images::Images,
    /// Traces many rays through a prototype.
    nested: Tracer<'a>,
}

/// An instance that a ray meets: its image, and where the ray is in the instance's box.
#[derive(Clone, Copy, Debug)]
struct Met {
    id: InstanceId,
    image: ImageRay,
    near: f32,
    far: f32,
}

impl Met {
    /// The scene's distance of a hit of the image.
    #[inline(always)]
    fn distance(&self, t: f32) -> f32 {
        self.image.in_scene(t).max(self.near).min(self.far)
    }

    /// A t of the image above all those whose distance is `t_max` or less.
    #[inline(always)]
    fn beyond(&self, t_max: f32) -> f32 {
        if self.far <= t_max {
            T_MAX
        } else {
            self.image.beyond(t_max)
        }
    }

    /// The t of the image from which on all distances are `t_max` or more; 0 if all are.
    #[inline(always)]
    fn end(&self, t_max: f32) -> f32 {
        if self.near >= t_max || self.far <= 0.0 {
            0.0
        } else if self.far < t_max {
            T_MAX
        } else {
            self.image.end(t_max)
        }
    }
}

/// Where the results of a group go.
enum Results<'r> {
    /// Closest hits and their instances.
    Closest(&'r mut [HitPacket], &'r mut [[u32; LANES]]),
    /// Occlusion: a bit per lane.
    Any(&'r mut [u8]),
}

impl Results<'_> {
    /// The lanes of a packet that need not be traced.
    fn done(&self, packet: usize) -> u32 {
        match self {
            Self::Closest(..) => 0,
            Self::Any(occluded) => u32::from(occluded[packet]),
        }
    }

    /// The ends of rays that may still hit something; negative for others.
    #[inline(always)]
    fn ends<S: Simd>(&self, simd: S, p: usize, rays: &RayPacket) -> S::V8 {
        let end = simd.load(&rays.t_max);
        let live = end.gt(simd.splat(0.0)).bits() & !self.done(p);
        let end = match self {
            Self::Closest(hits, _) => simd.load(&hits[p].t),
            Self::Any(_) => end,
        };
        S::V8::select(simd.mask(live), end, simd.splat(-1.0))
    }

    /// Replaces the closest hit of a ray by one in an instance, if that is nearer; `end` is then where that is.
    #[inline(always)]
    fn offer(&mut self, (packet, lane): (usize, usize), met: &Met, hit: &Hit, end: &mut f32) {
        let Self::Closest(hits, found) = self else { return };
        if !hit.is_hit() {
            return;
        }
        let (t, best) = (met.distance(hit.t), hits[packet].t.as_array()[lane]);
        let instance = &mut found[packet][lane];
        let wins_tie = *instance != InstanceId::NONE.0 && met.id.0 < *instance;
        if t > 0.0 && (t < best || t == best && wins_tie) {
            hits[packet].set_hit(lane, &Hit { t, ..*hit });
            *instance = met.id.0;
            *end = t;
        }
    }

    /// Marks a ray as blocked.
    #[inline(always)]
    fn block(&mut self, (packet, lane): (usize, usize), end: &mut f32) {
        if let Self::Any(occluded) = self {
            occluded[packet] |= 1 << lane;
            *end = -1.0;
        }
    }
}

/// The origins of `count` packets from `start` on.
fn part_of(origins: Origins<'_>, start: usize, count: usize) -> Origins<'_> {
    match origins {
        Origins::Shared(_) => origins,
        Origins::Separate(origins) => Origins::Separate(&origins[start..start + count]),
    }
}

/// Whether all rays from `origin` are valid.
#[inline(always)]
fn are_valid<S: Simd>(simd: S, origin: Vec3, rays: &[RayPacket]) -> bool {
    // A loop, because closures do not inherit the instruction set.
    let mut any = simd.mask(0);
    for packet in rays {
        any = any | invalid(simd, packet);
    }
    origin.is_finite() && !any.any()
}

impl<'a> Instances<'a> {
    /// `None` if the scene has none.
    pub fn of(scene: &'a Scene, instanced: Option<&'a Instanced>, method: Method) -> Option<Box<Self>> {
        let instanced = instanced?;
        let nested = Tracer::with_method(instanced.deepest()?, method);
        Some(Box::new(Self {
            scene,
            instanced,
            method,
            found: Vec::new(),
            group: groups::Group::default(),
            waves: waves::Waves::default(),
            images: images::Images::default(),
            nested: nested.pass_cut_outs(scene),
        }))
    }

    /// Uses a level from now on.
    pub fn hold_to(&mut self, level: Level) {
        self.nested.hold_to(level);
    }

    /// See [`Tracer::stopping_where_dimmed`].
    pub fn stop_where_dimmed(&mut self, stops: bool) {
        self.nested.stopping_where_dimmed(stops);
    }

    /// See [`Tracer::opaque_hit`].
    pub fn stop_only_where_opaque(&mut self, stops: bool) {
        self.nested.stopping_only_where_opaque(stops);
    }

    /// See [`Tracer::passing_backs`].
    pub fn pass_backs(&mut self, passes: bool) {
        self.nested.passing_backs(passes);
    }

    /// The instances of the last call's closest hits.
    pub fn found_mut(&mut self) -> &mut Vec<[u32; LANES]> {
        &mut self.found
    }

    /// Replaces hits that are behind an instance.
    #[inline(always)]
    pub fn closest<S: Simd>(
        &mut self,
        simd: S,
        origins: Origins<'_>,
        rays: &[RayPacket],
        hits: &mut [HitPacket],
    ) {
        let mut found = std::mem::take(&mut self.found);
        found.clear();
        found.resize(rays.len(), [InstanceId::NONE.0; LANES]);
        let chunks = rays.chunks(groups::PACKETS).zip(hits.chunks_mut(groups::PACKETS));
        for (i, ((rays, hits), found)) in chunks.zip(found.chunks_mut(groups::PACKETS)).enumerate() {
            let origins = part_of(origins, i * groups::PACKETS, rays.len());
            self.trace(simd, origins, rays, &mut Results::Closest(hits, found));
        }
        self.found = found;
    }

    /// Blocks the rays that hit an instance before their end.
    #[inline(always)]
    pub fn occluded<S: Simd>(
        &mut self,
        simd: S,
        origins: Origins<'_>,
        rays: &[RayPacket],
        occluded: &mut [u8],
    ) {
        let chunks = rays
            .chunks(groups::PACKETS)
            .zip(occluded.chunks_mut(groups::PACKETS));
        for (i, (rays, occluded)) in chunks.enumerate() {
            let origins = part_of(origins, i * groups::PACKETS, rays.len());
            self.trace(simd, origins, rays, &mut Results::Any(occluded));
        }
    }

    /// Traces a group of rays together, if they share their origin and stay together, else in waves.
    #[inline(always)]
    fn trace<S: Simd>(
        &mut self,
        simd: S,
        origins: Origins<'_>,
        rays: &[RayPacket],
        results: &mut Results<'_>,
    ) {
        if let Origins::Shared(origin) = origins
            && are_valid(simd, origin, rays)
            && self.trace_group(simd, origin, rays, results)
        {
            return;
        }
        self.trace_in_waves(simd, origins, rays, results);
    }

    /// Clears the instances of these lanes' closest hits.
    pub fn forget(&mut self, packet: usize, lanes: u32) {
        for lane in bits(lanes) {
            self.found[packet][lane] = InstanceId::NONE.0;
        }
    }

    #[inline(always)]
    fn prototype_of(&self, id: InstanceId) -> &'a Bvh {
        let instance = &self.scene.instances()[id.0 as usize];
        self.instanced.prototype(instance.prototype())
    }
}

impl<'a> Tracer<'a> {
    /// Traces through another BVH from now on, which is no deeper than the first.
    fn through(&mut self, bvh: &'a Bvh) {
        self.bvh = bvh;
    }

    /// Lets rays hit the instances of `scene`, too, which the BVH was built from.
    ///
    /// # Panics
    /// If the BVH was built from another scene.
    #[must_use]
    pub fn with_instances(mut self, scene: &'a Scene) -> Self {
        self = self.check(scene);
        let level = self.level;
        self.instances = Instances::of(scene, self.bvh.instanced(), self.policy.method());
        if let Some(instances) = &mut self.instances {
            instances.hold_to(level);
        }
        self
    }

    /// Lets rays hit all of `scene`, which the BVH was built from, with planes, instances and cut-outs.
    ///
    /// # Panics
    /// If the BVH was built from another scene.
    #[must_use]
    pub fn of_scene(self, scene: &'a Scene) -> Self {
        self.through_cut_outs(scene)
            .with_instances(scene)
            .with_planes(scene)
    }

    /// Returns the instances of the last call's closest hits, raw values of [`InstanceId`]; empty if the scene has none.
    #[must_use]
    pub fn instances_hit(&self) -> &[[u32; LANES]] {
        self.instances.as_ref().map_or(&[], |instances| &instances.found)
    }

    /// Returns a hit of the last call, whose results are `hits`, with its instance.
    #[must_use]
    pub fn scene_hit(&self, hits: &[HitPacket], packet: usize, lane: usize) -> SceneHit {
        let instance = self
            .instances_hit()
            .get(packet)
            .map_or(InstanceId::NONE.0, |of| of[lane]);
        SceneHit {
            hit: hits[packet].hit(lane),
            instance: InstanceId(instance),
        }
    }
}
