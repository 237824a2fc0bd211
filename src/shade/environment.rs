//! Light of the environment: one random direction for each point and sample, drawn by the cosine or by the light itself.

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
        arriving.n_dot_l.push(cosines);
        arriving.to_light.push(direction);
        arriving.power.push(power);
        let active = n_dot_l.gt(zero) & simd.mask(s.active);
        let bits = active.bits();
        if shadows && bits != 0 {
            count += u64::from(bits.count_ones());
            let ray = (to_light, simd.splat(T_MAX));
            soft::push(simd, scratch, (surface_i, s), ray, active);
        }
    }
    count
}

/// Returns directions: the first half of the unit square draws by the cosine, the other by the environment.
#[inline(always)]
fn drawn<S: Simd>(simd: S, environment: &Environment, s: &SurfacePacket, [u, v]: [S::V8; 2]) -> Vec3x8 {
    let twice = u + u;
    let mut directions = by_cosine(simd, simd.load3(&s.normal), [twice, v]).to8();
    let (u, v) = (twice.to8(), v.to8());
    for lane in 0..LANES {
        let (u, v) = (u.as_array()[lane], v.as_array()[lane]);
        if u >= 1.0 {
            let direction = environment.sample([u - 1.0, v]);
            directions.x.as_mut_array()[lane] = direction.x;
            directions.y.as_mut_array()[lane] = direction.y;
            directions.z.as_mut_array()[lane] = direction.z;
        }
    }
    directions
}
