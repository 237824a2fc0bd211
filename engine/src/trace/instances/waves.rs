//! Rays with separate origins, in waves: each ray traverses the BVH over the instances singly, up to one that it meets. Then
//! all are traced through the prototypes together, and continue.

use super::{
    Instances, Met, Results, Slot,
    images::{Images, Meeting},
};
use crate::{
    accel::{Instanced, Node8},
    lanes::LANES,
    ray::{InstanceId, Origins, Ray, RayPacket},
    scene::Scene,
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Lanes, unpack},
    trace::{bits::bits, cut_outs::ray, single::SingleRay},
};

/// A ray that traverses the BVH over the instances.
#[derive(Debug)]
pub(super) struct Walk {
    /// Its packet and lane.
    at: (usize, usize),
    ray: Ray,
    single: SingleRay,
    /// Where the ray ends, or its nearest hit; negative when it is done.
    pub(super) end: f32,
    /// Children that it has yet to visit, and where it enters them, the nearest last.
    pub(super) todo: Vec<(f32, Slot)>,
}

/// The memory of waves.
#[derive(Debug, Default)]
pub(super) struct Waves {
    walks: Vec<Walk>,
    /// Stacks that are free.
    stacks: Vec<Vec<(f32, Slot)>>,
}

impl Instances<'_> {
    /// Traces incoherent rays.
    #[inline(always)]
    pub(super) fn trace_in_waves<S: Simd>(
        &mut self,
        simd: S,
        origins: Origins<'_>,
        rays: &[RayPacket],
        results: &mut Results<'_>,
    ) {
        let (mut waves, mut images) = (std::mem::take(&mut self.waves), std::mem::take(&mut self.images));
        for (p, packet) in rays.iter().enumerate() {
            let ends = results.ends(simd, p, packet);
            for lane in bits(ends.gt(simd.splat(0.0)).bits()) {
                let ray = ray(origins, rays, p, lane);
                if !ray.is_valid() {
                    continue;
                }
                let stack = waves.stacks.pop().unwrap_or_default();
                let ray = (ray, ends.lane(lane));
                waves
                    .walks
                    .push(Walk::new(simd, self.instanced, ray, (p, lane), stack));
            }
        }
        while !waves.walks.is_empty() {
            self.wave(simd, &mut waves, &mut images, results);
        }
        (self.waves, self.images) = (waves, images);
    }

    /// One wave: each ray continues to its next instance and through it.
    #[inline(always)]
    fn wave<S: Simd>(&mut self, simd: S, waves: &mut Waves, images: &mut Images, results: &mut Results<'_>) {
        images.met.clear();
        let Waves { walks, stacks } = waves;
        let mut i = 0;
        while let Some(walk) = walks.get_mut(i) {
            if let Some(met) = walk.next_met(simd, self.scene, self.instanced) {
                images.met.push(Meeting {
                    at: walk.at,
                    met,
                    end: walk.end,
                    walk: i,
                });
                i += 1;
            } else {
                let mut walk = walks.swap_remove(i);
                walk.todo.clear();
                stacks.push(walk.todo);
            }
        }
        if self.scene.prototypes().len() > 1 {
            let instances = self.scene.instances();
            images
                .met
                .sort_unstable_by_key(|meeting| instances[meeting.met.id.0 as usize].prototype());
        }
        self.trace_images(images, false, results);
        for meeting in &images.met {
            walks[meeting.walk].end = meeting.end;
        }
    }
}

impl Walk {
    /// Begins at the root, with an empty stack.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        simd: S,
        instanced: &Instanced,
        (ray, end): (Ray, f32),
        at: (usize, usize),
        todo: Vec<(f32, Slot)>,
    ) -> Self {
        let mut walk = Self {
            at,
            ray,
            single: SingleRay::of(&ray),
            end,
            todo,
        };
        walk.push_children(simd, instanced, 0);
        walk
    }

    /// The next instance that the ray meets.
    #[inline(always)]
    pub(super) fn next_met<S: Simd>(&mut self, simd: S, scene: &Scene, instanced: &Instanced) -> Option<Met> {
        while let Some((near, slot)) = self.todo.pop() {
            if near > self.end {
                continue;
            }
            let (node_i, lane) = (slot as usize / LANES, slot as usize % LANES);
            let node = &instanced.nodes()[node_i];
            let child = node.child[lane];
            if child.is_inner() {
                self.push_children(simd, instanced, child.index());
                continue;
            }
            let [near, far] = interval(simd, &self.single, node, lane);
            if near > far {
                continue;
            }
            if let Some(image) = scene.instances()[child.index()].image(&self.ray) {
                let id = InstanceId(child.index() as u32);
                return Some(Met { id, image, near, far });
            }
        }
        None
    }

    /// Puts the children of a node that the ray enters on its stack.
    #[inline(always)]
    fn push_children<S: Simd>(&mut self, simd: S, instanced: &Instanced, node_i: usize) {
        let node = &instanced.nodes()[node_i];
        let (entered, near) = self.single.enter(simd, node, self.end);
        let (entries, count) = near.nearest_last(entered);
        for &entry in entries.iter().take(count) {
            let (near, lane) = unpack(entry);
            self.todo.push((near, (node_i * LANES + lane) as Slot));
        }
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
