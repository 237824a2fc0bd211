//! glTF 2.0: JSON with external or embedded buffers, or one binary file (.glb).
//!
//! Reads the triangles, strips and fans, or else the points and lines, of all nodes of the default scene, with transforms,
//! vertex colours, skins and morph targets in the stored pose or that of an animation, materials, textures, punctual lights and cameras. [`extras`]
//! lists what it does not read. [`sharing`] decides which meshes are stored once.
//!
//! The gltf crate parses the JSON and checks its references. [`buffers`] reads the bytes and checks every access: the
//! crate's own readers trust offsets and counts.
//!
//! Format: *glTF 2.0 Specification*, The Khronos Group, 2021.

mod animations;
mod arrays;
mod buffers;
mod compression;
mod elements;
mod estimate;
mod extras;
mod images;
mod instancing;
mod lights;
mod materials;
mod morphs;
mod nodes;
mod normal_maps;
mod scalars;
mod shapes;
mod sharing;
mod skins;
mod specular;
mod translations;
mod transmission;
mod tree;
mod visibility;

use super::place::{BYTE_ORDER_MARK, is_utf16};
use super::{
    OpenMesh,
    budget::Budget,
    left_out::counted,
    mesh::{LoadedMesh, Surface, add_texture_file},
    reason::Reason,
    textures,
};
use crate::error::LoadError;
use buffers::Buffers;
use compression::Compression;
use gltf::{
    Document,
    json::{self, validation::Validate},
};
use percent_encoding::percent_decode_str;
use std::path::{Path, PathBuf};

/// Extensions that a file may require because octray reads them, or they change nothing that it reads.
const HARMLESS: [&str; 14] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
    "KHR_animation_pointer",
    "KHR_materials_",
    "KHR_texture_",
    "KHR_technique",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "KHR_node_visibility",
    "KHR_xmp",
    "KHR_mesh_quantization",
];

/// Reads a mesh; `open` provides the files of its buffers.
///
/// # Errors
/// [`LoadError`]: with line and column if the JSON does not parse, else with the JSON path of the fault.
pub(super) fn parse(
    bytes: &[u8],
    path: &Path,
    open: OpenMesh<'_>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let (json, blob) = split(bytes, path)?;
    let parsed = estimate::parsed_size(json);
    budget.take(parsed).map_err(|error| error.into_error(path))?;
    let mut root = root(json, path, budget)?;
    let hidden = visibility::Hidden::of(json);
    let is_cloud = extras::is_cloud(&root, &hidden);
    let moment = budget.moment();
    let shows_colors = budget.scalars().shows_colors();
    let mut left_out = extras::left_out(&root, is_cloud, moment.is_some(), shows_colors);
    let listed = animations::listed(&root);
    let names = listed
        .iter()
        .map(|animation| size_of_val(animation) + animation.name.len());
    budget.take(names.sum()).map_err(|error| error.into_error(path))?;
    let animations = std::mem::take(&mut root.animations);
    let texture_files = texture_files(&root, path);
    let sources = images::sources(&mut root);
    let webp = materials::webp_images(&root, json);
    let unsupported = materials::unsupported_textures(&root);
    let lights = lights::PunctualLights::of(json);
    let instancing = instancing::Instancing::of(json, path)?;
    left_out.count(hidden.count(), "hidden node", "hidden nodes");
    let translations = translations::Translations::of(json, budget.offset());
    let document = document(root, path)?;
    let compression = Compression::of(json, path, &document)?;
    let targets = morphs::MorphTargets::of(json, path, &document)?;
    let transforms = normal_maps::Transforms::of(json);
    let materials = materials::materials(&document, &webp, &transforms);
    left_out.count(
        materials.iter().filter(|material| material.is_cut_away).count(),
        "material below its alpha cutoff",
        "materials below their alpha cutoffs",
    );
    let scalars = scalars::Scalars::of(json, path, &document, budget.scalars())?;
    let mut buffers = Buffers::new(path, bytes.len(), blob, open, &compression, budget);
    buffers = buffers.with_scalars(scalars);
    let pose = animations::AnimatedPose::at(
        moment,
        (&animations, &listed),
        (&document, &targets),
        &mut buffers,
    )?;
    let mut reading = nodes::Reading::new(lights, is_cloud);
    let contents = nodes::Contents {
        document: &document,
        materials: &materials,
        instancing: &instancing,
        translations: &translations,
        hidden: &hidden,
        targets: &targets,
        pose: &pose,
    };
    reading.scene(&contents, &mut buffers)?;
    reading.list_left_out(&mut left_out);
    transmission::left_out(&document, &mut left_out);
    specular::left_out(&document, &mut left_out);
    materials::left_out(&materials, unsupported, &mut left_out);
    left_out.count(
        reading.arrays().map(|arrays| arrays.odd_uvs).sum(),
        "texture coordinate that is NaN or too large",
        "texture coordinates that are NaN or too large",
    );
    let highlights = materials.iter().map(|shown| shown.highlight).collect::<Vec<_>>();
    let unusable = reading.arrays().find_map(|arrays| arrays.unusable.take());
    let mut mesh = reading.finish(materials, path);
    mesh.notes.extend(left_out.note(path));
    mesh.leave_out_unusable(unusable, path, budget)?;
    mesh.texture_files = texture_files;
    mesh.animations = listed;
    mesh.scalars.listed = buffers.scalars().listed();
    let used = used_surfaces(&mesh);
    let surfaces = (&mut mesh.surfaces[..], &used[..], &highlights[..]);
    mesh.images = images::read(&sources, &document, &mut buffers, surfaces, &mut mesh.notes);
    if mesh.images.is_empty() && budget.wants_images() {
        for columns in mesh.arrays_mut() {
            (columns.uvs, columns.tangents) = Default::default();
        }
    }
    Ok(mesh)
}

