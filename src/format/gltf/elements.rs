//! The elements of an accessor: numbers in a buffer, read one at a time.

use super::buffers::Bytes;
use crate::format::mesh::Range;
use gltf::accessor::DataType;

/// The elements of an accessor.
pub(super) struct Elements<'a> {
    /// The accessor's index in the file.
    pub(super) accessor: usize,
    pub(super) count: usize,
    pub(super) kind: DataType,
    /// What normalised integers are divided by.
    pub(super) scale: Option<f32>,
    /// `None` if all elements are zeros.
    pub(super) dense: Option<Part<'a>>,
    pub(super) replacements: Option<Replacements<'a>>,
}

impl Elements<'_> {
    /// The bytes of element `i`; none if they are zeros.
    fn bytes(&self, i: usize) -> &[u8] {
        if let Some(replacements) = &self.replacements
            && let Some(bytes) = replacements.element(i)
        {
            return bytes;
        }
        self.dense.as_ref().map_or(&[], |part| part.element(i))
    }

    /// Vector `i`, as [`Elements::numbers`].
    pub(super) fn vector(&self, i: usize) -> [f32; 3] {
        self.numbers(i)
    }

    /// The first numbers of element `i`. Normalised integers are scaled to 0..1 or -1..1.
    pub(super) fn numbers<const N: usize>(&self, i: usize) -> [f32; N] {
        let mut vector = [0.0; N];
        for (value, bytes) in vector
            .iter_mut()
            .zip(self.bytes(i).chunks_exact(self.kind.size()))
        {
            let number = number(self.kind, bytes) as f32;
            *value = match self.scale {
                // The least integer is one step below -1.
                Some(scale) => (number / scale).max(-1.0),
                None => number,
            };
        }
        vector
    }

    /// Colour `i`, linear. Integers are always normalised: some programs forget to say so.
    pub(super) fn color(&self, i: usize) -> [f32; 3] {
        let color = self.vector(i);
        match (self.kind, self.scale) {
            (DataType::U8, None) => color.map(|channel| channel / f32::from(u8::MAX)),
            (DataType::U16, None) => color.map(|channel| channel / f32::from(u16::MAX)),
            _ => color,
        }
    }

    /// The single number of element `i`, scaled as vectors.
    pub(super) fn value(&self, i: usize) -> f64 {
        let bytes = self.bytes(i);
        if bytes.is_empty() {
            return 0.0;
        }
        let value = number(self.kind, bytes);
        self.scale
            .map_or(value, |scale| (value / f64::from(scale)).max(-1.0))
    }

    /// How many elements are stored. Without a dense part, those that nothing replaces are not.
    pub(super) fn stored(&self) -> usize {
        match (&self.dense, &self.replacements) {
            (Some(_), _) => self.count,
            (None, Some(replacements)) => replacements.order.len(),
            (None, None) => 0,
        }
    }

    /// The range of single numbers.
    pub(super) fn range(&self) -> Range {
        let order = match (&self.dense, &self.replacements) {
            (Some(_), _) => return Range::of((0..self.count).map(|i| self.value(i))),
            (None, Some(replacements)) => replacements.order.as_slice(),
            (None, None) => &[],
        };
        let replaced = Range::of(order.iter().map(|&[element, _]| self.value(element as usize)));
        if order.len() < self.count {
            replaced.with(0.0)
        } else {
            replaced
        }
    }

    /// The numbers of the joints of vertex `i`.
    pub(super) fn joints(&self, i: usize) -> [usize; 4] {
        let mut joints = [0; 4];
        let numbers = self.bytes(i).chunks_exact(self.kind.size());
        for (joint, bytes) in joints.iter_mut().zip(numbers) {
            *joint = number(self.kind, bytes) as usize;
        }
        joints
    }

    /// Index `i`.
    pub(super) fn index(&self, i: usize) -> u32 {
        number(self.kind, self.bytes(i)) as u32
    }
}

/// The elements that a sparse accessor replaces.
pub(super) struct Replacements<'a> {
    /// An element and the number of its replacement, ascending. Of several for one element the last counts.
    pub(super) order: Vec<[u32; 2]>,
    pub(super) values: Part<'a>,
}

impl Replacements<'_> {
    fn element(&self, i: usize) -> Option<&[u8]> {
        let end = self.order.partition_point(|&[element, _]| element as usize <= i);
        match self.order.get(end.checked_sub(1)?) {
            Some(&[element, number]) if element as usize == i => Some(self.values.element(number as usize)),
            _ => None,
        }
    }
}

/// Elements of one size in a buffer; all are within it.
pub(super) struct Part<'a> {
    pub(super) buffer: Bytes<'a>,
    /// Where the first one is, in bytes.
    pub(super) start: usize,
    pub(super) stride: usize,
    pub(super) size: usize,
}

impl Part<'_> {
    pub(super) fn element(&self, i: usize) -> &[u8] {
        let at = self.start + i * self.stride;
        self.buffer.get(at..at + self.size).unwrap_or_default()
    }
}

/// What integers of an accessor are divided by.
pub(super) fn scale_of(kind: DataType, is_normalized: bool) -> Option<f32> {
    match kind {
        _ if !is_normalized => None,
        DataType::I8 => Some(f32::from(i8::MAX)),
        DataType::U8 => Some(f32::from(u8::MAX)),
        DataType::I16 => Some(f32::from(i16::MAX)),
        DataType::U16 => Some(f32::from(u16::MAX)),
        DataType::U32 | DataType::F32 => None,
    }
}

/// A number of an accessor, exact in `f64`.
pub(super) fn number(kind: DataType, bytes: &[u8]) -> f64 {
    match (kind, bytes) {
        (DataType::I8, &[b]) => f64::from(b as i8),
        (DataType::U8, &[b]) => f64::from(b),
        (DataType::I16, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (DataType::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (DataType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (DataType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN,
    }
}
