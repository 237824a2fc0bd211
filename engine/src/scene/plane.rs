//! Infinite planes. They are in no BVH and not in the scene's bounds.

use super::{MaterialId, Scene, SceneBuilder, is_usable};
use crate::{error::SceneError, ray::PrimitiveId};
use glam::Vec3;

/// The most planes of a scene: every ray is tested against each.
pub const MAX_PLANES: usize = 64;

/// An infinite plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Plane {
    /// Its point nearest to the scene's origin, relative to it, scene units.
    pub point: Vec3,
    /// A unit normal.
    pub normal: Vec3,
    /// Its material.
    pub material: MaterialId,
}

impl Plane {
    /// Returns the plane relative to `origin`, with the point nearest to it.
    fn relative_to(self, origin: Vec3) -> Self {
        let normal = self.normal.as_dvec3();
        let height = normal.dot(self.point.as_dvec3() - origin.as_dvec3()) / normal.length_squared();
        Self {
            point: (normal * height).as_vec3(),
            ..self
        }
    }
}

impl SceneBuilder {
    /// Adds the plane through `point` with that normal, of any length. Both sides look the same.
    ///
    /// # Errors
    /// [`SceneError::NotUsable`], [`SceneError::NotPositive`] for a normal of 0, [`SceneError::UnknownMaterial`] or
    /// [`SceneError::TooMany`].
    pub fn add_plane(&mut self, point: Vec3, normal: Vec3, material: MaterialId) -> Result<(), SceneError> {
        for (axis, value) in ["x", "y", "z", "x", "y", "z"]
            .into_iter()
            .zip(point.to_array().into_iter().chain(normal.to_array()))
        {
            if !is_usable(value) {
                return Err(SceneError::NotUsable { what: axis, value });
            }
        }
        self.check_material(material)?;
        if self.planes.len() >= MAX_PLANES {
            return Err(SceneError::TooMany {
                what: "planes",
                limit: MAX_PLANES,
            });
        }
        let normal = normal.as_dvec3().try_normalize();
        let normal = normal.ok_or(SceneError::NotPositive {
            what: "length of the normal",
            value: 0.0,
        })?;
        self.planes.push(Plane {
            point,
            normal: normal.as_vec3(),
            material,
        });
        Ok(())
    }
}

impl Scene {
    /// Returns the planes, in the order of their addition. Their ids follow those of all primitives.
    #[inline]
    #[must_use]
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Returns the id of plane `i`.
    #[inline]
    #[must_use]
    pub fn plane_id(&self, i: usize) -> PrimitiveId {
        PrimitiveId((self.primitive_count() + i) as u32)
    }

    /// Makes the planes relative to the scene's origin.
    pub(super) fn move_planes(&mut self) {
        for plane in &mut self.planes {
            *plane = plane.relative_to(self.origin);
        }
    }
}

#[cfg(test)]
mod tests;
