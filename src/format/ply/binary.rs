//! The values of a binary file.

use super::{
    ascii::whole_of,
    header::{Element, Role, Step, scalar_size},
    rows::{At, Fault, Place, Values, Wrong, is_usable},
};
use crate::scene::MeshColumns;
use glam::Vec3;
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

    /// One property of all records, as a column.
    fn column(records: &[u8], stride: usize, offset: usize, scalar: ScalarType) -> Vec<f32> {
        fn all<const N: usize>(
            records: &[u8],
            stride: usize,
            offset: usize,
            value: impl Fn([u8; N]) -> f32,
        ) -> Vec<f32> {
            records
                .chunks_exact(stride)
                .map(|record| {
                    record
                        .get(offset..)
                        .and_then(|rest| rest.first_chunk())
                        .map_or(f32::NAN, |b| value(*b))
                })
                .collect()
        }
        match scalar {
            ScalarType::I8 => all(records, stride, offset, |b| f32::from(from_bytes!(i8, b))),
            ScalarType::U8 => all(records, stride, offset, |b| f32::from(from_bytes!(u8, b))),
            ScalarType::I16 => all(records, stride, offset, |b| f32::from(from_bytes!(i16, b))),
            ScalarType::U16 => all(records, stride, offset, |b| f32::from(from_bytes!(u16, b))),
            ScalarType::I32 => all(records, stride, offset, |b| from_bytes!(i32, b) as f32),
            ScalarType::U32 => all(records, stride, offset, |b| from_bytes!(u32, b) as f32),
            ScalarType::F32 => all(records, stride, offset, |b| from_bytes!(f32, b)),
            ScalarType::F64 => all(records, stride, offset, |b| from_bytes!(f64, b) as f32),
        }
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
        let mut columns: [Vec<f32>; 6] = Default::default();
        let mut offset = 0;
        let mut first_unusable: Option<(usize, usize, f32)> = None;
        for (step_i, step) in element.steps.iter().enumerate() {
            let (Step::Keep { scalar, .. } | Step::Skip(scalar)) = *step else {
                return None;
            };
            if let Step::Keep { slot, .. } = *step {
                let column = Self::column(records, stride, offset, scalar);
                let unusable = column.iter().position(|&value| !is_usable(value));
                if let Some(row) =
                    unusable.filter(|&row| first_unusable.is_none_or(|(first, ..)| row < first))
                {
                    let value = column.get(row).copied().unwrap_or(f32::NAN);
                    first_unusable = Some((row, step_i, value));
                }
                if let Some(kept) = columns.get_mut(slot) {
                    *kept = column;
                }
            }
            offset += scalar_size(scalar);
        }
        if let Some((row, step_i, value)) = first_unusable {
            let at = At {
                element,
                step_i,
                start: start + row * stride,
                record: row + 1,
            };
            return Some(Err(at.unusable(self, value)));
        }
        let [x, y, z, nx, ny, nz] = columns;
        let normals = nx.iter().zip(&ny).zip(&nz);
        mesh.normals = normals.map(|((&x, &y), &z)| Vec3::new(x, y, z)).collect();
        (mesh.x, mesh.y, mesh.z) = (x, y, z);
        Some(Ok(()))
    }

    fn fast_skip(&mut self, element: &Element) -> bool {
        debug_assert_eq!(element.role, Role::Other);
        let records = element
            .stride()
            .and_then(|stride| self.take_records(element.count, stride));
        records.is_some()
    }
}
