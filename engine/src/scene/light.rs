//! Lights: shapes, power, falloff and cones.

use super::{builder::usable, material::check_color};
use crate::{error::SceneError, math};
use glam::{DVec3, Vec3};

/// Upper bound on the factor of falloff near a light.
const MOST_FALLOFF: f32 = 1e9;

/// The least difference of the cosines of a spot's angles: the width of its edge.
const NARROWEST: f64 = 1e-6;

/// That of narrow spots, whose difference of 1 and a cosine is exact.
const NARROWEST_OF_NARROW: f64 = 1e-16;

/// Up to this outer angle, degrees, a spot is narrow: so close to 1, a cosine has too few steps in `f32`.
const NARROW: f32 = 0.5;

/// A light. Lights are invisible and cast no shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Its shape and position.
    pub shape: LightShape,
    /// Intensity I_i: what a white matte surface that faces the light reflects. 0 or more.
    pub intensity: f32,
    /// Colour, linear RGB from 0 to 1.
    pub color: [f32; 3],
    /// The distance at which a light with inverse-square falloff has its intensity, scene units, above 0; `None` without
    /// falloff.
    pub falloff: Option<f32>,
    /// The cone of a spot.
    pub spot: Option<Spot>,
}

/// The shapes of lights. Positions are relative to [`Scene::origin`](super::Scene::origin) in a scene, and in world space
/// before; lengths are in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// A point, with hard shadows.
    Point {
        /// Its position.
        position: Vec3,
    },
    /// A sphere. It lights each point evenly from all directions in which it is seen.
    Sphere {
        /// Its centre.
        center: Vec3,
        /// Its radius, above 0.
        radius: f32,
    },
    /// A rectangle or parallelogram. It shines to the side of `edges[0] x edges[1]`, by the cosine (Lambert).
    Rectangle {
        /// Its centre.
        center: Vec3,
        /// Two of its edges.
        edges: [Vec3; 2],
    },
    /// A light infinitely far away, such as the sun.
    Directional {
        /// The unit vector to the light.
        to_light: Vec3,
        /// Sine of the light's angular radius; 0 for hard shadows.
        sine: f32,
    },
}

/// A cone of light: full within the inner angle, none beyond the outer one, in between the square of a linear function of
/// the angle's cosine, as `KHR_lights_punctual` of glTF recommends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    direction: Vec3,
    /// The share of full light is `(scale * cosine + offset)`, cut to 0 and 1, and squared. Narrow spots have 1 - cosine
    /// instead: half the squared length of the sum of the direction and that to the light.
    pub(crate) scale: f32,
    pub(crate) offset: f32,
    pub(crate) is_narrow: bool,
    degrees: [f32; 2],
}

impl Spot {
    /// Makes a cone around `direction`, from the light, of any length; half angles in degrees.
    ///
    /// # Errors
    /// [`SceneError::NotPositive`] for a direction of length 0; [`SceneError::OutOfRange`] unless 0 <= outer <= 180;
    /// [`SceneError::InnerAngle`] unless 0 <= inner <= outer.
    pub fn new(direction: DVec3, inner_degrees: f32, outer_degrees: f32) -> Result<Self, SceneError> {
        check_range("outer", outer_degrees, (0.0, 180.0))?;
        if !(0.0..=outer_degrees).contains(&inner_degrees) {
            return Err(SceneError::InnerAngle {
                inner: inner_degrees,
                outer: outer_degrees,
            });
        }
        let radians = [inner_degrees, outer_degrees].map(|a| f64::from(a).to_radians());
        let is_narrow = outer_degrees <= NARROW;
        let (scale, offset) = if is_narrow {
            // 1 - cos a = 2 sin^2 (a / 2)
            let [inner, outer] = radians.map(|a| 2.0 * libm::sin(a / 2.0).powi(2));
            let scale = 1.0 / (outer - inner).max(NARROWEST_OF_NARROW);
            (-scale, outer * scale)
        } else {
            let [inner, outer] = radians.map(libm::cos);
            let scale = 1.0 / (inner - outer).max(NARROWEST);
            (scale, -outer * scale)
        };
        Ok(Self {
            direction: unit(direction)?,
            scale: scale as f32,
            offset: offset as f32,
            is_narrow,
            degrees: [inner_degrees, outer_degrees],
        })
    }

    /// Returns the unit vector along the middle of the cone, away from the light.
    #[must_use]
    pub fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Returns the half angles inner and outer, degrees.
    #[must_use]
    pub fn degrees(&self) -> [f32; 2] {
        self.degrees
    }
}

impl LightShape {
    /// Makes a directional light; `to_light` has any length, and `degrees` is the angular diameter.
    ///
    /// # Errors
    /// [`SceneError::NotPositive`] for a direction of length 0, [`SceneError::OutOfRange`] unless the angle is from 0 to
    /// 180.
    pub fn directional(to_light: DVec3, degrees: f32) -> Result<Self, SceneError> {
        check_range("angle", degrees, (0.0, 180.0))?;
        Ok(Self::Directional {
            to_light: unit(to_light)?,
            sine: libm::sin(f64::from(degrees).to_radians() * 0.5) as f32,
        })
    }

