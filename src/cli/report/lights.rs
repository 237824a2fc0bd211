//! The lights of a scene, as statements of the scene language and as JSON.

use super::{info::list, positions::Positions};
use crate::scene::{Light, LightShape, Scene};
use serde::Serialize;

#[derive(Debug, Serialize)]
pub(super) struct LightInfo {
    /// `null` for directional lights, like other fields that do not apply.
    position: Option<[f64; 3]>,
    intensity: f32,
    color: [f32; 3],
    /// 0 for all but spheres.
    radius: f32,
    /// Two edges of a rectangle.
    rectangle: Option<[[f32; 3]; 2]>,
    /// The unit vector to a directional light.
    direction: Option<[f32; 3]>,
    /// Angular diameter of a directional light, degrees.
    angle: Option<f32>,
    falloff: Option<f32>,
    spot: Option<SpotInfo>,
}

#[derive(Debug, Serialize)]
struct SpotInfo {
    direction: [f32; 3],
    /// Half angles inner and outer, degrees.
    angles: [f32; 2],
}

pub(super) fn lights(scene: &Scene) -> Vec<LightInfo> {
    let positions = Positions::of(scene);
    let one = |light: &Light| {
        let mut info = LightInfo {
            position: light
                .shape
                .position()
                .map(|p| positions.within(p + scene.origin())),
            intensity: light.intensity,
            color: light.color,
            radius: 0.0,
            rectangle: None,
            direction: None,
            angle: None,
            falloff: light.falloff,
            spot: light.spot.map(|spot| SpotInfo {
                direction: spot.direction().to_array(),
                angles: spot.degrees(),
            }),
        };
        match light.shape {
            LightShape::Point { .. } => {}
            LightShape::Sphere { radius, .. } => info.radius = radius,
            LightShape::Rectangle { edges, .. } => info.rectangle = Some(edges.map(|edge| edge.to_array())),
            LightShape::Directional { to_light, sine } => {
                info.direction = Some(to_light.to_array());
                info.angle = Some(shortened(libm::asin(f64::from(sine)).to_degrees() * 2.0));
            }
        }
        info
    };
    scene.lights().iter().map(one).collect()
}

/// To a thousandth: angles are kept as cosines in `f32`.
fn shortened(degrees: f64) -> f32 {
    ((degrees * 1e3).round() * 1e-3) as f32
}

impl LightInfo {
    pub(super) fn text(&self) -> String {
        let mut text = match (self.position, self.direction) {
            (Some(position), _) => format!("light {} {}", list(position), self.intensity),
            (None, Some(direction)) => format!("directional_light {} {}", list(direction), self.intensity),
            (None, None) => String::new(),
        };
        if self.color != [1.0; 3] {
            text += &format!(" color {}", list(self.color));
        }
        if self.radius > 0.0 {
            text += &format!(" radius {}", self.radius);
        }
        if let Some([a, b]) = self.rectangle {
            text += &format!(" rectangle {} {}", list(a), list(b));
        }
        if let Some(angle) = self.angle.filter(|&angle| angle > 0.0) {
            text += &format!(" angle {angle}");
        }
        if let Some(distance) = self.falloff {
            text += &format!(" falloff {distance}");
        }
        if let Some(spot) = &self.spot {
            let [inner, outer] = spot.angles;
            text += &format!(" spot {} {inner} {outer}", list(spot.direction));
        }
        text
    }
}
