//! The header: parsed by serde-ply, checked, and turned into steps that read a record.

use super::{
    fault::{Fault, Place},
    slots::{COLOR_SLOT, SlotNames, VERTEX_SLOTS},
};
use crate::{
    error::{LoadErrorKind, quote},
    format::{
        foreign,
        left_out::counted,
        mesh::{Owner, UpAxis},
        place::{LFS_POINTER, LONE_RETURNS, after_mark, is_lfs_pointer, is_utf16},
    },
};
use serde_ply::{PlyFormat, PlyReader, PropertyType, ScalarType};
use std::{io::Cursor, ops::Range};

/// The longest header, in bytes. Without a limit, a file of comments would be in memory several times.
const MAX_HEADER: usize = 1 << 20;

/// A valid header; the rest of the file is long enough for its counts.
#[derive(Debug)]
pub(super) struct Header {
    /// Text, or binary with its byte order.
    pub(super) format: PlyFormat,
    /// The elements in file order.
    pub(super) elements: Vec<Element>,
    /// Where the first record starts, in bytes.
    pub(super) body: usize,
    /// The number of vertices.
    pub(super) vertices: usize,
    /// Whether the vertices have normals.
    pub(super) has_normals: bool,
    /// Whether the vertices have colours.
    pub(super) has_colors: bool,
    /// The up axis, if a `comment up` line names one.
    pub(super) up: Option<UpAxis>,
    /// The word of a `comment up` line that names no axis, quoted.
    pub(super) odd_up: Option<String>,
    /// The image files that `comment TextureFile` lines name.
    pub(super) textures: Vec<String>,
    /// Whether the vertices have texture coordinates.
    pub(super) has_uvs: bool,
    /// Whether the corners of faces have some.
    pub(super) has_corner_uvs: bool,
    /// Whether faces say which of `textures` they show; else it is the first one.
    pub(super) has_texture_numbers: bool,
    /// Whether faces have colours.
    pub(super) has_face_colors: bool,
    /// Whether numbers or coordinates are shown instead of colours.
    pub(super) shows_numbers: bool,
    /// What has the numbers, if they are asked for by name.
    pub(super) valued: Option<Owner>,
}

/// What an element's records become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Positions, normals and colours.
    Vertex,
    /// Triangles.
    Face,
    /// Triangle strips; index -1 begins a new strip.
    Strips,
    /// Lines, in a file without faces.
    Edge,
    /// Nothing.
    Other,
}

/// An element and how to read its records.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) role: Role,
    pub(super) name: String,
    pub(super) count: usize,
    /// A step and a name for each property.
    pub(super) steps: Vec<Step>,
    pub(super) property_names: Vec<String>,
}

/// How to read one property of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Keep a number: slots 0 to 2 are the position, 3 to 5 the normal, 6 to 8 the colour, 9 and 10 the texture
    /// coordinates, and [`VALUE_SLOT`] what is shown instead of colours. Faces have only colours or that, edges only the
    /// vertices at their ends, 0 and 1.
    Keep { slot: usize, scalar: ScalarType },
    /// Make triangles of a list of vertex indices.
    Indices { count: ScalarType, item: ScalarType },
    /// Keep a list of texture coordinates, two for each corner of a face.
    CornerUvs { count: ScalarType, item: ScalarType },
    /// Keep the number of a face's texture.
    TextureNumber(ScalarType),
    /// Skip a number.
    Skip(ScalarType),
    /// Skip a list.
    SkipList { count: ScalarType, item: ScalarType },
}

impl Step {
    /// Its bytes in a binary file; `None` for lists.
    pub(super) fn size(&self) -> Option<usize> {
        match *self {
            Self::Keep { scalar, .. } | Self::TextureNumber(scalar) | Self::Skip(scalar) => {
                Some(scalar_size(scalar))
            }
            Self::Indices { .. } | Self::CornerUvs { .. } | Self::SkipList { .. } => None,
        }
    }

    /// The step over what this one keeps.
    pub(super) fn skipped(self) -> Self {
        match self {
            Self::Keep { scalar, .. } | Self::TextureNumber(scalar) | Self::Skip(scalar) => {
                Self::Skip(scalar)
            }
            Self::Indices { count, item }
            | Self::CornerUvs { count, item }
            | Self::SkipList { count, item } => Self::SkipList { count, item },
        }
    }
}

const INDEX_NAMES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Bytes of a scalar in a binary file.
pub(super) fn scalar_size(scalar: ScalarType) -> usize {
    match scalar {
        ScalarType::I8 | ScalarType::U8 => 1,
        ScalarType::I16 | ScalarType::U16 => 2,
        ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
        ScalarType::F64 => 8,
    }
}

