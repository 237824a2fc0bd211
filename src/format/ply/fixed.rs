//! The fast path for binary records of equal size, as most programs write them: pieces are read in parallel, directly into
//! the arrays. Other layouts and faults are left to the slow path (`rows.rs`), which locates them.

use super::{
    columns::{Attributes, VertexColumns},
    faces::{Faces, upper_left},
    fault::Fault,
    header::{Element, Header, Role, Step, color_scale},
    rows::zeroed,
    slots::{COLOR_SLOT, SLOTS, UV_SLOT, VALUE_SLOT},
};
use crate::{
    format::{budget::Budget, mesh::channels, offset::Offset, polygon::Fans, source::Pieces},
    scene::{TriangleMesh, is_usable},
};
use glam::Vec3;
use rayon::prelude::*;
use serde_ply::ScalarType;
use std::{
    iter::repeat_n,
    sync::atomic::{AtomicBool, Ordering},
};

/// How many records are read at a time: few enough to stay in the cache.
const PIECE: usize = 1 << 12;

/// `$type::from_*_bytes` in the byte order of the surrounding `BIG_ENDIAN`.
macro_rules! from_bytes {
    ($type:ty, $bytes:expr) => {
        if BIG_ENDIAN {
            <$type>::from_be_bytes($bytes)
        } else {
            <$type>::from_le_bytes($bytes)
        }
    };
}
pub(super) use from_bytes;

/// Reads all elements that a mesh needs; `None` if the slow path has to.
pub(super) fn read_all<'b, const BIG_ENDIAN: bool>(
    header: &Header,
    source: &impl Pieces,
    budget: &'b Budget,
) -> Result<Option<(TriangleMesh, Faces<'b>)>, Fault> {
    let (mut mesh, mut triangles) = (TriangleMesh::default(), Faces::new(budget));
    let mut at = header.body;
    for element in header.needed() {
        let end = match element.role {
            Role::Vertex => vertices::<BIG_ENDIAN>(source, at, element, &mut mesh, &mut triangles)?,
            Role::Face if element.is_painted() => None,
            Role::Face => faces::<BIG_ENDIAN>(source, at, element, header.vertices, &mut triangles)?,
            Role::Other => end_of(element, at),
            Role::Strips | Role::Edge => None,
        };
        match end {
            Some(end) => at = end,
            None => return Ok(None),
        }
    }
    Ok(Some((mesh, triangles)))
}

/// Where the element that starts at `at` ends; `None` if its records differ in size.
fn end_of(element: &Element, at: usize) -> Option<usize> {
    at.checked_add(element.count.checked_mul(element.stride()?)?)
}

/// The offset of a number in its record, and its type.
type Part = (usize, ScalarType);

/// Where the numbers of a vertex are.
struct VertexLayout {
    stride: usize,
    position: [Part; 3],
    normal: Option<[Part; 3]>,
    color: Option<[Part; 3]>,
    uv: Option<[Part; 2]>,
    /// What is shown instead of colours.
    value: Option<Part>,
    /// That of the colours; only whether it is less than 1 matters.
    alpha: Option<Part>,
}

impl VertexLayout {
    /// `None` if the records differ in size.
    fn of(element: &Element) -> Option<Self> {
        let mut parts: [Option<Part>; SLOTS] = [None; SLOTS];
        let (mut offset, mut alpha, mut value) = (0, None, None);
        let alpha_i = element.alpha();
        for (i, step) in element.steps.iter().enumerate() {
            if let Step::Keep { slot, scalar } = *step
                && let Some(part) = parts.get_mut(slot)
            {
                *part = Some((offset, scalar));
            }
            if let Step::Keep {
                slot: VALUE_SLOT,
                scalar,
            } = *step
            {
                value = Some((offset, scalar));
            }
            if let Step::Skip(scalar) = *step
                && alpha_i == Some(i)
            {
                alpha = Some((offset, scalar));
            }
            offset += step.size()?;
        }
        let three = |first: usize| match parts.get(first..first + 3) {
            Some(&[Some(x), Some(y), Some(z)]) => Some([x, y, z]),
            _ => None,
        };
        Some(Self {
            stride: offset,
            position: three(0)?,
            normal: three(3),
            color: three(COLOR_SLOT),
            uv: match parts.get(UV_SLOT..) {
                Some(&[Some(u), Some(v)]) => Some([u, v]),
                _ => None,
            },
            value,
            alpha,
        })
    }
}

