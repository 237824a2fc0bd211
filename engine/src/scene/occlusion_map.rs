//! Occlusion maps: how much light from all around reaches a point, as an image (glTF 2.0, section 3.9.3).

use super::{Primitive, Scene, Texture, TexturePoint, material::check_range, texture::Lookup};
use crate::error::SceneError;

/// An image whose red says which share of ambient light and of the environment reaches a surface, made by
/// [`Image::of_numbers`](super::Image::of_numbers).
///
/// It does not change the light of lamps, what mirrors show, or emission. Only triangles with texture coordinates use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionMap {
    /// The image.
    pub texture: Texture,
    /// From 0, without effect, to 1.
    pub strength: f32,
}

impl OcclusionMap {
    pub(super) fn check(&self) -> Result<(), SceneError> {
        check_range("strength of an occlusion map", self.strength, (0.0, 1.0))
    }
}

impl Scene {
    /// Returns the factor of ambient light and of the environment's light that the map gives at a hit. Both modes call it.
    #[must_use]
    pub fn occlusion(&self, map: &OcclusionMap, point: &TexturePoint) -> f32 {
        let Primitive::Triangle(i) = self.primitive(point.hit.primitive) else {
            return 1.0;
        };
        let [red, ..] = Lookup::new(self, i, point).color(self, map.texture);
        1.0 + map.strength * (red - 1.0)
    }
}
