//! Materials as octray shows them: base colour, highlight, emission, textures and their coordinates.

use super::{normal_maps::Transforms, specular, transmission::Through};
use crate::{
    format::{
        left_out::LeftOut,
        mesh::Surface,
        textures::{Highlight, STRONGEST},
    },
    math::srgb,
    scene::{CutOut, MAX_EMISSION, Opacity, SurfaceTextures, Texture, Wrap},
};
use gltf::{
    json::{self, Root},
    material::AlphaMode,
    texture::{self, Info, MagFilter, WrappingMode},
};
use serde::Deserialize;

/// The assumed value of a roughness map that is not shown.
const ROUGHNESS_MAP: f32 = 0.5;

/// The metallic factor from which a material without a map has highlights of its texture's colours.
const METAL: f32 = 0.5;

const WEBP: &str = "EXT_texture_webp";

/// Where the textures of a material take their coordinates from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Placement {
    /// Which set of texture coordinates.
    pub(super) set: u32,
    pub(super) offset: [f32; 2],
    pub(super) rotation: f32,
    pub(super) scale: [f32; 2],
}

impl Placement {
    /// That of a set of coordinates that are not moved.
    pub(super) fn plain(set: u32) -> Self {
        Self {
            set,
            offset: [0.0; 2],
            rotation: 0.0,
            scale: [1.0; 2],
        }
    }

    fn of(info: &Info<'_>) -> Self {
        let plain = Self::plain(info.tex_coord());
        info.texture_transform().map_or(plain, |transform| Self {
            set: transform.tex_coord().unwrap_or(plain.set),
            offset: transform.offset(),
            rotation: transform.rotation(),
            scale: transform.scale(),
        })
    }

    /// Moves texture coordinates as KHR_texture_transform says.
    pub(super) fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        if self.rotation == 0.0 && self.scale == [1.0; 2] {
            return [u + self.offset[0], v + self.offset[1]];
        }
        let (sin, cos) = libm::sincos(f64::from(self.rotation));
        let [u, v] = [u * self.scale[0], v * self.scale[1]].map(f64::from);
        let turned = [cos * u + sin * v, cos * v - sin * u];
        [
            turned[0] as f32 + self.offset[0],
            turned[1] as f32 + self.offset[1],
        ]
    }
}

/// A material.
pub(super) struct Shown {
    pub(super) surface: Surface,
    /// `None` if it shows no texture.
    pub(super) placement: Option<Placement>,
    /// Whether its emission has other coordinates, so that its texture is not shown.
    pub(super) emission_left_out: bool,
    /// Whether its normal map has other coordinates.
    pub(super) normals_left_out: bool,
    /// Whether its occlusion map has other coordinates.
    pub(super) occlusion_left_out: bool,
    /// What its roughness map becomes, if it has one.
    pub(super) highlight: Option<Highlight>,
    /// Whether its roughness map has other coordinates.
    pub(super) roughness_left_out: bool,
    /// Whether an image of it is of a kind that octray does not read.
    pub(super) is_unsupported: bool,
    /// Whether the factor of its alpha alone cuts all of it out.
    pub(super) is_cut_away: bool,
}

/// The materials of a file; textures have the numbers of the file's images.
pub(super) fn materials(
    document: &gltf::Document,
    webp: &[Option<u32>],
    transforms: &Transforms,
) -> Vec<Shown> {
    document
        .materials()
        .map(|material| {
            let mut shown = shown(&material, webp, transforms);
            transforms.add_occlusion(&material, webp, &mut shown);
            shown
        })
        .collect()
}

