//! Contents of a glTF file that octray does not read.

use super::visibility::Hidden;
use crate::format::left_out::LeftOut;
use gltf::{
    json::{Index, Material, Root, accessor::Type, mesh::Primitive, validation::Checked},
    material::AlphaMode,
    mesh::{Mode, Semantic},
};

/// Extensions that octray reads, that change nothing visible, or whose contents are listed elsewhere: textures, animations,
/// lights.
const NOT_LISTED: [&str; 18] = [
    "EXT_mesh_gpu_instancing",
    // Which triangles were one polygon.
    "FB_ngon_encoding",
    "KHR_lights_punctual",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_",
    "KHR_xmp",
    "EXT_meshopt_compression",
    "EXT_texture_",
];

/// Whether a file shows points or lines and no triangles: a cloud.
pub(super) fn is_cloud(root: &Root, hidden: &Hidden) -> bool {
    let shown = shown_meshes(root, hidden);
    let meshes = root.meshes.iter().zip(shown).filter(|(_, is_shown)| *is_shown);
    let mut primitives = meshes.flat_map(|(mesh, _)| &mesh.primitives).peekable();
    primitives.peek().is_some() && primitives.all(|primitive| is_points(primitive) || is_lines(primitive))
}

/// Which meshes the default scene shows, or else the first one, or else all nodes.
fn shown_meshes(root: &Root, hidden: &Hidden) -> Vec<bool> {
    let scene = root.scene.map_or(0, |scene| scene.value());
    let mut waiting: Vec<usize> = match root.scenes.get(scene) {
        Some(scene) => scene.nodes.iter().map(Index::value).collect(),
        None => (0..root.nodes.len()).collect(),
    };
    let mut shown = vec![false; root.meshes.len()];
    let mut is_known = vec![false; root.nodes.len()];
    // The indices are not checked yet.
    while let Some(i) = waiting.pop() {
        let Some(node) = root.nodes.get(i).filter(|_| !hidden.is_at(i)) else {
            continue;
        };
        if !std::mem::replace(&mut is_known[i], true) {
            waiting.extend(node.children.iter().flatten().map(Index::value));
            if let Some(shown) = node.mesh.and_then(|mesh| shown.get_mut(mesh.value())) {
                *shown = true;
            }
        }
    }
    shown
}

/// Lists what octray does not read of a file. Points and lines are read if it is a cloud, and of its animations one if it
/// `is_animated`. Unless it `shows_colors`, these are not missed.
pub(super) fn left_out(root: &Root, is_cloud: bool, is_animated: bool, shows_colors: bool) -> LeftOut {
    let mut left_out = LeftOut::default();
    if !is_animated {
        left_out.count(root.animations.len(), "animation", "animations");
    }
    if root.textures.is_empty() {
        left_out.count(root.images.len(), "image", "images");
    }
    let materials = |is: fn(&&Material) -> bool| root.materials.iter().filter(is).count();
    let gloss_maps = materials(|m| has_gloss_map(m));
    left_out.count(gloss_maps, "glossiness map", "glossiness maps");
    let primitives = || root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let count = |is: fn(&&Primitive) -> bool| primitives().filter(is).count();
    if !is_cloud {
        left_out.count(count(|p| is_points(p)), "set of points", "sets of points");
        left_out.count(count(|p| is_lines(p)), "set of lines", "sets of lines");
    }
    left_out.count(
        count(|p| !has(p, |semantic| *semantic == Semantic::Positions)),
        "primitive without positions",
        "primitives without positions",
    );
    let shown = || primitives().filter(|_| shows_colors);
    if shown().any(|p| has(p, |semantic| matches!(semantic, Semantic::Colors(1..)))) {
        left_out.add("more vertex colours");
    }
    if shown().any(|p| has_vertex_alpha(root, p)) {
        left_out.add("vertex alpha");
    }
    if shown().any(|p| p.attributes.contains_key(&Checked::Invalid)) {
        left_out.add("custom attributes of vertices");
    }
    left_out.count(root.scenes.len().saturating_sub(1), "other scene", "other scenes");
    let is_listed = |name: &&str| !NOT_LISTED.iter().any(|known| name.starts_with(known));
    let used = root.extensions_used.iter().map(String::as_str);
    left_out.names("extensions", used.filter(is_listed));
    left_out
}

/// Whether the alpha of its vertex colours would count.
fn has_vertex_alpha(root: &Root, primitive: &Primitive) -> bool {
    let colors = primitive.attributes.get(&Checked::Valid(Semantic::Colors(0)));
    let has_alpha = colors
        .and_then(|colors| root.accessors.get(colors.value()))
        .is_some_and(|accessor| accessor.type_ == Checked::Valid(Type::Vec4));
    let material = primitive.material.and_then(|i| root.materials.get(i.value()));
    has_alpha && material.is_some_and(|material| material.alpha_mode != Checked::Valid(AlphaMode::Opaque))
}

fn has_gloss_map(material: &Material) -> bool {
    let extensions = material.extensions.as_ref();
    let old = extensions.and_then(|extensions| extensions.pbr_specular_glossiness.as_ref());
    old.is_some_and(|old| old.specular_glossiness_texture.is_some())
}

fn is_points(primitive: &Primitive) -> bool {
    primitive.mode == Checked::Valid(Mode::Points)
}

fn is_lines(primitive: &Primitive) -> bool {
    matches!(
        primitive.mode,
        Checked::Valid(Mode::Lines | Mode::LineLoop | Mode::LineStrip)
    )
}

fn has(primitive: &Primitive, is: impl Fn(&Semantic) -> bool) -> bool {
    let mut semantics = primitive.attributes.keys();
    semantics.any(|semantic| matches!(semantic, Checked::Valid(semantic) if is(semantic)))
}
