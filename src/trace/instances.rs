//! Instances: rays that meet the box of one are traced, as their images in its prototype's space, through the prototype's
//! hierarchy. Scenes without instances never come here.
//!
//! An instance is hit only within its padded box, where both planes and hits are computed as for primitives: so whatever is
//! culled holds no hit, and all ways of tracing find the same ones.

use super::{
    Tracer,
    bits::bits,
    cut_outs::{Any, Closest, ray},
    single::SingleRay,
    visit,
};
use crate::{
    accel::{Instanced, Node8},
    lanes::LANES,
    ray::{Hit, HitPacket, InstanceId, Origins, Ray, RayPacket, SceneHit, T_MAX},
    scene::{ImageRay, Scene},
    simd::{EightLanes, LaneMask, Lanes, Level, Simd, Vec3Lanes, unpack},
};

/// A child of a node: the node's index times eight, and its place there.
type Slot = u32;

/// What tracing needs of a scene with instances.
#[derive(Debug)]
pub(super) struct Instances<'a> {
    scene: &'a Scene,
    instanced: &'a Instanced,
    /// Children that the current ray has yet to visit, and where it enters them.
    stack: Vec<(f32, Slot)>,
    /// The instances that the last call's closest hits are in.
    found: Vec<[u32; LANES]>,
}

/// An instance that a ray meets: its image, and where the ray is in the instance's box.
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

impl<'a> Instances<'a> {
    /// `None` if the scene has none.
    pub fn of(scene: &'a Scene, instanced: Option<&'a Instanced>) -> Option<Box<Self>> {
        Some(Box::new(Self {
            scene,
            instanced: instanced?,
            stack: Vec::new(),
            found: Vec::new(),
        }))
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
        self.found.clear();
        self.found.resize(rays.len(), [InstanceId::NONE.0; LANES]);
        for (p, hits) in hits.iter_mut().enumerate() {
            let live = simd.load(&rays[p].t_max).gt(simd.splat(0.0)).bits();
            for lane in bits(live) {
                let ray = ray(origins, rays, p, lane);
                if !ray.is_valid() {
                    continue;
                }
                let mut best = SceneHit::from(hits.hit(lane));
                self.closest_of_ray(simd, level, &ray, &mut best);
                if best.instance != InstanceId::NONE {
                    hits.set_hit(lane, &best);
                    self.found[p][lane] = best.instance.0;
                }
            }
        }
    }

    #[inline(always)]
    fn closest_of_ray<S: Simd>(&mut self, simd: S, level: Level, ray: &Ray, best: &mut SceneHit) {
        let single = SingleRay::of(ray);
        self.start(simd, &single, best.t);
        while let Some((near, slot)) = self.stack.pop() {
            if near > best.t {
                continue;
            }
            let Some(met) = self.visit_slot(simd, ray, &single, slot, best.t) else {
                continue;
            };
            let mut closest = Closest {
                scene: self.scene,
                best: Hit::miss(met.beyond(best.t)),
            };
            let bvh = self.prototype_of(met.id);
            visit(level, bvh, &met.image.ray, &mut closest);
            let hit = closest.best;
            let t = met.distance(hit.t);
            let ties = t == best.t && met.id < best.instance && best.instance != InstanceId::NONE;
            if hit.is_hit() && t > 0.0 && (t < best.t || ties) {
                *best = SceneHit {
                    hit: Hit { t, ..hit },
                    instance: met.id,
                };
            }
        }
    }

    /// Notes that the closest hits of these lanes of a packet are outside of any instance after all.
    pub fn forget(&mut self, packet: usize, lanes: u32) {
        for lane in bits(lanes) {
            self.found[packet][lane] = InstanceId::NONE.0;
        }
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
        for (p, occluded) in occluded.iter_mut().enumerate() {
            let live = simd.load(&rays[p].t_max).gt(simd.splat(0.0)).bits();
            for lane in bits(live & !u32::from(*occluded)) {
                let ray = ray(origins, rays, p, lane);
                let is_blocked = ray.is_valid() && self.blocks(simd, level, &ray);
                *occluded |= u8::from(is_blocked) << lane;
            }
        }
    }

    #[inline(always)]
    fn blocks<S: Simd>(&mut self, simd: S, level: Level, ray: &Ray) -> bool {
        let single = SingleRay::of(ray);
        self.start(simd, &single, ray.t_max);
        while let Some((_, slot)) = self.stack.pop() {
            let Some(met) = self.visit_slot(simd, ray, &single, slot, ray.t_max) else {
                continue;
            };
            let mut any = Any {
                scene: self.scene,
                end: met.end(ray.t_max),
                is_hit: false,
            };
            visit(level, self.prototype_of(met.id), &met.image.ray, &mut any);
            if any.is_hit {
                return true;
            }
        }
        false
    }

    /// Puts the children of the root on the stack.
    #[inline(always)]
    fn start<S: Simd>(&mut self, simd: S, ray: &SingleRay, end: f32) {
        self.stack.clear();
        self.push_children(simd, ray, 0, end);
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
    fn prototype_of(&self, id: InstanceId) -> &'a crate::accel::Bvh {
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
    /// Lets rays hit the instances of `scene`, too, which the BVH was built from.
    #[must_use]
    pub fn with_instances(mut self, scene: &'a Scene) -> Self {
        self.instances = Instances::of(scene, self.bvh.instanced());
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
