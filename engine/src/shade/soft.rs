//! Shadow rays that start at surfaces, and ambient occlusion: one random direction for each point and sample.

use super::{
    LIGHT_OFFSET, SURFACE_OFFSET,
    draw::{Draws, scattered},
    shadow::Scratch,
    surface::SurfacePacket,
};
use crate::{
    lanes::F32x8,
    ray::RayPacket,
    simd::{EightLanes, Lanes, Simd, Vec3Eight, Vec3Lanes, at_level},
    trace::Tracer,
};
use std::time::Duration;

/// Shadow rays start at the facet if the light is higher above it than the arcsine of the inverse: 14 degrees. A larger
/// number makes a step in cast shadows between neighbouring facets, a smaller one lets more light through touching walls.
// Tuned: see docs/lab-notes.md#smooth-shadows
const STEEPNESS: f32 = 4.0;

/// Returns how far off the surface shadow rays to the light start: with smooth shadows on the smooth surface.
///
/// Only for light that grazes the facet or is below it, since the facet blocks no other. So a wall between the facet and the
/// smooth surface still blocks light that is high above the facet.
#[inline(always)]
pub(super) fn lift<S: Simd>(simd: S, s: &SurfacePacket, to_light: Vec3Eight<S>) -> S::V8 {
    if s.raised == 0 {
        return offset(simd, s);
    }
    let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
    let height = simd.load3(&s.geometric_normal).dot(to_light);
    let share = (one - height * simd.splat(STEEPNESS)).max(zero).min(one);
    share.mul_add(simd.load(&s.rise), offset(simd, s))
}

/// Returns how far off the surface other rays start.
#[inline(always)]
fn offset<S: Simd>(simd: S, s: &SurfacePacket) -> S::V8 {
    simd.load(&s.magnitude) * SURFACE_OFFSET
}

/// Queues rays from off the surface by `lift`, `length` long and in the lanes `active`.
#[inline(always)]
pub(super) fn push<S: Simd>(
    simd: S,
    scratch: &mut Scratch,
    (surface_i, s, lift): (usize, &SurfacePacket, S::V8),
    (direction, length): (Vec3Eight<S>, S::V8),
    active: <S::V8 as Lanes>::Mask,
) {
    let geometric = simd.load3(&s.geometric_normal);
    let origin = geometric.mul_add(lift, simd.load3(&s.point));
    scratch.surface.push(surface_i as u32);
    scratch.origins.push(origin.to8());
    scratch.rays.push(RayPacket {
        // A light's centre itself has no direction.
        direction: Vec3Lanes::select(active, direction, geometric).to8(),
        t_max: S::V8::select(active, length, simd.splat(0.0)).to8(),
    });
}

/// Queues rays from off the surface by `lift` to just before points of a light, which may lie on another surface.
#[inline(always)]
pub(super) fn push_to<S: Simd>(
    simd: S,
    scratch: &mut Scratch,
    (surface_i, s, lift): (usize, &SurfacePacket, S::V8),
    on_light: Vec3Eight<S>,
    active: <S::V8 as Lanes>::Mask,
) {
    let geometric = simd.load3(&s.geometric_normal);
    let origin = geometric.mul_add(lift, simd.load3(&s.point));
    let offset = on_light - origin;
    let length = offset.dot(offset).sqrt();
    let margin = length.mul_add(simd.splat(LIGHT_OFFSET), on_light.max_abs() * SURFACE_OFFSET);
    scratch.surface.push(surface_i as u32);
    scratch.origins.push(origin.to8());
    scratch.rays.push(RayPacket {
        direction: Vec3Lanes::select(active, offset * (simd.splat(1.0) / length), geometric).to8(),
        t_max: S::V8::select(active, length - margin, simd.splat(0.0)).to8(),
    });
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

/// Queues a ray for each point, which it counts. Rays start at the facet, because none goes below it.
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
            (surface_i, s, offset(simd, s)),
            (direction, simd.splat(reach)),
            active,
        );
    }
    count
}