/// Reads the vertices that start at `at` and returns where they end. `None`, with `mesh` unchanged, if the slow path has
/// to read them.
pub(super) fn vertices<const BIG_ENDIAN: bool>(
    source: &impl Pieces,
    at: usize,
    element: &Element,
    mesh: &mut TriangleMesh,
    faces: &mut Faces<'_>,
) -> Result<Option<usize>, Fault> {
    let (Some(end), Some(layout)) = (end_of(element, at), VertexLayout::of(element)) else {
        return Ok(None);
    };
    let VertexLayout {
        stride,
        position,
        normal,
        color,
        uv,
        value,
        alpha,
    } = layout;
    let (is_translucent, offset) = (AtomicBool::new(false), faces.budget.offset());
    if end > source.length() {
        return Ok(None);
    }
    let has = Attributes {
        normals: normal.is_some(),
        colors: color.is_some() || value.is_some(),
        uvs: uv.is_some(),
    };
    let mut columns = VertexColumns::zeroed(element, has, faces.budget)?;
    let pieces = columns.pieces(repeat_n(PIECE, element.count.div_ceil(PIECE)));
    let read = pieces
        .into_par_iter()
        .enumerate()
        .try_for_each_init(Vec::new, |buffer, (i, piece)| {
            let records = source.piece(at + i * PIECE * stride, piece.x.len() * stride, buffer)?;
            let put = |i: usize, [px, py, pz]: [f32; 3]| {
                if let (Some(x), Some(y), Some(z)) =
                    (piece.x.get_mut(i), piece.y.get_mut(i), piece.z.get_mut(i))
                {
                    (*x, *y, *z) = (px, py, pz);
                }
            };
            let to_columns = if offset.is_none() {
                triples::<BIG_ENDIAN>(records, stride, position, put)
            } else {
                relative_triples::<BIG_ENDIAN>(records, stride, position, offset, put)
            };
            let normals_too = normal.is_none_or(|normal| {
                triples::<BIG_ENDIAN>(records, stride, normal, |i, normal| {
                    if let Some(to) = piece.normals.get_mut(i) {
                        *to = Vec3::from_array(normal);
                    }
                })
            });
            let colors_too =
                color.is_none_or(|color| read_colors::<BIG_ENDIAN>(records, stride, color, piece.colors));
            if let Some(value) = value {
                let records = records.chunks_exact(stride);
                for (to, record) in piece.colors.iter_mut().zip(records) {
                    *to = channels(double::<BIG_ENDIAN>(record, value));
                }
            }
            let uvs_too = uv.is_none_or(|uv| read_uvs::<BIG_ENDIAN>(records, stride, uv, piece.uvs));
            if alpha.is_some_and(|alpha| !is_opaque::<BIG_ENDIAN>(records, stride, alpha)) {
                is_translucent.store(true, Ordering::Relaxed);
            }
            (to_columns && normals_too && colors_too && uvs_too).then_some(())
        });
    if read.is_none() {
        return Ok(None);
    }
    columns.move_into(mesh);
    faces.translucent.vertex |= is_translucent.into_inner();
    Ok(Some(end))
}

/// Whether the alpha of each record is 1.
fn is_opaque<const BIG_ENDIAN: bool>(records: &[u8], stride: usize, alpha: Part) -> bool {
    let mut records = records.chunks_exact(stride);
    records.all(|record| number::<BIG_ENDIAN>(record, alpha) == color_scale(alpha.1))
}

/// Reads a texture coordinate of each record. Returns whether all are usable.
fn read_uvs<const BIG_ENDIAN: bool>(
    records: &[u8],
    stride: usize,
    [u, v]: [Part; 2],
    uvs: &mut [[f32; 2]],
) -> bool {
    let mut records = records.chunks_exact(stride).zip(uvs);
    records.all(|(record, uv)| {
        let read = upper_left([number::<BIG_ENDIAN>(record, u), number::<BIG_ENDIAN>(record, v)]);
        *uv = read.unwrap_or_default();
        read.is_some()
    })
}