/// Lists the textures that are not shown; `unsupported` is what those of unknown kinds are called.
pub(super) fn left_out(materials: &[Shown], unsupported: [&str; 2], left_out: &mut LeftOut) {
    let count = |is: fn(&Shown) -> bool| materials.iter().filter(|shown| is(shown)).count();
    let [one, several] = unsupported;
    left_out.count(count(|shown| shown.is_unsupported), one, several);
    left_out.count(
        count(|shown| shown.emission_left_out),
        "emission texture with other texture coordinates",
        "emission textures with other texture coordinates",
    );
    left_out.count(
        count(|shown| shown.normals_left_out),
        "normal map with other texture coordinates",
        "normal maps with other texture coordinates",
    );
    left_out.count(
        count(|shown| shown.occlusion_left_out),
        "occlusion map with other texture coordinates",
        "occlusion maps with other texture coordinates",
    );
    left_out.count(
        count(|shown| shown.roughness_left_out),
        "roughness map with other texture coordinates",
        "roughness maps with other texture coordinates",
    );
}

/// Whether a factor alone cuts all of a material out.
fn is_cut_away(material: &gltf::Material<'_>, alpha: f32, has_map: bool) -> bool {
    let is_masked = material.alpha_mode() == AlphaMode::Mask;
    is_masked && !has_map && alpha < material.alpha_cutoff().unwrap_or(0.5)
}

/// The images of WebP textures by texture, which the gltf crate skips; `text` is the JSON.
pub(super) fn webp_images(root: &Root, text: &[u8]) -> Vec<Option<u32>> {
    if !super::has(text, WEBP) {
        return Vec::new();
    }
    let file: WebpFile = json::deserialize::from_slice(text).unwrap_or_default();
    let images = file
        .textures
        .into_iter()
        .map(|texture| texture.extensions.webp.source);
    images
        .map(|image| image.filter(|&image| (image as usize) < root.images.len()))
        .collect()
}

/// What textures are called that octray does not read: one, and several.
pub(super) fn unsupported_textures(root: &Root) -> [&'static str; 2] {
    let kinds = [
        ("EXT_texture_avif", ["AVIF texture", "AVIF textures"]),
        (
            "KHR_texture_basisu",
            [
                "KTX2 texture (`gltf-transform ktxdecompress` makes it PNG)",
                "KTX2 textures (`gltf-transform ktxdecompress` makes them PNG)",
            ],
        ),
        ("MSFT_texture_dds", ["DDS texture", "DDS textures"]),
    ];
    let is_used = |name: &str| root.extensions_used.iter().any(|used| used == name);
    let kind = kinds.into_iter().find(|&(name, _)| is_used(name));
    kind.map_or(["unsupported texture", "unsupported textures"], |(_, words)| {
        words
    })
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct WebpFile {
    textures: Vec<WebpTexture>,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct WebpTexture {
    extensions: WebpExtensions,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct WebpExtensions {
    #[serde(rename = "EXT_texture_webp")]
    webp: WebpSource,
}

#[derive(Default, Deserialize)]
#[serde(default)]
struct WebpSource {
    source: Option<u32>,
}

/// A texture with the number of its image; `None` if its image is of a kind that octray does not read.
fn texture(texture: &texture::Texture<'_>, webp: &[Option<u32>]) -> Option<Texture> {
    let preferred = webp.get(texture.index()).copied().flatten();
    let image = preferred.or_else(|| Some(texture.source()?.index() as u32))?;
    let sampler = texture.sampler();
    let wrap = |mode| match mode {
        WrappingMode::ClampToEdge => Wrap::Clamp,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::Repeat => Wrap::Repeat,
    };
    Some(Texture {
        image,
        wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())],
        nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
    })
}

/// A texture of a material, as far as octray reads it.
pub(super) struct MapRead {
    pub(super) texture: Option<Texture>,
    /// `None` without a texture.
    pub(super) placement: Option<Placement>,
    /// Its image is of a kind that octray does not read.
    pub(super) is_unsupported: bool,
}

impl MapRead {
    pub(super) fn new(written: Option<(&texture::Texture<'_>, Placement)>, webp: &[Option<u32>]) -> Self {
        let read = written.and_then(|(map, _)| texture(map, webp));
        Self {
            texture: read,
            placement: written.filter(|_| read.is_some()).map(|(_, placement)| placement),
            is_unsupported: written.is_some() && read.is_none(),
        }
    }

    fn of(info: Option<&Info<'_>>, webp: &[Option<u32>]) -> Self {
        let map = info.map(Info::texture);
        Self::new(map.as_ref().zip(info.map(Placement::of)), webp)
    }
}

/// A material's base colour, linear, with its texture; its roughness with its map; its metallic factor.
struct Factors<'a> {
    base: [f32; 4],
    base_map: Option<Info<'a>>,
    roughness: f32,
    roughness_map: Option<Info<'a>>,
    metallic: f32,
}

fn factors<'a>(material: &gltf::Material<'a>) -> Factors<'a> {
    if let Some(old) = material.pbr_specular_glossiness() {
        let (base, metallic) = specular::base_and_metallic(&old);
        return Factors {
            base,
            base_map: old.diffuse_texture(),
            roughness: 1.0 - old.glossiness_factor(),
            roughness_map: None,
            metallic,
        };
    }
    let pbr = material.pbr_metallic_roughness();
    Factors {
        base: pbr.base_color_factor(),
        base_map: pbr.base_color_texture(),
        roughness: pbr.roughness_factor().clamp(0.0, 1.0),
        roughness_map: pbr.metallic_roughness_texture(),
        metallic: pbr.metallic_factor(),
    }
}

