//! Buffers and accessors. Every range is checked before it is read; elements are read one at a time, so that no accessor
//! takes memory beside its buffer.

use super::super::{
    OpenMesh,
    budget::{Budget, BudgetError},
    files,
};
use super::{
    compression::Compression,
    elements::{Elements, Part, Replacements, number, scale_of},
    scalars::Scalars,
};
use crate::error::{LoadError, LoadErrorKind, quote};
use base64::{Engine, prelude::BASE64_STANDARD};
use gltf::{
    Accessor, Primitive,
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

/// What follows the scheme of a data URI (RFC 2397); `None` if it is another URI. Schemes may be in capitals.
pub(super) fn data_of(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.split_once(':')?;
    scheme.eq_ignore_ascii_case("data").then_some(data)
}

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
    compression: &'a Compression<'a>,
    scalars: Scalars<'a>,
    /// By the index of their view.
    decoded: HashMap<usize, Bytes<'a>>,
    /// How many bytes were decoded.
    decoded_size: usize,
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
        compression: &'a Compression<'a>,
        budget: &'a Budget,
    ) -> Self {
        Self {
            path,
            blob,
            open,
            budget,
            read: HashMap::new(),
            files: HashMap::new(),
            compression,
            scalars: Scalars::default(),
            decoded: HashMap::new(),
            decoded_size: 0,
            accessors: HashMap::new(),
            size,
            replaced: 0,
        }
    }

    /// With the numbers of vertices that are wanted.
    pub(super) fn with_scalars(self, scalars: Scalars<'a>) -> Self {
        Self { scalars, ..self }
    }

    pub(super) fn scalars(&self) -> &Scalars<'a> {
        &self.scalars
    }

    pub(super) fn scalars_mut(&mut self) -> &mut Scalars<'a> {
        &mut self.scalars
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

    /// An error about more of something than octray takes.
    pub(super) fn too_much(&self, message: impl AsRef<str>) -> LoadError {
        self.refused(message).with_kind(LoadErrorKind::Limit)
    }

    /// An error about the file.
    pub(super) fn refused(&self, message: impl AsRef<str>) -> LoadError {
        LoadError::whole_file(self.path, message)
    }

    /// The bytes of a buffer, as they stand in its file.
    pub(super) fn bytes(&mut self, buffer: &Buffer<'_>) -> Result<Bytes<'a>, LoadError> {
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
        match data_of(uri) {
            Some(data) => Ok(Rc::new(Cow::Owned(self.data(name, data)?))),
            None => self.beside(name, uri),
        }
    }

    /// The buffer of a view, or what is decoded for it, and which part of that the view is.
    pub(super) fn view(&mut self, view: &View<'_>) -> Result<(Bytes<'a>, Range<usize>), LoadError> {
        let compression = self.compression;
        let (bytes, start) = match compression.view(view, self)? {
            Some(decoded) => (decoded, 0),
            None => (self.bytes(&view.buffer())?, view.offset()),
        };
        Ok((bytes, start..start.saturating_add(view.length())))
    }

    /// Decodes a primitive if it is compressed, so that its accessors are there.
    pub(super) fn decode_primitive(
        &mut self,
        mesh: usize,
        primitive: &Primitive<'_>,
    ) -> Result<(), LoadError> {
        self.compression.primitive(mesh, primitive, self)
    }

    /// What was decoded for a view.
    pub(super) fn decoded(&self, view: usize) -> Option<Bytes<'a>> {
        self.decoded.get(&view).map(Rc::clone)
    }

    /// Keeps what was decoded for a view.
    pub(super) fn keep_decoded(&mut self, view: usize, bytes: Vec<u8>) -> Bytes<'a> {
        let bytes: Bytes<'a> = Rc::new(Cow::Owned(bytes));
        self.decoded.insert(view, Rc::clone(&bytes));
        bytes
    }

    /// Counts bytes that are about to be decoded. Many views may name the same bytes.
    pub(super) fn count_decoded(&mut self, size: usize) -> Result<(), LoadError> {
        self.decoded_size = self.decoded_size.saturating_add(size);
        if self.decoded_size > self.size {
            return Err(self.too_much(format!(
                "{} bytes of compressed geometry, more than the {} bytes of the file hold",
                self.decoded_size, self.size
            )));
        }
        Ok(())
    }

    /// Whether an accessor has been read.
    pub(super) fn has_read(&self, accessor: usize) -> bool {
        self.accessors.contains_key(&accessor)
    }

    /// Keeps what was decoded for an accessor: packed elements of this kind, `size` bytes each.
    pub(super) fn keep(&mut self, accessor: &Accessor<'_>, kind: DataType, size: usize, bytes: Vec<u8>) {
        let index = accessor.index();
        let elements = Elements {
            accessor: index,
            kind,
            scale: scale_of(accessor.data_type(), accessor.normalized()),
            count: bytes.len() / size,
            dense: Some(Part {
                buffer: Rc::new(Cow::Owned(bytes)),
                start: 0,
                stride: size,
                size,
            }),
            replacements: None,
        };
        self.accessors.insert(index, Rc::new(elements));
    }

    /// A data URI (RFC 2397) without its scheme.
    fn data(&self, name: &str, data: &str) -> Result<Vec<u8>, LoadError> {
        let is_base64 = |(kind, _): &(&str, &str)| kind.to_ascii_lowercase().ends_with(";base64");
        let Some((_, base64)) = data.split_once(',').filter(is_base64) else {
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
        let is_right = accessor.dimensions() == Dimensions::Vec3;
        self.expected(accessor, is_right, "vectors of 3 numbers")
    }

    /// The elements of an accessor of tangents.
    pub(super) fn tangents(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Vec4;
        self.expected(accessor, is_right, "tangents (vectors of 4 numbers)")
    }

    /// The elements of an accessor of quaternions.
    pub(super) fn quaternions(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Vec4;
        self.expected(accessor, is_right, "quaternions (vectors of 4 numbers)")
    }

    /// The elements of an accessor of single numbers.
    pub(super) fn numbers(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Scalar;
        self.expected(accessor, is_right, "single numbers")
    }

    /// The elements of an accessor of times.
    pub(super) fn times(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Scalar && accessor.data_type() == DataType::F32;
        self.expected(accessor, is_right, "times (floats)")
    }

    /// The elements of an accessor of texture coordinates.
    pub(super) fn pairs(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Vec2;
        self.expected(accessor, is_right, "texture coordinates (vectors of 2 numbers)")
    }

    /// The elements of an accessor of colours: red, green and blue, perhaps alpha.
    pub(super) fn colors(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = matches!(accessor.dimensions(), Dimensions::Vec3 | Dimensions::Vec4)
            && matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::F32);
        self.expected(
            accessor,
            is_right,
            "colours (3 or 4 bytes, unsigned shorts or floats)",
        )
    }

    /// The elements of an accessor of differences of colours, which may be negative.
    pub(super) fn color_differences(
        &mut self,
        accessor: &Accessor<'_>,
    ) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = matches!(accessor.dimensions(), Dimensions::Vec3 | Dimensions::Vec4);
        self.expected(accessor, is_right, "differences of colours (3 or 4 numbers)")
    }

    /// The elements of an accessor of the numbers of joints.
    pub(super) fn joints(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Vec4
            && matches!(accessor.data_type(), DataType::U8 | DataType::U16);
        self.expected(accessor, is_right, "joints (4 bytes or unsigned shorts)")
    }

    /// The elements of an accessor of the weights of joints.
    pub(super) fn weights(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Vec4
            && matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::F32);
        self.expected(accessor, is_right, "weights (4 bytes, unsigned shorts or floats)")
    }

    /// The elements of an accessor of 4x4 matrices.
    pub(super) fn matrices(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Mat4 && accessor.data_type() == DataType::F32;
        self.expected(accessor, is_right, "matrices (16 floats)")
    }

    /// The elements of an accessor of indices.
    pub(super) fn indices(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let is_right = accessor.dimensions() == Dimensions::Scalar
            && matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        self.expected(accessor, is_right, "indices (unsigned integers)")
    }

    /// The elements of an accessor, if it has the right type; else an error that says what was expected.
    fn expected(
        &mut self,
        accessor: &Accessor<'_>,
        is_right: bool,
        expected: &str,
    ) -> Result<Rc<Elements<'a>>, LoadError> {
        if is_right {
            return self.elements(accessor);
        }
        Err(self.refused(format!(
            "accessors[{}] holds other elements, expected {expected}",
            accessor.index()
        )))
    }

    fn elements(&mut self, accessor: &Accessor<'_>) -> Result<Rc<Elements<'a>>, LoadError> {
        let index = accessor.index();
        if let Some(elements) = self.accessors.get(&index) {
            return Ok(Rc::clone(elements));
        }
        let (size, count) = (accessor.size(), accessor.count());
        let dense = match accessor.view() {
            Some(view) => {
                let name = format!("accessors[{index}]");
                Some(self.part(&view, &name, accessor.offset(), [count, size])?)
            }
            // All elements are zeros, says the specification.
            None => None,
        };
        let replacements = match accessor.sparse() {
            Some(sparse) => Some(self.sparse(&sparse, index, [count, size])?),
            None => None,
        };
        let kind = accessor.data_type();
        let scale = scale_of(kind, accessor.normalized());
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
            return Err(self.too_much(format!(
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
        let (buffer, range) = self.view(view)?;
        let stride = view.stride().unwrap_or(size);
        let beyond = |what: &str| {
            self.refused(format!(
                "{what} reaches beyond its buffer: the file is cut short or broken"
            ))
        };
        let in_view = buffer
            .get(range.clone())
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
            start: range.start + offset,
            buffer,
            stride,
            size,
        })
    }
}
