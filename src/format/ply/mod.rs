//! PLY meshes: text, and binary of both byte orders; any scalar types; elements and properties in any order.
//!
//! Polygons become triangles, also concave ones (`format/polygon.rs`). Faces of fewer than three corners are skipped.
//! Vertices have positions, normals and colours. A file without faces is a cloud of points. Triangle strips (`tristrips`, of Cyberware's and Stanford's programs) are read. A header line `comment up z` names the
//! up axis; y is up without one.
//!
//! serde-ply parses the header. Our own loops read the values: they know the place of every error, write straight into
//! the arrays, and never trust a count that the file is too short for.
//!
//! Format: Greg Turk, *The PLY Polygon File Format*, 1994.

mod ascii;
mod binary;
mod faces;
mod fixed;
mod header;
mod lines;
mod rows;

use super::{
    budget::Budget,
    files,
    mesh::{Cloud, LoadedMesh, MeshFormat, UpAxis, UpSource, clamp_colors, clamped_note},
    source::{OpenFile, Opened, Pieces},
};
use crate::{
    error::{LoadError, SourcePos},
    scene::TriangleMesh,
};
use ascii::Text;
use binary::Binary;
use header::{COLOR_SLOT, Header, Step};
use rows::{Fault, Place};
use serde_ply::PlyFormat;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Reads a mesh. `name` stands for the file in errors. A file without vertices or faces is an empty mesh.
///
/// An error in a binary file is placed by its record, counted from 1, instead of its line.
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
/// [`LoadError`]: a header that is not understood or promises more than the file holds, a value that is not a number,
/// not finite or too large, a vertex index out of range, a file that is cut short.
pub fn parse(bytes: &[u8], name: &Path) -> Result<TriangleMesh, LoadError> {
    parse_mesh(bytes, name, true, &Budget::unlimited()).map(|mesh| mesh.columns)
}

/// As [`parse`], with what the header says about the mesh; colours are left out unless it `keeps_colors`.
pub(super) fn parse_mesh(
    bytes: &[u8],
    name: &Path,
    keeps_colors: bool,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let error = |fault: Fault| fault_to_error(bytes, &Arc::new(name.to_path_buf()), &fault);
    let mut header = Header::parse(bytes, bytes.len()).map_err(error)?;
    if !keeps_colors {
        skip_colors(&mut header);
    }
    let mesh = match header.format {
        PlyFormat::Ascii => rows::read_all(&header, &mut Text::new(bytes, header.body), budget),
        PlyFormat::BinaryLittleEndian => {
            rows::read_all(&header, &mut Binary::<false>::new(bytes, header.body), budget)
        }
        PlyFormat::BinaryBigEndian => {
            rows::read_all(&header, &mut Binary::<true>::new(bytes, header.body), budget)
        }
    };
    Ok(loaded(mesh.map_err(error)?, &header, name))
}

/// Reads a mesh piece by piece if its layout allows it, so that the file's bytes are not kept beside the mesh.
pub(super) fn read(
    opened: Opened,
    name: &Path,
    keeps_colors: bool,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let before = budget.taken();
    if let Opened::File(file) = &opened
        && let Some(mesh) = read_pieces(file, name, keeps_colors, budget)?
    {
        return Ok(mesh);
    }
    budget.give_back_to(before);
    let bytes = opened.into_bytes(budget);
    let bytes = bytes.map_err(|error| files::load_error(name, &error))?;
    parse_mesh(&bytes, name, keeps_colors, budget)
}

/// Files with longer headers, in bytes, are read whole.
const HEAD: usize = 1 << 14;

/// `None` if the whole file has to be read.
fn read_pieces(
    file: &OpenFile,
    name: &Path,
    keeps_colors: bool,
    budget: &Budget,
) -> Result<Option<LoadedMesh>, LoadError> {
    let mut head = Vec::new();
    let Some(head) = file.piece(0, file.length().min(HEAD), &mut head) else {
        return Ok(None);
    };
    if header::find_end(head).is_err() {
        return Ok(None);
    }
    let error = |fault: Fault| fault_to_error(head, &Arc::new(name.to_path_buf()), &fault);
    let mut header = Header::parse(head, file.length()).map_err(error)?;
    if !keeps_colors {
        skip_colors(&mut header);
    }
    let mesh = match header.format {
        PlyFormat::Ascii => Ok(None),
        PlyFormat::BinaryLittleEndian => fixed::read_all::<false>(&header, file, budget),
        PlyFormat::BinaryBigEndian => fixed::read_all::<true>(&header, file, budget),
    };
    let columns = mesh.map_err(error)?;
    Ok(columns.map(|columns| loaded(columns, &header, name)))
}

/// Leaves colours out: what a mesh could not have, such as NaN, is no fault then.
fn skip_colors(header: &mut Header) {
    header.has_colors = false;
    for step in header.elements.iter_mut().flat_map(|element| &mut element.steps) {
        if let Step::Keep {
            slot: COLOR_SLOT..,
            scalar,
        } = *step
        {
            *step = Step::Skip(scalar);
        }
    }
}

/// The mesh with what its header says. PLY has no field for the up axis, and y is what most programs write.
fn loaded(mut columns: TriangleMesh, header: &Header, name: &Path) -> LoadedMesh {
    let clamped = clamp_colors(&mut columns.colors);
    let notes = [clamped_note(clamped, name), header.left_out().note(name)];
    LoadedMesh {
        columns,
        cloud: header.is_cloud().then(Cloud::default),
        up: header.up.unwrap_or(UpAxis::Y),
        up_source: match header.up {
            Some(_) => UpSource::Stated,
            None => UpSource::Assumed(MeshFormat::Ply),
        },
        notes: notes.into_iter().flatten().collect(),
        ..LoadedMesh::default()
    }
}

/// Adds the place of a fault.
fn fault_to_error(bytes: &[u8], file: &Arc<PathBuf>, fault: &Fault) -> LoadError {
    match &fault.place {
        Place::File => LoadError::whole_file(file, &fault.message),
        Place::Record(record) => LoadError::new(SourcePos::record(file, *record), &fault.message),
        Place::Text(range) => LoadError::in_text(file, bytes, range.clone(), &fault.message),
    }
}

#[cfg(test)]
mod tests;
