//! Files that are neither scenes nor meshes, known by their first bytes: their errors say what they are.

use crate::error::LoadError;
use std::path::Path;

const KINDS: [(&[u8], &str); 21] = [
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
    (b"BLENDER-v", "a Blender file"),
    (b"BLENDER_v", "a Blender file"),
    (b"BLENDER17-", "a Blender file"),
    (b"Kaydara FBX Binary", "an FBX file"),
    (b"PXR-USDC", "a USD file"),
    (b"ISO-10303-21;", "a STEP file"),
    (b"\x7fELF", "a program"),
    (b"\x1f\x8b", "compressed by gzip"),
    (b"\x28\xb5\x2f\xfd", "compressed by Zstandard"),
    (b"\xfd7zXZ\0", "compressed by xz"),
    (b"BZh9", "compressed by bzip2"),
];

/// The error about the contents of such a file, which ends with what is `expected`.
pub(super) fn fault(bytes: &[u8], expected: &str) -> Option<String> {
    let (_, kind) = KINDS.iter().find(|(start, _)| bytes.starts_with(start))?;
    Some(format!("this is {kind}, {expected}"))
}

/// Refuses them.
pub(super) fn refuse(bytes: &[u8], path: &Path, expected: &str) -> Result<(), LoadError> {
    match fault(bytes, expected) {
        Some(message) => Err(LoadError::whole_file(path, message)),
        None => Ok(()),
    }
}
