//! Reads scenes and meshes.
//!
//! [`load`] reads a `.scn` file and the files that it names; [`load_from_bytes`] does the same without the disk;
//! [`load_any`] reads a scene or a mesh from a pipe. [`mesh`] reads mesh files. Every error has file, line and column, what
//! was found and what was expected. `docs/scene-language.md` is the reference of `.scn`.

mod alike;
mod budget;
mod detect;
pub(crate) mod environment;
mod files;
mod foreign;
#[cfg(feature = "gltf")]
mod gltf;
mod left_out;
pub mod mesh;
mod obj;
mod off;
mod offset;
mod place;
pub mod ply;
mod polygon;
mod reason;
mod scn;
mod source;
mod stl;
mod textures;
#[cfg(feature = "threemf")]
mod threemf;
#[cfg(feature = "textures")]
pub(crate) mod tiff;
mod vertices;
#[cfg(feature = "vtk")]
mod vtk;
#[cfg(any(feature = "threemf", feature = "vtk"))]
mod xml;

#[cfg(feature = "cli")]
pub(crate) use {detect::load_any_shown, source::open_file};

pub use detect::{Detected, Loaded, detect, load_any};

use crate::{error::LoadError, scene::Scene};
use budget::Budget;
pub(crate) use budget::Limits;
use files::{Disk, Given, MAX_TEXT_BYTES};
use std::{
    io,
    path::{Path, PathBuf},
};

/// Provides the bytes of a file: a mesh, a file that a mesh names, or an included scene. The path is as written in the file
/// that names it, joined to that file's folder.
pub type OpenMesh<'a> = &'a mut dyn FnMut(&Path) -> io::Result<Vec<u8>>;

/// Loads a `.scn` file and the meshes and scene files that it names. Paths are relative to the file that contains them. A
/// mesh that is named again with the same placement is not read again: its copy would be invisible inside the first, which
/// keeps its material.
///
/// # Errors
/// [`LoadError`], with the place of the fault: a file that cannot be read or is not a regular file, a statement that is
/// not understood, a broken mesh.
pub fn load(path: &Path) -> Result<Scene, LoadError> {
    load_within(path, &mut Vec::new(), u64::MAX)
}

/// Checks that a path is a regular file, as [`load`] does, without reading it.
///
/// # Errors
/// [`LoadError`].
pub fn check_file(path: &Path) -> Result<(), LoadError> {
    files::check_is_file(path).map_err(|error| files::load_error(path, &error))
}

/// Refuses a file that is of another kind by its first bytes, and says which.
///
/// # Errors
/// [`LoadError`].
#[cfg(feature = "cli")]
pub(crate) fn refuse_foreign(path: &Path, start: &[u8]) -> Result<(), LoadError> {
    foreign::refuse(start, path, "expected a scene or a mesh")
}

/// Whether the beginning of a file without the extension `.scn` is that of a scene. If it has another extension than
/// `.txt`, a misspelt statement does not count.
#[cfg(feature = "cli")]
pub(crate) fn is_scene_file(path: &Path, start: &[u8]) -> bool {
    let text = start.strip_prefix(place::BYTE_ORDER_MARK).unwrap_or(start);
    let is_any_text = path
        .extension()
        .is_none_or(|extension| extension.eq_ignore_ascii_case("txt"));
    !start.contains(&0) && detect(start) == Detected::Scene && (is_any_text || scn::is_well_spelt(text))
}

/// Refuses a model that octray does not read, by its first bytes or else its extension, and says how to convert it. A text that
/// begins with a statement of a scene is one, whatever it is called.
///
/// # Errors
/// [`LoadError`].
#[cfg(feature = "cli")]
pub(crate) fn refuse_unread(path: &Path, start: &[u8]) -> Result<(), LoadError> {
    match foreign::fault_by_name(path) {
        Some(by_name) if !scn::begins_with_statement(start) => {
            let message = foreign::fault(start, "expected a scene or a mesh").unwrap_or(by_name);
            Err(reason::Reason::unsupported(message).of_file(path))
        }
        _ => Ok(()),
    }
}

