//! Rays for the kernels: unit directions in `f32`, relative to the scene's origin, t as a distance.
//!
//! The reported t is the distance divided by the direction's length in `f64`, rounded once.

use super::{Ray, rays::EightRays};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{self, RayPacket, T_MAX},
};
use glam::DVec3;

/// Squared lengths between these lose nothing to underflow and overflow.
const ORDINARY: std::ops::Range<f64> = 1e-250..1e250;

/// A ray for the kernels.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct UnitRay {
    /// Ends at the first distance that is not before the original ray's end.
    pub ray: ray::Ray,
    /// Hits up to this distance are before the beginning.
    pub start: f32,
    /// The length of the original direction.
    pub length: f64,
}

/// Eight of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnitPacket {
    pub origin: Vec3x8,
    pub rays: RayPacket,
    pub start: [f32; LANES],
    pub length: [f64; LANES],
}

/// Returns the t that is reported for a hit at this distance.
#[inline(always)]
pub(super) fn reported(distance: f32, length: f64) -> f32 {
    (f64::from(distance) / length) as f32
}

/// Returns the length of a vector whose square is `squared`.
#[inline(always)]
fn length_of(vector: DVec3, squared: f64) -> f64 {
    if ORDINARY.contains(&squared) {
        squared.sqrt()
    } else {
        scaled_length(vector)
    }
}

#[cold]
fn scaled_length(vector: DVec3) -> f64 {
    let largest = vector.abs().max_element();
    (vector / largest).length() * largest
}

/// Returns the smallest distance that is reported as `t` or more.
#[inline(always)]
fn end_of(t: f32, length: f64) -> f32 {
    if t <= 0.0 {
        return 0.0;
    }
    if t == f32::INFINITY && length >= 0.5 {
        return T_MAX;
    }
    // Quotients from the middle between `t` and the number before it on are rounded to `t` or more.
    let above = if t == f32::INFINITY {
        TWO_TO_128
    } else {
        f64::from(t)
    };
    let end = 0.5 * (f64::from(t.next_down()) + above) * length;
    let nearest = end as f32;
    if nearest < f32::MIN_POSITIVE || (f64::from(nearest) - end).abs() <= end * DOUBT {
        return searched_end(t, length);
    }
    // The next number if it is below; not a branch, because nothing predicts it.
    f32::from_bits(nearest.to_bits() + u32::from(f64::from(nearest) < end)).min(T_MAX)
}

/// What `f32` would hold above its largest number.
const TWO_TO_128: f64 = 340_282_366_920_938_463_463_374_607_431_768_211_456.0;

/// More than the rounding of a product and a quotient in `f64`, as a fraction of either.
const DOUBT: f64 = 4.0 * f64::EPSILON;

/// By bisection, starting at the product: the quotient grows with the distance, rounding included.
#[cold]
fn searched_end(t: f32, length: f64) -> f32 {
    let reaches = |bits: u32| reported(f32::from_bits(bits), length) >= t;
    let guess = ((f64::from(t) * length) as f32).min(T_MAX).to_bits();
    let (mut below, mut above) = (0, T_MAX.to_bits());
    if guess > 2 && !reaches(guess - 2) {
        below = guess - 2;
    }
    if guess + 2 < above && reaches(guess + 2) {
        above = guess + 2;
    }
    while above - below > 1 {
        let middle = below + (above - below) / 2;
        if reaches(middle) {
            above = middle;
        } else {
            below = middle;
        }
    }
    f32::from_bits(above)
}

/// Returns the largest distance that is not reported as more than `t`, which is at least 0.
#[inline(always)]
pub(super) fn last_reported_as(t: f32, length: f64) -> f32 {
    end_of(t.next_up(), length).next_down()
}

/// Directions up to this length do not round t to 0 for any relevant distance, those above 1e-25.
const LONG: f64 = 1e20;

/// Returns the largest distance that is not reported as more than `t`.
#[inline(always)]
fn start_of(t: f32, length: f64) -> f32 {
    if t > 0.0 || length > LONG {
        last_reported_as(t.max(0.0), length)
    } else {
        0.0
    }
}

