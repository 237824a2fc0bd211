//! The textures of a material, for `octray info`.

use crate::scene::{MaterialId, Scene};

/// The textures and the emission of a material; `None` if it has neither.
pub fn textures(scene: &Scene, material: usize) -> Option<String> {
    let all = scene.textures(MaterialId(material as u32))?;
    let size = |image: u32| {
        let [width, height] = scene
            .images()
            .get(image as usize)
            .map_or([0; 2], |image| image.size());
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
        all.emits().then(|| format!("emission {red} {green} {blue}")),
        all.emission_map
            .map(|texture| format!("emission map {}", size(texture.image))),
    ];
    Some(parts.into_iter().flatten().collect::<Vec<_>>().join(", "))
}