    /// Returns the position or centre; `None` for directional lights.
    #[must_use]
    pub fn position(&self) -> Option<Vec3> {
        match *self {
            Self::Point { position } => Some(position),
            Self::Sphere { center, .. } | Self::Rectangle { center, .. } => Some(center),
            Self::Directional { .. } => None,
        }
    }

    /// Returns the unit vector from `point` to the light's position or centre; 0 at it.
    #[must_use]
    pub fn direction_from(&self, point: Vec3) -> Vec3 {
        match *self {
            Self::Directional { to_light, .. } => to_light,
            Self::Point { position: center }
            | Self::Sphere { center, .. }
            | Self::Rectangle { center, .. } => (center - point).normalize_or_zero(),
        }
    }

    /// Returns whether shadows are soft: light comes from many directions.
    #[must_use]
    pub fn is_soft(&self) -> bool {
        match *self {
            Self::Point { .. } => false,
            Self::Sphere { .. } | Self::Rectangle { .. } => true,
            Self::Directional { sine, .. } => sine > 0.0,
        }
    }

    /// Moves it.
    pub(super) fn translate(&mut self, by: Vec3) {
        match self {
            Self::Point { position } => *position += by,
            Self::Sphere { center, .. } | Self::Rectangle { center, .. } => *center += by,
            Self::Directional { .. } => {}
        }
    }
}

impl Light {
    /// Makes a white light of intensity 1 without falloff.
    #[must_use]
    pub fn new(shape: LightShape) -> Self {
        Self {
            shape,
            intensity: 1.0,
            color: [1.0; 3],
            falloff: None,
            spot: None,
        }
    }

    /// Returns the intensity times the colour.
    #[inline]
    #[must_use]
    pub fn power(&self) -> [f32; 3] {
        self.color.map(|channel| self.intensity * channel)
    }

    /// Returns whether the same power arrives at every point that the light reaches.
    #[inline]
    #[must_use]
    pub(crate) fn is_even(&self) -> bool {
        self.falloff.is_none() && self.spot.is_none() && !matches!(self.shape, LightShape::Rectangle { .. })
    }

    /// Returns the squared distance of falloff and the largest factor of it: inside a sphere, that at its surface.
    pub(crate) fn falloff(&self) -> Option<[f32; 2]> {
        let squared = self.falloff.map(|distance| distance * distance)?;
        let most = match self.shape {
            LightShape::Sphere { radius, .. } => (squared / (radius * radius)).min(MOST_FALLOFF),
            _ => MOST_FALLOFF,
        };
        Some([squared, most])
    }

    /// Returns the direction to which a rectangle shines, a unit vector.
    #[must_use]
    pub(crate) fn front(&self) -> Option<Vec3> {
        let LightShape::Rectangle { edges: [a, b], .. } = self.shape else {
            return None;
        };
        unit(a.as_dvec3().cross(b.as_dvec3())).ok()
    }

    /// Checks all numbers, and makes directions unit vectors.
    pub(super) fn checked(mut self) -> Result<Self, SceneError> {
        if let Some(position) = self.shape.position() {
            super::builder::usable_point(position)?;
        }
        match &mut self.shape {
            LightShape::Point { .. } => {}
            &mut LightShape::Sphere { radius, .. } => check_positive("radius", radius)?,
            &mut LightShape::Rectangle { edges, .. } => {
                for edge in edges {
                    super::builder::usable_point(edge)?;
                }
                if self.front().is_none() {
                    return Err(SceneError::NotPositive {
                        what: "area",
                        value: 0.0,
                    });
                }
            }
            LightShape::Directional { to_light, sine } => {
                check_range("sine of half the angle", *sine, (0.0, 1.0))?;
                *to_light = unit(to_light.as_dvec3())?;
            }
        }
        usable("intensity", self.intensity)?;
        if self.intensity < 0.0 {
            return Err(SceneError::Negative {
                what: "intensity",
                value: self.intensity,
            });
        }
        check_color(self.color)?;
        if let Some(distance) = self.falloff {
            check_positive("falloff", distance)?;
        }
        Ok(self)
    }
}

fn unit(direction: DVec3) -> Result<Vec3, SceneError> {
    let unit = math::moderate(direction).try_normalize().map(DVec3::as_vec3);
    unit.ok_or(SceneError::NotPositive {
        what: "length of the direction",
        value: 0.0,
    })
}

fn check_range(what: &'static str, value: f32, range: (f32, f32)) -> Result<(), SceneError> {
    if (range.0..=range.1).contains(&value) {
        return Ok(());
    }
    Err(SceneError::OutOfRange { what, value, range })
}

fn check_positive(what: &'static str, value: f32) -> Result<(), SceneError> {
    usable(what, value)?;
    if value > 0.0 {
        return Ok(());
    }
    Err(SceneError::NotPositive { what, value })
}
