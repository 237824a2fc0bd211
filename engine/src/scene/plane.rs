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
mod tests {
    use super::*;

    #[test]
    fn planes_keep_their_place() {
        let far = Vec3::new(8000.5, -5500.25, 100.0);
        let mut builder = SceneBuilder::new();
        builder.add_sphere(far, 1.0, MaterialId(1)).unwrap();
        builder
            .add_plane(Vec3::new(3.0, 4.0, 99.0), Vec3::Z * 7.0, MaterialId(2))
            .unwrap();
        let oblique = Vec3::new(1.0, 2.0, -2.0);
        builder.add_plane(far, oblique, MaterialId(1)).unwrap();
        let scene = builder.finish();
        assert_eq!(scene.origin(), far);
        assert_eq!(scene.planes()[0].point, Vec3::new(0.0, 0.0, -1.0));
        assert_eq!(scene.planes()[0].normal, Vec3::Z);
        assert_eq!(scene.planes()[1].point, Vec3::ZERO);
        assert_eq!((scene.plane_id(1), scene.primitive_count()), (PrimitiveId(2), 1));
        assert_eq!(scene.material_of(PrimitiveId(1)), MaterialId(2));
    }

    #[test]
    fn planes_without_a_normal_are_refused() {
        let mut builder = SceneBuilder::new();
        let mut add = |normal| builder.add_plane(Vec3::ZERO, normal, MaterialId(1));
        assert!(matches!(add(Vec3::ZERO), Err(SceneError::NotPositive { .. })));
        assert!(matches!(add(Vec3::NAN), Err(SceneError::NotUsable { .. })));
        for _ in 0..MAX_PLANES {
            add(Vec3::new(1e-30, 0.0, 1e-30)).unwrap();
        }
        assert!(matches!(add(Vec3::X), Err(SceneError::TooMany { .. })));
    }
}
