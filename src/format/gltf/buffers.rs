//! Buffers and accessors. Every range is checked before it is read; elements are read one by one, so that no accessor
//! takes memory beside its buffer.

use super::super::{
    OpenMesh,
    budget::{Budget, BudgetError},
    files,
};
use crate::error::{LoadError, quote};
use base64::{Engine, prelude::BASE64_STANDARD};
use gltf::{
    Accessor,
    accessor::{
        DataType, Dimensions,
        sparse::{IndexType, Sparse},
    },
    buffer::{Buffer, Source, View},
};
use percent_encoding::percent_decode_str;
use std::{
    borrow::Cow,
    collections::HashMap,
    ops::Range,
    path::{Component, Path, PathBuf},
    rc::Rc,
};

/// The bytes of a buffer.
pub(super) type Bytes<'a> = Rc<Cow<'a, [u8]>>;

/// A file's buffers and accessors; each is read once, and so is each file, however many buffers name it.
pub(super) struct Buffers<'a> {
    path: &'a Path,
    blob: Option<&'a [u8]>,
    open: OpenMesh<'a>,
    budget: &'a Budget,
    /// By their index.
    read: HashMap<usize, Bytes<'a>>,
    files: HashMap<PathBuf, Bytes<'a>>,
    /// By their index.
    accessors: HashMap<usize, Rc<Elements<'a>>>,
    /// The bytes of the file and of all buffers that were read.
    size: usize,
    /// How many elements of sparse accessors were read.
    replaced: usize,
}

impl<'a> Buffers<'a> {
    /// The buffers of the file at `path`, which has `size` bytes; `blob` is the buffer inside a .glb.
    pub(super) fn new(
        path: &'a Path,
        size: usize,
        blob: Option<&'a [u8]>,
        open: OpenMesh<'a>,
        budget: &'a Budget,
    ) -> Self {
        Self {
            path,
            blob,
            open,
            budget,
            read: HashMap::new(),
            files: HashMap::new(),
            accessors: HashMap::new(),
            size,
            replaced: 0,
        }
    }

    /// How many bytes the file and all buffers that were read have, each file once.
    pub(super) fn size(&self) -> usize {
        self.size
    }

