//! One-sided surfaces: rays that look at them from behind pass. Shadow rays and ambient occlusion rays stop at both sides.

use super::{Primitive, Scene};
use crate::ray::{PrimitiveId, Ray, SceneHit};
use glam::Vec3;

impl Scene {
    /// Returns whether any surface is one-sided.
    #[inline]
    #[must_use]
    pub fn has_one_sided(&self) -> bool {
        !self.one_sided.is_empty()
    }

    /// Returns whether a primitive's material is one-sided.
    #[inline]
    #[must_use]
    pub fn is_one_sided(&self, id: PrimitiveId) -> bool {
        let of_material = || self.one_sided.get(self.material_of(id).0 as usize);
        self.has_one_sided() && of_material() == Some(&true)
    }

    /// Returns whether a ray hits the back of a one-sided triangle, where its corners are clockwise.
    #[must_use]
    #[doc(hidden)]
    pub fn shows_back(&self, ray: &Ray, hit: &SceneHit) -> bool {
        if !hit.is_hit() || !self.is_one_sided(hit.primitive) {
            return false;
        }
        match self.instance(hit.instance) {
            // The sides stay what they are in the prototype, mirrored or not.
            Some(instance) => instance
                .image(ray)
                .is_some_and(|image| self.is_back(&image.ray, hit.primitive)),
            None => self.is_back(ray, hit.primitive),
        }
    }

    /// The same of a primitive and a ray in its prototype's space.
    pub(crate) fn is_back(&self, ray: &Ray, id: PrimitiveId) -> bool {
        let Primitive::Triangle(i) = self.primitive(id) else {
            return false;
        };
        let [v0, v1, v2] = self.triangle(i).map(Vec3::as_dvec3);
        self.is_one_sided(id) && (v1 - v0).cross(v2 - v0).dot(ray.direction.as_dvec3()) > 0.0
    }
}