/// Lists the animations of a file, without reading anything else.
///
/// # Errors
/// [`LoadError`], as for [`parse`].
#[cfg(feature = "cli")]
pub(super) fn animations(
    bytes: &[u8],
    path: &Path,
    budget: &Budget,
) -> Result<Vec<super::mesh::MeshAnimation>, LoadError> {
    let (json, _) = split(bytes, path)?;
    let parsed = estimate::parsed_size(json);
    budget.take(parsed).map_err(|error| error.into_error(path))?;
    Ok(animations::listed(&root(json, path, budget)?))
}

/// The JSON of a file, and the buffer of a binary one.
fn split<'a>(bytes: &'a [u8], path: &Path) -> Result<(&'a [u8], Option<&'a [u8]>), LoadError> {
    let refused = |message: String| LoadError::whole_file(path, message);
    if bytes.is_empty() {
        return Err(refused("the file is empty, expected a glTF mesh".into()));
    }
    if is_utf16(bytes) {
        return Err(refused("this is UTF-16, expected JSON in UTF-8".into()));
    }
    let (json, blob) = if bytes.starts_with(b"glTF") {
        split_binary(bytes).map_err(refused)?
    } else {
        let is_binary = path
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("glb"));
        let first = bytes
            .strip_prefix(BYTE_ORDER_MARK)
            .unwrap_or(bytes)
            .trim_ascii_start();
        if is_binary && first.first() != Some(&b'{') {
            return Err(refused("not a GLB file: its first bytes are not `glTF`".into()));
        }
        (bytes, None)
    };
    Ok((json.strip_prefix(BYTE_ORDER_MARK).unwrap_or(json), blob))
}

/// The files of a file's images.
fn texture_files(root: &json::Root, path: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for uri in root.images.iter().filter_map(|image| image.uri.as_deref()) {
        if buffers::data_of(uri).is_none() {
            let file = percent_decode_str(uri).decode_utf8_lossy();
            add_texture_file(&mut files, path, &file);
        }
    }
    files
}

/// Which surfaces any triangle has.
fn used_surfaces(mesh: &LoadedMesh) -> Vec<bool> {
    let mut used = textures::used_surfaces(mesh.surfaces.len(), &mesh.surface_of);
    for part in &mesh.shared {
        let of_part = textures::used_surfaces(used.len(), &part.surface_of);
        used.iter_mut()
            .zip(of_part)
            .for_each(|(used, more)| *used |= more);
    }
    used
}

