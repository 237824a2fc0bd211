//! Light from many directions: spherical lights and ambient occlusion, by one random direction for each point and sample.

use super::{
    SURFACE_OFFSET,
    draw::{Draws, cone, scattered},
    shadow::{Arriving, Scratch},
    surface::SurfacePacket,
};
use crate::{
    lanes::F32x8,
    ray::RayPacket,
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes, at_level},
    trace::Tracer,
};
use glam::Vec3;
use std::time::Duration;

/// Queues rays from just off the surface, `length` long and in the lanes `active`.
#[inline(always)]
fn push<S: Simd>(
    simd: S,
    scratch: &mut Scratch,
    (surface_i, s): (usize, &SurfacePacket),
    (direction, length): (Vec3Eight<S>, S::V8),
    active: <S::V8 as Lanes>::Mask,
) {
    let geometric = simd.load3(&s.geometric_normal);
    let origin = geometric.mul_add(simd.load(&s.magnitude) * SURFACE_OFFSET, simd.load3(&s.point));
    scratch.surface.push(surface_i as u32);
    scratch.origins.push(origin.to8());
    scratch.rays.push(RayPacket {
        // A light's centre itself has no direction.
        direction: Vec3Lanes::select(active, direction, geometric).to8(),
        t_max: S::V8::select(active, length, simd.splat(0.0)).to8(),
    });
}

/// Fills `arriving` with the light of a sphere as if nothing were occluded, and `scratch` with the shadow rays, which it
/// counts.
#[inline(always)]
pub(super) fn facing<S: Simd>(
    simd: S,
    (center, radius): (Vec3, f32),
    (draws, shadows): (Draws<'_>, bool),
    surfaces: &[SurfacePacket],
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> u64 {
    let (center, zero) = (simd.splat3(center), simd.splat(0.0));
    let mut count = 0;
    for (surface_i, s) in surfaces.iter().enumerate() {
        let point = draws.points(simd, &s.pixel);
        let cone = cone(simd, center - simd.load3(&s.point), radius, point);
        let n_dot_l = simd.load3(&s.normal).dot(cone.direction).max(zero);
        arriving.n_dot_l.push(n_dot_l.to8());
        arriving.to_light.push(cone.direction.to8());
        let active = n_dot_l.gt(zero) & cone.distance.gt(zero) & simd.mask(s.active);
        let bits = active.bits();
        if shadows && bits != 0 {
            count += u64::from(bits.count_ones());
            let ray = (cone.direction, cone.distance);
            push(simd, scratch, (surface_i, s), ray, active);
        }
    }
    count
}

/// Computes the ambient light at each point: `ambient`, or 0 where something is hit within `reach`. Returns the number of
/// rays and the time spent tracing them.
pub(super) fn ambient_pass(
    (ambient, reach): (f32, f32),
    draws: Draws<'_>,
    tracer: &mut Tracer<'_>,
    surfaces: &[SurfacePacket],
    arriving: &mut Vec<F32x8>,
    scratch: &mut Scratch,
) -> (u64, Duration) {
    let level = tracer.level();
    arriving.clear();
    arriving.resize(surfaces.len(), F32x8::splat(ambient));
    let count = at_level!(level, |simd| scatter(simd, reach, draws, surfaces, scratch));
    let time = scratch.trace(tracer, None);
    for (&surface_i, &blocked) in scratch.surface.iter().zip(&scratch.blocked) {
        let lanes = arriving[surface_i as usize].as_mut_array();
        for (lane, ambient) in lanes.iter_mut().enumerate() {
            if blocked >> lane & 1 == 1 {
                *ambient = 0.0;
            }
        }
    }
    (count, time)
}

/// Queues a ray for each point, which it counts.
#[inline(always)]
fn scatter<S: Simd>(
    simd: S,
    reach: f32,
    draws: Draws<'_>,
    surfaces: &[SurfacePacket],
    scratch: &mut Scratch,
) -> u64 {
    scratch.clear();
    let mut count = 0;
    for (surface_i, s) in surfaces.iter().enumerate() {
        let (normal, geometric) = (simd.load3(&s.normal), simd.load3(&s.geometric_normal));
        let direction = scattered(simd, normal, geometric, draws.points(simd, &s.pixel));
        count += u64::from(s.active.count_ones());
        let active = simd.mask(s.active);
        push(
            simd,
            scratch,
            (surface_i, s),
            (direction, simd.splat(reach)),
            active,
        );
    }
    count
}