/// The number of frames of a scene file, `None` if nothing moves. Reads only scene files, no meshes.
///
/// # Errors
/// [`LoadError`] if the file cannot be read.
#[cfg(feature = "cli")]
pub(crate) fn frames(path: &Path) -> Result<Option<u32>, LoadError> {
    scn::frames(path)
}

/// As [`load`], with the text of the `.scn` file from a reader such as a pipe. `name` stands for the file in errors;
/// paths are relative to its folder, or to the current folder if it has none. `asked` and `memory` are as in
/// [`load_within`].
///
/// # Errors
/// [`LoadError`], as for [`load_within`]; also if the text is too long for a scene.
pub fn load_from_reader(
    reader: impl io::Read,
    name: &Path,
    asked: &mut Vec<PathBuf>,
    memory: u64,
) -> Result<Scene, LoadError> {
    let budget = Budget::new(memory);
    let text = files::read_all(reader, MAX_TEXT_BYTES, &budget);
    let text = text.map_err(|error| files::load_error(name, &error))?;
    scn::parse(&text, name, &mut Disk { asked }, &budget)
}

/// As [`load`], and adds to `asked` every file that it tried to open, also those that it could not read, to be watched
/// for changes. The scene may take `memory` bytes, including the build of its BVH; that is an estimate.
///
/// # Errors
/// [`LoadError`], as for [`load`]; also if the scene or one of its files would take more memory.
pub fn load_within(path: &Path, asked: &mut Vec<PathBuf>, memory: u64) -> Result<Scene, LoadError> {
    load_limited(path, asked, memory)
}

/// As [`load_within`].
pub(crate) fn load_limited(
    path: &Path,
    asked: &mut Vec<PathBuf>,
    limits: impl Into<Limits>,
) -> Result<Scene, LoadError> {
    asked.push(path.to_path_buf());
    let budget = Budget::new(limits);
    let text = files::read_text(path, &budget).map_err(|error| files::load_error(path, &error))?;
    scn::parse(&text, path, &mut Disk { asked }, &budget)
}

/// Loads a scene from the text of a `.scn` file. `name` stands for the file in errors, and paths are relative to its
/// folder. `open` gives the bytes of the files that the scene names, once for each `include` and at least once for each
/// mesh; `.` components of paths are ignored when paths are compared.
///
/// ```
/// use octray::format::load_from_bytes;
/// use std::{io, path::Path};
///
/// # fn main() -> Result<(), octray::error::LoadError> {
/// let triangle = "ply\nformat ascii 1.0\n\
///     element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
///     element face 1\nproperty list uchar int vertex_indices\nend_header\n\
///     0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
/// let scene = load_from_bytes(
///     b"light 9 -4 10 0.7\nmaterial 1\nsphere 0 0 0.4 0.4\nply_file triangle.ply\n",
///     Path::new("example.scn"),
///     &mut |path| match path.to_str() {
///         Some("triangle.ply") => Ok(triangle.into()),
///         _ => Err(io::ErrorKind::NotFound.into()),
///     },
/// )?;
/// assert_eq!(scene.primitive_count(), 2);
/// # Ok(())
/// # }
/// ```
///
/// # Errors
/// [`LoadError`], as for [`load`].
pub fn load_from_bytes(text: &[u8], name: &Path, open: OpenMesh<'_>) -> Result<Scene, LoadError> {
    load_from_bytes_within(text, name, open, u64::MAX)
}

/// As [`load_from_bytes`], within `memory` bytes: a few bytes of an untrusted file may be an image of a gigabyte.
///
/// # Errors
/// [`LoadError`], as for [`load`]; also if the scene or one of its files would take more memory.
pub fn load_from_bytes_within(
    text: &[u8],
    name: &Path,
    open: OpenMesh<'_>,
    memory: u64,
) -> Result<Scene, LoadError> {
    scn::parse(text, name, &mut Given(open), &Budget::new(memory))
}
