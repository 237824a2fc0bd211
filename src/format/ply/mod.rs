//! PLY meshes: text and binary of both byte orders, any scalar types, elements and properties in any order;
//! what a mesh does not need is skipped. Polygons become triangles, concave ones too (`format/polygon.rs`); faces of
//! fewer than three corners are skipped. Strips of triangles (`tristrips`, as Cyberware's and Stanford's programs wrote them) are read, too.
//!
//! The header is parsed by serde-ply. The values are read by loops of our own: they know where they are when
//! something is wrong, write straight into the columns, and never believe a count that the file is too short
//! for.
//!
//! Format: Greg Turk, *The PLY Polygon File Format*, 1994.

mod ascii;
mod binary;
mod fixed;
mod header;
mod lines;
mod rows;

use super::{
    files,
    place::text_error,
    source::{OpenFile, Opened, Pieces},
};
use crate::{
    error::{LoadError, SourcePos},
    scene::MeshColumns,
};
use ascii::Text;
use binary::Binary;
use header::Header;
use rows::{Fault, Place};
use serde_ply::PlyFormat;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Reads a mesh. `name` stands for the file in errors. A file without vertices or faces is an empty mesh.
///
/// In a binary file the place of an error is the record of the element, 1-based, instead of the line.
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
/// [`LoadError`]: a header that is not understood or promises more than the file holds, a value that is no
/// number, not finite or too large, an index of a vertex that the file does not have, the end of the file.
pub fn parse(bytes: &[u8], name: &Path) -> Result<MeshColumns, LoadError> {
    let file = Arc::new(name.to_path_buf());
    let header = Header::parse(bytes, bytes.len()).map_err(|fault| fault_to_error(bytes, &file, &fault))?;
    let mesh = match header.format {
        PlyFormat::Ascii => rows::read_all(&header, &mut Text::new(bytes, header.body)),
        PlyFormat::BinaryLittleEndian => {
            rows::read_all(&header, &mut Binary::<false>::new(bytes, header.body))
        }
        PlyFormat::BinaryBigEndian => rows::read_all(&header, &mut Binary::<true>::new(bytes, header.body)),
    };
    mesh.map_err(|fault| fault_to_error(bytes, &file, &fault))
}

/// As [`parse`]: piece by piece where the file's layout allows it, so that the file is not kept beside the mesh.
pub(super) fn read(opened: Opened, name: &Path) -> Result<MeshColumns, LoadError> {
    if let Opened::File(file) = &opened
        && let Some(mesh) = read_pieces(file, name)?
    {
        return Ok(mesh);
    }
    let bytes = opened.into_bytes();
    parse(&bytes.map_err(|error| files::load_error(name, &error))?, name)
}

/// Longer headers than this, bytes, are unusual.
pub(super) const HEAD: usize = 1 << 14;

/// `None` where the whole file has to be read.
fn read_pieces(file: &OpenFile, name: &Path) -> Result<Option<MeshColumns>, LoadError> {
    let mut head = Vec::new();
    let Some(head) = file.piece(0, file.length().min(HEAD), &mut head) else {
        return Ok(None);
    };
    if header::find_end(head).is_err() {
        return Ok(None);
    }
    let mesh = Header::parse(head, file.length()).and_then(|header| match header.format {
        PlyFormat::Ascii => Ok(None),
        PlyFormat::BinaryLittleEndian => fixed::read_all::<false>(&header, file),
        PlyFormat::BinaryBigEndian => fixed::read_all::<true>(&header, file),
    });
    mesh.map_err(|fault| fault_to_error(head, &Arc::new(name.to_path_buf()), &fault))
}

/// Whether the vertices have colours, which are not read. `head` is what the file begins with.
pub(super) fn has_vertex_colors(head: &[u8]) -> bool {
    Header::parse(head, usize::MAX).is_ok_and(|header| header.has_colors)
}

/// Finds the line of a fault. Done only once, so it may count lines from the start.
fn fault_to_error(bytes: &[u8], file: &Arc<PathBuf>, fault: &Fault) -> LoadError {
    match &fault.place {
        Place::File => LoadError::whole_file(file, &fault.message),
        Place::Record(record) => LoadError::new(SourcePos::record(file, *record), &fault.message),
        Place::Text(range) => text_error(bytes, file, range.clone(), &fault.message),
    }
}

#[cfg(test)]
mod tests;
