//! Loads meshes from files and bytes, and chooses the reader of their format.

#[cfg(feature = "gltf")]
use super::super::gltf;
#[cfg(feature = "threemf")]
use super::super::threemf;
#[cfg(feature = "vtk")]
use super::super::vtk;
#[cfg(any(feature = "gltf", feature = "threemf"))]
use super::used;
use super::{
    super::{
        OpenMesh,
        budget::Budget,
        files::{self, Companions},
        foreign, obj, off,
        place::{BYTE_ORDER_MARK, LFS_POINTER, is_lfs_pointer},
        ply,
        reason::Reason,
        scn,
        source::Opened,
        stl,
    },
    LoadedMesh, MeshFormat, Moment, Sharing, far, scalars,
};
#[cfg(feature = "cli")]
use super::{MeshAnimation, Shown};
use crate::error::{LoadError, LoadErrorKind, clip_path};
use std::path::{Path, PathBuf};

/// Loads a mesh file and the files that it names.
///
/// # Errors
/// [`LoadError`], with the place of the fault as far as the format has places.
pub fn load(path: &Path) -> Result<LoadedMesh, LoadError> {
    load_within(path, &mut Vec::new(), u64::MAX)
}

/// As [`load`], and adds to `asked` every file that it tried to open, to be watched for changes. All files and the mesh
/// may take `memory` bytes together.
///
/// # Errors
/// [`LoadError`], as for [`load`].
pub fn load_within(path: &Path, asked: &mut Vec<PathBuf>, memory: u64) -> Result<LoadedMesh, LoadError> {
    load_budgeted(path, asked, &Budget::new(memory))
}

/// As [`load`], for a glTF file in the pose of an animation.
///
/// # Errors
/// [`LoadError`], as for [`load`]; also if the file has no such animation.
pub fn load_posed(path: &Path, moment: Moment) -> Result<LoadedMesh, LoadError> {
    let budget = Budget::new(u64::MAX).with_moment(Some(moment));
    load_budgeted(path, &mut Vec::new(), &budget)
}

/// As [`load_within`]; parts that are placed several times may be stored once, in [`LoadedMesh::shared`].
///
/// # Errors
/// [`LoadError`], as for [`load`].
pub fn load_shared(
    path: &Path,
    asked: &mut Vec<PathBuf>,
    memory: u64,
    sharing: Sharing,
) -> Result<LoadedMesh, LoadError> {
    load_budgeted(path, asked, &Budget::new(memory).with_sharing(sharing))
}

/// As [`load_shared`], for a mesh of which this is `shown`.
#[cfg(feature = "cli")]
pub(crate) fn load_shown(
    path: &Path,
    asked: &mut Vec<PathBuf>,
    limits: impl Into<super::super::Limits>,
    shown: Shown,
) -> Result<LoadedMesh, LoadError> {
    let budget = Budget::new(limits)
        .with_sharing(shown.sharing())
        .with_moment(shown.moment)
        .with_scalars(shown.scalars);
    budget.set_wants_images(shown.images);
    load_budgeted(path, asked, &budget)
}

/// Lists the animations of a mesh file, without reading anything else.
///
/// # Errors
/// [`LoadError`], as for [`load`].
#[cfg(feature = "cli")]
pub(crate) fn animations(path: &Path, memory: u64) -> Result<Vec<MeshAnimation>, LoadError> {
    let budget = Budget::new(memory);
    let failed = |error| files::load_error(path, &error);
    let opened = Opened::File(files::open(path, &budget).map_err(failed)?);
    let mut head = Vec::new();
    let head = opened.head(TEXT_HEAD, &mut head);
    if MeshFormat::of(path, head) != Some(MeshFormat::Gltf) {
        return Ok(Vec::new());
    }
    let bytes = opened.into_bytes(&budget).map_err(failed)?;
    gltf::animations(&bytes, path, &budget)
}

fn load_budgeted(path: &Path, asked: &mut Vec<PathBuf>, budget: &Budget) -> Result<LoadedMesh, LoadError> {
    asked.push(path.to_path_buf());
    far::read(budget, path, || {
        let file = files::open(path, budget).map_err(|error| files::load_error(path, &error))?;
        let mut companions = Companions::new(asked);
        let mut mesh = read(
            Opened::File(file),
            path,
            &mut |path| companions.read(path, budget),
            budget,
        )?;
        mesh.notes.extend(companions.note(path));
        Ok(mesh)
    })
}

