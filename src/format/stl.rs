//! STL, binary and text. Each facet has its own corners, so vertices are not shared. Facet normals are ignored: they
//! follow from the corners.
//!
//! Why not stl_io: it takes binary files that begin with `solid ` for text, and texts whose first line is `solid` for
//! binary. It stops silently after the first of several solids. It rejects names that are not UTF-8, keywords in
//! capitals, and the `nan` normals that some programs write for degenerate facets. Its errors have no line.
//!
//! Format: *StereoLithography Interface Specification*, 3D Systems, 1989.

mod colors;

use super::{
    budget::Budget,
    files,
    left_out::{LeftOut, counted},
    mesh::{LoadedMesh, MeshFormat, Unusable, UpAxis, UpSource},
    offset::Offset,
    place::{TextFault, Words},
    polygon::{Fans, fans_note},
    reason::Reason,
    source::{Opened, Pieces},
};
use crate::{
    error::{LoadError, SceneError, quote},
    scene::{TriangleMesh, check_memory, is_usable},
};
use colors::Bits;
use rayon::prelude::*;
use std::{ops::Range, path::Path};

/// Bytes before the first facet of a binary file: a comment, and the number of facets.
const HEADER: usize = 84;
/// Bytes of a facet: normal, three corners, two attribute bytes.
const FACET: usize = 50;
/// The least vertices for each thread.
const MIN_PIECE: usize = 1 << 14;

/// How many facets are read at a time.
const PIECE: usize = 1 << 12;
/// How many bytes decide whether a file is text.
const HEAD: usize = 1024;

/// Reads a mesh: text as a whole, binary piece by piece.
///
/// # Errors
/// [`LoadError`], with line and column in text and the facet's number in binary files.
pub(super) fn read(opened: Opened, path: &Path, budget: &Budget) -> Result<LoadedMesh, LoadError> {
    let is_text = is_text(opened.head(HEAD, &mut Vec::new()), opened.length());
    if let Opened::File(file) = &opened
        && !is_text
        && let Some(mesh) = binary(file, path, budget)?
    {
        return Ok(mesh);
    }
    let bytes = opened.into_bytes(budget);
    let bytes = bytes.map_err(|error| files::load_error(path, &error))?;
    parse(&bytes, path, budget)
}

/// Reads a mesh from the bytes of its file.
///
/// # Errors
/// [`LoadError`], as for [`read`].
pub(super) fn parse(bytes: &[u8], path: &Path, budget: &Budget) -> Result<LoadedMesh, LoadError> {
    if is_text(bytes, bytes.len()) {
        let located = |fault: TextFault| fault.into_error(bytes, path);
        let (columns, reader) = text(bytes, budget).map_err(located)?;
        let mut left_out = LeftOut::default();
        left_out.small_faces(reader.small);
        let mut mesh = loaded(columns, left_out.note(path));
        mesh.notes.extend(fans_note(reader.complex, path));
        mesh.keep_used(reader.unusable.map(located), path, budget)?;
        Ok(mesh)
    } else {
        Ok(binary(&bytes, path, budget)?.unwrap_or_default())
    }
}

/// The mesh. STL has no field for the up axis; printing and CAD, where it is at home, use z.
fn loaded(columns: TriangleMesh, note: Option<String>) -> LoadedMesh {
    LoadedMesh {
        columns,
        up: UpAxis::Z,
        up_source: UpSource::Assumed(MeshFormat::Stl),
        notes: note.into_iter().collect(),
        ..LoadedMesh::default()
    }
}

/// The number of facets by a binary file's header.
fn promised(head: &[u8]) -> Option<usize> {
    let count = head.get(HEADER - 4..)?.first_chunk()?;
    Some(u32::from_le_bytes(*count) as usize)
}