/// Returns both ends as distances; NaN makes the ray invalid.
#[inline(always)]
fn ends(t_min: f32, t_max: f32, length: f64) -> (f32, f32) {
    if t_min.is_nan() || t_max.is_nan() || length.is_nan() {
        return (0.0, f32::NAN);
    }
    (start_of(t_min, length), end_of(t_max, length))
}

impl UnitRay {
    /// Makes one of a ray in world space; `middle` is the scene's origin.
    #[inline(always)]
    #[doc(hidden)]
    pub fn new(ray: &Ray, middle: DVec3) -> Self {
        let direction = ray.direction.as_dvec3();
        Self::of(ray.origin.as_dvec3() - middle, direction, [ray.t_min, ray.t_max])
    }

    /// Makes one of an origin relative to the scene's.
    #[inline(always)]
    pub(super) fn of(origin: DVec3, direction: DVec3, [t_min, t_max]: [f32; 2]) -> Self {
        let length = length_of(direction, squared(direction.x, direction.y, direction.z));
        let (start, t_max) = ends(t_min, t_max, length);
        Self {
            ray: ray::Ray {
                origin: origin.as_vec3(),
                direction: (direction * (1.0 / length)).as_vec3(),
                t_max,
            },
            start,
            length,
        }
    }
}

#[inline(always)]
fn squared(x: f64, y: f64, z: f64) -> f64 {
    x * x + y * y + z * z
}

impl UnitPacket {
    /// Makes eight at once, in loops that vectorise.
    #[inline(always)]
    pub(super) fn new(from: &EightRays, middle: DVec3) -> Self {
        let [x, y, z] = &from.direction;
        let (mut length, mut is_ordinary) = ([0.0; LANES], true);
        for lane in 0..LANES {
            let squared = squared(x[lane], y[lane], z[lane]);
            is_ordinary &= ORDINARY.contains(&squared);
            length[lane] = squared.sqrt();
        }
        if !is_ordinary {
            for lane in 0..LANES {
                let direction = DVec3::new(x[lane], y[lane], z[lane]);
                length[lane] = length_of(direction, squared(x[lane], y[lane], z[lane]));
            }
        }
        let (middle, mut inverse) = (middle.to_array(), [0.0; LANES]);
        for lane in 0..LANES {
            inverse[lane] = 1.0 / length[lane];
        }
        let (mut direction, mut origin) = ([[0.0; LANES]; 3], [[0.0; LANES]; 3]);
        for axis in 0..3 {
            for lane in 0..LANES {
                direction[axis][lane] = (from.direction[axis][lane] * inverse[lane]) as f32;
                origin[axis][lane] = (from.origin[axis][lane] - middle[axis]) as f32;
            }
        }
        let (mut start, mut t_max, mut is_open) = ([0.0; LANES], [T_MAX; LANES], true);
        for lane in 0..LANES {
            is_open &= from.t_min[lane] == 0.0
                && from.t_max[lane] == f32::INFINITY
                && (0.5..LONG).contains(&length[lane]);
        }
        if !is_open {
            for lane in 0..LANES {
                (start[lane], t_max[lane]) = ends(from.t_min[lane], from.t_max[lane], length[lane]);
            }
        }
        Self {
            origin: columns(origin),
            rays: RayPacket {
                direction: columns(direction),
                t_max: F32x8::new(t_max),
            },
            start,
            length,
        }
    }

    /// Returns one of the eight.
    pub(super) fn ray(&self, lane: usize) -> UnitRay {
        UnitRay {
            ray: self.rays.ray(lane, self.origin.lane(lane)),
            start: self.start[lane],
            length: self.length[lane],
        }
    }
}

#[inline(always)]
fn columns([x, y, z]: [[f32; LANES]; 3]) -> Vec3x8 {
    Vec3x8 {
        x: F32x8::new(x),
        y: F32x8::new(y),
        z: F32x8::new(z),
    }
}

#[cfg(test)]
mod tests;
