//! Buffers and accessors. Every range is checked before it is read.

use super::super::{OpenMesh, files};
use crate::error::{LoadError, quote};
use base64::{Engine, prelude::BASE64_STANDARD};
use gltf::{
    Accessor,
    accessor::{DataType, Dimensions, sparse::IndexType},
    buffer::{Buffer, Source, View},
};
use percent_encoding::percent_decode_str;
use std::{borrow::Cow, collections::HashMap, path::Path, rc::Rc};

/// The most elements of an accessor without a buffer view, which are zeros.
const MAX_ZEROS: usize = 1 << 22;

/// A file's buffers; each is read once.
pub(super) struct Buffers<'a> {
    path: &'a Path,
    blob: Option<&'a [u8]>,
    open: OpenMesh<'a>,
    read: HashMap<usize, Rc<Cow<'a, [u8]>>>,
}

impl<'a> Buffers<'a> {
    /// The buffers of the file at `path`; `blob` is the one inside a .glb.
    pub(super) fn new(path: &'a Path, blob: Option<&'a [u8]>, open: OpenMesh<'a>) -> Self {
        Self {
            path,
            blob,
            open,
            read: HashMap::new(),
        }
    }

    /// An error about the file.
    pub(super) fn refused(&self, message: impl AsRef<str>) -> LoadError {
        LoadError::whole_file(self.path, message)
    }