/// The JSON and the buffer of a .glb file.
fn split_binary(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let version = bytes.get(4..).and_then(|rest| rest.first_chunk());
    if let Some(&version) = version
        && u32::from_le_bytes(version) != 2
    {
        return Err(other_version(&format!("{}.0", u32::from_le_bytes(version))));
    }
    let length = bytes.get(8..).and_then(|rest| rest.first_chunk());
    let length = length.map_or(0, |&length| u32::from_le_bytes(length) as usize);
    if length < 20 || length > bytes.len() {
        return Err(format!(
            "the header promises {length} bytes, but the file has {}: it is cut short or broken",
            bytes.len()
        ));
    }
    let mut rest = bytes.get(12..length).unwrap_or_default();
    let (b"JSON", json) = next_chunk(&mut rest)? else {
        return Err("broken binary glTF: its first chunk is not JSON".to_owned());
    };
    // Chunks of other types are ignored, as the specification says.
    while !rest.is_empty() {
        if let (b"BIN\0", buffer) = next_chunk(&mut rest)? {
            return Ok((json, Some(buffer)));
        }
    }
    Ok((json, None))
}

/// The type of the next chunk of a .glb file, and its bytes.
fn next_chunk<'a>(rest: &mut &'a [u8]) -> Result<(&'a [u8; 4], &'a [u8]), String> {
    let split = |bytes: &'a [u8]| {
        let (length, after) = bytes.split_first_chunk::<4>()?;
        let (kind, after) = after.split_first_chunk::<4>()?;
        let (chunk, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        Some(((kind, chunk), after))
    };
    let (chunk, after) = split(rest).ok_or("broken binary glTF: a chunk is cut short")?;
    *rest = after;
    Ok(chunk)
}

/// The error about a version that is not 2.
fn other_version(version: &str) -> String {
    let version = shortened(version);
    let advice = if version.starts_with('1') {
        "convert the file to glTF 2.0, for example with gltf-pipeline"
    } else {
        "expected glTF 2.0"
    };
    format!("glTF {version} is not supported; {advice}")
}

/// The JSON, not yet checked.
fn root(text: &[u8], path: &Path, budget: &Budget) -> Result<json::Root, LoadError> {
    let other_version = |version: &str| Reason::unsupported(other_version(version)).of_file(path);
    // Not generic, so compiled with its crate, at less optimisation.
    let mut root = json::Root::from_slice(text);
    if let Err(error) = &root
        && error.to_string().starts_with("missing field `node")
    {
        // A tree of values takes less than twice as much as the estimate, which is for the crate's own types.
        let room = estimate::parsed_size(text).saturating_mul(2);
        budget.take(room).map_err(|error| error.into_error(path))?;
        root = without_optional(text).map_or(root, Ok);
        budget.give_back(room);
    }
    let root = root.map_err(|error| {
        // Version 1 has other types nearly everywhere: the first mismatch says little.
        if let Some(version) = version(text).filter(|version| version.starts_with(['0', '1'])) {
            return other_version(&version);
        }
        let place = [error.line(), error.column()];
        LoadError::in_json(path, place, "not a valid glTF file", &error.to_string())
    })?;
    match root.asset.min_version.as_ref().or(Some(&root.asset.version)) {
        Some(version) if !version.starts_with("2.") => Err(other_version(version)),
        _ => Ok(root),
    }
}

/// Reads a file again that has scenes without `nodes` or channels of animations without `node`, which the crate requires and
/// the specification does not.
fn without_optional(text: &[u8]) -> Option<json::Root> {
    let mut value: json::Value = json::deserialize::from_slice(text).ok()?;
    let mut arrays = |key: &str| {
        value
            .get_mut(key)
            .and_then(|found| found.as_array_mut().map(std::mem::take))
    };
    let (mut scenes, mut animations) = (arrays("scenes"), arrays("animations"));
    for scene in scenes.iter_mut().flatten() {
        let scene = scene.as_object_mut()?;
        scene
            .entry("nodes")
            .or_insert_with(|| json::Value::Array(Vec::new()));
    }
    // A channel without a node is one of an extension.
    for channels in animations
        .iter_mut()
        .flatten()
        .filter_map(|one| one.get_mut("channels"))
    {
        let has_node =
            |channel: &json::Value| channel.get("target").is_some_and(|to| to.get("node").is_some());
        channels.as_array_mut()?.retain(has_node);
    }
    for (key, array) in [("scenes", scenes), ("animations", animations)] {
        if let Some(array) = array {
            value.as_object_mut()?.insert(key.to_owned(), array.into());
        }
    }
    json::deserialize::from_value(value).ok()
}

