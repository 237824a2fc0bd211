//! Cut-outs and half-transparent surfaces: hits that kernels find there are invalid, so those rays are traced again, one at
//! a time.

use super::{Found, HitSink, Tracer, bits, visit};
use crate::{
    lanes::{F32x8, LANES},
    ray::{Hit, HitPacket, Origins, PrimitiveId, Ray, RayPacket, RayPackets, SceneHit},
    scene::Scene,
};

impl<'a> Tracer<'a> {
    /// Lets rays pass where surfaces of `scene`, which the BVH was built from, are cut out, and occlusion rays where little
    /// of them is seen. Else all surfaces are whole.
    ///
    /// # Panics
    /// If the BVH was built from another scene.
    #[must_use]
    pub fn through_cut_outs(self, scene: &'a Scene) -> Self {
        self.check(scene).pass_cut_outs(scene)
    }

    /// As [`through_cut_outs`](Self::through_cut_outs), for the BVH of a prototype as well.
    pub(super) fn pass_cut_outs(mut self, scene: &'a Scene) -> Self {
        self.cut_outs = scene.has_cut_outs().then_some(scene);
        self.dimming = scene.dims_light().then_some(scene);
        self.one_sided = scene.has_one_sided().then_some(scene);
        self
    }

    /// Finds the closest hit of one ray that is not on the back of a one-sided surface.
    pub fn visible_hit(&mut self, ray: &Ray) -> SceneHit {
        let mut packets = RayPackets::default();
        packets.restart(None);
        packets.push_rays(&std::array::from_fn(|lane| Ray {
            t_max: if lane == 0 { ray.t_max } else { 0.0 },
            ..*ray
        }));
        let mut hits = [HitPacket::miss(F32x8::ZERO)];
        let kept = self.instances.as_mut().map(|all| std::mem::take(all.found_mut()));
        self.passing_backs(true);
        self.closest_hit(packets.origins(), packets.packets(), &mut hits);
        self.passing_backs(false);
        let found = self.scene_hit(&hits, 0, 0);
        if let (Some(instances), Some(kept)) = (&mut self.instances, kept) {
            *instances.found_mut() = kept;
        }
        found
    }

    /// Lets rays other than occlusion rays pass the backs of one-sided surfaces; or no longer.
    pub(crate) fn passing_backs(&mut self, passes: bool) {
        self.passes_backs = passes;
        if let Some(instances) = &mut self.instances {
            instances.pass_backs(passes);
        }
    }

    /// Whether a ray meets a back that it passes.
    fn passes_back(&self, ray: &Ray, id: PrimitiveId) -> bool {
        self.passes_backs && self.one_sided.is_some_and(|scene| scene.is_back(ray, id))
    }

    /// As [`closest_hit`](Self::closest_hit), on opaque surfaces only, one ray at a time: for short rays.
    pub(crate) fn opaque_hit(&mut self, origins: Origins<'_>, rays: &[RayPacket], hits: &mut [HitPacket]) {
        self.stopping_only_where_opaque(true);
        self.closest_hit(origins, rays, hits);
        self.stopping_only_where_opaque(false);
    }

    /// Lets rays pass all surfaces that are not opaque; or no longer.
    pub(super) fn stopping_only_where_opaque(&mut self, stops: bool) {
        self.stops_only_where_opaque = stops;
        if let Some(instances) = &mut self.instances {
            instances.stop_only_where_opaque(stops);
        }
    }

    /// Whether rays other than occlusion rays pass a primitive.
    pub(super) fn passes(&self, id: PrimitiveId, weights: [f32; 2]) -> bool {
        if self.stops_only_where_opaque {
            self.dimming.is_some_and(|scene| !scene.is_opaque(id, weights))
        } else {
            self.cut_outs.is_some_and(|scene| scene.is_cut_out(id, weights))
        }
    }

    /// Lets occlusion rays pass only where surfaces are cut out, not where their opacity is low; or no longer.
    pub(crate) fn stopping_where_dimmed(&mut self, stops: bool) -> &mut Self {
        self.stops_where_dimmed = stops;
        if let Some(instances) = &mut self.instances {
            instances.stop_where_dimmed(stops);
        }
        self
    }