/// Blinn-Phong's exponent for the width of a microfacet lobe: Walter et al., EGSR 2007.
pub(super) fn exponent(roughness: f32) -> u32 {
    ((2.0 / roughness.clamp(0.1, 1.0).powi(4) - 2.0) as u32).clamp(4, 2000)
}

/// The colour of a highlight; a metal's is its own.
fn specular(roughness: f32, metallic: f32, diffuse: [f32; 3]) -> [f32; 3] {
    diffuse.map(|channel| STRONGEST * (1.0 - roughness) * (1.0 + metallic * (channel - 1.0)))
}

fn emission(material: &gltf::Material<'_>) -> [f32; 3] {
    let strength = material.emissive_strength().unwrap_or(1.0);
    material
        .emissive_factor()
        .map(|factor| display_emission(factor * strength))
}

/// A material as octray shows it. Base colours and those of vertices are linear; surfaces and meshes hold display values.
fn shown(material: &gltf::Material<'_>, webp: &[Option<u32>], transforms: &Transforms) -> Shown {
    let Factors {
        base: [red, green, blue, alpha],
        base_map,
        roughness,
        roughness_map,
        metallic,
    } = factors(material);
    let through = Through::of(material);
    let glass = match through {
        Through::Body(glass) => Some(glass),
        _ => None,
    };
    let is_cut_away = is_cut_away(material, alpha, base_map.is_some());
    let has_highlight = glass.is_none() && !material.unlit();
    // Glass shows neither its base colour nor a texture of it.
    let base = MapRead::of(base_map.as_ref().filter(|_| glass.is_none()), webp);
    let emissive = MapRead::of(material.emissive_texture().as_ref(), webp);
    let emission_left_out =
        emissive.placement.is_some() && base.placement.is_some() && emissive.placement != base.placement;
    let emission = if emission_left_out || emissive.is_unsupported || material.unlit() {
        [0.0; 3]
    } else {
        emission(material)
    };
    let placement = base.placement.or(emissive.placement);
    let (normals, normal_map) = transforms.map(material, has_highlight, webp);
    let normals_left_out =
        normals.placement.is_some() && placement.is_some_and(|own| normals.placement != Some(own));
    let roughness_map = roughness_map.filter(|_| has_highlight);
    let rough = MapRead::of(roughness_map.as_ref(), webp);
    let placement = placement.or(normals.placement);
    let roughness_left_out =
        rough.placement.is_some() && placement.is_some_and(|own| rough.placement != Some(own));
    let rough_shown = rough.texture.filter(|_| !roughness_left_out);
    let metallic = metallic.clamp(0.0, 1.0);
    let own_color = base
        .texture
        .filter(|_| has_highlight && roughness_map.is_none() && metallic >= METAL);
    let (cut_out, opacity) = coverage(material, alpha, base.texture, through);
    let mut diffuse = [red, green, blue].map(display_value);
    if base.is_unsupported {
        diffuse = tinted(diffuse, Surface::NEUTRAL.diffuse);
    }
    let specular = match (&roughness_map, rough_shown) {
        // Until the map is read, which has all of it.
        (Some(_), Some(_)) => [STRONGEST; 3],
        (Some(_), None) => specular(ROUGHNESS_MAP, metallic, diffuse),
        _ => specular(roughness.clamp(0.1, 1.0), metallic, diffuse),
    };
    let base_image = base.texture.map(|texture| texture.image);
    let surface = Surface {
        diffuse,
        specular,
        // A map that is shown brings its own mean.
        alpha: exponent(roughness * roughness_map.map_or(1.0, |_| ROUGHNESS_MAP)),
        is_unlit: material.unlit(),
        glass,
        textures: SurfaceTextures {
            base: base.texture,
            cut_out,
            opacity,
            emission,
            specular_map: rough_shown.or(own_color),
            emission_map: emissive.texture.filter(|_| emission != [0.0; 3]),
            normal_map: normal_map.filter(|_| !normals_left_out),
            // Light enters glass and leaves it.
            one_sided: !material.double_sided() && matches!(through, Through::Not | Through::Faint),
            ..SurfaceTextures::NONE
        },
    };
    Shown {
        surface,
        placement: placement.or(rough.placement),
        highlight: rough_shown.map(|_| Highlight::new(roughness, metallic, diffuse, base_image)),
        roughness_left_out,
        occlusion_left_out: false,
        emission_left_out,
        normals_left_out,
        is_unsupported: base.is_unsupported
            || emissive.is_unsupported
            || normals.is_unsupported
            || rough.is_unsupported,
        is_cut_away,
    }
}

