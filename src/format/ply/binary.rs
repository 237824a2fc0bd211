//! The values of a binary file.

use super::{
    ascii::whole_of,
    header::{Element, Role, Step, scalar_size},
    rows::{At, Fault, Place, Values, Wrong, first_unusable_in, first_where, reserve, zeroed},
};
use crate::scene::{MeshColumns, is_usable};
use glam::Vec3;
use rayon::prelude::*;
use serde_ply::ScalarType;

/// Values without anything between them, the highest byte first if `BIG_ENDIAN`.
pub(super) struct Binary<'a, const BIG_ENDIAN: bool> {
    bytes: &'a [u8],
    at: usize,
}

/// `$type::from_*_bytes` in the byte order of the surrounding `Binary`.
macro_rules! from_bytes {
    ($type:ty, $bytes:expr) => {
        if BIG_ENDIAN {
            <$type>::from_be_bytes($bytes)
        } else {
            <$type>::from_le_bytes($bytes)
        }
    };
}

impl<'a, const BIG_ENDIAN: bool> Binary<'a, BIG_ENDIAN> {
    /// Reads `bytes` from `at` on.
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at }
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Wrong> {
        let taken = *self.rest().first_chunk().ok_or(Wrong::End)?;
        self.at += N;
        Ok(taken)
    }

    /// Takes `count` records of `stride` bytes.
    fn take_records(&mut self, count: usize, stride: usize) -> Option<&'a [u8]> {
        let taken = self.rest().get(..count.checked_mul(stride)?)?;
        self.at += taken.len();
        Some(taken)
    }

    /// One property of some records.
    fn column(records: &[u8], stride: usize, offset: usize, scalar: ScalarType, column: &mut [f32]) {
        #[inline(always)]
        fn all<const N: usize>(
            records: &[u8],
            stride: usize,
            offset: usize,
            column: &mut [f32],
            value: impl Fn([u8; N]) -> f32,
        ) {
            for (to, record) in column.iter_mut().zip(records.chunks_exact(stride)) {
                let bytes = record.get(offset..).and_then(|rest| rest.first_chunk());
                *to = bytes.map_or(f32::NAN, |bytes| value(*bytes));
            }
        }
        match scalar {
            ScalarType::I8 => all(records, stride, offset, column, |b| f32::from(from_bytes!(i8, b))),
            ScalarType::U8 => all(records, stride, offset, column, |b| f32::from(from_bytes!(u8, b))),
            ScalarType::I16 => all(records, stride, offset, column, |b| {
                f32::from(from_bytes!(i16, b))
            }),
            ScalarType::U16 => all(records, stride, offset, column, |b| {
                f32::from(from_bytes!(u16, b))
            }),
            ScalarType::I32 => all(records, stride, offset, column, |b| from_bytes!(i32, b) as f32),
            ScalarType::U32 => all(records, stride, offset, column, |b| from_bytes!(u32, b) as f32),
            ScalarType::F32 => all(records, stride, offset, column, |b| from_bytes!(f32, b)),
            ScalarType::F64 => all(records, stride, offset, column, |b| from_bytes!(f64, b) as f32),
        }
    }

    /// Three properties of some records, as vectors.
    fn vectors(records: &[u8], stride: usize, parts: [(usize, ScalarType); 3], vectors: &mut [Vec3]) {
        let [(x, x_type), (y, y_type), (z, z_type)] = parts;
        if [x_type, y_type, z_type] == [ScalarType::F32; 3] {
            for (to, record) in vectors.iter_mut().zip(records.chunks_exact(stride)) {
                let [x, y, z] =
                    [x, y, z].map(|offset| record.get(offset..).and_then(|rest| rest.first_chunk()));
                if let (Some(x), Some(y), Some(z)) = (x, y, z) {
                    *to = Vec3::new(from_bytes!(f32, *x), from_bytes!(f32, *y), from_bytes!(f32, *z));
                }
            }
            return;
        }
        let mut column = vec![0.0; vectors.len()];
        for (axis, (offset, scalar)) in parts.into_iter().enumerate() {
            Self::column(records, stride, offset, scalar, &mut column);
            for (to, value) in vectors.iter_mut().zip(&column) {
                to[axis] = *value;
            }
        }
    }

    /// Faces that all have as many corners as `stride` has room for, in parallel. `false` if they do not, or if an
    /// index is too large.
    fn uniform_faces<const FANS: usize>(
        records: &[u8],
        layout: FaceLayout,
        vertices: usize,
        triangles: &mut [[u32; 3]],
    ) -> bool {
        let stride = layout.stride(FANS + 2);
        records
            .par_chunks(PIECE * stride)
            .zip(triangles.par_chunks_mut(PIECE * FANS))
            .map(|(records, triangles)| {
                let mut fine = true;
                let faces = records.chunks_exact(stride).zip(triangles.chunks_exact_mut(FANS));
                for (record, fan) in faces {
                    let Some((&corners, list)) = record.get(layout.before..).and_then(<[u8]>::split_first)
                    else {
                        return false;
                    };
                    fine &= usize::from(corners) == FANS + 2;
                    let (indices, _) = list.as_chunks::<4>();
                    let Some((first, others)) = indices.get(..FANS + 2).and_then(<[[u8; 4]]>::split_first)
                    else {
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
            })
            .reduce(|| true, |a, b| a & b)
    }

    /// Faces of any number of corners, one after the other. `None` if something is wrong with one.
    fn mixed_faces(
        bytes: &[u8],
        count: usize,
        layout: FaceLayout,
        vertices: usize,
        triangles: &mut Vec<[u32; 3]>,
    ) -> Option<usize> {
        let mut at = 0;
        for _ in 0..count {
            let list = bytes.get(at + layout.before..)?;
            let (&corners, rest) = list.split_first()?;
            let corners = rest.get(..4 * usize::from(corners))?;
            let mut indices = corners.as_chunks::<4>().0.iter().map(|&b| from_bytes!(u32, b));
            if let (Some(first), Some(mut previous)) = (indices.next(), indices.next()) {
                if first.max(previous) as usize >= vertices {
                    return None;
                }
                for index in indices {
                    if index as usize >= vertices || triangles.len() == triangles.capacity() {
                        return None;
                    }
                    triangles.push([first, previous, index]);
                    previous = index;
                }
            } else if !corners.is_empty() {
                // One corner: its index is to be looked at all the same.
                return None;
            }
            at += layout.before + 1 + corners.len() + layout.after;
        }
        (at <= bytes.len()).then_some(at)
    }
}

/// So many records are read at a time: they stay in the cache while one column after the other is filled.
const PIECE: usize = 1 << 13;

/// Faces as most programs write them: a list with a byte for its length and four bytes an index, and perhaps
/// numbers before and behind it.
#[derive(Clone, Copy)]
struct FaceLayout {
    before: usize,
    after: usize,
}

impl FaceLayout {
    fn of(element: &Element) -> Option<Self> {
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

    /// Bytes of a face with this many corners.
    fn stride(self, corners: usize) -> usize {
        self.before + 1 + 4 * corners + self.after
    }
}

impl<const BIG_ENDIAN: bool> Values for Binary<'_, BIG_ENDIAN> {
    const SPARE: usize = 0;

    fn real(&mut self, scalar: ScalarType) -> Result<f32, Wrong> {
        Ok(match scalar {
            ScalarType::F32 => from_bytes!(f32, self.take()?),
            ScalarType::F64 => from_bytes!(f64, self.take()?) as f32,
            _ => self.whole(scalar)? as f32,
        })
    }

    #[inline]
    fn whole(&mut self, scalar: ScalarType) -> Result<i64, Wrong> {
        Ok(match scalar {
            ScalarType::I8 => from_bytes!(i8, self.take()?).into(),
            ScalarType::U8 => from_bytes!(u8, self.take()?).into(),
            ScalarType::I16 => from_bytes!(i16, self.take()?).into(),
            ScalarType::U16 => from_bytes!(u16, self.take()?).into(),
            ScalarType::I32 => from_bytes!(i32, self.take()?).into(),
            ScalarType::U32 => from_bytes!(u32, self.take()?).into(),
            ScalarType::F32 => whole_of(from_bytes!(f32, self.take()?).into())?,
            ScalarType::F64 => whole_of(from_bytes!(f64, self.take()?))?,
        })
    }

    fn skip(&mut self, scalar: ScalarType, count: usize) -> Result<(), Wrong> {
        self.take_records(count, scalar_size(scalar)).ok_or(Wrong::End)?;
        Ok(())
    }

    fn begin_record(&mut self) -> usize {
        self.at
    }

    fn end_record(&mut self) -> bool {
        true
    }

    fn leftover(&self, _start: usize, record: &str) -> Fault {
        Fault {
            place: Place::File,
            message: format!("{record} is too long"),
        }
    }

    fn bytes_left(&self) -> usize {
        self.rest().len()
    }

    fn least_bytes(scalar: ScalarType) -> usize {
        scalar_size(scalar)
    }

    fn last_word(&self) -> Option<&[u8]> {
        None
    }

    fn place(&self, _start: usize, record: usize, _whole_record: bool) -> Place {
        Place::Record(record)
    }

    fn where_in_file(&self, record: &str, start: usize) -> String {
        format!(" ({record} starts at byte {start})")
    }

    /// Column by column, which takes the decision about types out of the loops.
    fn fast_vertices(&mut self, element: &Element, mesh: &mut MeshColumns) -> Option<Result<(), Fault>> {
        let stride = element.stride()?;
        let start = self.at;
        let records = self.take_records(element.count, stride)?;
        let faulty = |values: &Self, row: usize, step_i: usize, value: f32| {
            let at = At {
                element,
                step_i,
                start: start + row * stride,
                record: row + 1,
            };
            Some(Err(at.unusable(values, value)))
        };
        // Which step, where in the record and what each of the numbers is.
        let mut parts: [Option<(usize, usize, ScalarType)>; 6] = [None; 6];
        let mut offset = 0;
        for (step_i, step) in element.steps.iter().enumerate() {
            if let Step::Keep { slot, scalar } = *step {
                *parts.get_mut(slot)? = Some((step_i, offset, scalar));
            }
            offset += step.size()?;
        }
        let [x, y, z, normal @ ..] = parts;
        let position = [x?, y?, z?];
        let normal = match normal {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            _ => None,
        };
        let columns = || {
            let column = || zeroed(element.count, element);
            let normals = if normal.is_some() { element.count } else { 0 };
            Ok((column()?, column()?, column()?, zeroed(normals, element)?))
        };
        let (mut x, mut y, mut z, mut normals) = match columns() {
            Ok(columns) => columns,
            Err(fault) => return Some(Err(fault)),
        };
        let pieces = records.par_chunks(PIECE * stride);
        pieces
            .zip(x.par_chunks_mut(PIECE))
            .zip(y.par_chunks_mut(PIECE))
            .zip(z.par_chunks_mut(PIECE))
            .for_each(|(((records, x), y), z)| {
                for (column, (_, offset, scalar)) in [x, y, z].into_iter().zip(position) {
                    Self::column(records, stride, offset, scalar, column);
                }
            });
        if let Some(parts) = normal {
            let parts = parts.map(|(_, offset, scalar)| (offset, scalar));
            let pieces = records.par_chunks(PIECE * stride);
            pieces
                .zip(normals.par_chunks_mut(PIECE))
                .for_each(|(records, normals)| Self::vectors(records, stride, parts, normals));
        }

        // The first row with something that cannot be used, and in it the first number in the order of the file.
        let unusable = [&x, &y, &z].into_iter().zip(position);
        let unusable = unusable.filter_map(|(column, (step_i, ..))| {
            first_unusable_in(column).map(|(row, value)| (row, step_i, value))
        });
        let in_normals = first_where(&normals, |normal| !normal.to_array().into_iter().all(is_usable));
        let in_normals = in_normals.zip(normal).and_then(|(row, parts)| {
            let values = normals.get(row)?.to_array().into_iter().zip(parts);
            let unusable = values.filter(|&(value, _)| !is_usable(value));
            let first = unusable.min_by_key(|&(_, (step_i, ..))| step_i);
            first.map(|(value, (step_i, ..))| (row, step_i, value))
        });
        let first = unusable
            .chain(in_normals)
            .min_by_key(|&(row, step_i, _)| (row, step_i));
        if let Some((row, step_i, value)) = first {
            return faulty(self, row, step_i, value);
        }
        (mesh.x, mesh.y, mesh.z, mesh.normals) = (x, y, z, normals);
        Some(Ok(()))
    }

    fn fast_faces(
        &mut self,
        element: &Element,
        vertices: usize,
        mesh: &mut MeshColumns,
    ) -> Result<bool, Fault> {
        let Some(layout) = FaceLayout::of(element) else {
            return Ok(false);
        };
        let rest = self.rest();
        // The first face tells what the others probably are.
        let corners = rest.get(layout.before).map_or(0, |&corners| usize::from(corners));
        let stride = layout.stride(corners);
        if let (3 | 4, Some(records)) = (corners, rest.get(..element.count.saturating_mul(stride))) {
            let mut triangles = zeroed(element.count * (corners - 2), element)?;
            let read = if corners == 3 {
                Self::uniform_faces::<1>
            } else {
                Self::uniform_faces::<2>
            };
            if read(records, layout, vertices, &mut triangles) {
                mesh.triangles = triangles;
                self.at += records.len();
                return Ok(true);
            }
        }
        // Every index is four bytes of the file, and every triangle has one of its own.
        let least = element.count.saturating_mul(layout.stride(0));
        let possible = rest.len().saturating_sub(least) / 4;
        reserve(
            &mut mesh.triangles,
            possible.min(element.count.saturating_mul(2)),
            element,
        )?;
        let read = Self::mixed_faces(rest, element.count, layout, vertices, &mut mesh.triangles);
        if let Some(length) = read {
            self.at += length;
        } else {
            mesh.triangles.clear();
        }
        Ok(read.is_some())
    }

    fn fast_skip(&mut self, element: &Element) -> bool {
        debug_assert_eq!(element.role, Role::Other);
        let records = element
            .stride()
            .and_then(|stride| self.take_records(element.count, stride));
        records.is_some()
    }
}
