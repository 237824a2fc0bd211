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

    /// Adds a material with textures, emission or opacity, even if an equal one exists. Glass ignores the opacity,
    /// the normal map and the occlusion map.
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
            textures.occlusion_map = None;
        }
        // Kept apart: scenes without textures skip their pass.
        let one_sided = std::mem::take(&mut textures.one_sided);
        let id = if textures == SurfaceTextures::NONE {
            self.add_sided_material(material, one_sided)?
        } else {
            material.check()?;
            textures.check(self.images.len())?;
            let id = self.push_material(material)?;
            self.textures.resize(id.0 as usize, None);
            self.textures.push(Some(textures));
            id
        };
        if one_sided {
            let count = self.one_sided.len().max(id.0 as usize + 1);
            self.one_sided.resize(count, false);
            self.one_sided[id.0 as usize] = true;
        }
        Ok(id)
    }
}
