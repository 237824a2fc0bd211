//! PLY meshes: text, and binary of both byte orders; any scalar types; elements and properties in any order.
//!
//! Polygons become triangles, also concave ones (`format/polygon.rs`). Faces of fewer than three corners are left out.
//! Vertices have positions, normals, colours and texture coordinates; faces have colours, texture coordinates of their
//! corners, and the number of a texture. A file without faces shows its vertices as points, and the lines between them
//! (`edge`, with `vertex1` and `vertex2`). Triangle strips (`tristrips`, of Cyberware's and Stanford's programs) are read.
//! Header lines name the up axis, which is y without `comment up z`, and the images of textures, as MeshLab does:
//! `comment TextureFile NAME`.
//!
//! ```text
//! header ── choice: what is shown ── rows, painted; fixed, lines: fast paths ── finish: images, surfaces
//! ```
//!
//! serde-ply parses the header. Our own loops read the values: they locate every error, write directly into the arrays, and
//! never trust a count that exceeds the file.
//!
//! Format: Greg Turk, *The PLY Polygon File Format*, 1994.

mod ascii;
mod at;
mod binary;
mod choice;
mod columns;
mod faces;
mod fault;
mod finish;
mod fixed;
mod header;
mod lines;
mod painted;
mod rows;
mod slots;
mod values;

#[cfg(feature = "vtk")]
pub(super) use finish::paint;
#[cfg(feature = "cli")]
pub(crate) use finish::paint_triangles;

use super::{
    OpenMesh,
    budget::Budget,
    files,
    mesh::{LoadedMesh, Unusable, Wanted},
    source::{OpenFile, Opened, Pieces},
};
use crate::{error::LoadError, scene::TriangleMesh};
use ascii::Text;
use binary::Binary;
use faces::Faces;
use fault::{Fault, Place};
use header::{Header, Role, Step};
use serde_ply::{PlyFormat, ScalarType};
use slots::NORMAL_SLOT;
use std::{
    io,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Reads a mesh. `name` stands for the file in errors. A file without vertices or faces is an empty mesh. Vertices that no
/// face uses are left out, and so are faces and points with coordinates that are NaN or too large.
///
/// An error in a binary file names the record, counted from 1, and its first byte, instead of a line.
///
/// ```
/// let bytes = b"ply\nformat ascii 1.0\n\
///     element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
///     element face 1\nproperty list uchar int vertex_indices\nend_header\n\
///     0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
/// let mesh = octray::format::ply::parse(bytes, "square.ply".as_ref())?;
/// assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
/// # Ok::<(), octray::error::LoadError>(())
/// ```
///
/// # Errors
/// [`LoadError`]: a header that is not understood or promises more than the file holds, a file that is cut short, a value
/// that is not a number, a vertex index out of range, only positions that are NaN or too large.
pub fn parse(bytes: &[u8], name: &Path) -> Result<TriangleMesh, LoadError> {
    let no_images = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    parse_mesh(bytes, name, Some(no_images), &Budget::unlimited()).map(|mesh| mesh.columns)
}

/// As [`parse`], with the file's other contents. `open` provides the images that it names; without it, colours and textures
/// are ignored.
pub(super) fn parse_mesh(
    bytes: &[u8],
    name: &Path,
    open: Option<OpenMesh<'_>>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let read = read_values(bytes, name, open.is_some(), budget)?;
    finish(read, name, open, budget)
}

/// Reads a mesh piece by piece if its layout allows it, so that the file is never in memory together with the mesh.
pub(super) fn read(
    opened: Opened,
    name: &Path,
    open: Option<OpenMesh<'_>>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let before = budget.taken();
    let shows_colors = open.is_some();
    if let Opened::File(file) = &opened
        && let Some(read) = read_pieces(file, name, shows_colors, budget)?
    {
        return finish(read, name, open, budget);
    }
    budget.give_back_to(before);
    let bytes = opened.into_bytes(budget);
    let bytes = bytes.map_err(|error| files::load_error(name, &error))?;
    let read = read_values(&bytes, name, shows_colors, budget)?;
    let capacity = bytes.capacity();
    drop(bytes);
    budget.give_back(capacity);
    finish(read, name, open, budget)
}

/// A header, the vertices and faces that follow, and the unusable ones of these vertices.
struct Read<'b> {
    header: Header,
    vertices: TriangleMesh,
    faces: Faces<'b>,
    unusable: Unusable<LoadError>,
}