/// Whether a file of `length` bytes, whose first [`HEAD`] are `head`, is text. Text begins with `solid`, but the header of
/// a binary file may, too: such a file has the size that its count implies, or a NUL byte in its head before other bytes.
fn is_text(head: &[u8], length: usize) -> bool {
    let start = head.trim_ascii_start();
    let begins = start
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let head = head.get(..HEAD).unwrap_or(head);
    begins && !has_binary_size(head, length) && !head[..text_end(head)].contains(&0)
}

/// Where text ends: some programs write NUL bytes after it.
fn text_end(bytes: &[u8]) -> usize {
    let is_last = |&byte: &u8| byte != 0 && !byte.is_ascii_whitespace();
    bytes.iter().rposition(is_last).map_or(0, |last| last + 1)
}

/// Whether the bytes of a whole file are an STL mesh: binary of the right size, or text.
pub(super) fn is_stl(bytes: &[u8]) -> bool {
    let first_word = bytes.trim_ascii_start().split(u8::is_ascii_whitespace).next();
    first_word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) || has_binary_size(bytes, bytes.len())
}

/// Whether a binary file with this head has exactly the facets that it promises.
fn has_binary_size(head: &[u8], length: usize) -> bool {
    promised(head).is_some_and(|count| HEADER + count * FACET == length)
}

/// Reads a binary file. `None` if bytes that were there can no longer be read.
fn binary(source: &impl Pieces, path: &Path, budget: &Budget) -> Result<Option<LoadedMesh>, LoadError> {
    budget.add_single_reach(f32::MAX);
    let refused = |message: String| Err(LoadError::whole_file(path, message));
    let length = source.length();
    if length == 0 {
        return refused("the file is empty, expected an STL mesh".into());
    }
    if length < HEADER {
        return refused(format!(
            "not an STL mesh: text begins with `solid`, and binary files have at least {HEADER} bytes, not {length}"
        ));
    }
    let mut buffer = Vec::new();
    let Some(count) = source.piece(0, HEADER, &mut buffer).and_then(promised) else {
        return Ok(None);
    };
    if length - HEADER < count * FACET {
        return refused(format!(
            "{count} facets need {} bytes, but only {} follow the header: the file is cut short, the count is wrong, or \
             this is not an STL mesh",
            count * FACET,
            length - HEADER
        ));
    }
    let extra = length - HEADER - count * FACET;
    if count == 0 && extra >= FACET {
        return refused(format!("the header promises 0 facets, but {extra} bytes follow"));
    }
    // The scene would refuse it later.
    if let Err(error) = check_memory([count, 0, 3 * count], 0, budget.limit()) {
        return Err(Reason::from(error).of_file(path));
    }
    let mut mesh = TriangleMesh::default();
    let room = [&mut mesh.x, &mut mesh.y, &mut mesh.z]
        .into_iter()
        .try_for_each(|column| budget.reserve(column, 3 * count))
        .and_then(|()| budget.reserve(&mut mesh.triangles, count));
    room.map_err(|error| error.into_error(path))?;
    for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
        column.resize(3 * count, 0.0);
    }
    let Some(bits) = read_corners(source, &mut mesh) else {
        return Ok(None);
    };
    let unusable = unusable(&mesh, count, path);
    let triangles = (0..count as u32).into_par_iter().with_min_len(MIN_PIECE);
    mesh.triangles
        .par_extend(triangles.map(|i| [3 * i, 3 * i + 1, 3 * i + 2]));
    let mut left_out = LeftOut::default();
    let colors = colors::read(source, count, bits, &mut left_out, budget);
    let Some(colors) = colors.map_err(|error| error.into_error(path))? else {
        return Ok(None);
    };
    if extra >= FACET {
        let facets = counted(count, "facet", "facets");
        left_out.add(&format!(
            "{extra} bytes after the {facets} that the header promises"
        ));
    }
    let mut mesh = loaded(mesh, left_out.note(path));
    (mesh.surfaces, mesh.surface_of) = (colors.surfaces, colors.surface_of);
    // Facets use all of their corners.
    if unusable.count > 0 {
        mesh.keep_used(unusable, path, budget)?;
    }
    Ok(Some(mesh))
}