    fn bytes(&mut self, buffer: &Buffer<'_>) -> Result<Rc<Cow<'a, [u8]>>, LoadError> {
        let index = buffer.index();
        if let Some(bytes) = self.read.get(&index) {
            return Ok(Rc::clone(bytes));
        }
        let bytes: Cow<'a, [u8]> = match buffer.source() {
            Source::Bin => match self.blob {
                Some(blob) if index == 0 => Cow::Borrowed(blob),
                _ => {
                    return Err(self.refused(format!(
                        "buffers[{index}] has no `uri`, and the file has no binary chunk"
                    )));
                }
            },
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => Cow::Owned(self.data(index, data)?),
                None => Cow::Owned(self.beside(index, uri)?),
            },
        };
        if bytes.len() < buffer.length() {
            return Err(self.refused(format!(
                "buffers[{index}] has {} bytes, expected {}",
                bytes.len(),
                buffer.length()
            )));
        }
        let bytes = Rc::new(bytes);
        self.read.insert(index, Rc::clone(&bytes));
        Ok(bytes)
    }

    /// A data URI (RFC 2397) without its scheme.
    fn data(&self, index: usize, data: &str) -> Result<Vec<u8>, LoadError> {
        let Some((_, base64)) = data.split_once(";base64,") else {
            return Err(self.refused(format!("buffers[{index}] is a data URI without `;base64,`")));
        };
        BASE64_STANDARD
            .decode(base64)
            .map_err(|error| self.refused(format!("buffers[{index}] is not valid Base64: {error}")))
    }

    /// Reads a file beside this one.
    fn beside(&mut self, index: usize, uri: &str) -> Result<Vec<u8>, LoadError> {
        let name = percent_decode_str(uri).decode_utf8_lossy();
        if uri.contains("://") || name.len() > 4096 {
            let found = quote(uri.as_bytes());
            return Err(self.refused(format!(
                "buffers[{index}] is {found}, expected the name of a file beside this one"
            )));
        }
        let path = self.path.parent().unwrap_or(Path::new("")).join(name.as_ref());
        (self.open)(&path).map_err(|error| {
            self.refused(format!("cannot load buffers[{index}]"))
                .caused_by(files::load_error(&path, &error))
        })
    }

    /// The elements of an accessor, `N` numbers each. Normalised integers are scaled to 0..1 or -1..1.
    pub(super) fn vectors<const N: usize>(
        &mut self,
        accessor: &Accessor<'_>,
    ) -> Result<Vec<[f32; N]>, LoadError> {
        let kind = accessor.data_type();
        if accessor.dimensions().multiplicity() != N || !matches!(accessor.dimensions(), Dimensions::Vec3) {
            let index = accessor.index();
            return Err(self.refused(format!(
                "accessors[{index}] holds other elements, expected vectors of {N} numbers"
            )));
        }
        let scale = match kind {
            _ if !accessor.normalized() => None,
            DataType::I8 => Some(f32::from(i8::MAX)),
            DataType::U8 => Some(f32::from(u8::MAX)),
            DataType::I16 => Some(f32::from(i16::MAX)),
            DataType::U16 => Some(f32::from(u16::MAX)),
            DataType::U32 | DataType::F32 => None,
        };
        self.elements(accessor, |element| {
            let mut vector = [0.0; N];
            for (value, bytes) in vector.iter_mut().zip(element.chunks_exact(kind.size())) {
                let number = number(kind, bytes) as f32;
                *value = match scale {
                    // The least integer is one step below -1.
                    Some(scale) => (number / scale).max(-1.0),
                    None => number,
                };
            }
            vector
        })
    }

    /// The elements of an accessor of indices.
    pub(super) fn indices(&mut self, accessor: &Accessor<'_>) -> Result<Vec<u32>, LoadError> {
        let kind = accessor.data_type();
        let unsigned = matches!(kind, DataType::U8 | DataType::U16 | DataType::U32);
        if !unsigned || accessor.dimensions() != Dimensions::Scalar {
            let index = accessor.index();
            return Err(self.refused(format!(
                "accessors[{index}] holds other elements, expected indices (unsigned integers)"
            )));
        }
        self.elements(accessor, |element| number(kind, element) as u32)
    }

    fn elements<T: Clone>(
        &mut self,
        accessor: &Accessor<'_>,
        element: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, LoadError> {
        let index = accessor.index();
        let (size, count) = (accessor.size(), accessor.count());
        let mut values = match (accessor.view(), accessor.sparse()) {
            (Some(view), _) => {
                let part = Part {
                    name: format!("accessors[{index}]"),
                    offset: accessor.offset(),
                    count,
                    size,
                };
                self.part(&view, &part, &element)?
            }
            // The file's size does not limit how many zeros it asks for.
            (None, Some(_)) if count <= MAX_ZEROS => vec![element(&vec![0; size]); count],
            (None, Some(_)) => {
                return Err(self.refused(format!(
                    "accessors[{index}] has {count} elements without a buffer view, expected at most {MAX_ZEROS}"
                )));
            }
            (None, None) => return Err(self.refused(format!("accessors[{index}] has no buffer view"))),
        };
        let Some(sparse) = accessor.sparse() else {
            return Ok(values);
        };
        let (indices, replacements) = (sparse.indices(), sparse.values());
        let (kind, index_size) = match indices.index_type() {
            IndexType::U8 => (DataType::U8, 1),
            IndexType::U16 => (DataType::U16, 2),
            IndexType::U32 => (DataType::U32, 4),
        };
        let mut part = Part {
            name: format!("accessors[{index}].sparse.indices"),
            offset: indices.offset(),
            count: sparse.count(),
            size: index_size,
        };
        let places = self.part(&indices.view(), &part, |bytes| number(kind, bytes) as usize)?;
        part = Part {
            name: format!("accessors[{index}].sparse.values"),
            offset: replacements.offset(),
            size,
            ..part
        };
        let replacements = self.part(&replacements.view(), &part, element)?;
        for (place, value) in places.into_iter().zip(replacements) {
            let Some(to) = values.get_mut(place) else {
                return Err(self.refused(format!(
                    "accessors[{index}].sparse: element {place}, but the accessor has only {count}"
                )));
            };
            *to = value;
        }
        Ok(values)
    }

    /// Reads elements of a buffer view.
    fn part<T>(
        &mut self,
        view: &View<'_>,
        part: &Part,
        element: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, LoadError> {
        let buffer = self.bytes(&view.buffer())?;
        let &Part {
            ref name,
            offset,
            count,
            size,
        } = part;
        let stride = view.stride().unwrap_or(size);
        let beyond = |what: &str| {
            self.refused(format!(
                "{what} reaches beyond its buffer: the file is cut short or broken"
            ))
        };
        let view_end = view.offset().checked_add(view.length());
        let in_view = view_end
            .and_then(|end| buffer.get(view.offset()..end))
            .ok_or_else(|| beyond(&format!("bufferViews[{}]", view.index())))?;
        let length = count
            .checked_sub(1)
            .map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
        let elements = length
            .and_then(|length| offset.checked_add(length))
            .and_then(|end| in_view.get(offset..end))
            .ok_or_else(|| beyond(&format!("{name} ({count} elements of {size} bytes)")))?;
        let mut values = Vec::new();
        values
            .try_reserve_exact(count)
            .map_err(|_| self.refused(format!("{name} does not fit into memory")))?;
        if stride == 0 && count > 1 {
            return Err(self.refused(format!("{name} has a stride of 0")));
        }
        values.extend(
            elements
                .chunks(stride.max(1))
                .take(count)
                .map(|bytes| element(bytes.get(..size).unwrap_or_default())),
        );
        Ok(values)
    }
}

/// Elements in a buffer view.
struct Part {
    /// Their name in errors.
    name: String,
    /// Where they start in the view, in bytes.
    offset: usize,
    count: usize,
    /// Bytes of one element.
    size: usize,
}

/// A number of an accessor, exact in `f64`.
fn number(kind: DataType, bytes: &[u8]) -> f64 {
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
