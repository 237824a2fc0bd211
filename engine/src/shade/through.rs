//! Light that passes straight through surfaces: shadow rays continue behind what they hit while any light is left. Only
//! scenes with glass or half-transparent surfaces run this pass.

use super::{
    SURFACE_OFFSET, TileColors,
    found::Found,
    queue::RayQueue,
    shadow::{Arriving, Scratch},
};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Hit, RayPacket},
    scene::{Crossing, MaterialId, Passage, RayCone, Scene},
    simd::{Simd, at_level},
    trace::Tracer,
};
use glam::Vec3;

/// The scratch memory of the pass.
#[derive(Debug, Default)]
pub(super) struct Through {
    /// The index of each packet with a blocked ray or a point in tinted glass, and its eight lights.
    packets: Vec<u32>,
    passages: Vec<[Passage; LANES]>,
    /// Their rays: the parent of one is its number in `passages`, times eight, and its lane.
    rays: RayQueue,
    next: RayQueue,
    found: Found,
    /// Nothing is shown.
    colors: TileColors,
}

impl Through {
    /// Follows the blocked rays. The share of their light that is left multiplies its power in `arriving`, or `power` where
    /// that has none; rays with light left are no longer blocked. Light to points in tinted glass is tinted on its way, though
    /// it meets nothing. Cost: docs/lab-notes.md#light-through-surfaces
    pub(super) fn pass(
        &mut self,
        scene: &Scene,
        tracer: &mut Tracer<'_>,
        (rays, origin): (&mut Scratch, Option<Vec3>),
        media: &[[Option<MaterialId>; LANES]],
        (arriving, power): (&mut Arriving, [f32; 3]),
    ) {
        self.start(scene, rays, origin, media);
        while !self.rays.rays.packets().is_empty() {
            self.cross(scene, tracer);
        }
        if self.packets.is_empty() {
            return;
        }
        let all = arriving.n_dot_l.len();
        arriving.power.resize(all, power.map(F32x8::splat));
        for (&p, passages) in self.packets.iter().zip(&self.passages) {
            let power = &mut arriving.power[rays.surface[p as usize] as usize];
            let blocked = &mut rays.blocked[p as usize];
            for (lane, passage) in passages.iter().enumerate() {
                if *blocked >> lane & 1 == 1 && passage.left == [0.0; 3] {
                    continue;
                }
                *blocked &= !(1 << lane);
                for (power, left) in power.iter_mut().zip(passage.left) {
                    power.as_mut_array()[lane] *= left;
                }
            }
        }
    }

    /// Queues the blocked rays. Others, which meet nothing, arrive.
    fn start(
        &mut self,
        scene: &Scene,
        rays: &Scratch,
        origin: Option<Vec3>,
        media: &[[Option<MaterialId>; LANES]],
    ) {
        self.packets.clear();
        self.passages.clear();
        self.rays.restart_camera(None);
        for (p, &blocked) in rays.blocked.iter().enumerate() {
            let media = media.get(rays.surface[p] as usize).copied();
            let media = media.unwrap_or([None; LANES]);
            if blocked == 0 && media == [None; LANES] {
                continue;
            }
            let mut packet = rays.rays[p];
            for (lane, t_max) in packet.t_max.as_mut_array().iter_mut().enumerate() {
                if blocked >> lane & 1 == 0 {
                    *t_max = 0.0;
                }
            }
            let origins = origin.map_or_else(|| rays.origins[p], Vec3x8::splat);
            if blocked != 0 {
                let first = (self.passages.len() * LANES) as u32;
                let own = std::array::from_fn(|lane| first + lane as u32);
                self.rays.push_from(origins, packet, own, F32x8::ZERO);
            }
            self.packets.push(p as u32);
            self.passages.push(std::array::from_fn(|lane| {
                let ray = rays.rays[p].ray(lane, origins.lane(lane));
                let mut passage = Passage::along(&ray, origin.is_some(), media[lane]);
                if blocked >> lane & 1 == 0 && ray.t_max > 0.0 {
                    passage.arrive(scene, ray.t_max);
                }
                passage
            }));
        }
    }

    /// Traces all rays to the next surface, and queues those that continue behind it.
    fn cross(&mut self, scene: &Scene, tracer: &mut Tracer<'_>) {
        self.found.trace(tracer, &self.rays);
        let packets = self.rays.rays.packets();
        for (p, (packet, hits)) in packets.iter().zip(&mut self.found.hits).enumerate() {
            for (lane, &t_max) in packet.t_max.as_array().iter().enumerate() {
                let (hit, i) = (hits.hit(lane), self.rays.parent(p)[lane] as usize);
                let passage = &mut self.passages[i / LANES][i % LANES];
                if t_max > 0.0 && !hit.is_hit() {
                    passage.arrive(scene, t_max);
                } else if hit.is_hit() && !scene.passes_light(scene.material_of(hit.primitive)) {
                    // Nothing of the surface matters.
                    passage.left = [0.0; 3];
                    hits.set_hit(lane, &Hit::miss(t_max));
                }
            }
        }
        self.colors.resize(packets.len());
        self.next.restart_camera(None);
        let (level, no_cone) = (tracer.level(), RayCone::default());
        let queue = (&self.rays, true);
        self.found
            .gather(scene, (tracer, no_cone), queue, &mut self.colors);
        at_level!(level, |simd| self.go_on(simd, scene));
        std::mem::swap(&mut self.rays, &mut self.next);
    }

    /// Dims the light at each surface, and queues the rays with light left.
    #[inline(always)]
    fn go_on<S: Simd>(&mut self, simd: S, scene: &Scene) {
        for (id, range) in self.found.by_material.ranges() {
            let base = scene.materials()[id.0 as usize].base_color();
            for i in range {
                let s = &self.found.surfaces[i];
                let tint = self.found.tints.get(i).copied().unwrap_or([F32x8::splat(1.0); 3]);
                let (mut origins, mut own) = (s.point, [0; LANES]);
                let (mut direction, mut t_max) = (s.direction, F32x8::ZERO);
                for lane in (0..LANES).filter(|lane| s.active >> lane & 1 == 1) {
                    let (p, from) = (s.pixel[lane] as usize / LANES, s.pixel[lane] as usize % LANES);
                    let hit = self.found.hits[p].hit(from);
                    own[lane] = self.rays.parent(p)[from];
                    let crossing = Crossing {
                        direction: s.direction.lane(lane),
                        geometric_normal: s.geometric_normal.lane(lane),
                        normal: s.normal.lane(lane),
                        from_behind: s.from_behind >> lane & 1 == 1,
                        ..Crossing::at(&hit, std::array::from_fn(|c| base[c] * tint[c].as_array()[lane]))
                    };
                    let passage = &mut self.passages[own[lane] as usize / LANES][own[lane] as usize % LANES];
                    if passage.cross(simd, scene, &crossing) {
                        let offset = -(s.magnitude.as_array()[lane] * SURFACE_OFFSET);
                        let behind = simd.mul_add3(crossing.geometric_normal, offset, s.point.lane(lane));
                        let ray = passage.onward(simd, behind, crossing.direction);
                        origins.set(lane, ray.origin);
                        direction.set(lane, ray.direction);
                        t_max.as_mut_array()[lane] = ray.t_max;
                    }
                }
                if t_max.as_array().iter().any(|&t| t > 0.0) {
                    self.next
                        .push_from(origins, RayPacket { direction, t_max }, own, F32x8::ZERO);
                }
            }
        }
    }
}
