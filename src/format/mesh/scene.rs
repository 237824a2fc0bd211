//! From meshes to scenes: their colours, materials and triangles.

use super::{Cloud, LoadedMesh, SharedMesh, Surface};
use crate::{
    error::SceneError,
    format::textures::used_surfaces,
    math::srgb,
    scene::{Curve, MaterialId, SceneBuilder, TriangleMesh},
};
use rayon::prelude::*;

impl LoadedMesh {
    /// Gives all of the mesh one surface, and no other colours.
    pub fn paint(&mut self, surface: Surface) {
        self.show_only_colors(surface);
        self.leave_out_colors();
    }

    /// Gives all of the mesh one surface, and no other colours but those of its vertices.
    pub(crate) fn show_only_colors(&mut self, surface: Surface) {
        self.surfaces = vec![surface];
        self.surface_of = Vec::new();
        for part in &mut self.shared {
            part.surface_of = Vec::new();
        }
        self.images = Vec::new();
        for columns in self.arrays_mut() {
            (columns.uvs, columns.tangents) = Default::default();
        }
    }

    fn leave_out_colors(&mut self) {
        for columns in self.arrays_mut() {
            (columns.colors, columns.uvs, columns.tangents) = Default::default();
        }
    }

    /// Converts the display values of all colours and images to linear light, for pictures that are written with the sRGB curve.
    pub fn linearize(&mut self) {
        let linear = |color: &mut [f32; 3]| {
            for channel in color {
                *channel = srgb::decode(f64::from(*channel)) as f32;
            }
        };
        if self.surfaces.is_empty() {
            self.surfaces = vec![Surface::without_material(self.has_colors())];
        }
        for surface in &mut self.surfaces {
            linear(&mut surface.diffuse);
            linear(&mut surface.specular);
            linear(&mut surface.textures.emission);
            if let Some(glass) = &mut surface.glass {
                linear(glass.base_color_mut());
            }
        }
        for image in &mut self.images {
            image.set_curve(Curve::Srgb);
        }
        for columns in self.arrays_mut() {
            columns.colors.par_iter_mut().for_each(linear);
        }
    }

    /// Adds the mesh, or the spheres and tubes of its points and lines, to a scene: with only `material` if given, else with
    /// its own surfaces and colours. Without surfaces it is [`Surface::WHITE`] if there are colours, else
    /// [`Surface::NEUTRAL`]. Shared parts become prototypes and instances. If the scene has another offset than the mesh, all
    /// is moved and rounded to `f32` first: [`SceneBuilder::set_offset`] avoids that.
    ///
    /// # Errors
    /// [`SceneError`], as for [`SceneBuilder::add_mesh`], [`SceneBuilder::add_spheres`] and
    /// [`SceneBuilder::add_instance`].
    pub fn add_to(
        mut self,
        builder: &mut SceneBuilder,
        material: Option<MaterialId>,
    ) -> Result<(), SceneError> {
        self.move_offset(builder.offset());
        builder.add_texture_files(std::mem::take(&mut self.texture_files));
        let ids = if let Some(material) = material {
            self.leave_out_colors();
            self.surface_of = Vec::new();
            for part in &mut self.shared {
                part.surface_of = Vec::new();
            }
            vec![material]
        } else {
            self.add_surfaces(builder)?
        };
        add_columns(builder, self.columns, self.cloud, &ids, &self.surface_of)?;
        self.shared.into_iter().try_for_each(|part| {
            let SharedMesh {
                columns,
                surface_of,
                placements,
            } = part;
            let start = builder.start_prototype();
            add_columns(builder, columns, None, &ids, &surface_of)?;
            let prototype = builder.end_prototype(start)?;
            placements
                .iter()
                .try_for_each(|placement| builder.add_instance(prototype, placement))
        })
    }

    /// Whether some of it is black without light: all but unlit surfaces and glass.
    pub(in crate::format) fn needs_light(&self) -> bool {
        let needs = |surface: &Surface| !surface.is_unlit && surface.glass.is_none();
        if self.surface_of.is_empty() {
            return self.surfaces.is_empty() || self.surfaces.iter().any(needs);
        }
        let used = used_surfaces(self.surfaces.len(), &self.surface_of);
        self.surfaces
            .iter()
            .zip(used)
            .any(|(surface, is_used)| is_used && needs(surface))
    }

    /// Adds the materials and images of the surfaces to a scene, or the material of a mesh without surfaces. The images
    /// are moved.
    pub(in crate::format) fn add_surfaces(
        &mut self,
        builder: &mut SceneBuilder,
    ) -> Result<Vec<MaterialId>, SceneError> {
        let images = std::mem::take(&mut self.images).into_iter();
        let images: Vec<u32> = images
            .map(|image| builder.add_image(image))
            .collect::<Result<_, _>>()?;
        let surfaces = match &self.surfaces[..] {
            [] => &[Surface::without_material(self.has_colors())],
            surfaces => surfaces,
        };
        let add = |surface: &Surface| {
            let textures = surface.textures.with_images(&images);
            builder.add_textured_material(surface.material(), textures)
        };
        surfaces.iter().map(add).collect()
    }
}

/// Adds a mesh, or a cloud, with the materials of its surfaces and the colours of its vertices. `surface_of` has an index
/// into `materials` for each triangle; it is empty if there is only one.
pub(in crate::format) fn add_columns(
    builder: &mut SceneBuilder,
    columns: TriangleMesh,
    cloud: Option<Cloud>,
    materials: &[MaterialId],
    surface_of: &[u32],
) -> Result<(), SceneError> {
    if let Some(cloud) = cloud {
        let material = materials.first().copied().unwrap_or(MaterialId(u32::MAX));
        return cloud.add_to(columns, builder, material);
    }
    if let ([material], []) = (materials, surface_of) {
        return builder.add_mesh(columns, *material);
    }
    // An index beyond the surfaces becomes a material that the builder refuses.
    let material = |&i: &u32| materials.get(i as usize).copied().unwrap_or(MaterialId(u32::MAX));
    builder.add_mesh_with_materials(columns, surface_of.iter().map(material).collect())
}
