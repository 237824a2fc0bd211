//! Detects the format of bytes without a file name, such as those of standard input.

use super::{
    budget::Budget,
    files::{self, Disk},
    foreign,
    mesh::{self, LoadedMesh, MeshFormat},
    off,
    place::BYTE_ORDER_MARK,
    scn, stl,
};
use crate::{error::LoadError, scene::Scene};
use std::{
    io::Read,
    path::{Path, PathBuf},
};

/// The format of some bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detected {
    /// The text of a `.scn` scene.
    Scene,
    /// A mesh.
    Mesh(MeshFormat),
}

/// A scene or a mesh.
#[derive(Debug)]
pub enum Loaded {
    /// A scene.
    Scene(Box<Scene>),
    /// A mesh.
    Mesh(Box<LoadedMesh>),
}

/// Detects the format of `bytes`, the whole input.
///
/// The first that applies, in this order:
/// - PLY begins with a line `ply`.
/// - glTF begins with `glTF` or `{`.
/// - 3MF is a ZIP archive.
/// - VTK begins with `# vtk DataFile`, or is XML with the element `VTKFile`.
/// - OFF begins with `OFF` and its prefixes, such as `COFF`.
/// - STL has the size that its count of facets implies, or begins with `solid`.
/// - A scene has a `.scn` statement, perhaps misspelt, before any keyword of OBJ, or nothing but `//` comments.
/// - All else is OBJ.
///
/// ```
/// use octray::format::{Detected, detect, mesh::MeshFormat};
///
/// assert_eq!(detect(b"sphere 0 0 0 1"), Detected::Scene);
/// assert_eq!(detect(b"v 0 0 0\nv 1 0 0\n"), Detected::Mesh(MeshFormat::Obj));
/// ```
#[must_use]
pub fn detect(bytes: &[u8]) -> Detected {
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    if mesh::ply_first(text) {
        Detected::Mesh(MeshFormat::Ply)
    } else if bytes.starts_with(b"glTF") || text.trim_ascii_start().starts_with(b"{") {
        Detected::Mesh(MeshFormat::Gltf)
    } else if bytes.starts_with(mesh::ZIP) {
        Detected::Mesh(MeshFormat::ThreeMf)
    } else if mesh::is_vtk(bytes) {
        Detected::Mesh(MeshFormat::Vtk)
    } else if off::is_off(text) {
        Detected::Mesh(MeshFormat::Off)
    } else if stl::is_stl(bytes) {
        Detected::Mesh(MeshFormat::Stl)
    } else if scn::is_scene(text) {
        Detected::Scene
    } else {
        Detected::Mesh(MeshFormat::Obj)
    }
}

/// Loads a scene or a mesh of any format from a reader such as a pipe. `name` stands for the input in errors; the paths
/// that it names are relative to the folder of `name`, and to the current folder if it has none. They are added to
/// `asked`, and `memory` limits what the scene may take, in bytes, as in [`load_within`](super::load_within).
///
/// # Errors
/// [`LoadError`], as for [`load`](super::load) and [`mesh::load`].
pub fn load_any(
    reader: impl Read,
    name: &Path,
    asked: &mut Vec<PathBuf>,
    memory: u64,
) -> Result<Loaded, LoadError> {
    load_budgeted(reader, name, asked, Budget::new(memory), |budget| budget)
}

/// As [`load_any`], for a mesh of which this is `shown`: parts that are placed often may be stored once. The images of a
/// scene's meshes are always read.
#[cfg(feature = "cli")]
pub(crate) fn load_any_shown(
    reader: impl Read,
    name: &Path,
    asked: &mut Vec<PathBuf>,
    limits: impl Into<super::Limits>,
    shown: mesh::Shown,
) -> Result<Loaded, LoadError> {
    let sharing = shown.sharing();
    let budget = Budget::new(limits).with_moment(shown.moment);
    budget.set_wants_images(shown.images);
    load_budgeted(reader, name, asked, budget, |budget| {
        budget.with_sharing(sharing).with_scalars(shown.scalars)
    })
}

/// As [`load_any`]; `of_mesh` makes the budget of a mesh outside of a scene.
fn load_budgeted(
    reader: impl Read,
    name: &Path,
    asked: &mut Vec<PathBuf>,
    budget: Budget,
    of_mesh: impl FnOnce(Budget) -> Budget,
) -> Result<Loaded, LoadError> {
    let bytes = files::read_all(reader, files::MAX_BYTES, &budget);
    let bytes = bytes.map_err(|error| files::load_error(name, &error))?;
    foreign::refuse(&bytes, name, "expected a scene or a mesh")?;
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&bytes);
    if text.trim_ascii().is_empty() {
        // The program that should have written to the pipe has failed.
        return Err(LoadError::whole_file(
            name,
            "the input is empty, expected a scene or a mesh",
        ));
    }
    Ok(match detect(&bytes) {
        Detected::Scene => Loaded::Scene(Box::new(scn::parse(&bytes, name, &mut Disk { asked }, &budget)?)),
        Detected::Mesh(format) => {
            let budget = of_mesh(budget);
            let open = &mut |path: &Path| {
                asked.push(path.to_path_buf());
                files::read(path, &budget)
            };
            let read = || mesh::parse_as(format, &bytes, name, open, &budget);
            Loaded::Mesh(Box::new(mesh::read_far(&budget, name, read)?))
        }
    })
}

#[cfg(test)]
mod tests;