/// What a number of a colour is divided by: full brightness is 1 for floats, and the largest value of `uchar` and
/// `ushort`. Other integers are bytes in larger types.
pub(super) fn color_scale(scalar: ScalarType) -> f32 {
    match scalar {
        ScalarType::F32 | ScalarType::F64 => 1.0,
        ScalarType::U16 => f32::from(u16::MAX),
        _ => f32::from(u8::MAX),
    }
}

impl Header {
    /// Parses the header at the start of `bytes`; `length` is that of the whole file.
    pub(super) fn parse(bytes: &[u8], length: usize) -> Result<Self, Fault> {
        let body = find_end(bytes)?;
        // Comments may be in any encoding. The last newline may be missing.
        let mut text =
            String::from_utf8_lossy(bytes.get(after_mark(bytes)..body).unwrap_or(bytes)).into_owned();
        if !text.ends_with('\n') {
            text.push('\n');
        }
        // Some programs write `PLY`.
        if let Some(first) = text.get_mut(..3) {
            first.make_ascii_lowercase();
        }
        let mut cursor = Cursor::new(text.as_bytes());
        let parsed = PlyReader::from_reader(&mut cursor).map(|reader| reader.header().clone());
        let consumed = cursor.position();
        let parsed = parsed.map_err(|error| not_understood(bytes, &text, consumed, &error.0.to_string()))?;
        if consumed != text.len() as u64 {
            // An earlier `end_header` with odd spaces around it: it is unclear which one counts.
            let before = text.get(..consumed as usize).unwrap_or_default();
            let line = line_range(bytes, before.matches('\n').count().saturating_sub(1));
            return Err(Fault::text(line, "two `end_header` lines, expected one"));
        }

        let mut header = Self {
            format: parsed.format,
            elements: Vec::with_capacity(parsed.elem_defs.len()),
            body,
            vertices: 0,
            has_normals: false,
            has_colors: false,
            up: None,
            odd_up: None,
            textures: Vec::new(),
            has_uvs: false,
            has_corner_uvs: false,
            has_texture_numbers: false,
            has_face_colors: false,
            shows_numbers: false,
            valued: None,
        };
        header.read_comments(&text);
        for (i, definition) in parsed.elem_defs.iter().enumerate() {
            let element = Element::plan(definition)
                .map_err(|(property, message)| Fault::text(header_line(bytes, i, property), message))?;
            if element.role != Role::Other && header.elements.iter().any(|e| e.role == element.role) {
                let message = format!("second element {}, expected one", quote(element.name.as_bytes()));
                return Err(Fault::text(header_line(bytes, i, 0), message));
            }
            if element.role == Role::Vertex {
                header.vertices = element.count;
                header.has_normals = element.keeps(3);
                header.has_colors = element.keeps(COLOR_SLOT);
            }
            header.elements.push(element);
        }
        header.choose();
        header.check_room(bytes, length)?;
        Ok(header)
    }

    /// Whether the vertices are points of a cloud, or ends of lines.
    pub(super) fn is_cloud(&self) -> bool {
        self.vertices > 0 && !self.has_faces()
    }

    /// Whether there are faces or strips.
    pub(super) fn has_faces(&self) -> bool {
        let has_faces =
            |element: &Element| matches!(element.role, Role::Face | Role::Strips) && element.count > 0;
        self.elements.iter().any(has_faces)
    }

    /// The elements up to the last one that a mesh needs. Records without properties are skipped: any count of them fits.
    pub(super) fn needed(&self) -> impl Iterator<Item = &Element> {
        let last = self
            .elements
            .iter()
            .rposition(|element| element.role != Role::Other);
        let needed = self.elements.iter().take(last.map_or(0, |last| last + 1));
        needed.filter(|element| !element.steps.is_empty())
    }

    /// Refuses counts that do not fit into the rest of the file, before anything is allocated for them.
    fn check_room(&self, bytes: &[u8], length: usize) -> Result<(), Fault> {
        let room = length.saturating_sub(self.body);
        let mut needed = 0_u128;
        for (i, element) in self.elements.iter().enumerate() {
            needed += element.count as u128 * element.least_bytes(self.format) as u128;
            // The last number of a text needs no space after it.
            let spare = u128::from(self.format == PlyFormat::Ascii);
            if needed.saturating_sub(spare) > room as u128 {
                let message = format!(
                    "{} need at least {needed} bytes, but only {room} follow the header: the file is cut short or the \
                     count is wrong",
                    counted(
                        element.count,
                        &format!("{} record", quote(element.name.as_bytes())),
                        &format!("{} records", quote(element.name.as_bytes()))
                    ),
                );
                return Err(Fault::text(header_line(bytes, i, 0), message));
            }
        }
        Ok(())
    }
}

