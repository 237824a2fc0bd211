//! Adding lights.

use super::{MAX_LIGHTS, SceneBuilder, usable};
use crate::{
    error::SceneError,
    scene::{Light, LightShape, material::check_share},
};
use glam::Vec3;

impl SceneBuilder {
    /// Sets the ambient light I_a, the same in all channels.
    ///
    /// # Errors
    /// [`SceneError::OutOfRange`] if it is not from 0 to 1.
    pub fn set_ambient(&mut self, ambient: f32) -> Result<(), SceneError> {
        check_share("ambient", ambient)?;
        self.ambient = ambient;
        Ok(())
    }

    /// Sets the distance within which geometry blocks ambient light (ambient occlusion), scene units, above 0; `None` for
    /// ambient light that reaches every surface.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`] or [`SceneError::NotPositive`].
    pub fn set_ambient_reach(&mut self, reach: Option<f32>) -> Result<(), SceneError> {
        if let Some(reach) = reach {
            usable("reach", reach)?;
            if reach <= 0.0 {
                return Err(SceneError::NotPositive {
                    what: "reach",
                    value: reach,
                });
            }
        }
        self.ambient_reach = reach;
        Ok(())
    }

    /// Sets whether the shadow rays of triangles with vertex normals start on the smooth surface that these stand for, so
    /// that facets do not show where light grazes them. Off by default.
    pub fn set_smooth_shadows(&mut self, smooth_shadows: bool) {
        self.smooth_shadows = smooth_shadows;
    }

    /// Sets whether surfaces with highlights reflect ambient light, too: see
    /// [`Scene::ambient_specular`](crate::scene::Scene::ambient_specular). Off by default.
    pub fn set_ambient_specular(&mut self, ambient_specular: bool) {
        self.ambient_specular = ambient_specular;
    }

    /// Adds a white point light.
    ///
    /// # Errors
    /// As [`SceneBuilder::add`].
    pub fn add_light(&mut self, position: Vec3, intensity: f32) -> Result<(), SceneError> {
        self.add_colored_light(position, intensity, [1.0; 3])
    }

    /// Adds a coloured point light, linear RGB.
    ///
    /// # Errors
    /// As [`SceneBuilder::add`].
    pub fn add_colored_light(
        &mut self,
        position: Vec3,
        intensity: f32,
        color: [f32; 3],
    ) -> Result<(), SceneError> {
        self.add_sphere_light(position, 0.0, intensity, color)
    }

    /// Adds a spherical light, which makes soft shadows; a point light if the radius is 0. Its colour is linear RGB.
    ///
    /// # Errors
    /// As [`SceneBuilder::add`]; [`SceneError::Negative`] for a radius below 0.
    pub fn add_sphere_light(
        &mut self,
        position: Vec3,
        radius: f32,
        intensity: f32,
        color: [f32; 3],
    ) -> Result<(), SceneError> {
        usable("radius", radius)?;
        if radius < 0.0 {
            return Err(SceneError::Negative {
                what: "radius",
                value: radius,
            });
        }
        let center = position;
        let shape = if radius == 0.0 {
            LightShape::Point { position }
        } else {
            LightShape::Sphere { center, radius }
        };
        self.add(Light {
            intensity,
            color,
            ..Light::new(shape)
        })
    }

    /// Adds a light.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::Negative`], [`SceneError::NotPositive`] (a rectangle without area, too),
    /// [`SceneError::OutOfRange`] if a channel is not from 0 to 1, or [`SceneError::TooMany`] above [`MAX_LIGHTS`].
    pub fn add(&mut self, light: Light) -> Result<(), SceneError> {
        let light = light.checked()?;
        if self.lights.len() >= MAX_LIGHTS {
            return Err(SceneError::TooMany {
                what: "lights",
                limit: MAX_LIGHTS,
            });
        }
        self.lights.push(light);
        Ok(())
    }
}
