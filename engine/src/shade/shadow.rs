//! The shadow pass: finds the points that a light or the environment reaches.

use super::{
    LIGHT_OFFSET,
    draw::Draws,
    environment::{self, Part},
    light::{self, Beam},
    soft,
    surface::SurfacePacket,
    through::Through,
};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Origins, RayPacket},
    scene::{Environment, Light, LightShape, MaterialId, Scene},
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes, at_level},
    trace::Tracer,
};
use glam::Vec3;
use std::time::{Duration, Instant};

/// A source of light.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Light(&'a Light),
    Environment(&'a Environment, Part),
}

/// The scratch memory of a pass: occlusion rays.
#[derive(Debug, Default)]
pub struct Scratch {
    pub(super) rays: Vec<RayPacket>,
    /// Empty for rays that share their origin.
    pub(super) origins: Vec<Vec3x8>,
    /// The index of the surface packet of each packet of rays.
    pub(super) surface: Vec<u32>,
    /// Rays that hit something, a bit each.
    pub(super) blocked: Vec<u8>,
    through: Through,
}

impl Scratch {
    /// Reserves memory for this many surface packets.
    pub fn reserve(&mut self, packets: usize) {
        self.rays.reserve(packets);
        self.surface.reserve(packets);
        self.blocked.reserve(packets);
    }

    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.origins.clear();
        self.surface.clear();
        self.blocked.clear();
    }

    /// Traces the rays, from `origin` if they share it. Returns the time.
    pub(super) fn trace(&mut self, tracer: &mut Tracer<'_>, origin: Option<Vec3>) -> Duration {
        if self.rays.is_empty() {
            return Duration::ZERO;
        }
        self.blocked.resize(self.rays.len(), 0);
        let start = Instant::now();
        let origins = origin.map_or(Origins::Separate(&self.origins), Origins::Shared);
        tracer.occluded(origins, &self.rays, &mut self.blocked);
        start.elapsed()
    }
}

/// The light that arrives at each point from one source.
#[derive(Debug, Default)]
pub struct Arriving {
    /// max(0, n.l), or 0 where the light is occluded.
    pub n_dot_l: Vec<F32x8>,
    /// The unit direction l to the light.
    pub to_light: Vec<Vec3x8>,
    /// Intensity times colour that arrives at each point; empty if it is the same everywhere.
    pub power: Vec<[F32x8; 3]>,
}

impl Arriving {
    /// Reserves memory for this many surface packets.
    pub fn reserve(&mut self, packets: usize) {
        self.n_dot_l.reserve(packets);
        self.to_light.reserve(packets);
        self.power.reserve(packets);
    }

    fn clear(&mut self) {
        self.n_dot_l.clear();
        self.to_light.clear();
        self.power.clear();
    }
}

