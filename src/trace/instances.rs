//! Instances: rays that meet the box of one are traced, as their images in its prototype's space, through the prototype's
//! hierarchy. Scenes without instances never come here.
//!
//! An instance is hit only within its padded box, where both planes and hits are computed as for primitives: so whatever is
//! culled holds no hit, and all ways of tracing find the same ones.

mod groups;

use super::{
    Method, Tracer,
    bits::bits,
    cut_outs::{Any, Closest, ray},
    run::invalid,
    single::SingleRay,
    visit,
};
use crate::{
    accel::{Bvh, Instanced, Node8},
    lanes::LANES,
    ray::{Hit, HitPacket, InstanceId, Origins, Ray, RayPacket, SceneHit, T_MAX},
    scene::{ImageRay, Scene},
    simd::{EightLanes, LaneMask, Lanes, Level, Simd, Vec3Lanes, unpack},
};
use glam::Vec3;

/// A child of a node: the node's index times eight, and its place there.
type Slot = u32;

/// What tracing needs of a scene with instances.
#[derive(Debug)]
pub(super) struct Instances<'a> {
    scene: &'a Scene,
    instanced: &'a Instanced,
    method: Method,
    /// Children that the current ray has yet to visit, and where it enters them.
    stack: Vec<(f32, Slot)>,
    /// The instances that the last call's closest hits are in.
    found: Vec<[u32; LANES]>,
    group: groups::Group,
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
    /// The distance in the scene of a hit of the image.
    #[inline(always)]
    fn distance(&self, t: f32) -> f32 {
        self.image.in_scene(t).max(self.near).min(self.far)
    }

    /// More than any t of the image whose distance is `t_max` or less.
    #[inline(always)]
    fn beyond(&self, t_max: f32) -> f32 {
        if self.far <= t_max {
            T_MAX
        } else {
            self.image.beyond(t_max)
        }
    }

    /// The t of the image whose distance, and that of all that is farther, is `t_max` or more; 0 if all are.
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
    /// Closest hits, and the instances that they are in.
    Closest(&'r mut [HitPacket], &'r mut [[u32; LANES]]),
    /// Occlusion: a bit a lane.
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

    /// Where a ray ends: at `t_max` or at its hit.
    fn end(&self, (packet, lane): (usize, usize), t_max: f32) -> f32 {
        match self {
            Self::Closest(hits, _) => hits[packet].t.as_array()[lane],
            Self::Any(_) => t_max,
        }
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

    /// Notes that a ray is blocked: it is done.
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
            stack: Vec::new(),
            found: Vec::new(),
            group: groups::Group::default(),
            nested: nested.through_cut_outs(scene),
        }))
    }

    /// Holds to a level.
    pub fn hold_to(&mut self, level: Level) {
        self.nested.hold_to(level);
    }

    /// Replaces hits that are behind an instance.
    #[inline(always)]
    pub fn closest<S: Simd>(
        &mut self,
        simd: S,
        level: Level,
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
            self.trace(simd, level, origins, rays, &mut Results::Closest(hits, found));
        }
        self.found = found;
    }

    /// Blocks the rays that hit an instance before their end.
    #[inline(always)]
    pub fn occluded<S: Simd>(
        &mut self,
        simd: S,
        level: Level,
        origins: Origins<'_>,
        rays: &[RayPacket],
        occluded: &mut [u8],
    ) {
        let chunks = rays
            .chunks(groups::PACKETS)
            .zip(occluded.chunks_mut(groups::PACKETS));
        for (i, (rays, occluded)) in chunks.enumerate() {
            let origins = part_of(origins, i * groups::PACKETS, rays.len());
            self.trace(simd, level, origins, rays, &mut Results::Any(occluded));
        }
    }

    /// Traces a group of rays together, if that is possible, or else ray by ray.
    #[inline(always)]
    fn trace<S: Simd>(
        &mut self,
        simd: S,
        level: Level,
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
        for (p, packet) in rays.iter().enumerate() {
            let live = simd.load(&packet.t_max).gt(simd.splat(0.0)).bits();
            for lane in bits(live & !results.done(p)) {
                let ray = ray(origins, rays, p, lane);
                if ray.is_valid() {
                    self.trace_ray(simd, level, &ray, (p, lane), results);
                }
            }
        }
    }

    #[inline(always)]
    fn trace_ray<S: Simd>(
        &mut self,
        simd: S,
        level: Level,
        ray: &Ray,
        at: (usize, usize),
        results: &mut Results<'_>,
    ) {
        let single = SingleRay::of(ray);
        let mut end = results.end(at, ray.t_max);
        self.stack.clear();
        self.push_children(simd, &single, 0, end);
        while let Some((near, slot)) = self.stack.pop() {
            if near > end {
                continue;
            }
            if let Some(met) = self.visit_slot(simd, ray, &single, slot, end) {
                self.trace_in(level, &met, at, &mut end, results);
                if end < 0.0 {
                    return;
                }
            }
        }
    }

    /// Traces one ray through an instance. `end` becomes its new end, negative if it is done.
    #[inline(always)]
    fn trace_in(
        &self,
        level: Level,
        met: &Met,
        at: (usize, usize),
        end: &mut f32,
        results: &mut Results<'_>,
    ) {
        let bvh = self.prototype_of(met.id);
        let scene = self.scene;
        match results {
            Results::Closest(..) => {
                let best = Hit::miss(met.beyond(*end));
                let mut closest = Closest { scene, best };
                visit(level, bvh, &met.image.ray, &mut closest);
                results.offer(at, met, &closest.best, end);
            }
            Results::Any(_) => {
                let mut any = Any {
                    scene,
                    end: met.end(*end),
                    is_hit: false,
                };
                visit(level, bvh, &met.image.ray, &mut any);
                if any.is_hit {
                    results.block(at, end);
                }
            }
        }
    }

    /// Notes that the closest hits of these lanes of a packet are outside of any instance after all.
    pub fn forget(&mut self, packet: usize, lanes: u32) {
        for lane in bits(lanes) {
            self.found[packet][lane] = InstanceId::NONE.0;
        }
    }

    /// Puts the children of a node that a ray enters on the stack, the nearest last.
    #[inline(always)]
    fn push_children<S: Simd>(&mut self, simd: S, ray: &SingleRay, node_i: usize, end: f32) {
        let node = &self.instanced.nodes()[node_i];
        let (entered, near) = ray.enter(simd, node, end);
        let (entries, count) = near.nearest_last(entered);
        for &entry in entries.iter().take(count) {
            let (near, lane) = unpack(entry);
            self.stack.push((near, (node_i * LANES + lane) as Slot));
        }
    }

    /// Descends into a child, or returns the instance that it is, if the ray meets that.
    #[inline(always)]
    fn visit_slot<S: Simd>(
        &mut self,
        simd: S,
        ray: &Ray,
        single: &SingleRay,
        slot: Slot,
        end: f32,
    ) -> Option<Met> {
        let (node_i, lane) = (slot as usize / LANES, slot as usize % LANES);
        let node = &self.instanced.nodes()[node_i];
        let child = node.child[lane];
        if child.is_inner() {
            self.push_children(simd, single, child.index(), end);
            return None;
        }
        let [near, far] = interval(simd, single, node, lane);
        let id = InstanceId(child.index() as u32);
        let image = (near <= far).then(|| self.scene.instances()[child.index()].image(ray))??;
        Some(Met { id, image, near, far })
    }

    #[inline(always)]
    fn prototype_of(&self, id: InstanceId) -> &'a Bvh {
        let instance = &self.scene.instances()[id.0 as usize];
        self.instanced.prototype(instance.prototype())
    }
}