    /// What loading may take.
    pub(super) fn budget(&self) -> &'a Budget {
        self.budget
    }

    /// An error about memory.
    pub(super) fn no_room(&self, error: BudgetError) -> LoadError {
        error.into_error(self.path)
    }

    /// An error about the file.
    pub(super) fn refused(&self, message: impl AsRef<str>) -> LoadError {
        LoadError::whole_file(self.path, message)
    }

    fn bytes(&mut self, buffer: &Buffer<'_>) -> Result<Bytes<'a>, LoadError> {
        let index = buffer.index();
        if let Some(bytes) = self.read.get(&index) {
            return Ok(Rc::clone(bytes));
        }
        let bytes: Bytes<'a> = match buffer.source() {
            Source::Bin => match self.blob {
                Some(blob) if index == 0 => Rc::new(Cow::Borrowed(blob)),
                _ => {
                    return Err(self.refused(format!(
                        "buffers[{index}] has no `uri`, and the file has no binary chunk"
                    )));
                }
            },
            Source::Uri(uri) => self.uri(&format!("buffers[{index}]"), uri)?,
        };
        if bytes.len() < buffer.length() {
            return Err(self.refused(format!(
                "buffers[{index}] has {} bytes, expected {}",
                bytes.len(),
                buffer.length()
            )));
        }
        self.read.insert(index, Rc::clone(&bytes));
        Ok(bytes)
    }

    /// The path of the file.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// What a URI holds or names; `name` is what errors call it.
    pub(super) fn uri(&mut self, name: &str, uri: &str) -> Result<Bytes<'a>, LoadError> {
        match uri.strip_prefix("data:") {
            Some(data) => Ok(Rc::new(Cow::Owned(self.data(name, data)?))),
            None => self.beside(name, uri),
        }
    }

    /// The buffer of a view, and which part of it the view is.
    pub(super) fn view(&mut self, view: &View<'_>) -> Result<(Bytes<'a>, Range<usize>), LoadError> {
        let bytes = self.bytes(&view.buffer())?;
        let end = view.offset().saturating_add(view.length());
        Ok((bytes, view.offset()..end))
    }

    /// A data URI (RFC 2397) without its scheme.
    fn data(&self, name: &str, data: &str) -> Result<Vec<u8>, LoadError> {
        let Some((_, base64)) = data.split_once(";base64,") else {
            return Err(self.refused(format!("{name} is a data URI without `;base64,`")));
        };
        let room = base64::decoded_len_estimate(base64.len());
        self.budget.take(room).map_err(|error| self.no_room(error))?;
        BASE64_STANDARD
            .decode(base64)
            .map_err(|error| self.refused(format!("{name} is not valid Base64: {error}")))
    }

    /// Reads a file beside this one.
    fn beside(&mut self, name: &str, uri: &str) -> Result<Bytes<'a>, LoadError> {
        let file = percent_decode_str(uri).decode_utf8_lossy();
        if uri.contains("://") || file.len() > 4096 {
            let found = quote(uri.as_bytes());
            return Err(self.refused(format!(
                "{name} is {found}, expected the name of a file beside this one"
            )));
        }
        let path = self.path.parent().unwrap_or(Path::new("")).join(file.as_ref());
        let same = path.components().filter(|part| *part != Component::CurDir);
        let same: PathBuf = same.collect();
        if let Some(bytes) = self.files.get(&same) {
            return Ok(Rc::clone(bytes));
        }
        let bytes = (self.open)(&path).map_err(|error| {
            self.refused(format!("cannot load {name}"))
                .caused_by(files::load_error(&path, &error))
        })?;
        self.size = self.size.saturating_add(bytes.len());
        let bytes = Rc::new(Cow::Owned(bytes));
        self.files.insert(same, Rc::clone(&bytes));
        Ok(bytes)
    }

    /// The elements of an accessor of vectors.
    pub(super) fn vectors(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        if !matches!(accessor.dimensions(), Dimensions::Vec3) {
            let index = accessor.index();
            return Err(self.refused(format!(
                "accessors[{index}] holds other elements, expected vectors of 3 numbers"
            )));
        }
        self.elements(accessor)
    }

    /// The elements of an accessor of quaternions.
    pub(super) fn quaternions(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        if !matches!(accessor.dimensions(), Dimensions::Vec4) {
            let index = accessor.index();
            return Err(self.refused(format!(
                "accessors[{index}] holds other elements, expected quaternions (vectors of 4 numbers)"
            )));
        }
        self.elements(accessor)
    }

    /// The elements of an accessor of texture coordinates.
    pub(super) fn pairs(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        if !matches!(accessor.dimensions(), Dimensions::Vec2) {
            let index = accessor.index();
            return Err(self.refused(format!(
                "accessors[{index}] holds other elements, expected texture coordinates (vectors of 2 numbers)"
            )));
        }
        self.elements(accessor)
    }

    /// The elements of an accessor of colours: red, green and blue, perhaps alpha.
    pub(super) fn colors(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_color = matches!(accessor.dimensions(), Dimensions::Vec3 | Dimensions::Vec4)
            && matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::F32);
        if !is_color {
            let index = accessor.index();
            return Err(self.refused(format!(
                "accessors[{index}] holds other elements, expected colours (3 or 4 bytes, unsigned shorts or floats)"
            )));
        }
        self.elements(accessor)
    }

    /// The elements of an accessor of indices.
    pub(super) fn indices(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let kind = accessor.data_type();
        let unsigned = matches!(kind, DataType::U8 | DataType::U16 | DataType::U32);
        if !unsigned || accessor.dimensions() != Dimensions::Scalar {
            let index = accessor.index();
            return Err(self.refused(format!(
                "accessors[{index}] holds other elements, expected indices (unsigned integers)"
            )));
        }
        self.elements(accessor)
    }

    fn elements(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let index = accessor.index();
        if let Some(elements) = self.accessors.get(&index) {
            return Ok(Rc::clone(elements));
        }
        let (size, count) = (accessor.size(), accessor.count());
        let dense = match (accessor.view(), accessor.sparse()) {
            (Some(view), _) => {
                let name = format!("accessors[{index}]");
                Some(self.part(&view, &name, accessor.offset(), [count, size])?)
            }
            (None, Some(_)) => None,
            (None, None) => return Err(self.refused(format!("accessors[{index}] has no buffer view"))),
        };
        let replacements = match accessor.sparse() {
            Some(sparse) => Some(self.sparse(&sparse, index, [count, size])?),
            None => None,
        };
        let kind = accessor.data_type();
        let scale = match kind {
            _ if !accessor.normalized() => None,
            DataType::I8 => Some(f32::from(i8::MAX)),
            DataType::U8 => Some(f32::from(u8::MAX)),
            DataType::I16 => Some(f32::from(i16::MAX)),
            DataType::U16 => Some(f32::from(u16::MAX)),
            DataType::U32 | DataType::F32 => None,
        };
        let elements = Rc::new(Elements {
            accessor: index,
            kind,
            scale,
            count,
            dense,
            replacements,
        });
        self.accessors.insert(index, Rc::clone(&elements));
        Ok(elements)
    }

    /// The elements that a sparse accessor replaces. The accessor has the number `index`, and its elements have this
    /// count and size.
    fn sparse(
        &mut self,
        sparse: &Sparse<'_>,
        index: usize,
        [count, size]: [usize; 2],
    ) -> Result<Replacements<'a>, LoadError> {
        let (kind, index_size) = match sparse.indices().index_type() {
            IndexType::U8 => (DataType::U8, 1),
            IndexType::U16 => (DataType::U16, 2),
            IndexType::U32 => (DataType::U32, 4),
        };
        let (places, values) = (sparse.indices(), sparse.values());
        let name = format!("accessors[{index}].sparse");
        let shape = [sparse.count(), index_size];
        let places = self.part(&places.view(), &format!("{name}.indices"), places.offset(), shape)?;
        let shape = [sparse.count(), size];
        let values = self.part(&values.view(), &format!("{name}.values"), values.offset(), shape)?;
        // Many accessors may name the same bytes.
        self.replaced = self.replaced.saturating_add(sparse.count());
        if self.replaced > self.size {
            return Err(self.refused(format!(
                "sparse accessors replace {} elements, more than the {} bytes of the file hold",
                self.replaced, self.size
            )));
        }
        let mut order = Vec::new();
        let room = self.budget.reserve(&mut order, sparse.count());
        room.map_err(|error| self.no_room(error))?;
        for i in 0..sparse.count() {
            let place = number(kind, places.element(i)) as u32;
            if place as usize >= count {
                return Err(self.refused(format!(
                    "accessors[{index}].sparse: element {place}, but the accessor has only {count}"
                )));
            }
            order.push([place, i as u32]);
        }
        order.sort_unstable();
        Ok(Replacements { order, values })
    }

    /// Elements of a buffer view from `offset` on, of this count and size. `name` is what errors call them.
    fn part(
        &mut self,
        view: &View<'_>,
        name: &str,
        offset: usize,
        [count, size]: [usize; 2],
    ) -> Result<Part<'a>, LoadError> {
        let buffer = self.bytes(&view.buffer())?;
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
        length
            .and_then(|length| offset.checked_add(length))
            .and_then(|end| in_view.get(offset..end))
            .ok_or_else(|| beyond(&format!("{name} ({count} elements of {size} bytes)")))?;
        // Else few bytes could hold many elements.
        if stride < size && count > 1 {
            return Err(self.refused(format!(
                "{name} has elements of {size} bytes but a stride of {stride}, expected {size} or more"
            )));
        }
        Ok(Part {
            start: view.offset() + offset,
            buffer,
            stride,
            size,
        })
    }
}

/// The elements of an accessor.
pub(super) struct Elements<'a> {
    /// The accessor's index in the file.
    pub(super) accessor: usize,
    pub(super) count: usize,
    kind: DataType,
    /// What normalised integers are divided by.
    scale: Option<f32>,
    /// `None` if all elements are zeros.
    dense: Option<Part<'a>>,
    replacements: Option<Replacements<'a>>,
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

    /// Index `i`.
    pub(super) fn index(&self, i: usize) -> u32 {
        number(self.kind, self.bytes(i)) as u32
    }
}

/// The elements that a sparse accessor replaces.
struct Replacements<'a> {
    /// An element and the number of its replacement, ascending. Of several for one element the last counts.
    order: Vec<[u32; 2]>,
    values: Part<'a>,
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
struct Part<'a> {
    buffer: Bytes<'a>,
    /// Where the first one is, in bytes.
    start: usize,
    stride: usize,
    size: usize,
}

impl Part<'_> {
    fn element(&self, i: usize) -> &[u8] {
        let at = self.start + i * self.stride;
        self.buffer.get(at..at + self.size).unwrap_or_default()
    }
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
