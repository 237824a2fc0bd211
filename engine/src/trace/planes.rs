//! Infinite planes, which no BVH holds: a pass over finished results. Scenes without planes never run it.

use super::Tracer;
use crate::{
    geometry::plane_hits,
    ray::{HitPacket, Origins, PrimitiveId, RayPacket, T_MAX},
    scene::{Plane, Scene},
    simd::{EightLanes, LaneMask, Lanes, Portable, Simd, Vec3Eight},
};
use glam::Vec3;

/// Corners of a cone whose cosine to a plane is less than this may be on either side of it.
const MARGIN: f32 = 1e-5;

impl<'a> Tracer<'a> {
    /// Lets rays hit the planes of `scene`, too, which the BVH was built from.
    ///
    /// # Panics
    /// If the BVH was built from another scene.
    #[must_use]
    pub fn with_planes(mut self, scene: &'a Scene) -> Self {
        self = self.check(scene);
        self.planes = scene.planes();
        self.first_plane = scene.plane_id(0);
        self
    }

    /// Returns whether rays from `origin` may hit a plane in the cone spanned by `corners`.
    pub(super) fn may_hit_planes(&self, origin: Vec3, corners: [Vec3; 4]) -> bool {
        self.planes.iter().any(|plane| {
            let side = Portable.dot(plane.normal, plane.point - origin).signum();
            // NaN is no proof.
            let is_off = |corner: &Vec3| Portable.dot(plane.normal, *corner) * side < -MARGIN;
            !corners.iter().all(is_off)
        })
    }

    fn plane_id(&self, i: u32) -> PrimitiveId {
        PrimitiveId(self.first_plane.0 + i)
    }

    /// Replaces hits that are behind a plane. At equal distances primitives win, because their ids are lower.
    #[inline(always)]
    pub(super) fn planes_closest<S: Simd>(
        &mut self,
        simd: S,
        origins: Origins<'_>,
        rays: &[RayPacket],
        hits: &mut [HitPacket],
    ) {
        for (p, hits) in hits.iter_mut().enumerate() {
            let ray = ray(simd, origins, rays, p);
            let usable = simd.load(&rays[p].t_max).le(simd.splat(T_MAX));
            for (i, plane) in (0..).zip(self.planes) {
                if self.passes(self.plane_id(i), [0.0; 2]) {
                    continue;
                }
                let best = simd.load(&hits.t);
                let (hit, t) = plane_hits(surface(simd, plane), ray);
                let nearer = hit & usable & t.lt(best);
                let bits = nearer.bits();
                if bits == 0 {
                    continue;
                }
                hits.t = S::V8::select(nearer, t, best).to8();
                let zero = simd.splat(0.0);
                for weights in [&mut hits.u, &mut hits.v] {
                    *weights = S::V8::select(nearer, zero, simd.load(weights)).to8();
                }
                for (lane, id) in hits.primitive.iter_mut().enumerate() {
                    if bits >> lane & 1 == 1 {
                        *id = self.first_plane.0 + i;
                    }
                }
                if let Some(instances) = &mut self.instances {
                    instances.forget(p, bits);
                }
            }
        }
    }

    /// Blocks the rays that hit a plane before their end.
    #[inline(always)]
    pub(super) fn planes_occluded<S: Simd>(
        &self,
        simd: S,
        origins: Origins<'_>,
        rays: &[RayPacket],
        occluded: &mut [u8],
    ) {
        for (p, occluded) in occluded.iter_mut().enumerate() {
            let ray = ray(simd, origins, rays, p);
            let end = simd.load(&rays[p].t_max);
            for (i, plane) in (0..).zip(self.planes) {
                let lets_pass = |scene| self.lets_light_pass(scene, self.plane_id(i), [0.0; 2]);
                if self.cut_outs.is_some_and(lets_pass) {
                    continue;
                }
                let (hit, t) = plane_hits(surface(simd, plane), ray);
                *occluded |= (hit & t.lt(end) & end.le(simd.splat(T_MAX))).bits() as u8;
            }
        }
    }
}

/// A point and the normal of a plane.
#[inline(always)]
fn surface<S: Simd>(simd: S, plane: &Plane) -> (Vec3Eight<S>, Vec3Eight<S>) {
    (simd.splat3(plane.point), simd.splat3(plane.normal))
}

/// The origins and directions of a packet.
#[inline(always)]
fn ray<S: Simd>(simd: S, origins: Origins<'_>, rays: &[RayPacket], p: usize) -> (Vec3Eight<S>, Vec3Eight<S>) {
    let origin = match origins {
        Origins::Shared(origin) => simd.splat3(origin),
        Origins::Separate(origins) => simd.load3(&origins[p]),
    };
    (origin, simd.load3(&rays[p].direction))
}