/// Reads a colour of each record. Returns whether all are finite.
fn read_colors<const BIG_ENDIAN: bool>(
    records: &[u8],
    stride: usize,
    parts: [Part; 3],
    colors: &mut [[f32; 3]],
) -> bool {
    let records = records.chunks_exact(stride).zip(colors);
    // Nearly always: three adjacent bytes.
    let [(first, _), ..] = parts;
    if parts == [first, first + 1, first + 2].map(|offset| (offset, ScalarType::U8)) {
        let full = color_scale(ScalarType::U8);
        for (record, color) in records {
            let Some(&[red, green, blue]) = record.get(first..first + 3) else {
                return false;
            };
            *color = [
                f32::from(red) / full,
                f32::from(green) / full,
                f32::from(blue) / full,
            ];
        }
        return true;
    }
    let mut finite = true;
    for (record, color) in records {
        for (channel, part) in color.iter_mut().zip(parts) {
            let value = number::<BIG_ENDIAN>(record, part);
            finite &= value.is_finite();
            *channel = value / color_scale(part.1);
        }
    }
    finite
}

/// Passes three numbers of each record to `put`. Returns whether all are usable. (No `map` of arrays in the loops: it is
/// not always inlined.)
#[inline(always)]
fn triples<const BIG_ENDIAN: bool>(
    records: &[u8],
    stride: usize,
    parts: [Part; 3],
    mut put: impl FnMut(usize, [f32; 3]),
) -> bool {
    let mut usable = true;
    let mut take = |i: usize, triple: [f32; 3]| {
        // No early exit, so that the loop vectorises.
        usable &= is_usable(triple[0]) & is_usable(triple[1]) & is_usable(triple[2]);
        put(i, triple);
    };
    let records = records.chunks_exact(stride).enumerate();
    // Nearly always: three adjacent floats.
    let [(first, _), ..] = parts;
    if parts == [first, first + 4, first + 8].map(|offset| (offset, ScalarType::F32)) {
        for (i, record) in records {
            let Some(bytes) = record.get(first..first + 12) else {
                return false;
            };
            let ([x, y, z], _) = bytes.as_chunks::<4>() else {
                return false;
            };
            take(
                i,
                [from_bytes!(f32, *x), from_bytes!(f32, *y), from_bytes!(f32, *z)],
            );
        }
    } else {
        let [x, y, z] = parts;
        for (i, record) in records {
            let number = |part| number::<BIG_ENDIAN>(record, part);
            take(i, [number(x), number(y), number(z)]);
        }
    }
    usable
}

/// As [`triples`], relative to an offset.
fn relative_triples<const BIG_ENDIAN: bool>(
    records: &[u8],
    stride: usize,
    parts: [Part; 3],
    offset: Offset,
    mut put: impl FnMut(usize, [f32; 3]),
) -> bool {
    let mut records = records.chunks_exact(stride).enumerate();
    records.all(|(i, record)| {
        let value = |axis: usize| offset.relative(axis, double::<BIG_ENDIAN>(record, parts[axis]));
        let triple = [value(0), value(1), value(2)];
        put(i, triple);
        triple.into_iter().all(is_usable)
    })
}

/// As [`number`], not rounded to `f32`.
fn double<const BIG_ENDIAN: bool>(record: &[u8], (offset, scalar): Part) -> f64 {
    let bytes = record.get(offset..).unwrap_or_default();
    macro_rules! read {
        ($type:ty) => {
            bytes
                .first_chunk()
                .map_or(f64::NAN, |&bytes| from_bytes!($type, bytes).into())
        };
    }
    match scalar {
        ScalarType::I32 => read!(i32),
        ScalarType::U32 => read!(u32),
        ScalarType::F64 => read!(f64),
        _ => number::<BIG_ENDIAN>(record, (offset, scalar)).into(),
    }
}

/// A number of any type; NaN if the record is too short.
#[inline]
fn number<const BIG_ENDIAN: bool>(record: &[u8], (offset, scalar): Part) -> f32 {
    let bytes = record.get(offset..).unwrap_or_default();
    macro_rules! read {
        ($type:ty) => {
            bytes.first_chunk().map(|&bytes| from_bytes!($type, bytes))
        };
    }
    match scalar {
        ScalarType::I8 => read!(i8).map(f32::from),
        ScalarType::U8 => read!(u8).map(f32::from),
        ScalarType::I16 => read!(i16).map(f32::from),
        ScalarType::U16 => read!(u16).map(f32::from),
        ScalarType::I32 => read!(i32).map(|value| value as f32),
        ScalarType::U32 => read!(u32).map(|value| value as f32),
        ScalarType::F32 => read!(f32),
        ScalarType::F64 => read!(f64).map(|value| value as f32),
    }
    .unwrap_or(f32::NAN)
}

