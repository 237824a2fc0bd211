//! Files that are neither scenes nor meshes that octray reads, known by their first bytes or their extension: their errors say
//! what they are.

use crate::error::LoadError;
use std::path::Path;

const KINDS: [(&[u8], &str); 15] = [
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"GIF87a", "a GIF picture"),
    (b"GIF89a", "a GIF picture"),
    (b"II*\0", "a TIFF picture"),
    (b"MM\0*", "a TIFF picture"),
    (b"\x76\x2f\x31\x01", "an EXR picture"),
    (b"RIFF", "a WebP picture or another RIFF file"),
    (b"#?RADIANCE", "an HDR picture"),
    (b"%PDF-", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"\x1f\x8b", "compressed by gzip"),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard"),
    (b"\xfd7zXZ\0", "compressed by xz"),
    (b"BZh9", "compressed by bzip2"),
];

/// A kind of models that octray does not read.
struct Model {
    /// What files begin with.
    starts: &'static [&'static [u8]],
    extensions: &'static [&'static str],
    name: &'static str,
    /// A program that makes glTF of it.
    converter: &'static str,
}

const fn model(
    starts: &'static [&'static [u8]],
    extensions: &'static [&'static str],
    name: &'static str,
    converter: &'static str,
) -> Model {
    Model {
        starts,
        extensions,
        name,
        converter,
    }
}

const MODELS: [Model; 10] = [
    model(
        &[b"BLENDER-v", b"BLENDER_v", b"BLENDER17-"],
        &["blend"],
        "a Blender file",
        "Blender",
    ),
    model(&[b"Kaydara FBX Binary"], &["fbx"], "an FBX file", "Blender"),
    model(
        &[b"PXR-USDC"],
        &["usd", "usda", "usdc", "usdz"],
        "a USD file",
        "Blender",
    ),
    model(&[b"ISO-10303-21;"], &["step", "stp"], "a STEP file", "FreeCAD"),
    model(&[], &["iges", "igs"], "an IGES file", "FreeCAD"),
    model(&[], &["dae"], "COLLADA", "Blender"),
    model(&[], &["3ds"], "a 3D Studio file", "Blender"),
    model(&[], &["wrl", "x3d"], "VRML or X3D", "Blender"),
    model(&[], &["vtk", "vtp", "vtu"], "a VTK file", "ParaView"),
    model(&[], &["svg"], "an SVG drawing", "Blender"),
];

impl Model {
    fn fault(&self) -> String {
        let Self { name, converter, .. } = self;
        format!(
            "this is {name}, which octray does not read; convert it to glTF (.glb), for example with {converter}"
        )
    }
}

/// The error about the contents of such a file, which ends with what is `expected`.
pub(super) fn fault(bytes: &[u8], expected: &str) -> Option<String> {
    if let Some((_, kind)) = KINDS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Some(format!("this is {kind}, {expected}"));
    }
    let is_start = |model: &&Model| model.starts.iter().any(|start| bytes.starts_with(start));
    MODELS.iter().find(is_start).map(Model::fault)
}

/// The error about a model of another program, known by its file's extension.
pub(super) fn fault_by_name(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_str()?.to_ascii_lowercase();
    let is_named = |model: &&Model| model.extensions.contains(&&*extension);
    MODELS.iter().find(is_named).map(Model::fault)
}

/// Refuses them by their contents.
pub(super) fn refuse(bytes: &[u8], path: &Path, expected: &str) -> Result<(), LoadError> {
    // USDZ is a ZIP archive, as 3MF.
    let by_name = || fault_by_name(path).filter(|_| bytes.starts_with(super::mesh::ZIP));
    match fault(bytes, expected).or_else(by_name) {
        Some(message) => Err(LoadError::whole_file(path, message)),
        None => Ok(()),
    }
}