/// Where a ray is in the box of a node's child, as for the box of a primitive.
#[inline(always)]
fn interval<S: Simd>(simd: S, ray: &SingleRay, node: &Node8, lane: usize) -> [f32; 2] {
    let [lx, ly, lz, ux, uy, uz] = &node.planes;
    let (lower, upper) = (
        Vec3Lanes::new(simd.load(lx), simd.load(ly), simd.load(lz)),
        Vec3Lanes::new(simd.load(ux), simd.load(uy), simd.load(uz)),
    );
    let (near, far) = ray.slabs(simd).interval(lower, upper);
    [near.lane(lane), far.lane(lane)]
}

impl<'a> Tracer<'a> {
    /// Traces through another hierarchy from now on, not a deeper one than the first.
    fn through(&mut self, bvh: &'a Bvh) {
        self.bvh = bvh;
    }

    /// Lets rays hit the instances of `scene`, too, which the BVH was built from.
    #[must_use]
    pub fn with_instances(mut self, scene: &'a Scene) -> Self {
        let level = self.level;
        self.instances = Instances::of(scene, self.bvh.instanced(), self.policy.method());
        if let Some(instances) = &mut self.instances {
            instances.hold_to(level);
        }
        self
    }

    /// Lets rays hit all of `scene`, which the BVH was built from: planes and instances, too, but not what is cut out.
    #[must_use]
    pub fn of_scene(self, scene: &'a Scene) -> Self {
        self.through_cut_outs(scene)
            .with_instances(scene)
            .with_planes(scene)
    }

    /// Returns the instances that the closest hits of the last call are in, raw values of [`InstanceId`]; nothing if the scene
    /// has none.
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