/// Where a material is cut out, and how opaque it is.
fn coverage(
    material: &gltf::Material<'_>,
    alpha: f32,
    base_texture: Option<Texture>,
    through: Through,
) -> (Option<CutOut>, Option<Opacity>) {
    let (limit, opacity) = match material.alpha_mode() {
        AlphaMode::Opaque => (None, None),
        // The factor multiplies the texture's alpha.
        AlphaMode::Mask => {
            let limit = material.alpha_cutoff().unwrap_or(0.5) / alpha.max(f32::MIN_POSITIVE);
            (Some(limit), None)
        }
        AlphaMode::Blend => (None, Opacity::new(alpha.clamp(0.0, 1.0), base_texture)),
    };
    let opacity = match through {
        Through::Sheet(share) => sheet(opacity, share),
        _ => opacity,
    };
    let cut_out = base_texture.zip(limit).map(|(texture, limit)| CutOut {
        texture,
        channel: 3,
        limit: limit.clamp(0.0, f32::MAX),
    });
    (cut_out, opacity)
}

/// The opacity of a sheet that lets a share of light through.
fn sheet(coverage: Option<Opacity>, share: f32) -> Option<Opacity> {
    let (factor, map) = coverage.map_or((1.0, None), |coverage| (coverage.factor, coverage.map));
    let opacity = Opacity::new(factor * (1.0 - share), map);
    opacity.map(|opacity| Opacity {
        // Where the map says that there is nothing, nothing is tinted.
        is_tinted: map.is_none(),
        ..opacity
    })
}

/// A colour under a texture that is not shown: textures are rarely white.
fn tinted(color: [f32; 3], by: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|channel| color[channel] * by[channel])
}

pub(super) fn display_value(linear: f32) -> f32 {
    srgb::encode(linear.clamp(0.0, 1.0).into()) as f32
}

/// Below [`MAX_EMISSION`] even after it was encoded, rounded and decoded.
const MOST_EMISSION: f32 = 0.1 * MAX_EMISSION;

/// The display value of an emission, above 1 if it is brighter than white.
fn display_emission(linear: f32) -> f32 {
    srgb::encode(linear.clamp(0.0, MOST_EMISSION).into()) as f32
}