    /// Whether occlusion rays pass a primitive.
    #[inline(always)]
    pub(super) fn lets_light_pass(&self, scene: &Scene, id: PrimitiveId, weights: [f32; 2]) -> bool {
        if self.stops_where_dimmed {
            scene.is_cut_out(id, weights)
        } else {
            scene.lets_light_pass(id, weights)
        }
    }

    /// Replaces the hits in cut-outs.
    pub(super) fn pass_closest(&self, origins: Origins<'_>, rays: &[RayPacket], hits: &mut [HitPacket]) {
        for (p, hits) in hits.iter_mut().enumerate() {
            for lane in 0..LANES {
                let hit = hits.hit(lane);
                if hit.is_hit() && self.passes(hit.primitive, [hit.u, hit.v]) {
                    hits.set_hit(lane, &self.visit_closest(&ray(origins, rays, p, lane)));
                }
            }
        }
    }

    /// The hits of all rays, found one at a time.
    pub(super) fn visit_all(&self, origins: Origins<'_>, rays: &[RayPacket], hits: &mut [HitPacket]) {
        for (p, hits) in hits.iter_mut().enumerate() {
            for lane in 0..LANES {
                hits.set_hit(lane, &self.visit_closest(&ray(origins, rays, p, lane)));
            }
        }
    }

    fn visit_closest(&self, ray: &Ray) -> Hit {
        let mut closest = Closest {
            passes: |hit: &Hit| {
                self.passes(hit.primitive, [hit.u, hit.v]) || self.passes_back(ray, hit.primitive)
            },
            best: Hit::miss(ray.t_max),
        };
        if ray.t_max > 0.0 {
            visit(self.level, self.bvh, ray, &mut closest);
        }
        closest.best
    }

    /// Unblocks the rays that hit only cut-outs and surfaces that let light pass. Cost: docs/lab-notes.md#cut-outs
    pub(super) fn pass_occluded(
        &self,
        scene: &Scene,
        origins: Origins<'_>,
        rays: &[RayPacket],
        occluded: &mut [u8],
    ) {
        for (p, occluded) in occluded.iter_mut().enumerate() {
            for lane in bits(u32::from(*occluded)) {
                let ray = ray(origins, rays, p, lane);
                let mut any = Any {
                    passes: |hit: &Hit| self.lets_light_pass(scene, hit.primitive, [hit.u, hit.v]),
                    end: ray.t_max,
                    is_hit: false,
                };
                visit(self.level, self.bvh, &ray, &mut any);
                *occluded &= !(u8::from(!any.is_hit) << lane);
            }
        }
    }
}

pub(super) fn ray(origins: Origins<'_>, rays: &[RayPacket], p: usize, lane: usize) -> Ray {
    let origin = match origins {
        Origins::Shared(origin) => origin,
        Origins::Separate(origins) => origins[p].lane(lane),
    };
    rays[p].ray(lane, origin)
}

/// The closest hit; of equally near ones, the one with the lowest id.
struct Closest<P> {
    /// Whether the ray passes a surface.
    passes: P,
    best: Hit,
}

impl<P: Fn(&Hit) -> bool> HitSink for Closest<P> {
    #[inline(always)]
    fn end(&self) -> f32 {
        self.best.t
    }

    #[inline(always)]
    fn take(&mut self, found: Found) {
        if self.best.loses_to(found.t, found.primitive) {
            let hit = found.hit();
            if !(self.passes)(&hit) {
                self.best = hit;
            }
        }
    }
}

/// Whether anything that stops light is hit.
struct Any<P> {
    /// Whether light passes a surface.
    passes: P,
    end: f32,
    is_hit: bool,
}

impl<P: Fn(&Hit) -> bool> HitSink for Any<P> {
    #[inline(always)]
    fn end(&self) -> f32 {
        // Entries are never negative.
        if self.is_hit { -1.0 } else { self.end }
    }

    #[inline(always)]
    fn take(&mut self, found: Found) {
        self.is_hit = self.is_hit || found.t < self.end && !(self.passes)(&found.hit());
    }
}
