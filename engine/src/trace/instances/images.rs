//! Traces the images of rays that meet instances of one prototype through its BVH.

use super::{Instances, Met, Results};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    math::Aabb,
    ray::{HitPacket, Origins, Ray, RayPacket},
};
use std::ops::Range;

/// A ray that meets an instance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    /// Its packet and lane.
    pub at: (usize, usize),
    pub met: Met,
    /// Where the ray ends, or its nearest hit; negative when it is done.
    pub end: f32,
    /// What the caller keeps of the ray.
    pub walk: usize,
}

/// Rays that meet instances, and their hits there.
#[derive(Debug, Default)]
pub(super) struct Images {
    pub met: Vec<Meeting>,
    rays: Vec<RayPacket>,
    origins: Vec<Vec3x8>,
    hits: Vec<HitPacket>,
    blocked: Vec<u8>,
}

impl Instances<'_> {
    /// Traces all rays that meet an instance. Those of one prototype follow each other.
    pub(super) fn trace_images(
        &mut self,
        images: &mut Images,
        share_origin: bool,
        results: &mut Results<'_>,
    ) {
        let instances = self.scene.instances();
        let prototype = |meeting: &Meeting| instances[meeting.met.id.0 as usize].prototype();
        let mut start = 0;
        while let Some(first) = images.met.get(start) {
            let id = prototype(first);
            let count = images.met[start..]
                .iter()
                .take_while(|meeting| prototype(meeting) == id)
                .count();
            self.trace_prototype(images, start..start + count, share_origin, results);
            start += count;
        }
    }

    /// Traces those rays that meet instances of one prototype.
    fn trace_prototype(
        &mut self,
        images: &mut Images,
        range: Range<usize>,
        share_origin: bool,
        results: &mut Results<'_>,
    ) {
        let is_any = matches!(results, Results::Any(_));
        images.fill(range.clone(), is_any);
        let Images {
            met,
            rays,
            origins,
            hits,
            blocked,
        } = images;
        let met = &mut met[range];
        let origins = if share_origin {
            Origins::Shared(met[0].met.image.ray.origin)
        } else {
            Origins::Separate(origins)
        };
        let bvh = self.prototype_of(met[0].met.id);
        let in_the_way = bvh.stats().primitives() as f32
            * if share_origin {
                share_of(met, bvh.bounds())
            } else {
                1.0
            };
        self.nested
            .policy
            .suit_instance(self.method, met.len(), in_the_way);
        self.nested.through(bvh);
        if is_any {
            blocked.resize(rays.len(), 0);
            self.nested.occluded(origins, rays, blocked);
        } else {
            hits.resize(rays.len(), HitPacket::miss(F32x8::ZERO));
            self.nested.closest_hit(origins, rays, hits);
        }
        for (i, Meeting { at, met, end, .. }) in met.iter_mut().enumerate() {
            match results {
                Results::Closest(..) => results.offer(*at, met, &hits[i / LANES].hit(i % LANES), end),
                Results::Any(_) if blocked[i / LANES] >> (i % LANES) & 1 == 1 => results.block(*at, end),
                Results::Any(_) => {}
            }
        }
    }
}

/// The share of a prototype's box around the points where these rays enter it.
fn share_of(met: &[Meeting], bounds: Aabb) -> f32 {
    let half_area = |bounds: Aabb| {
        let size = bounds.upper - bounds.lower;
        size.x * size.y + size.y * size.z + size.z * size.x
    };
    let entered = Aabb::around(met.iter().map(|Meeting { met, .. }| {
        let Ray {
            origin, direction, ..
        } = met.image.ray;
        origin + direction * met.image.of_distance(met.near.max(0.0))
    }));
    (half_area(entered) / half_area(bounds)).min(1.0)
}

impl Images {
    /// Packs these rays' images, eight to a packet.
    fn fill(&mut self, range: Range<usize>, is_any: bool) {
        let Self {
            met, rays, origins, ..
        } = self;
        rays.clear();
        origins.clear();
        for eight in met[range].chunks(LANES) {
            let mut origin = Vec3x8::ZERO;
            let mut packet = RayPacket {
                direction: Vec3x8::ZERO,
                t_max: F32x8::ZERO,
            };
            for lane in 0..LANES {
                let Meeting { met, end, .. } = &eight[lane.min(eight.len() - 1)];
                origin.set(lane, met.image.ray.origin);
                packet.direction.set(lane, met.image.ray.direction);
                if lane < eight.len() {
                    packet.t_max.as_mut_array()[lane] = if is_any { met.end(*end) } else { met.beyond(*end) };
                }
            }
            origins.push(origin);
            rays.push(packet);
        }
    }
}
