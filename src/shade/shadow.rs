//! One light at a time: which points it reaches.

use super::{LIGHT_OFFSET, SURFACE_OFFSET, surface::SurfacePacket};
use crate::{
    ray::RayPacket,
    simd::{F32x8, Mask8, Vec3x8, gt, max, mul_add, splat},
    trace::{Origins, Tracer},
};
use glam::Vec3;
use std::time::{Duration, Instant};

/// Memory of a pass, reused.
#[derive(Debug, Default)]
pub struct Scratch {
    rays: Vec<RayPacket>,
    blocked: Vec<u8>,
}

/// For each point max(0, n.l) of the light at `light`, and 0 where the light is hidden; `tracer` is absent
/// where shadows are off. Answers how many rays were traced, and in what time.
///
/// A shadow ray runs from the light to the point, offset to the viewer's side: so all rays of a pass share
/// their origin.
pub fn pass(
    light: Vec3,
    tracer: Option<&mut Tracer<'_>>,
    surfaces: &[SurfacePacket],
    arriving: &mut Vec<F32x8>,
    scratch: &mut Scratch,
) -> (u64, Duration) {
    let light8 = Vec3x8::splat(light);
    arriving.clear();
    arriving.extend(
        surfaces
            .iter()
            .map(|s| max(s.normal.dot((light8 - s.point).normalize()), splat(0.0))),
    );
    let Some(tracer) = tracer else {
        return (0, Duration::ZERO);
    };

    scratch.rays.clear();
    scratch.rays.extend(
        surfaces
            .iter()
            .zip(&*arriving)
            .map(|(s, &facing)| ray(light8, s, facing)),
    );
    scratch.blocked.clear();
    scratch.blocked.resize(surfaces.len(), 0);
    let start = Instant::now();
    tracer.occluded(Origins::Shared, &scratch.rays, &mut scratch.blocked);
    let time = start.elapsed();
    for (facing, &blocked) in arriving.iter_mut().zip(&scratch.blocked) {
        *facing = Mask8::from_bits(blocked.into()).select(splat(0.0), *facing);
    }
    let active = |rays: &RayPacket| u64::from(gt(rays.t_max, splat(0.0)).bits().count_ones());
    (scratch.rays.iter().map(active).sum(), time)
}

/// From the light to eight points; lanes that face away from it, or hold no point, get no ray.
fn ray(light8: Vec3x8, s: &SurfacePacket, facing: F32x8) -> RayPacket {
    let to_light = light8 - s.point;
    let distance = to_light.dot(to_light).sqrt();
    let offset = mul_add(distance, splat(LIGHT_OFFSET), s.magnitude * splat(SURFACE_OFFSET));
    let from_light = s.geometric_normal.mul_add(offset, s.point) - light8;
    let length = from_light.dot(from_light).sqrt();
    let direction = Vec3x8::new(
        from_light.x / length,
        from_light.y / length,
        from_light.z / length,
    );
    let active = gt(facing, splat(0.0)) & Mask8::from_bits(s.active);
    // A point on the light has no direction; its ray of length 0 hits nothing, whichever way it goes.
    let somewhere = Vec3x8::select(gt(length, splat(0.0)), direction, Vec3x8::splat(Vec3::Z));
    RayPacket {
        origin: light8,
        direction: somewhere,
        t_max: active.select(length, splat(0.0)),
    }
}
