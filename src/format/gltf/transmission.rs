//! Transmission through surfaces: the extensions `KHR_materials_transmission`, `KHR_materials_volume` and
//! `KHR_materials_ior`, The Khronos Group, 2021.
//!
//! A surface without thickness is a sheet, which does not refract, and one with thickness is the boundary of a body of glass.
//! docs/meshes.md has the rule.

use super::materials::display_value;
use crate::{
    format::left_out::LeftOut,
    scene::{INDEX_RANGE, Material, is_usable},
};

/// From this transmission on, the boundary of a volume is glass; else it is opaque.
const GLASS: f32 = 0.5;

/// The extension's default.
const INDEX: f32 = 1.5;

/// The transmission of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Through {
    /// None.
    Not,
    /// A sheet that transmits this share, without refraction, tinted by the base colour.
    Sheet(f32),
    /// The boundary of a body of [`Material::Glass`], whose tint is a display value.
    Body(Material),
    /// A body with too little transmission for glass.
    Faint,
}

impl Through {
    /// By the factors: no map is read.
    pub(super) fn of(material: &gltf::Material<'_>) -> Self {
        let Some(transmission) = material.transmission().filter(|_| !material.unlit()) else {
            return Self::Not;
        };
        let pbr = material.pbr_metallic_roughness();
        // Metal lets no light through. A map multiplies its factor, which is mostly 1 then, and says where the metal is.
        let is_mapped = pbr.metallic_roughness_texture().is_some();
        let metallic = if is_mapped || material.pbr_specular_glossiness().is_some() {
            0.0
        } else {
            pbr.metallic_factor().clamp(0.0, 1.0)
        };
        let share = transmission.transmission_factor().clamp(0.0, 1.0) * (1.0 - metallic);
        let volume = material.volume().filter(|volume| volume.thickness_factor() > 0.0);
        match volume {
            _ if share == 0.0 => Self::Not,
            None => Self::Sheet(share),
            Some(_) if share < GLASS => Self::Faint,
            Some(volume) => {
                // An index of 0 is that of old materials without one.
                let index = material.ior().filter(|&index| index > 0.0).unwrap_or(INDEX);
                let distance = volume.attenuation_distance();
                // It is infinite by default.
                let (tint, depth) = if is_usable(distance) && distance > 0.0 {
                    (volume.attenuation_color().map(display_value), distance)
                } else {
                    ([1.0; 3], 1.0)
                };
                Self::Body(Material::Glass {
                    index: index.clamp(INDEX_RANGE.0, INDEX_RANGE.1),
                    tint,
                    depth,
                })
            }
        }
    }
}

/// Lists the parts of transmission that are not shown.
pub(super) fn left_out(document: &gltf::Document, left_out: &mut LeftOut) {
    let count = |is: fn(&gltf::Material<'_>) -> bool| document.materials().filter(is).count();
    left_out.count(
        count(|material| {
            let transmission = material.transmission();
            transmission.is_some_and(|all| all.transmission_texture().is_some())
        }),
        "transmission map",
        "transmission maps",
    );
    left_out.count(
        count(|material| Through::of(material) == Through::Faint),
        "volume that lets little light through",
        "volumes that let little light through",
    );
    left_out.count(
        count(|material| {
            let pbr = material.pbr_metallic_roughness();
            let [red, green, blue, _] = pbr.base_color_factor();
            let is_white = [red, green, blue] == [1.0; 3] && pbr.base_color_texture().is_none();
            matches!(Through::of(material), Through::Body(_)) && !is_white
        }),
        "base colour of glass",
        "base colours of glass",
    );
    left_out.count(
        count(|material| {
            matches!(Through::of(material), Through::Body(_)) && material.normal_texture().is_some()
        }),
        "normal map of glass",
        "normal maps of glass",
    );
}