impl Element {
    /// An error has the number of the property that it is about, from 1; 0 for the element.
    fn plan(definition: &serde_ply::ElementDef) -> Result<Self, (usize, String)> {
        let role = match definition.name.as_str() {
            "vertex" => Role::Vertex,
            "face" => Role::Face,
            "tristrips" => Role::Strips,
            _ => Role::Other,
        };
        let mut element = Self {
            role,
            name: definition.name.clone(),
            count: definition.count,
            steps: Vec::with_capacity(definition.properties.len()),
            property_names: definition.properties.iter().map(|p| p.name.clone()).collect(),
        };
        let names = SlotNames::of(definition, role);
        for property in &definition.properties {
            let step = element.step(&property.name, &property.property_type, &names);
            let number = element.steps.len() + 1;
            element.steps.push(step.map_err(|message| (number, message))?);
        }
        element.expect_complete().map_err(|message| (0, message))?;
        Ok(element)
    }

    /// What becomes of the next property.
    fn step(&self, name: &str, kind: &PropertyType, names: &SlotNames) -> Result<Step, String> {
        let is_indices = matches!(self.role, Role::Face | Role::Strips) && INDEX_NAMES.contains(&name);
        let is_new = |kind: fn(&Step) -> bool| self.role == Role::Face && !self.steps.iter().any(kind);
        match (kind, names.slot(name)) {
            (&PropertyType::Scalar(scalar), Some(slot)) => {
                if self.keeps(slot) {
                    return Err(format!("second property `{name}`, expected one"));
                }
                Ok(Step::Keep { slot, scalar })
            }
            (PropertyType::List { .. }, Some(_)) => Err(format!("`{name}` is a list, expected a number")),
            (PropertyType::Scalar(_), None) if is_indices => {
                Err(format!("`{name}` is a number, expected a list"))
            }
            (&PropertyType::Scalar(scalar), None) => {
                let is_number = name == "texnumber" && is_new(|step| matches!(step, Step::TextureNumber(_)));
                Ok(if is_number {
                    Step::TextureNumber(scalar)
                } else {
                    Step::Skip(scalar)
                })
            }
            (
                &PropertyType::List {
                    count_type: count,
                    data_type: item,
                },
                None,
            ) => {
                if is_indices {
                    if self.steps.iter().any(|step| matches!(step, Step::Indices { .. })) {
                        return Err("second list of vertex indices, expected one".to_owned());
                    }
                    return Ok(Step::Indices { count, item });
                }
                let is_uvs = name == "texcoord" && is_new(|step| matches!(step, Step::CornerUvs { .. }));
                Ok(if is_uvs {
                    Step::CornerUvs { count, item }
                } else {
                    Step::SkipList { count, item }
                })
            }
        }
    }

    /// Refuses vertices without positions and faces without indices, if there are any records of them.
    fn expect_complete(&self) -> Result<(), String> {
        if self.count == 0 {
            return Ok(());
        }
        let has_indices = self.steps.iter().any(|step| matches!(step, Step::Indices { .. }));
        match self.role {
            Role::Vertex => match (0..3).find(|&slot| !self.keeps(slot)) {
                Some(slot) => Err(format!(
                    "element `vertex` has no property `{}`, expected `x`, `y` and `z`",
                    VERTEX_SLOTS.get(slot).unwrap_or(&"")
                )),
                None => Ok(()),
            },
            Role::Face | Role::Strips if !has_indices => Err(format!(
                "element {} has no list `vertex_indices` or `vertex_index`, expected one",
                quote(self.name.as_bytes())
            )),
            _ => Ok(()),
        }
    }

    /// Whether a property fills this slot.
    pub(super) fn keeps(&self, wanted: usize) -> bool {
        self.steps
            .iter()
            .any(|step| matches!(step, Step::Keep { slot, .. } if *slot == wanted))
    }

    /// The number of the property that is the alpha of the colours; it is not kept.
    pub(super) fn alpha(&self) -> Option<usize> {
        let names = self.property_names.iter().zip(&self.steps);
        let is_alpha = |(name, step): (&String, &Step)| {
            matches!(name.as_str(), "alpha" | "a") && matches!(step, Step::Skip(_))
        };
        names
            .map(is_alpha)
            .position(|is_alpha| is_alpha)
            .filter(|_| self.keeps(COLOR_SLOT))
    }

    /// The least bytes that a record takes, if its lists are empty.
    fn least_bytes(&self, format: PlyFormat) -> usize {
        let size = |scalar| match format {
            // A digit and a space.
            PlyFormat::Ascii => 2,
            PlyFormat::BinaryLittleEndian | PlyFormat::BinaryBigEndian => scalar_size(scalar),
        };
        let of_step = |step: &Step| match *step {
            Step::Keep { scalar, .. } | Step::TextureNumber(scalar) | Step::Skip(scalar) => size(scalar),
            Step::Indices { count, .. } | Step::CornerUvs { count, .. } | Step::SkipList { count, .. } => {
                size(count)
            }
        };
        self.steps.iter().map(of_step).sum()
    }

