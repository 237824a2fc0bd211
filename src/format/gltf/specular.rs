//! Materials of specular colour and glossiness: the extension `KHR_materials_pbrSpecularGlossiness`, The Khronos Group, 2017.
//!
//! Without textures, a material becomes one of base colour and metal by the extension's own conversion, its example
//! `convert-between-workflows`. A texture may have another colour at each point, so one with textures keeps its diffuse
//! colour.

use crate::format::left_out::LeftOut;
use gltf::{Document, material::PbrSpecularGlossiness};

/// What a dielectric reflects.
const DIELECTRIC: f32 = 0.04;

/// The base colour of a material, linear and with alpha, and its metallic factor.
pub(super) fn base_and_metallic(old: &PbrSpecularGlossiness<'_>) -> ([f32; 4], f32) {
    let [red, green, blue, alpha] = old.diffuse_factor();
    if is_textured(old) {
        return ([red, green, blue, alpha], 0.0);
    }
    let [diffuse, specular] =
        [[red, green, blue], old.specular_factor()].map(|color| color.map(|channel| channel.clamp(0.0, 1.0)));
    let rest = 1.0 - largest(specular);
    let metallic = metallic(brightness(diffuse), brightness(specular), rest);
    let share = metallic * metallic;
    let [red, green, blue] = [0, 1, 2].map(|i| {
        let of_diffuse = diffuse[i] * rest / (1.0 - DIELECTRIC) / (1.0 - metallic).max(1e-6);
        let of_specular = (specular[i] - DIELECTRIC * (1.0 - metallic)) / metallic.max(1e-6);
        (of_diffuse + share * (of_specular - of_diffuse)).clamp(0.0, 1.0)
    });
    ([red, green, blue, alpha], metallic)
}

/// Lists the materials whose textures hide that they are metal.
pub(super) fn left_out(document: &Document, left_out: &mut LeftOut) {
    let is_hidden = |material: &gltf::Material<'_>| {
        material.pbr_specular_glossiness().is_some_and(|old| {
            let [red, green, blue, _] = old.diffuse_factor();
            is_textured(&old) && largest(old.specular_factor()) > largest([red, green, blue])
        })
    };
    left_out.count(
        document.materials().filter(is_hidden).count(),
        "specular colour of a textured material",
        "specular colours of textured materials",
    );
}

fn is_textured(old: &PbrSpecularGlossiness<'_>) -> bool {
    old.diffuse_texture().is_some() || old.specular_glossiness_texture().is_some()
}

/// The metallic factor for the brightness of both colours; `rest` is what is not reflected.
fn metallic(diffuse: f32, specular: f32, rest: f32) -> f32 {
    if specular < DIELECTRIC {
        return 0.0;
    }
    let b = diffuse * rest / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - specular;
    let root = (b * b - 4.0 * DIELECTRIC * c).sqrt();
    ((root - b) / (2.0 * DIELECTRIC)).clamp(0.0, 1.0)
}

/// How bright a colour is perceived.
fn brightness([red, green, blue]: [f32; 3]) -> f32 {
    (0.299 * red * red + 0.587 * green * green + 0.114 * blue * blue).sqrt()
}

fn largest(color: [f32; 3]) -> f32 {
    color.into_iter().fold(0.0, f32::max)
}
