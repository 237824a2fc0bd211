//! Light of the environment: one random direction for each point and sample, drawn by the cosine or by the light itself. If
//! there are suns, another one to them.

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
use glam::Vec3;

/// Fills `arriving` as if nothing were occluded, and `scratch` with the shadow rays, which it counts.
#[inline(always)]
pub(super) fn facing<S: Simd>(
    simd: S,
    environment: &Environment,
    (draws, shadows): (Draws<'_>, bool),
    surfaces: &[SurfacePacket],
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> u64 {
    let zero = simd.splat(0.0);
    let mut count = 0;
    for (surface_i, s) in surfaces.iter().enumerate() {
        let point = draws.points(simd, &s.pixel);
        let direction = drawn(simd, environment, s, point);
        let to_light = simd.load3(&direction);
        let n_dot_l = simd.load3(&s.normal).dot(to_light).max(zero);
        let cosines = n_dot_l.to8();
        let mut power = [F32x8::ZERO; 3];
        for lane in 0..LANES {
            let one = environment.power(direction.lane(lane), cosines.as_array()[lane]);
            for (channel, value) in power.iter_mut().zip(one) {
                channel.as_mut_array()[lane] = value;
            }
        }
        count += push(
            simd,
            (surface_i, s),
            (direction, n_dot_l, power),
            shadows,
            (arriving, scratch),
        );
    }
    count
}

/// Does [`facing`] for the suns.
#[inline(always)]
pub(super) fn facing_suns<S: Simd>(
    simd: S,
    environment: &Environment,
    (draws, shadows): (Draws<'_>, bool),
    surfaces: &[SurfacePacket],
    arriving: &mut Arriving,
    scratch: &mut Scratch,
) -> u64 {
    let mut count = 0;
    for (surface_i, s) in surfaces.iter().enumerate() {
        let [u, v] = draws.points(simd, &s.pixel);
        let (u, v) = (u.to8(), v.to8());
        let (mut direction, mut power) = (Vec3x8::default(), [F32x8::ZERO; 3]);
        for lane in 0..LANES {
            let (to_sun, light) = environment.sample_suns([u.as_array()[lane], v.as_array()[lane]]);
            set(&mut direction, lane, to_sun);
            for (channel, value) in power.iter_mut().zip(light) {
                channel.as_mut_array()[lane] = value;
            }
        }
        let n_dot_l = simd
            .load3(&s.normal)
            .dot(simd.load3(&direction))
            .max(simd.splat(0.0));
        count += push(
            simd,
            (surface_i, s),
            (direction, n_dot_l, power),
            shadows,
            (arriving, scratch),
        );
    }
    count
}

/// Adds the light from directions, and their shadow rays, which it counts.
#[inline(always)]
fn push<S: Simd>(
    simd: S,
    (surface_i, s): (usize, &SurfacePacket),
    (direction, n_dot_l, power): (Vec3x8, S::V8, [F32x8; 3]),
    shadows: bool,
    (arriving, scratch): (&mut Arriving, &mut Scratch),
) -> u64 {
    arriving.n_dot_l.push(n_dot_l.to8());
    arriving.to_light.push(direction);
    arriving.power.push(power);
    let active = n_dot_l.gt(simd.splat(0.0)) & simd.mask(s.active);
    let bits = active.bits();
    if shadows && bits != 0 {
        let ray = (simd.load3(&direction), simd.splat(T_MAX));
        soft::push(simd, scratch, (surface_i, s), ray, active);
        return u64::from(bits.count_ones());
    }
    0
}

/// Returns directions: the left part of the unit square draws by the cosine, the other by the environment.
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
            set(&mut directions, lane, environment.sample([(u - edge) / share, v]));
        }
    }
    directions
}

#[inline(always)]
fn set(vectors: &mut Vec3x8, lane: usize, vector: Vec3) {
    vectors.x.as_mut_array()[lane] = vector.x;
    vectors.y.as_mut_array()[lane] = vector.y;
    vectors.z.as_mut_array()[lane] = vector.z;
}
