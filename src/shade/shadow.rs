//! One light at a time: which points it reaches.

use super::{LIGHT_OFFSET, SURFACE_OFFSET, surface::SurfacePacket};
use crate::{
    ray::{Origins, RayPacket},
    simd::{F32x8, Mask8, Vec3x8, gt, max, mul_add, splat},
    trace::Tracer,
};
use glam::Vec3;
use std::time::{Duration, Instant};

/// Memory of a pass, reused.
#[derive(Debug, Default)]
pub struct Scratch {
    rays: Vec<RayPacket>,
    /// For each packet of rays the surface packet that it ends at.
    surface: Vec<u32>,
    blocked: Vec<u8>,
}

impl Scratch {
    /// Makes room for so many surface packets.
    pub fn reserve(&mut self, packets: usize) {
        self.rays.reserve(packets);
        self.surface.reserve(packets);
        self.blocked.reserve(packets);
    }
}

/// What reaches points of one light.
#[derive(Debug, Default)]
pub struct Arriving {
    /// For each point max(0, n.l), and 0 where the light is hidden.
    pub share: Vec<F32x8>,
    /// The unit directions l to the light.
    pub toward: Vec<Vec3x8>,
}

impl Arriving {
    /// Makes room for so many surface packets.
    pub fn reserve(&mut self, packets: usize) {
        self.share.reserve(packets);
        self.toward.reserve(packets);
    }
}

/// What reaches the points of the light at `light`; `tracer` is absent where shadows are off. Answers how many rays were
/// traced, and in what time.
///
/// A shadow ray runs from the light to the point, offset to the viewer's side: so all rays of a pass share
/// their origin. Packets without a point that faces the light are left out.
pub fn pass(
    light: Vec3,
    tracer: Option<&mut Tracer<'_>>,
    surfaces: &[SurfacePacket],
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> (u64, Duration) {
    let light8 = Vec3x8::splat(light);
    arriving.share.clear();
    arriving.toward.clear();
    scratch.rays.clear();
    scratch.surface.clear();
    let mut count = 0;
    for (s, surface_i) in surfaces.iter().zip(0..) {
        let to_light = light8 - s.point;
        let distance = to_light.dot(to_light).sqrt();
        let toward = to_light * (splat(1.0) / distance);
        let facing = max(s.normal.dot(toward), splat(0.0));
        arriving.share.push(facing);
        arriving.toward.push(toward);
        let active = gt(facing, splat(0.0)) & Mask8::from_bits(s.active);
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
            let facing = &mut arriving.share[surface_i as usize];
            *facing = Mask8::from_bits(blocked.into()).select(splat(0.0), *facing);
        }
    }
    (count, time)
}

/// From the light to eight points at `distance`; lanes that are not active get no ray.
#[inline(always)]
fn ray(light8: Vec3x8, s: &SurfacePacket, distance: F32x8, active: Mask8) -> RayPacket {
    let offset = mul_add(distance, splat(LIGHT_OFFSET), s.magnitude * splat(SURFACE_OFFSET));
    let from_light = s.geometric_normal.mul_add(offset, s.point) - light8;
    let length = from_light.dot(from_light).sqrt();
    // A point on the light has no direction; its ray of length 0 hits nothing, whichever way it goes.
    let somewhere = Vec3x8::select(
        gt(length, splat(0.0)),
        from_light * (splat(1.0) / length),
        Vec3x8::splat(Vec3::Z),
    );
    RayPacket {
        direction: somewhere,
        t_max: active.select(length, splat(0.0)),
    }
}
