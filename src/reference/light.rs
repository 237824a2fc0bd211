//! The scalar twin of `shade::light`, with the same operations in the same order.

use super::draw::{by_cosine, cone};
#[cfg(feature = "viewer")]
use crate::simd::{Level, at_level};
use crate::{
    math::{max, min},
    ray::T_MAX,
    scene::{Environment, Light, LightShape, MOST_FALLOFF},
    simd::Simd,
};
use glam::Vec3;

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

/// Returns the unit vector to the middle of a light, and the power that arrives from there if nothing is between.
#[cfg(feature = "viewer")]
pub(crate) fn from_middle(light: &Light, from: Vec3) -> (Vec3, [f32; 3]) {
    at_level!(Level::current(), |simd| {
        let seen = seen(simd, &light.shape, from, || [0.5; 2]);
        let share = share(simd, light, &seen);
        (seen.to_light, light.power().map(|power| power * share))
    })
}

/// Returns the share of a light's power that arrives if nothing is between.
#[inline(always)]
pub(super) fn share<S: Simd>(simd: S, light: &Light, seen: &Seen) -> f32 {
    let mut share = 1.0;
    if let Some(distance) = light.falloff {
        share = min(distance * distance / seen.squared, MOST_FALLOFF);
    }
    if let Some(spot) = &light.spot {
        let cosine = -simd.dot(spot.direction(), seen.to_light);
        let in_cone = min(max(cosine * spot.scale + spot.offset, 0.0), 1.0);
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
    let twice = u + u;
    let direction = if twice >= 1.0 {
        environment.sample([twice - 1.0, v])
    } else {
        by_cosine(simd, normal, [twice, v])
    };
    let n_dot_l = max(simd.dot(normal, direction), 0.0);
    (direction, environment.power(direction, n_dot_l))
}