    /// Whether its records have colours or textures of faces: they take the slow path (`painted.rs`).
    pub(super) fn is_painted(&self) -> bool {
        let is_painted = |step: &Step| {
            matches!(
                step,
                Step::Keep { .. } | Step::CornerUvs { .. } | Step::TextureNumber(_)
            )
        };
        self.role == Role::Face && self.steps.iter().any(is_painted)
    }

    /// Bytes of each record in a binary file; `None` if they differ.
    pub(super) fn stride(&self) -> Option<usize> {
        self.steps.iter().map(Step::size).sum()
    }
}

/// Where the line after `end_header` starts, in bytes.
pub(super) fn find_end(bytes: &[u8]) -> Result<usize, Fault> {
    if bytes.is_empty() {
        return Err(Fault::file("the file is empty, expected a PLY mesh"));
    }
    if let Some(message) = foreign::fault(bytes, "expected a PLY mesh") {
        return Err(Fault {
            place: Place::File,
            message,
            kind: LoadErrorKind::Unsupported,
        });
    }
    if let Some([next, ..]) = bytes.strip_prefix(b"ply\r")
        && *next != b'\n'
    {
        return Err(Fault::file(LONE_RETURNS));
    }
    let mut end = after_mark(bytes);
    for (i, line) in bytes[end..].split_inclusive(|&byte| byte == b'\n').enumerate() {
        let start = end;
        end += line.len();
        let line = line.trim_ascii();
        if i == 0 && !line.eq_ignore_ascii_case(b"ply") {
            let message = if is_lfs_pointer(line) {
                LFS_POINTER.to_owned()
            } else if is_utf16(line) {
                "this is UTF-16, expected a PLY mesh in ASCII".to_owned()
            } else {
                format!("not a PLY mesh: found {}, expected `ply`", quote(line))
            };
            return Err(Fault::text(start..start + line.len(), message));
        }
        if line == b"end_header" {
            return Ok(end);
        }
        if end > MAX_HEADER {
            let message = format!("the header has more than {MAX_HEADER} bytes, expected `end_header`");
            return Err(Fault::text(start..start, message));
        }
    }
    let message = "the file ends inside its header, expected `end_header`";
    let end = bytes.trim_ascii_end().len();
    Err(Fault::text(end..end, message))
}

/// serde-ply's error, with the line at which it stopped and what it should have been.
fn not_understood(bytes: &[u8], text: &str, consumed: u64, complaint: &str) -> Fault {
    let read = text.get(..consumed as usize).unwrap_or(text);
    let line = line_range(bytes, read.matches('\n').count().saturating_sub(1));
    let keyword = read
        .lines()
        .last()
        .and_then(|line| line.split_whitespace().next());
    let expected = match keyword {
        Some("format") => {
            "expected `format ascii 1.0`, `format binary_little_endian 1.0` or `format binary_big_endian 1.0`"
        }
        Some("element") => "expected `element NAME COUNT`",
        Some("property") => {
            "expected `property TYPE NAME` or `property list TYPE TYPE NAME` after an `element` line, with types \
             char, uchar, short, ushort, int, uint, float, double or int8, uint8, ... float64"
        }
        _ => "expected a `format` line and an `end_header` line",
    };
    // The error may repeat long words of the file.
    let mut complaint: String = complaint.chars().take(80).collect();
    if let Some(first) = complaint.get_mut(..1) {
        first.make_ascii_lowercase();
    }
    Fault::text(line, format!("{complaint}; {expected}"))
}

/// The range of the words of line `wanted`, 0-based.
fn line_range(bytes: &[u8], wanted: usize) -> Range<usize> {
    let mut start = 0;
    for (i, line) in bytes.split_inclusive(|&byte| byte == b'\n').enumerate() {
        if i == wanted {
            let lead = line.len() - line.trim_ascii_start().len();
            return start + lead..start + lead + line.trim_ascii().len();
        }
        start += line.len();
    }
    start..start
}

/// The range of the header's line of an element, from 0, or of its property, from 1; property 0 is the element itself.
fn header_line(bytes: &[u8], element: usize, property: usize) -> Range<usize> {
    let (mut elements, mut properties) = (0, 0);
    let line = bytes.split(|&byte| byte == b'\n').position(|line| {
        match line.trim_ascii_start().split(u8::is_ascii_whitespace).next() {
            Some(b"element") => (elements, properties) = (elements + 1, 0),
            Some(b"property") => properties += 1,
            _ => return false,
        }
        elements == element + 1 && properties == property
    });
    line.map_or(0..0, |i| line_range(bytes, i))
}
