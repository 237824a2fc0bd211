//! Scales the lights of a file, which have physical units that need a camera's exposure.

use super::LoadedMesh;
use crate::{
    error::SceneError,
    math::Aabb,
    scene::{Light, MAX_COORDINATE, PlacedMesh, Spot, Transform},
};
use glam::DVec3;

/// Returns the middle of a box, and half its diagonal; those of a unit sphere if it is empty.
pub(crate) fn sphere_around(bounds: &Aabb) -> (DVec3, f64) {
    if bounds.is_empty() {
        return (DVec3::ZERO, 1.0);
    }
    let center = (bounds.lower.as_dvec3() + bounds.upper.as_dvec3()) * 0.5;
    let radius = (bounds.upper.as_dvec3() - bounds.lower.as_dvec3()).length() * 0.5;
    // A single point needs some room, too.
    (center, if radius > 0.0 { radius } else { 1e-6 })
}

/// Returns lights scaled by the factor at which those of `reference` have the total intensity `together` at the centre of a
/// mesh. Empty if these give no light there.
pub(crate) fn exposed(
    lights: &[Light],
    reference: &[Light],
    together: f32,
    (center, radius): (DVec3, f64),
) -> Vec<Light> {
    let arriving = |light: &Light| {
        let [r, g, b] = light.color;
        let reaches = light
            .spot
            .is_none_or(|spot| reaches(light, &spot, center, radius));
        let intensity = f64::from(light.intensity * f32::from(reaches)) * f64::from(r.max(g).max(b));
        let distance = light.shape.position().map(|position| {
            // A light in the middle would leave the rest dark.
            position.as_dvec3().distance(center).max(0.5 * radius)
        });
        (intensity / distance.map_or(1.0, |d| d * d), distance)
    };
    let sum: f64 = reference.iter().map(|light| arriving(light).0).sum();
    if sum <= 0.0 {
        return Vec::new();
    }
    let one = |light: &Light| {
        let [r, g, b] = light.color;
        let (intensity, distance) = arriving(light);
        let scale = f64::from(together) / (sum * f64::from(r.max(g).max(b)));
        Light {
            intensity: if intensity > 0.0 {
                (intensity * scale) as f32
            } else {
                0.0
            },
            falloff: distance.map(|distance| distance.min(f64::from(MAX_COORDINATE)) as f32),
            ..*light
        }
    };
    lights.iter().map(one).collect()
}

/// Whether any of a sphere is in the cone of a light.
fn reaches(light: &Light, spot: &Spot, center: DVec3, radius: f64) -> bool {
    let Some(position) = light.shape.position() else {
        return true;
    };
    let to_center = center - position.as_dvec3();
    let distance = to_center.length();
    if distance <= radius {
        return true;
    }
    let [_, outer] = spot.degrees().map(f64::from);
    let off_axis = spot.direction().as_dvec3().angle_between(to_center);
    off_axis - libm::asin(radius / distance) < outer.to_radians()
}

impl LoadedMesh {
    /// Returns the lights of a placed mesh, scaled to the total intensity `together` at its centre. Empty if they give no light
    /// there.
    pub(in crate::format) fn placed_lights(
        &self,
        transform: &Transform,
        together: f32,
    ) -> Result<Vec<Light>, SceneError> {
        if self.lights.is_empty() {
            return Ok(Vec::new());
        }
        let (center, radius) = sphere_around(&PlacedMesh::bounds(&self.placed()));
        let lights: Result<Vec<Light>, _> = self.lights.iter().map(|light| transform.light(light)).collect();
        let lights = lights?;
        Ok(exposed(
            &lights,
            &lights,
            together,
            transform.sphere(center, radius),
        ))
    }
}
