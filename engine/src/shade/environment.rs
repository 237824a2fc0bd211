//! Light of the environment: one random direction for each point and sample, by cosine or light importance sampling, and
//! another one to the suns, if there are any.

use super::{
    draw::{Draws, by_cosine},
    shadow::{Arriving, Scratch},
    soft,
    surface::SurfacePacket,
};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::T_MAX,
    scene::Environment,
    simd::{EightLanes, LaneMask, Lanes, Simd},
};

/// A part of an environment's light.
#[derive(Clone, Copy)]
pub(super) enum Part {
    /// All but its suns.
    Rest,
    Suns,
}

/// Fills `arriving` as if nothing were occluded, and `scratch` with the shadow rays, which it counts.
#[inline(always)]
pub(super) fn facing<S: Simd>(
    simd: S,
    (environment, part): (&Environment, Part),
    (draws, shadows): (Draws<'_>, bool),
    surfaces: &[SurfacePacket],
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> u64 {
    let zero = simd.splat(0.0);
    let mut count = 0;
    for (surface_i, s) in surfaces.iter().enumerate() {
        let point = draws.points(simd, &s.pixel);
        let (direction, power) = match part {
            Part::Rest => rest(simd, environment, s, point),
            Part::Suns => suns(environment, point),
        };
        let to_light = simd.load3(&direction);
        let n_dot_l = simd.load3(&s.normal).dot(to_light).max(zero);
        arriving.n_dot_l.push(n_dot_l.to8());
        arriving.to_light.push(direction);
        arriving.power.push(power);
        let active = n_dot_l.gt(zero) & simd.mask(s.active);
        let bits = active.bits();
        if shadows && bits != 0 {
            count += u64::from(bits.count_ones());
            let ray = (to_light, simd.splat(T_MAX));
            let lift = soft::lift(simd, s, to_light);
            soft::push(simd, scratch, (surface_i, s, lift), ray, active);
        }
    }
    count
}

/// Directions, and the light from there.
#[inline(always)]
fn rest<S: Simd>(
    simd: S,
    environment: &Environment,
    s: &SurfacePacket,
    point: [S::V8; 2],
) -> (Vec3x8, [F32x8; 3]) {
    let direction = drawn(simd, environment, s, point);
    let n_dot_l = simd.load3(&s.normal).dot(simd.load3(&direction));
    let n_dot_l = n_dot_l.max(simd.splat(0.0)).to8();
    let mut power = [F32x8::ZERO; 3];
    for lane in 0..LANES {
        let one = environment.power(direction.lane(lane), n_dot_l.as_array()[lane]);
        set(power.each_mut(), lane, one);
    }
    (direction, power)
}

/// Directions to the suns, and the light from there.
#[inline(always)]
fn suns<V: EightLanes>(environment: &Environment, [u, v]: [V; 2]) -> (Vec3x8, [F32x8; 3]) {
    let (u, v) = (u.to8(), v.to8());
    let (mut direction, mut power) = (Vec3x8::default(), [F32x8::ZERO; 3]);
    for lane in 0..LANES {
        let (to_sun, light) = environment.sample_suns([u.as_array()[lane], v.as_array()[lane]]);
        set(axes(&mut direction), lane, to_sun.to_array());
        set(power.each_mut(), lane, light);
    }
    (direction, power)
}

/// Returns directions: the left part of the unit square samples by the cosine, the right one by the environment.
#[inline(always)]
fn drawn<S: Simd>(simd: S, environment: &Environment, s: &SurfacePacket, [u, v]: [S::V8; 2]) -> Vec3x8 {
    let share = environment.light_share();
    let edge = 1.0 - share;
    let in_part = u * simd.splat(1.0 / edge);
    let mut directions = by_cosine(simd, simd.load3(&s.normal), [in_part, v]).to8();
    let (u, v) = (u.to8(), v.to8());
    for lane in 0..LANES {
        let (u, v) = (u.as_array()[lane], v.as_array()[lane]);
        if u >= edge {
            let direction = environment.sample([(u - edge) / share, v]);
            set(axes(&mut directions), lane, direction.to_array());
        }
    }
    directions
}

#[inline(always)]
fn axes(vectors: &mut Vec3x8) -> [&mut F32x8; 3] {
    [&mut vectors.x, &mut vectors.y, &mut vectors.z]
}

#[inline(always)]
fn set(channels: [&mut F32x8; 3], lane: usize, values: [f32; 3]) {
    for (channel, value) in channels.into_iter().zip(values) {
        channel.as_mut_array()[lane] = value;
    }
}