/// Fills the coordinates of a mesh with the corners of all facets, and returns the bits of their attributes. `None` if bytes
/// can no longer be read.
fn read_corners(source: &impl Pieces, mesh: &mut TriangleMesh) -> Option<Bits> {
    let pieces = (
        mesh.x.par_chunks_mut(3 * PIECE),
        mesh.y.par_chunks_mut(3 * PIECE),
        mesh.z.par_chunks_mut(3 * PIECE),
    );
    pieces
        .into_par_iter()
        .enumerate()
        .map_init(Vec::new, |buffer, (i, (x, y, z))| {
            let facets = source.piece(HEADER + i * PIECE * FACET, x.len() / 3 * FACET, buffer)?;
            let facets = facets.as_chunks::<FACET>().0;
            let corners = facets.iter().flat_map(corners);
            for (((x, y), z), corner) in x.iter_mut().zip(y).zip(z).zip(corners) {
                [*x, *y, *z] = corner;
            }
            Some(facets.iter().map(Bits::of).fold(Bits::NONE, Bits::join))
        })
        .try_reduce(|| Bits::NONE, |a, b| Some(a.join(b)))
}

/// The unusable vertices of a binary file.
fn unusable(mesh: &TriangleMesh, count: usize, path: &Path) -> Unusable<LoadError> {
    let mut unusable = Unusable::default();
    let columns = [&mesh.x, &mesh.y, &mesh.z];
    let first = |(column, what): (&Vec<f32>, &'static str)| {
        let values = column.par_iter().with_min_len(MIN_PIECE);
        let first = values.position_first(|value| !is_usable(*value))?;
        Some((first, what, column[first]))
    };
    let found = columns.into_iter().zip(["x", "y", "z"]).filter_map(first);
    let Some((i, what, value)) = found.min_by_key(|&(i, ..)| i) else {
        return unusable;
    };
    unusable.keep_first(|| {
        let error = SceneError::NotUsable { what, value };
        let message = format!(
            "facet {} of {count}, corner {}: {error} (the facet starts at byte {})",
            i / 3 + 1,
            i % 3 + 1,
            HEADER + i / 3 * FACET
        );
        LoadError::whole_file(path, message)
    });
    let is_unusable = |&i: &usize| columns.iter().any(|column| !is_usable(column[i]));
    unusable.count = (0..mesh.x.len()).filter(is_unusable).count();
    unusable
}

/// The corners of a facet, which follow its normal.
fn corners(facet: &[u8; FACET]) -> [[f32; 3]; 3] {
    let number = |i: usize| {
        let bytes = facet.get(4 * i..).and_then(|rest| rest.first_chunk());
        bytes.map_or(f32::NAN, |&bytes| f32::from_le_bytes(bytes))
    };
    [3, 6, 9].map(|first| [number(first), number(first + 1), number(first + 2)])
}

/// Reads words. Lines matter only after `solid` and `endsolid`, whose names reach to the end of the line.
struct Reader<'a> {
    text: &'a [u8],
    words: Words<'a>,
    end: Range<usize>,
    offset: Offset,
    unusable: Unusable<TextFault>,
    /// How many facets have fewer than three corners, and how many are too complex to be filled.
    small: usize,
    complex: usize,
}

impl<'a> Reader<'a> {
    fn next(&mut self, expected: &str) -> Result<(&'a [u8], Range<usize>), TextFault> {
        self.words.next().ok_or_else(|| {
            let message = format!("the file ends here, expected {expected}");
            TextFault::new(self.end.clone(), message)
        })
    }

    fn keyword(&mut self, keyword: &str) -> Result<(), TextFault> {
        let quoted = format!("`{keyword}`");
        let (word, place) = self.next(&quoted)?;
        if word.eq_ignore_ascii_case(keyword.as_bytes()) {
            Ok(())
        } else {
            let message = format!("found {}, expected {quoted}", quote(word));
            Err(TextFault::new(place, message))
        }
    }

