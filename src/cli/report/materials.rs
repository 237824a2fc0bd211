//! The materials that `octray info` shows.

use super::info::{count, list};
use crate::scene::{Image, Material, MaterialId, Opacity, Scene, SurfaceTextures};
use serde::Serialize;

#[derive(Debug, Serialize)]
pub(super) struct MaterialUse {
    index: usize,
    kind: &'static str,
    /// As a statement of a scene file.
    statement: String,
    /// What the statement does not say: images, emission and some opacities.
    textures: Option<String>,
    primitives: usize,
}

impl MaterialUse {
    pub(super) fn text(&self) -> String {
        let textures = self.textures.iter().map(|textures| format!(", {textures}"));
        let textures: String = textures.collect();
        format!(
            "{}{textures}, {} {}",
            self.statement,
            count(self.primitives),
            if self.primitives == 1 {
                "primitive"
            } else {
                "primitives"
            }
        )
    }
}

/// The materials of at least one primitive.
pub(super) fn materials_used(scene: &Scene) -> Vec<MaterialUse> {
    let mut primitives = vec![0; scene.materials().len()];
    let of_planes = scene.planes().iter().map(|plane| &plane.material);
    let finite = scene.triangles().material.iter().chain(&scene.spheres().material);
    for id in finite.chain(of_planes) {
        if let Some(count) = primitives.get_mut(id.0 as usize) {
            *count += 1;
        }
    }
    let kind = |material: &Material| match material {
        Material::Silhouette { .. } => "silhouette",
        Material::Matte { .. } => "matte",
        Material::BlinnPhong { .. } => "blinn_phong",
        Material::Reflection { .. } => "reflection",
        Material::Glass { .. } => "glass",
    };
    scene
        .materials()
        .iter()
        .zip(primitives)
        .enumerate()
        .filter(|&(_, (_, primitives))| primitives > 0)
        .map(|(index, (material, primitives))| MaterialUse {
            index,
            kind: kind(material),
            statement: statement(scene, index, material),
            textures: textures(scene, index, material),
            primitives,
        })
        .collect()
}

/// A material as a statement of a scene file. A checker's first colour is `cd`, as there.
fn statement(scene: &Scene, index: usize, material: &Material) -> String {
    let textures = scene.textures(MaterialId(index as u32));
    let opacity = textures.and_then(|textures| stated(material, textures));
    let opacity = opacity.map_or_else(String::new, |opacity| format!(" {}", opacity_text(opacity)));
    let checker = textures.and_then(|textures| textures.checker);
    let shown = |color: [f32; 3], part: usize| {
        let times = checker.map_or([1.0; 3], |checker| checker.colors[part]);
        list::<f32>(std::array::from_fn(|channel| color[channel] * times[channel]))
    };
    let with_checker = |text: String, color| match checker {
        Some(checker) => format!("{text} checker {} size {}", shown(color, 1), checker.size),
        None => text,
    };
    let text = match *material {
        Material::Silhouette { color } => format!("silhouette cd {}", list(color)),
        Material::Matte { color } => with_checker(format!("matte cd {}", shown(color, 0)), color),
        Material::BlinnPhong {
            diffuse,
            specular,
            k_d,
            k_s,
            alpha,
        } => {
            let (own, specular) = (shown(diffuse, 0), list(specular));
            let text = format!("blinn_phong cd {own} cs {specular} kd {k_d} ks {k_s} alpha {alpha}");
            with_checker(text, diffuse)
        }
        Material::Reflection { color, mirror_share } => with_checker(
            format!("reflection cd {} mix {mirror_share}", shown(color, 0)),
            color,
        ),
        Material::Glass { index, tint, depth } => {
            format!("glass ior {index} tint {} depth {depth}", list(tint))
        }
    };
    text + &opacity
}

/// The opacity that a statement can have: glass has none, and none has an image.
fn stated(material: &Material, textures: &SurfaceTextures) -> Option<Opacity> {
    let is_glass = matches!(material, Material::Glass { .. });
    let opacity = textures.opacity.filter(|_| !is_glass);
    opacity.filter(|opacity| opacity.map.is_none())
}

fn opacity_text(opacity: Opacity) -> String {
    let tinted = if opacity.is_tinted { " tinted" } else { "" };
    format!("opacity {}{tinted}", opacity.factor)
}

/// What the statement of a material does not say: images, emission and some opacities; `None` if it has none of them.
fn textures(scene: &Scene, index: usize, material: &Material) -> Option<String> {
    let all = scene.textures(MaterialId(index as u32))?;
    let is_not_stated = stated(material, all).is_none();
    let size = |image: u32| {
        let [width, height] = scene.images().get(image as usize).map_or([0; 2], Image::size);
        format!("{width}x{height}")
    };
    let [red, green, blue] = all.emission;
    let parts = [
        all.base.map(|texture| format!("texture {}", size(texture.image))),
        all.cut_out.map(|cut_out| {
            format!(
                "cut out below {} of {}",
                cut_out.limit,
                size(cut_out.texture.image)
            )
        }),
        all.opacity.filter(|_| is_not_stated).map(|opacity| {
            let of = opacity
                .map
                .map(|map| format!(" times alpha of {}", size(map.image)));
            opacity_text(opacity) + &of.unwrap_or_default()
        }),
        all.emits().then(|| format!("emission {red} {green} {blue}")),
        all.emission_map
            .map(|texture| format!("emission map {}", size(texture.image))),
        all.specular_map
            .map(|texture| format!("specular map {}", size(texture.image))),
        all.normal_map
            .map(|map| format!("normal map {}", size(map.texture.image))),
        all.occlusion_map
            .map(|map| format!("occlusion map {}", size(map.texture.image))),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}
