//! Lights as seen from surface points: the unit direction and distance to a light or to a random point of it, and the
//! light that arrives.

use super::{
    draw::{Draws, cone},
    surface::SurfacePacket,
};
use crate::{
    lanes::F32x8,
    ray::T_MAX,
    scene::{Light, LightShape},
    simd::{EightLanes, Lanes, Simd, Vec3Eight},
};
use glam::Vec3;

/// A light as seen from eight points.
pub(super) struct Seen<S: Simd> {
    /// Unit directions to the light.
    pub to_light: Vec3Eight<S>,
    /// Distances to it in that direction; not above 0 for points inside a sphere.
    pub distance: S::V8,
    /// The random points of a rectangle.
    pub on_light: Option<Vec3Eight<S>>,
    /// Squared distances for the falloff.
    squared: S::V8,
}

/// Returns a light as seen from the points of `s`; `draws` chooses the points of area lights.
#[inline(always)]
pub(super) fn seen<S: Simd>(simd: S, shape: &LightShape, s: &SurfacePacket, draws: Draws<'_>) -> Seen<S> {
    let from = simd.load3(&s.point);
    match *shape {
        LightShape::Point { position } => towards(simd, simd.splat3(position) - from),
        LightShape::Sphere { center, radius } => {
            let to_center = simd.splat3(center) - from;
            let cone = cone(simd, to_center, radius, draws.points(simd, &s.pixel));
            Seen {
                to_light: cone.direction,
                distance: cone.distance,
                on_light: None,
                squared: to_center.dot(to_center),
            }
        }
        LightShape::Rectangle {
            center,
            edges: [a, b],
        } => {
            let [u, v] = draws.points(simd, &s.pixel);
            let half = simd.splat(0.5);
            let along = simd.splat3(a).mul_add(u - half, simd.splat3(center));
            let point = simd.splat3(b).mul_add(v - half, along);
            Seen {
                on_light: Some(point),
                ..towards(simd, point - from)
            }
        }
        LightShape::Directional { to_light, sine } => {
            let axis = simd.splat3(to_light);
            let to_light = if sine > 0.0 {
                cone(simd, axis, sine, draws.points(simd, &s.pixel)).direction
            } else {
                axis
            };
            let (distance, squared) = (simd.splat(T_MAX), simd.splat(1.0));
            Seen {
                to_light,
                distance,
                on_light: None,
                squared,
            }
        }
    }
}

#[inline(always)]
fn towards<S: Simd>(simd: S, offset: Vec3Eight<S>) -> Seen<S> {
    let squared = offset.dot(offset);
    let distance = squared.sqrt();
    Seen {
        to_light: offset * (simd.splat(1.0) / distance),
        distance,
        on_light: None,
        squared,
    }
}

/// The directional distribution of a light: falloff, cone and cosine.
pub(super) struct Beam {
    light: Light,
    /// The normal of a rectangle's lit side.
    front: Option<Vec3>,
    power: [f32; 3],
}

impl Beam {
    /// Returns `None` for lights whose power is the same everywhere.
    pub fn of(light: &Light) -> Option<Self> {
        (!light.is_even()).then(|| Self {
            light: *light,
            front: light.front(),
            power: light.power(),
        })
    }

    /// Returns the share of the light's power that arrives unoccluded.
    #[inline(always)]
    pub fn share<S: Simd>(&self, simd: S, seen: &Seen<S>) -> S::V8 {
        let (zero, one) = (simd.splat(0.0), simd.splat(1.0));
        let mut share = one;
        if let Some([squared, most]) = self.light.falloff() {
            share = (simd.splat(squared) / seen.squared).min(simd.splat(most));
        }
        if let Some(spot) = &self.light.spot {
            let along = simd.splat3(spot.direction());
            let angle = if spot.is_narrow {
                let apart = seen.to_light + along;
                apart.dot(apart) * simd.splat(0.5)
            } else {
                -along.dot(seen.to_light)
            };
            let in_cone = angle * simd.splat(spot.scale) + simd.splat(spot.offset);
            let in_cone = in_cone.max(zero).min(one);
            share = share * (in_cone * in_cone);
        }
        if let Some(front) = self.front {
            share = share * (-simd.splat3(front).dot(seen.to_light)).max(zero);
        }
        share
    }

    /// Returns a share of the light's intensity times its colour.
    #[inline(always)]
    pub fn power<S: Simd>(&self, simd: S, share: S::V8) -> [F32x8; 3] {
        self.power.map(
            #[inline(always)]
            |channel| (simd.splat(channel) * share).to8(),
        )
    }
}
