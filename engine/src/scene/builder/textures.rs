//! Adding images, and materials that show them.

use super::SceneBuilder;
use crate::{
    error::SceneError,
    scene::{Image, Material, MaterialId, SurfaceTextures},
};

impl SceneBuilder {
    /// Adds an image and returns its index.
    ///
    /// # Errors
    /// [`SceneError::OverLimit`].
    pub fn add_image(&mut self, image: Image) -> Result<u32, SceneError> {
        let needed = self.image_bytes + Image::bytes(image.size()) as u64;
        if needed > self.memory {
            let limit = self.memory;
            return Err(SceneError::OverLimit { needed, limit });
        }
        self.image_bytes = needed;
        self.images.push(image);
        Ok(self.images.len() as u32 - 1)
    }

    /// Adds a material with textures, emission or opacity, even if an equal one exists. Glass ignores the opacity
    /// and the normal map.
    ///
    /// # Errors
    /// As [`SceneBuilder::add_material`]; also [`SceneError::UnknownImage`].
    pub fn add_textured_material(
        &mut self,
        material: Material,
        mut textures: SurfaceTextures,
    ) -> Result<MaterialId, SceneError> {
        if matches!(material, Material::Glass { .. }) {
            textures.opacity = None;
            textures.normal_map = None;
        }
        if textures == SurfaceTextures::NONE {
            return self.add_material(material);
        }
        material.check()?;
        textures.check(self.images.len())?;
        let id = self.push_material(material)?;
        self.textures.resize(id.0 as usize, None);
        self.textures.push(Some(textures));
        Ok(id)
    }
}