/// Checks the JSON.
fn document(mut root: json::Root, path: &Path) -> Result<Document, LoadError> {
    let refused = |message: String| LoadError::whole_file(path, message);
    root.extensions_required
        .retain(|name| !HARMLESS.iter().any(|harmless| name.starts_with(harmless)));
    if let Some(name) = root.extensions_required.first() {
        let name = shortened(name);
        let message = format!("the file requires the extension {name}, which octray does not support");
        return Err(Reason::unsupported(message).of_file(path));
    }
    let scenes = root.scenes.len();
    if let Some(scene) = root.scene.filter(|scene| scene.value() >= scenes) {
        let counted = counted(scenes, "scene", "scenes");
        return Err(refused(format!(
            "`scene` is {}, but the file has {counted}",
            scene.value()
        )));
    }
    // What octray does not read may be invalid, and morph targets are read separately.
    for accessor in &mut root.accessors {
        (accessor.min, accessor.max) = (None, None);
    }
    for (i, mesh) in root.meshes.iter_mut().enumerate() {
        for (j, primitive) in mesh.primitives.iter_mut().enumerate() {
            primitive.targets = None;
            // Names of their own, such as `_DENSITY`.
            primitive.attributes.remove(&json::validation::Checked::Invalid);
            // The crate's own check looks positions up before it checks their index.
            let accessors = root.accessors.len();
            if let Some(index) = primitive
                .attributes
                .values()
                .find(|index| index.value() >= accessors)
            {
                return Err(refused(format!(
                    "meshes[{i}].primitives[{j}].attributes: accessor {}, but the file has only {accessors}",
                    index.value()
                )));
            }
        }
    }
    let mut fault = None;
    root.validate(&root, json::Path::new, &mut |path, error| {
        let place = path().to_string();
        // Bounds of positions are redundant, and primitives without positions are skipped later.
        let matters = error != json::validation::Error::Missing
            || !(place.contains("accessors") || place.contains("attributes"));
        if matters && fault.is_none() {
            fault = Some(format!(
                "{}: {}",
                shortened(&place),
                error.to_string().to_lowercase()
            ));
        }
    });
    match fault {
        Some(fault) => Err(refused(fault)),
        None => Ok(Document::from_json_without_validation(root)),
    }
}

/// The version of a file that does not parse as glTF 2.0. In version 1 it was a text, a number or that of a profile.
fn version(text: &[u8]) -> Option<String> {
    use json::deserialize::from_slice;
    let word = from_slice(text).map(|Versioned::<Version<String>> { asset }| asset.version);
    let number =
        || from_slice(text).map(|Versioned::<Version<f64>> { asset }| format!("{:.1}", asset.version));
    let profile = || from_slice(text).map(|Versioned::<Profiled> { asset }| asset.profile.version);
    // The version was optional, too; what are arrays now were objects.
    let named = || from_slice(text).map(|Named { nodes: _ }| "1.0".to_owned());
    let stated = word.or_else(|_| number()).or_else(|_| profile());
    stated.or_else(|_| named()).ok()
}

#[derive(serde::Deserialize)]
struct Named {
    #[allow(dead_code, clippy::zero_sized_map_values, reason = "only its type matters")]
    nodes: std::collections::HashMap<String, serde::de::IgnoredAny>,
}

#[derive(serde::Deserialize)]
struct Versioned<T> {
    asset: T,
}

#[derive(serde::Deserialize)]
struct Version<T> {
    version: T,
}

#[derive(serde::Deserialize)]
struct Profiled {
    profile: Version<String>,
}

/// Whether JSON has this word anywhere. Text is searched several times as fast as bytes; what is not UTF-8 may stand in values
/// that nothing reads.
fn has(json: &[u8], word: &str) -> bool {
    String::from_utf8_lossy(json).contains(word)
}

/// Cuts text of the file, which may have any length.
fn shortened(text: &str) -> String {
    text.chars().take(120).collect()
}

#[cfg(test)]
mod tests;
