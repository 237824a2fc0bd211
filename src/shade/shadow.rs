//! The shadow pass: finds the points that one light reaches.

use super::{LIGHT_OFFSET, SURFACE_OFFSET, surface::SurfacePacket};
use crate::{
    ray::{Origins, RayPacket},
    simd_old::{F32x8, Mask8, Vec3x8, gt, max, mul_add, splat},
    trace::Tracer,
};
use glam::Vec3;
use std::time::{Duration, Instant};

/// The scratch memory of a pass.
#[derive(Debug, Default)]
pub struct Scratch {
    rays: Vec<RayPacket>,
    /// The index of the surface packet at the end of each packet of rays.
    surface: Vec<u32>,
    blocked: Vec<u8>,
}

impl Scratch {
    /// Reserves memory for this many surface packets.
    pub fn reserve(&mut self, packets: usize) {
        self.rays.reserve(packets);
        self.surface.reserve(packets);
        self.blocked.reserve(packets);
    }
}

/// The light that arrives at each point from one light.
#[derive(Debug, Default)]
pub struct Arriving {
    /// max(0, n.l), or 0 where the light is occluded.
    pub n_dot_l: Vec<F32x8>,
    /// The unit direction l to the light.
    pub to_light: Vec<Vec3x8>,
}

impl Arriving {
    /// Reserves memory for this many surface packets.
    pub fn reserve(&mut self, packets: usize) {
        self.n_dot_l.reserve(packets);
        self.to_light.reserve(packets);
    }
}

/// Computes what arrives from the light at `light`; without a tracer there are no shadows. Returns the number of rays
/// and the time spent tracing them.
///
/// Shadow rays run from the light to the point, offset to the viewer's side, so they share their origin. Packets
/// without a point that faces the light are left out.
pub fn pass(
    light: Vec3,
    tracer: Option<&mut Tracer<'_>>,
    surfaces: &[SurfacePacket],
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> (u64, Duration) {
    let light8 = Vec3x8::splat(light);
    arriving.n_dot_l.clear();
    arriving.to_light.clear();
    scratch.rays.clear();
    scratch.surface.clear();
    let mut count = 0;
    for (s, surface_i) in surfaces.iter().zip(0..) {
        let offset = light8 - s.point;
        let distance = offset.dot(offset).sqrt();
        let to_light = offset * (splat(1.0) / distance);
        let n_dot_l = max(s.normal.dot(to_light), splat(0.0));
        arriving.n_dot_l.push(n_dot_l);
        arriving.to_light.push(to_light);
        let active = gt(n_dot_l, splat(0.0)) & Mask8::from_bits(s.active);
        let bits = active.bits();
        if tracer.is_some() && bits != 0 {
            count += u64::from(bits.count_ones());
            scratch.surface.push(surface_i);
            scratch.rays.push(ray(light8, s, distance, active));
        }
    }
    let Some(tracer) = tracer else {
        return (0, Duration::ZERO);
    };
    if scratch.rays.is_empty() {
        return (0, Duration::ZERO);
    }

    scratch.blocked.clear();
    scratch.blocked.resize(scratch.rays.len(), 0);
    let start = Instant::now();
    tracer.occluded(Origins::Shared(light), &scratch.rays, &mut scratch.blocked);
    let time = start.elapsed();
    for (&surface_i, &blocked) in scratch.surface.iter().zip(&scratch.blocked) {
        if blocked != 0 {
            let n_dot_l = &mut arriving.n_dot_l[surface_i as usize];
            *n_dot_l = Mask8::from_bits(blocked.into()).select(splat(0.0), *n_dot_l);
        }
    }
    (count, time)
}

/// Makes the rays from the light to eight points at `distance`; inactive lanes get no ray.
#[inline(always)]
fn ray(light8: Vec3x8, s: &SurfacePacket, distance: F32x8, active: Mask8) -> RayPacket {
    let offset = mul_add(distance, splat(LIGHT_OFFSET), s.magnitude * splat(SURFACE_OFFSET));
    let from_light = s.geometric_normal.mul_add(offset, s.point) - light8;
    let length = from_light.dot(from_light).sqrt();
    // A point at the light gets any direction: its ray of length 0 hits nothing.
    let direction = Vec3x8::select(
        gt(length, splat(0.0)),
        from_light * (splat(1.0) / length),
        Vec3x8::splat(Vec3::Z),
    );
    RayPacket {
        direction,
        t_max: active.select(length, splat(0.0)),
    }
}