/// Computes the light that arrives from a source of this power. Returns the number of shadow rays and the time spent tracing
/// them.
///
/// Shadow rays of point lights run from the light to the surface, offset to the viewer's side, so they share their origin;
/// those of other sources start at the surface. Packets without a point that faces the light are left out. `media`: the tinted
/// glass that the points are seen in, or empty.
pub(super) fn pass(
    (source, power): (Source<'_>, [f32; 3]),
    (draws, shadows): (Draws<'_>, bool),
    (scene, tracer): (&Scene, &mut Tracer<'_>),
    (surfaces, media): (&[SurfacePacket], &[[Option<MaterialId>; LANES]]),
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> (u64, Duration) {
    let level = tracer.level();
    arriving.clear();
    scratch.clear();
    let (count, origin) = match source {
        Source::Light(light) => {
            let beam = Beam::of(light);
            let count = at_level!(level, |simd| facing(
                simd,
                (&light.shape, beam.as_ref()),
                (draws, shadows),
                surfaces,
                arriving,
                scratch
            ));
            let origin = match light.shape {
                LightShape::Point { position } => Some(position),
                _ => None,
            };
            (count, origin)
        }
        Source::Environment(environment, part) => {
            let count = at_level!(level, |simd| environment::facing(
                simd,
                (environment, part),
                (draws, shadows),
                surfaces,
                arriving,
                scratch
            ));
            (count, None)
        }
    };
    let mut time = scratch.trace(tracer.stopping_where_dimmed(scene.dims_light()), origin);
    tracer.stopping_where_dimmed(false);
    if scene.dims_light() {
        let start = Instant::now();
        let mut through = std::mem::take(&mut scratch.through);
        through.pass(scene, tracer, (scratch, origin), media, (arriving, power));
        scratch.through = through;
        time += start.elapsed();
    }
    at_level!(level, |simd| take_blocked(simd, arriving, scratch));
    (count, time)
}

/// Fills `arriving` as if nothing were occluded, and `scratch` with the shadow rays, which it counts.
#[inline(always)]
fn facing<S: Simd>(
    simd: S,
    (shape, beam): (&LightShape, Option<&Beam>),
    (draws, shadows): (Draws<'_>, bool),
    surfaces: &[SurfacePacket],
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> u64 {
    let zero = simd.splat(0.0);
    let mut count = 0;
    for (surface_i, s) in surfaces.iter().enumerate() {
        let seen = light::seen(simd, shape, s, draws);
        let n_dot_l = simd.load3(&s.normal).dot(seen.to_light).max(zero);
        arriving.n_dot_l.push(n_dot_l.to8());
        arriving.to_light.push(seen.to_light.to8());
        let mut active = n_dot_l.gt(zero) & simd.mask(s.active);
        if let Some(beam) = beam {
            let share = beam.share(simd, &seen);
            arriving.power.push(beam.power(simd, share));
            active = active & share.gt(zero);
        }
        let position = match *shape {
            LightShape::Point { position } => Some(simd.splat3(position)),
            _ => None,
        };
        if position.is_none() {
            active = active & seen.distance.gt(zero);
        }
        let bits = active.bits();
        if shadows && bits != 0 {
            count += u64::from(bits.count_ones());
            let lift = soft::lift(simd, s, seen.to_light);
            if let Some(position) = position {
                scratch.surface.push(surface_i as u32);
                scratch
                    .rays
                    .push(ray(simd, position, s, (seen.distance, lift), active));
            } else if let Some(on_light) = seen.on_light {
                soft::push_to(simd, scratch, (surface_i, s, lift), on_light, active);
            } else {
                let ray = (seen.to_light, seen.distance);
                soft::push(simd, scratch, (surface_i, s, lift), ray, active);
            }
        }
    }
    count
}

/// Makes the rays from the light to eight points at `distance`, moved off the surface by `lift`; inactive lanes get no ray.
#[inline(always)]
fn ray<S: Simd>(
    simd: S,
    light: Vec3Eight<S>,
    s: &SurfacePacket,
    (distance, lift): (S::V8, S::V8),
    active: <S::V8 as Lanes>::Mask,
) -> RayPacket {
    let offset = distance.mul_add(simd.splat(LIGHT_OFFSET), lift);
    let from_light = simd
        .load3(&s.geometric_normal)
        .mul_add(offset, simd.load3(&s.point))
        - light;
    let length = from_light.dot(from_light).sqrt();
    let zero = simd.splat(0.0);
    // A point at the light gets any direction: its ray of length 0 hits nothing.
    let direction = Vec3Lanes::select(
        length.gt(zero),
        from_light * (simd.splat(1.0) / length),
        simd.splat3(Vec3::Z),
    );
    RayPacket {
        direction: direction.to8(),
        t_max: S::V8::select(active, length, zero).to8(),
    }
}

/// Clears the light where the ray is blocked.
#[inline(always)]
fn take_blocked<S: Simd>(simd: S, arriving: &mut Arriving, scratch: &Scratch) {
    for (i, &surface_i) in scratch.surface.iter().enumerate() {
        let blocked = scratch.blocked[i];
        if blocked != 0 {
            let n_dot_l = &mut arriving.n_dot_l[surface_i as usize];
            let lit = S::V8::select(simd.mask(blocked.into()), simd.splat(0.0), simd.load(n_dot_l));
            *n_dot_l = lit.to8();
        }
    }
}
