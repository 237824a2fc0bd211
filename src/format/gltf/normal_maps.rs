//! Normal and occlusion maps of materials. The gltf crate does not read how they are moved.

use super::materials::{MapRead, Placement, Shown};
use crate::scene::{MAX_NORMAL_SCALE, NormalMap, OcclusionMap};
use gltf::{json, material::NormalTexture};
use serde::Deserialize;

const TRANSFORM: &str = "KHR_texture_transform";

/// The transforms of the normal and occlusion maps of a file.
pub(super) struct Transforms {
    materials: Vec<MaterialOf>,
}

impl Transforms {
    /// `text` is the JSON.
    pub(super) fn of(text: &[u8]) -> Self {
        let file: FileOf = if super::has(text, TRANSFORM) {
            json::deserialize::from_slice(text).unwrap_or_default()
        } else {
            FileOf::default()
        };
        Self {
            materials: file.materials,
        }
    }

    /// The normal map of a material; `None` without one, and if the material is not lit, as glass is not.
    pub(super) fn map(
        &self,
        material: &gltf::Material<'_>,
        is_lit: bool,
        webp: &[Option<u32>],
    ) -> (MapRead, Option<NormalMap>) {
        let normal = material.normal_texture().filter(|_| is_lit);
        let moved =
            |normal: &NormalTexture<'_>| self.placement(material, normal.tex_coord(), |own| &own.normal);
        let placement = normal.as_ref().map(moved);
        let image = normal.as_ref().map(NormalTexture::texture);
        let read = MapRead::new(image.as_ref().zip(placement), webp);
        let scale = normal.map_or(1.0, |normal| normal.scale());
        let map = read.texture.filter(|_| scale.is_finite());
        let map = map.map(|texture| NormalMap {
            texture,
            scale: scale.clamp(-MAX_NORMAL_SCALE, MAX_NORMAL_SCALE),
        });
        (read, map)
    }

    /// Adds the occlusion map of a material, if it is lit.
    pub(super) fn add_occlusion(
        &self,
        material: &gltf::Material<'_>,
        webp: &[Option<u32>],
        shown: &mut Shown,
    ) {
        let is_lit = shown.surface.glass.is_none() && !shown.surface.is_unlit;
        let Some(map) = material.occlusion_texture().filter(|_| is_lit) else {
            return;
        };
        let placement = self.placement(material, map.tex_coord(), |own| &own.occlusion);
        let read = MapRead::new(Some((&map.texture(), placement)), webp);
        shown.is_unsupported |= read.is_unsupported;
        let own = shown.placement.or(read.placement);
        shown.occlusion_left_out = read.placement.is_some() && read.placement != own;
        if let Some(texture) = read.texture.filter(|_| !shown.occlusion_left_out) {
            shown.placement = own;
            shown.surface.textures.occlusion_map = Some(OcclusionMap {
                texture,
                strength: map.strength().clamp(0.0, 1.0),
            });
        }
    }

    /// Where a map that takes this set of texture coordinates lies; `map` is its JSON.
    fn placement(
        &self,
        material: &gltf::Material<'_>,
        set: u32,
        map: impl Fn(&MaterialOf) -> &Option<MapOf>,
    ) -> Placement {
        let own = material.index().and_then(|i| self.materials.get(i));
        let moved = own.and_then(|own| map(own).as_ref()?.extensions.transform.as_ref());
        let plain = Placement::plain(set);
        moved.map_or(plain, |moved| Placement {
            set: moved.set.unwrap_or(plain.set),
            offset: moved.offset.unwrap_or(plain.offset),
            rotation: moved.rotation,
            scale: moved.scale.unwrap_or(plain.scale),
        })
    }
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct FileOf {
    materials: Vec<MaterialOf>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct MaterialOf {
    #[serde(rename = "normalTexture")]
    normal: Option<MapOf>,
    #[serde(rename = "occlusionTexture")]
    occlusion: Option<MapOf>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct MapOf {
    extensions: ExtensionsOf,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct ExtensionsOf {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<TransformOf>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct TransformOf {
    offset: Option<[f32; 2]>,
    rotation: f32,
    scale: Option<[f32; 2]>,
    #[serde(rename = "texCoord")]
    set: Option<u32>,
}