/// This many bytes tell whether an .obj file is text.
const TEXT_HEAD: usize = 4096;

/// Reads a mesh from its file, piece by piece if its format allows it. Its memory is taken from the budget; `open` takes the
/// bytes that it returns from the budget, too.
pub(in crate::format) fn read(
    opened: Opened,
    path: &Path,
    open: OpenMesh<'_>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let mut head = Vec::new();
    let head = opened.head(TEXT_HEAD, &mut head);
    foreign::refuse(head, path, MeshFormat::EXPECTED)?;
    let format = MeshFormat::of(path, head);
    if let Some(format) = format {
        check_name(format, path, head)?;
        check_moment(format, path, budget)?;
        check_scalar(format, path, budget)?;
    }
    match format {
        Some(MeshFormat::Ply) => return ply::read(opened, path, Some(open), budget),
        Some(MeshFormat::Stl) => return stl::read(opened, path, budget),
        // Refused now: reading gigabytes first would take seconds.
        Some(MeshFormat::Obj) if head.contains(&0) => return obj::parse(head, path, open, budget),
        _ => {}
    }
    let bytes = opened.into_bytes(budget);
    let bytes = bytes.map_err(|error| files::load_error(path, &error))?;
    match MeshFormat::of(path, &bytes) {
        Some(format) => parse_as(format, &bytes, path, open, budget),
        None => Err(unknown_format(path)),
    }
}

/// Reads a mesh from the bytes of its file. `path` is the file's name in errors; its extension determines the format if the
/// bytes do not. `open` provides the files that the mesh names (an .mtl, a .bin), by paths joined to its folder.
///
/// # Errors
/// [`LoadError`], as for [`load`].
pub fn parse(bytes: Vec<u8>, path: &Path, open: OpenMesh<'_>) -> Result<LoadedMesh, LoadError> {
    parse_budgeted(bytes, path, open, &Budget::unlimited())
}

/// As [`parse`], within `memory` bytes. Images that do not fit are left out with a note.
///
/// # Errors
/// [`LoadError`], as for [`load`]; also if the mesh would take more memory.
pub fn parse_within(
    bytes: Vec<u8>,
    path: &Path,
    open: OpenMesh<'_>,
    memory: u64,
) -> Result<LoadedMesh, LoadError> {
    parse_budgeted(bytes, path, open, &Budget::new(memory))
}

/// As [`parse`], for a glTF file in the pose of an animation.
///
/// # Errors
/// [`LoadError`], as for [`load`]; also if the file has no such animation.
pub fn parse_posed(
    bytes: Vec<u8>,
    path: &Path,
    open: OpenMesh<'_>,
    moment: Moment,
) -> Result<LoadedMesh, LoadError> {
    parse_budgeted(bytes, path, open, &Budget::unlimited().with_moment(Some(moment)))
}

/// As [`parse`]; parts that are placed several times may be stored once, in [`LoadedMesh::shared`].
///
/// # Errors
/// [`LoadError`], as for [`load`].
pub fn parse_shared(
    bytes: Vec<u8>,
    path: &Path,
    open: OpenMesh<'_>,
    sharing: Sharing,
) -> Result<LoadedMesh, LoadError> {
    parse_budgeted(bytes, path, open, &Budget::unlimited().with_sharing(sharing))
}

#[allow(
    clippy::needless_pass_by_value,
    reason = "frees the bytes once the mesh is read; both are large"
)]
fn parse_budgeted(
    bytes: Vec<u8>,
    path: &Path,
    open: OpenMesh<'_>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    foreign::refuse(&bytes, path, MeshFormat::EXPECTED)?;
    match MeshFormat::of(path, &bytes) {
        Some(format) => {
            check_name(format, path, &bytes)?;
            far::read(budget, path, || parse_as(format, &bytes, path, open, budget))
        }
        None => Err(unknown_format(path)),
    }
}