    fn coordinate(&mut self, axis: usize) -> Result<f32, TextFault> {
        let what = ["x", "y", "z"][axis];
        let (word, place) = self.next("a number")?;
        let value = self.offset.parse(axis, word).map_err(|_| {
            let message = format!("`{what}` is {}, expected a number", quote(word));
            TextFault::new(place.clone(), message)
        })?;
        if !is_usable(value) {
            let error = SceneError::NotUsable { what, value };
            self.unusable
                .keep_first(|| TextFault::new(place, error.to_string()));
        }
        Ok(value)
    }

    fn skip_line(&mut self) {
        let (from, end) = (self.words.position(), self.end.end);
        let line = self.text.get(from..end).unwrap_or_default();
        let ends = |&byte: &u8| byte == b'\n' || byte == b'\r';
        let length = line.iter().position(ends).unwrap_or(line.len());
        self.words = Words::new(self.text, from + length..end);
    }
}

/// The mesh, and what its reader found.
fn text<'a>(bytes: &'a [u8], budget: &Budget) -> Result<(TriangleMesh, Reader<'a>), TextFault> {
    let end = text_end(bytes);
    let mut reader = Reader {
        text: bytes,
        words: Words::new(bytes, 0..end),
        end: end..end,
        offset: budget.offset(),
        unusable: Unusable::default(),
        small: 0,
        complex: 0,
    };
    let mut mesh = TriangleMesh::default();
    let mut fans = Fans::default();
    let mut within = false;
    let mut progress = budget.parsing(bytes.len());
    while let Some((word, place)) = reader.words.next() {
        progress.at(place.start);
        let is = |keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
        if !within && is("solid") {
            reader.skip_line();
            within = true;
        } else if within && is("endsolid") {
            reader.skip_line();
            within = false;
        } else if within && is("facet") {
            facet(&mut reader, &mut mesh, &mut fans, budget)?;
        } else {
            let expected = if within {
                "`facet` or `endsolid`"
            } else {
                "`solid`"
            };
            let message = format!("found {}, expected {expected}", quote(word));
            return Err(TextFault::new(place, message));
        }
    }
    if within {
        return Err(TextFault::new(
            reader.end,
            "the file ends here, expected `endsolid`",
        ));
    }
    reader.complex = fans.cut_concave(&mut mesh, budget)?;
    Ok((mesh, reader))
}

fn facet(
    reader: &mut Reader<'_>,
    mesh: &mut TriangleMesh,
    fans: &mut Fans,
    budget: &Budget,
) -> Result<(), TextFault> {
    reader.keyword("normal")?;
    for _ in 0..3 {
        reader.next("a number")?;
    }
    reader.keyword("outer")?;
    reader.keyword("loop")?;
    let first = mesh.x.len();
    loop {
        let (word, place) = reader.next("`vertex` or `endloop`")?;
        if word.eq_ignore_ascii_case(b"endloop") {
            break;
        }
        if !word.eq_ignore_ascii_case(b"vertex") {
            let message = format!("found {}, expected `vertex` or `endloop`", quote(word));
            return Err(TextFault::new(place, message));
        }
        for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
            budget.reserve(column, 1)?;
        }
        let [x, y, z] = [0, 1, 2].map(|axis| reader.coordinate(axis));
        let corner = [x?, y?, z?];
        reader.unusable.count += usize::from(!corner.into_iter().all(is_usable));
        mesh.x.push(corner[0]);
        mesh.y.push(corner[1]);
        mesh.z.push(corner[2]);
    }
    let corner = |i: usize| (first + i) as u32;
    let corners = mesh.x.len() - first;
    // Facets should have three corners; more become a fan.
    reader.small += usize::from(corners < 3);
    let fan = corners.saturating_sub(2);
    budget.reserve(&mut mesh.triangles, fan)?;
    fans.add(mesh.triangles.len(), fan, 1, budget)?;
    mesh.triangles
        .extend((2..corners).map(|i| [corner(0), corner(i - 1), corner(i)]));
    reader.keyword("endfacet")
}

#[cfg(test)]
mod tests;