/// The usual layout of faces: a list with a length of one byte and indices of four, and perhaps numbers before and after.
#[derive(Clone, Copy)]
pub(super) struct FaceLayout {
    /// Bytes before the list.
    pub(super) before: usize,
    /// Bytes after the list.
    pub(super) after: usize,
}

impl FaceLayout {
    pub(super) fn of(element: &Element) -> Option<Self> {
        let list = element
            .steps
            .iter()
            .position(|step| matches!(step, Step::Indices { .. }))?;
        let Step::Indices { count, item } = *element.steps.get(list)? else {
            return None;
        };
        if !matches!(count, ScalarType::U8) || !matches!(item, ScalarType::I32 | ScalarType::U32) {
            return None;
        }
        let size = |steps: &[Step]| -> Option<usize> { steps.iter().map(Step::size).sum() };
        Some(Self {
            before: size(element.steps.get(..list)?)?,
            after: size(element.steps.get(list + 1..)?)?,
        })
    }

    /// Bytes of a face with `corners` corners.
    pub(super) fn stride(self, corners: usize) -> usize {
        self.before + 1 + 4 * corners + self.after
    }
}

/// Reads the faces that start at `at`, all triangles or all quads, and returns where they end. `None`, with `faces`
/// unchanged, if the slow path has to read them.
pub(super) fn faces<const BIG_ENDIAN: bool>(
    source: &impl Pieces,
    at: usize,
    element: &Element,
    vertices: usize,
    faces: &mut Faces<'_>,
) -> Result<Option<usize>, Fault> {
    let Some(layout) = FaceLayout::of(element) else {
        return Ok(None);
    };
    // The other faces are probably like the first.
    let mut buffer = Vec::new();
    let first = source.piece(at + layout.before, 1, &mut buffer);
    let (corners, piece_to_triangles): (usize, FacePiece) = match first {
        Some([3]) => (3, face_piece::<BIG_ENDIAN, 1>),
        Some([4]) => (4, face_piece::<BIG_ENDIAN, 2>),
        _ => return Ok(None),
    };
    let stride = layout.stride(corners);
    let end = element
        .count
        .checked_mul(stride)
        .and_then(|length| at.checked_add(length));
    let Some(end) = end.filter(|&end| end <= source.length()) else {
        return Ok(None);
    };
    let fan = corners - 2;
    let mut triangles = zeroed(element.count * fan, element, faces.budget)?;
    let read = triangles
        .par_chunks_mut(PIECE * fan)
        .enumerate()
        .try_for_each_init(Vec::new, |buffer, (i, triangles)| {
            let length = triangles.len() / fan * stride;
            let records = source.piece(at + i * PIECE * stride, length, buffer)?;
            piece_to_triangles(records, layout, vertices, triangles).then_some(())
        });
    if read.is_none() {
        return Ok(None);
    }
    let (mut fans, budget) = (Fans::default(), faces.budget);
    fans.add(0, fan, element.count, budget)?;
    faces.append(Faces {
        triangles,
        fans,
        ..Faces::new(budget)
    })?;
    Ok(Some(end))
}

/// See [`face_piece`].
type FacePiece = fn(&[u8], FaceLayout, usize, &mut [[u32; 3]]) -> bool;

/// Makes fans of faces with `FANS + 2` corners. `false` if a face has other corners or an index out of range.
fn face_piece<const BIG_ENDIAN: bool, const FANS: usize>(
    records: &[u8],
    layout: FaceLayout,
    vertices: usize,
    triangles: &mut [[u32; 3]],
) -> bool {
    let mut fine = true;
    let faces = records.chunks_exact(layout.stride(FANS + 2));
    for (record, fan) in faces.zip(triangles.chunks_exact_mut(FANS)) {
        let Some((&corners, list)) = record.get(layout.before..).and_then(<[u8]>::split_first) else {
            return false;
        };
        fine &= usize::from(corners) == FANS + 2;
        let (indices, _) = list.as_chunks::<4>();
        let Some((first, others)) = indices.get(..FANS + 2).and_then(<[[u8; 4]]>::split_first) else {
            return false;
        };
        let first = from_bytes!(u32, *first);
        for (triangle, pair) in fan.iter_mut().zip(others.windows(2)) {
            let [b, c] = pair else { continue };
            let [b, c] = [from_bytes!(u32, *b), from_bytes!(u32, *c)];
            fine &= (first.max(b).max(c) as usize) < vertices;
            *triangle = [first, b, c];
        }
    }
    fine
}
