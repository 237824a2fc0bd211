//! Reads the values of a binary file.

use super::{
    ascii::whole_of,
    faces::Faces,
    fault::{Fault, Place},
    fixed::{self, FaceLayout, from_bytes},
    header::{Element, Role, scalar_size},
    rows::{Values, Wrong, reserve},
};
use crate::scene::TriangleMesh;
use serde_ply::ScalarType;

/// Reads values that follow each other directly, in the byte order of `BIG_ENDIAN`.
pub(super) struct Binary<'a, const BIG_ENDIAN: bool> {
    bytes: &'a [u8],
    at: usize,
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

    /// Reads faces of any number of corners and returns their length in bytes. `None` if one is faulty.
    fn mixed_faces(
        bytes: &[u8],
        count: usize,
        layout: FaceLayout,
        vertices: usize,
        faces: &mut Faces<'_>,
    ) -> Option<usize> {
        let Faces {
            triangles,
            fans,
            budget,
            ..
        } = faces;
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
                fans.add(triangles.len(), indices.len(), 1, budget).ok()?;
                for index in indices {
                    if index as usize >= vertices || triangles.len() == triangles.capacity() {
                        return None;
                    }
                    triangles.push([first, previous, index]);
                    previous = index;
                }
            } else if !corners.is_empty() {
                // A single corner: the slow path checks its index.
                return None;
            }
            at += layout.before + 1 + corners.len() + layout.after;
        }
        (at <= bytes.len()).then_some(at)
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

    fn double(&mut self, scalar: ScalarType) -> Result<f64, Wrong> {
        Ok(match scalar {
            ScalarType::F32 => from_bytes!(f32, self.take()?).into(),
            ScalarType::F64 => from_bytes!(f64, self.take()?),
            _ => self.whole(scalar)? as f64,
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
        Fault::file(format!("{record} is too long"))
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

    fn place(&self, _start: usize, _whole_record: bool) -> Place {
        // The message names the record and its first byte.
        Place::File
    }

    fn where_in_file(&self, record: &str, start: usize) -> String {
        format!(" ({record} starts at byte {start})")
    }

    fn fast_vertices(
        &mut self,
        element: &Element,
        mesh: &mut TriangleMesh,
        faces: &mut Faces<'_>,
    ) -> Result<bool, Fault> {
        let end = fixed::vertices::<BIG_ENDIAN>(&self.bytes, self.at, element, mesh, faces)?;
        self.at = end.unwrap_or(self.at);
        Ok(end.is_some())
    }

    fn fast_faces(
        &mut self,
        element: &Element,
        vertices: usize,
        faces: &mut Faces<'_>,
    ) -> Result<bool, Fault> {
        let before = faces.budget.taken();
        if let Some(end) = fixed::faces::<BIG_ENDIAN>(&self.bytes, self.at, element, vertices, faces)? {
            self.at = end;
            return Ok(true);
        }
        faces.budget.give_back_to(before);
        let Some(layout) = FaceLayout::of(element) else {
            return Ok(false);
        };
        // Each triangle needs at least one index of four bytes.
        let rest = self.rest();
        let least = element.count.saturating_mul(layout.stride(0));
        let possible = rest.len().saturating_sub(least) / 4;
        let mut mixed = Faces::new(faces.budget);
        reserve(
            &mut mixed.triangles,
            possible.min(element.count.saturating_mul(2)),
            element,
            faces.budget,
        )?;
        let Some(length) = Self::mixed_faces(rest, element.count, layout, vertices, &mut mixed) else {
            return Ok(false);
        };
        self.at += length;
        faces.append(mixed)?;
        Ok(true)
    }

    fn fast_skip(&mut self, element: &Element) -> bool {
        debug_assert_eq!(element.role, Role::Other);
        let records = element
            .stride()
            .and_then(|stride| self.take_records(element.count, stride));
        records.is_some()
    }
}