fn unknown_format(path: &Path) -> LoadError {
    let unknown = || format!("unknown kind of file, {}", MeshFormat::EXPECTED);
    Reason::unsupported(foreign::fault_by_name(path).unwrap_or_else(unknown)).of_file(path)
}

/// Refuses text that is evidently another mesh format than its extension says.
fn check_name(format: MeshFormat, path: &Path, bytes: &[u8]) -> Result<(), LoadError> {
    let head = bytes.get(..TEXT_HEAD).unwrap_or(bytes);
    let head = head.strip_prefix(BYTE_ORDER_MARK).unwrap_or(head);
    let is_stl = || head.starts_with(b"solid") && head.windows(6).any(|word| word == b"facet ");
    let found = if head.contains(&0) {
        return Ok(());
    } else if head.trim_ascii_start().starts_with(b"{") {
        MeshFormat::Gltf
    } else if off::is_off(head) {
        MeshFormat::Off
    } else if is_stl() {
        MeshFormat::Stl
    } else if scn::is_obj(head) {
        MeshFormat::Obj
    } else {
        return Ok(());
    };
    if found == format {
        return Ok(());
    }
    let name = found.name();
    let renamed = path.with_extension(name.to_ascii_lowercase());
    let renamed = clip_path(Path::new(renamed.file_name().unwrap_or_default()));
    let article = if found == MeshFormat::Gltf { "a" } else { "an" };
    let message = format!("this looks like {article} {name} mesh; rename it to `{renamed}`");
    Err(LoadError::whole_file(path, message))
}

/// Refuses a moment of an animation in a file that has none.
fn check_moment(format: MeshFormat, path: &Path, budget: &Budget) -> Result<(), LoadError> {
    if budget.moment().is_none() || format == MeshFormat::Gltf {
        return Ok(());
    }
    let why = "there is no animation in the file: octray reads those of glTF";
    Err(LoadError::whole_file(path, why).with_kind(LoadErrorKind::Absent))
}

/// Refuses numbers by name in a file whose format has none.
fn check_scalar(format: MeshFormat, path: &Path, budget: &Budget) -> Result<(), LoadError> {
    match budget.scalars().name() {
        Some(name) if !matches!(format, MeshFormat::Ply | MeshFormat::Gltf | MeshFormat::Vtk) => {
            Err(scalars::absent(name, &[]).of_file(path))
        }
        _ => Ok(()),
    }
}

/// As [`parse`], for a known format. The bytes are already taken from the budget.
pub(in crate::format) fn parse_as(
    format: MeshFormat,
    bytes: &[u8],
    path: &Path,
    open: OpenMesh<'_>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    if is_lfs_pointer(bytes) {
        return Err(LoadError::whole_file(path, LFS_POINTER));
    }
    check_moment(format, path, budget)?;
    check_scalar(format, path, budget)?;
    match format {
        MeshFormat::Ply => ply::parse_mesh(bytes, path, Some(open), budget),
        MeshFormat::Obj => obj::parse(bytes, path, open, budget),
        MeshFormat::Off => off::parse(bytes, path, budget),
        MeshFormat::Stl => stl::parse(bytes, path, budget),
        #[cfg(feature = "gltf")]
        MeshFormat::Gltf => used::only(gltf::parse(bytes, path, open, budget)?, path, budget),
        #[cfg(not(feature = "gltf"))]
        MeshFormat::Gltf => Err(Reason::unsupported(
            "glTF is not read: octray was built without its feature `gltf`",
        )
        .of_file(path)),
        #[cfg(feature = "threemf")]
        MeshFormat::ThreeMf => used::only(threemf::parse(bytes, path, budget)?, path, budget),
        #[cfg(not(feature = "threemf"))]
        MeshFormat::ThreeMf => Err(Reason::unsupported(
            "3MF is not read: octray was built without its feature `threemf`",
        )
        .of_file(path)),
        #[cfg(feature = "vtk")]
        MeshFormat::Vtk => vtk::parse(bytes, path, budget),
        #[cfg(not(feature = "vtk"))]
        MeshFormat::Vtk => Err(Reason::unsupported(
            "VTK is not read: octray was built without its feature `vtk`",
        )
        .of_file(path)),
    }
}
