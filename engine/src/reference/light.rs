//! The scalar version of `shade::light`, with the same operations in the same order.

use super::{
    draw::{by_cosine, cone},
    shade::{SURFACE_OFFSET, Surface},
};
use crate::simd::{Level, at_level};
use crate::{
    math::{max, max_abs, min},
    ray::{Ray, T_MAX},
    scene::{Environment, Light, LightShape},
    simd::Simd,
};
use glam::Vec3;

const LIGHT_OFFSET: f32 = 32.0 / 16_777_216.0;
const STEEPNESS: f32 = 4.0;

/// A light as seen from a point; the fields are those of `shade::light::Seen`.
pub(super) struct Seen {
    pub to_light: Vec3,
    pub distance: f32,
    pub on_light: Option<Vec3>,
    squared: f32,
}

/// Returns a light as seen from `from`; `point` draws a point of the unit square.
#[inline(always)]
pub(super) fn seen<S: Simd>(simd: S, shape: &LightShape, from: Vec3, point: impl Fn() -> [f32; 2]) -> Seen {
    match *shape {
        LightShape::Point { position } => towards(simd, position - from),
        LightShape::Sphere { center, radius } => {
            let to_center = center - from;
            let (to_light, distance) = cone(simd, to_center, radius, point());
            Seen {
                to_light,
                distance,
                on_light: None,
                squared: simd.dot(to_center, to_center),
            }
        }
        LightShape::Rectangle {
            center,
            edges: [a, b],
        } => {
            let [u, v] = point();
            let along = simd.mul_add3(a, u - 0.5, center);
            let point = simd.mul_add3(b, v - 0.5, along);
            Seen {
                on_light: Some(point),
                ..towards(simd, point - from)
            }
        }
        LightShape::Directional { to_light, sine } => Seen {
            to_light: if sine > 0.0 {
                cone(simd, to_light, sine, point()).0
            } else {
                to_light
            },
            distance: T_MAX,
            on_light: None,
            squared: 1.0,
        },
    }
}

#[inline(always)]
fn towards<S: Simd>(simd: S, offset: Vec3) -> Seen {
    let squared = simd.dot(offset, offset);
    let distance = squared.sqrt();
    Seen {
        to_light: offset * (1.0 / distance),
        distance,
        on_light: None,
        squared,
    }
}

/// Returns the unit vector to the centre of a light, and the power that arrives from there unoccluded.
#[doc(hidden)]
pub fn from_middle(light: &Light, from: Vec3) -> (Vec3, [f32; 3]) {
    at_level!(Level::current(), |simd| {
        let seen = seen(simd, &light.shape, from, || [0.5; 2]);
        let share = share(simd, light, &seen);
        (seen.to_light, light.power().map(|power| power * share))
    })
}

/// Returns the share of a light's power that arrives unoccluded.
#[inline(always)]
pub(super) fn share<S: Simd>(simd: S, light: &Light, seen: &Seen) -> f32 {
    let mut share = 1.0;
    if let Some([squared, most]) = light.falloff() {
        share = min(squared / seen.squared, most);
    }
    if let Some(spot) = &light.spot {
        let along = spot.direction();
        let angle = if spot.is_narrow {
            let apart = seen.to_light + along;
            simd.dot(apart, apart) * 0.5
        } else {
            -simd.dot(along, seen.to_light)
        };
        let in_cone = min(max(angle * spot.scale + spot.offset, 0.0), 1.0);
        share *= in_cone * in_cone;
    }
    if let Some(front) = light.front() {
        share *= max(-simd.dot(front, seen.to_light), 0.0);
    }
    share
}

/// Returns a random direction of light from the environment, and its power there.
#[inline(always)]
pub(super) fn from_environment<S: Simd>(
    simd: S,
    environment: &Environment,
    normal: Vec3,
    [u, v]: [f32; 2],
) -> (Vec3, [f32; 3]) {
    let share = environment.light_share();
    let edge = 1.0 - share;
    let direction = if u >= edge {
        environment.sample([(u - edge) / share, v])
    } else {
        by_cosine(simd, normal, [u * (1.0 / edge), v])
    };
    let n_dot_l = max(simd.dot(normal, direction), 0.0);
    (direction, environment.power(direction, n_dot_l))
}

/// Returns how far off the surface shadow rays to the light start.
#[inline(always)]
pub(super) fn lift<S: Simd>(simd: S, s: &Surface, to_light: Vec3) -> f32 {
    let height = simd.dot(s.geometric_normal, to_light);
    let share = min(max(1.0 - height * STEEPNESS, 0.0), 1.0);
    simd.mul_add(share, s.rise, offset(s))
}

/// Returns how far off the surface other rays start.
#[inline(always)]
pub(super) fn offset(s: &Surface) -> f32 {
    s.magnitude * SURFACE_OFFSET
}

/// Returns the shadow ray of a light, and whether it starts there; `None` inside a sphere.
#[inline(always)]
pub(super) fn ray_of<S: Simd>(simd: S, shape: &LightShape, s: &Surface, seen: &Seen) -> Option<(Ray, bool)> {
    let lift = lift(simd, s, seen.to_light);
    match (shape, seen.on_light) {
        (LightShape::Point { position }, _) => Some((shadow_ray(simd, *position, (s, lift)), true)),
        (_, Some(on_light)) => Some((ending_before(simd, (s, lift), on_light), false)),
        _ => (seen.distance > 0.0).then(|| (leaving(simd, (s, lift), seen.to_light, seen.distance), false)),
    }
}

/// Returns the ray from off the surface by `lift`.
#[inline(always)]
pub(super) fn leaving<S: Simd>(simd: S, (s, lift): (&Surface, f32), direction: Vec3, t_max: f32) -> Ray {
    Ray {
        t_max,
        ..Ray::new(simd.mul_add3(s.geometric_normal, lift, s.point), direction)
    }
}

/// Returns the ray from off the surface by `lift` to just before a point of a light.
#[inline(always)]
fn ending_before<S: Simd>(simd: S, (s, lift): (&Surface, f32), on_light: Vec3) -> Ray {
    let origin = simd.mul_add3(s.geometric_normal, lift, s.point);
    let offset = on_light - origin;
    let length = simd.dot(offset, offset).sqrt();
    let margin = simd.mul_add(length, LIGHT_OFFSET, max_abs(on_light) * SURFACE_OFFSET);
    Ray {
        t_max: length - margin,
        ..Ray::new(origin, offset * (1.0 / length))
    }
}

/// Returns the ray from the light to the point, moved off the surface by `lift`.
#[inline(always)]
fn shadow_ray<S: Simd>(simd: S, light: Vec3, (s, lift): (&Surface, f32)) -> Ray {
    let to_light = light - s.point;
    let distance = simd.dot(to_light, to_light).sqrt();
    let offset = simd.mul_add(distance, LIGHT_OFFSET, lift);
    let from_light = simd.mul_add3(s.geometric_normal, offset, s.point) - light;
    let length = simd.dot(from_light, from_light).sqrt();
    Ray {
        origin: light,
        direction: from_light * (1.0 / length),
        t_max: length,
    }
}