/// The header at the start of `bytes`, of a file of `length` bytes, without what is not read.
fn read_header(
    (bytes, length): (&[u8], usize),
    shows_colors: bool,
    budget: &Budget,
) -> Result<Header, Fault> {
    let mut header = Header::parse(bytes, length)?;
    header.shows_numbers = !budget.scalars().shows_colors();
    if !shows_colors || header.shows_numbers {
        header.skip_colors();
    }
    if let Some(name) = budget.scalars().name() {
        header.keep_value(name)?;
    }
    if is_single(&header) {
        budget.add_single_reach(f32::MAX);
    }
    Ok(header)
}

fn read_values<'b>(
    bytes: &[u8],
    name: &Path,
    shows_colors: bool,
    budget: &'b Budget,
) -> Result<Read<'b>, LoadError> {
    let error = |fault: Fault| fault_to_error(bytes, &Arc::new(name.to_path_buf()), &fault);
    let header = read_header((bytes, bytes.len()), shows_colors, budget).map_err(error)?;
    let read = match header.format {
        PlyFormat::Ascii => rows::read_all(&header, &mut Text::new(bytes, header.body), budget),
        PlyFormat::BinaryLittleEndian => {
            rows::read_all(&header, &mut Binary::<false>::new(bytes, header.body), budget)
        }
        PlyFormat::BinaryBigEndian => {
            rows::read_all(&header, &mut Binary::<true>::new(bytes, header.body), budget)
        }
    };
    let (vertices, mut faces) = read.map_err(error)?;
    if *budget.scalars() == Wanted::Ranges {
        faces.values.listed = header.ranges(bytes);
    }
    Ok(Read {
        header,
        vertices,
        unusable: std::mem::take(&mut faces.unusable).map(error),
        faces,
    })
}

/// Files with longer headers, in bytes, are read whole.
const HEAD: usize = 1 << 14;

/// `None` if the whole file has to be read.
fn read_pieces<'b>(
    file: &OpenFile,
    name: &Path,
    shows_colors: bool,
    budget: &'b Budget,
) -> Result<Option<Read<'b>>, LoadError> {
    let mut head = Vec::new();
    let Some(head) = file.piece(0, file.length().min(HEAD), &mut head) else {
        return Ok(None);
    };
    if header::find_end(head).is_err() {
        return Ok(None);
    }
    let error = |fault: Fault| fault_to_error(head, &Arc::new(name.to_path_buf()), &fault);
    let header = read_header((head, file.length()), shows_colors, budget).map_err(error)?;
    if *budget.scalars() == Wanted::Ranges && header.has_scalars() {
        return Ok(None);
    }
    let read = match header.format {
        PlyFormat::Ascii => Ok(None),
        PlyFormat::BinaryLittleEndian => fixed::read_all::<false>(&header, file, budget),
        PlyFormat::BinaryBigEndian => fixed::read_all::<true>(&header, file, budget),
    };
    let read = read.map_err(error)?;
    Ok(read.map(|(vertices, faces)| Read {
        header,
        vertices,
        faces,
        unusable: Unusable::default(),
    }))
}

/// The mesh with its images.
fn finish(
    read: Read<'_>,
    name: &Path,
    open: Option<OpenMesh<'_>>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let no_images = &mut |_: &Path| Err(io::ErrorKind::NotFound.into());
    let Read {
        header,
        vertices,
        faces,
        unusable,
    } = read;
    let finished = finish::finish(
        (vertices, faces),
        &header,
        name,
        open.unwrap_or(no_images),
        budget,
    );
    let mut mesh = finished.map_err(|error| error.into_error(name))?;
    mesh.keep_used(unusable, name, budget)?;
    Ok(mesh)
}

/// Whether all coordinates fit into `f32` without rounding.
fn is_single(header: &Header) -> bool {
    let vertices = header.needed().filter(|element| element.role == Role::Vertex);
    let mut steps = vertices.flat_map(|element| &element.steps);
    !matches!(header.format, PlyFormat::Ascii)
        && steps.all(|step| match *step {
            Step::Keep { slot, scalar } if slot < NORMAL_SLOT => {
                !matches!(scalar, ScalarType::F64 | ScalarType::I32 | ScalarType::U32)
            }
            _ => true,
        })
}

/// Adds the place of a fault.
fn fault_to_error(bytes: &[u8], file: &Arc<PathBuf>, fault: &Fault) -> LoadError {
    let error = match &fault.place {
        Place::File => LoadError::whole_file(file, &fault.message),
        Place::Text(range) => LoadError::in_text(file, bytes, range.clone(), &fault.message),
    };
    error.with_kind(fault.kind)
}

#[cfg(test)]
mod tests;
