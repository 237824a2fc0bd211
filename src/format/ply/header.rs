//! The header: parsed by serde-ply, checked, and turned into steps that read a record.

use super::rows::{Fault, Place};
use crate::{
    error::quote,
    format::{
        left_out::{LeftOut, counted},
        mesh::UpAxis,
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
    odd_up: Option<String>,
    /// Whether a `comment TextureFile` line names a texture.
    has_texture: bool,
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
    /// Keep a number: slots 0 to 2 are the position, 3 to 5 the normal, 6 to 8 the colour.
    Keep { slot: usize, scalar: ScalarType },
    /// Make triangles of a list of vertex indices.
    Indices { count: ScalarType, item: ScalarType },
    /// Skip a number.
    Skip(ScalarType),
    /// Skip a list.
    SkipList { count: ScalarType, item: ScalarType },
}

impl Step {
    /// Its bytes in a binary file; `None` for lists.
    pub(super) fn size(&self) -> Option<usize> {
        match *self {
            Self::Keep { scalar, .. } | Self::Skip(scalar) => Some(scalar_size(scalar)),
            Self::Indices { .. } | Self::SkipList { .. } => None,
        }
    }
}

/// How many numbers of a vertex are kept.
pub(super) const SLOTS: usize = 9;
/// The slot of red; green and blue follow.
pub(super) const COLOR_SLOT: usize = 6;
const VERTEX_SLOTS: [&str; COLOR_SLOT] = ["x", "y", "z", "nx", "ny", "nz"];
/// What programs call the channels of a colour. A file's first complete set counts.
const COLOR_NAMES: [[&str; 3]; 3] = [
    ["red", "green", "blue"],
    ["diffuse_red", "diffuse_green", "diffuse_blue"],
    ["r", "g", "b"],
];
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
        let mut text = String::from_utf8_lossy(bytes.get(..body).unwrap_or(bytes)).into_owned();
        if !text.ends_with('\n') {
            text.push('\n');
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
            has_texture: false,
        };
        header.read_comments(&text);
        for (i, definition) in parsed.elem_defs.iter().enumerate() {
            let element =
                Element::plan(definition).map_err(|message| Fault::text(element_line(bytes, i), message))?;
            if element.role != Role::Other && header.elements.iter().any(|e| e.role == element.role) {
                let message = format!("second element {}, expected one", quote(element.name.as_bytes()));
                return Err(Fault::text(element_line(bytes, i), message));
            }
            if element.role == Role::Vertex {
                header.vertices = element.count;
                header.has_normals = element.keeps(3);
                header.has_colors = element.keeps(COLOR_SLOT);
            }
            header.elements.push(element);
        }
        header.check_room(bytes, length)?;
        Ok(header)
    }

    /// Reads what programs write into comments: `comment up z`, and MeshLab's `comment TextureFile NAME`.
    fn read_comments(&mut self, text: &str) {
        for line in text.lines() {
            let mut words = line.split_whitespace();
            if words.next() != Some("comment") {
                continue;
            }
            match (words.next(), words.next(), words.next()) {
                (Some(word), Some(axis), None) if word.eq_ignore_ascii_case("up") => match axis.parse() {
                    Ok(axis) => self.up = Some(axis),
                    Err(_) => self.odd_up = Some(quote(axis.as_bytes())),
                },
                (Some(word), Some(_), _) => self.has_texture |= word.eq_ignore_ascii_case("TextureFile"),
                _ => {}
            }
        }
    }

    /// What the file holds and is not read.
    pub(super) fn left_out(&self) -> LeftOut {
        let mut left_out = LeftOut::default();
        for element in self.elements.iter().filter(|element| element.count > 0) {
            let noun = match element.role {
                Role::Vertex => "vertex",
                Role::Face => "face",
                Role::Strips => "strip",
                Role::Other => {
                    let name = quote(element.name.as_bytes());
                    let (one, many) = (format!("{name} record"), format!("{name} records"));
                    left_out.count(element.count, &one, &many);
                    continue;
                }
            };
            let is_left_out = |step: &Step| matches!(step, Step::Skip(_) | Step::SkipList { .. });
            let names = element.steps.iter().zip(&element.property_names);
            let mut others = Vec::new();
            for (_, name) in names.filter(|(step, _)| is_left_out(step)) {
                match name.as_str() {
                    "alpha" | "a" if element.keeps(COLOR_SLOT) => left_out.add("vertex alpha"),
                    "red" | "green" | "blue" | "alpha" | "diffuse_red" | "diffuse_green" | "diffuse_blue"
                    | "r" | "g" | "b" | "a" => {
                        let more = if element.keeps(COLOR_SLOT) { "more " } else { "" };
                        left_out.add(&format!("{more}{noun} colours"));
                    }
                    "s" | "t" | "u" | "v" | "texture_u" | "texture_v" | "texcoord" | "texnumber" => {
                        left_out.add("texture coordinates");
                    }
                    name => others.push(name),
                }
            }
            left_out.names(&format!("{noun} properties"), others);
        }
        if let Some(word) = &self.odd_up {
            left_out.add(&format!("a comment that {word} is up, which is no axis"));
        }
        if self.has_texture {
            left_out.add("textures");
        }
        left_out
    }

    /// Whether the vertices are points of a cloud: nothing connects them.
    pub(super) fn is_cloud(&self) -> bool {
        let has_faces =
            |element: &Element| matches!(element.role, Role::Face | Role::Strips) && element.count > 0;
        self.vertices > 0 && !self.elements.iter().any(has_faces)
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
                return Err(Fault::text(element_line(bytes, i), message));
            }
        }
        Ok(())
    }
}

impl Element {
    fn plan(definition: &serde_ply::ElementDef) -> Result<Self, String> {
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
        let all_normals = VERTEX_SLOTS[3..].iter().all(|name| definition.has_property(name));
        let colors = color_names(definition);
        for property in &definition.properties {
            let kept = VERTEX_SLOTS
                .iter()
                .position(|name| *name == property.name)
                .filter(|&slot| slot < 3 || all_normals);
            let channel = || Some(COLOR_SLOT + colors?.iter().position(|name| *name == property.name)?);
            let slot = kept.or_else(channel).filter(|_| role == Role::Vertex);
            let is_indices =
                matches!(role, Role::Face | Role::Strips) && INDEX_NAMES.contains(&property.name.as_str());
            element.steps.push(match (&property.property_type, slot) {
                (&PropertyType::Scalar(scalar), Some(slot)) => {
                    if element.keeps(slot) {
                        return Err(format!("second property `{}`, expected one", property.name));
                    }
                    Step::Keep { slot, scalar }
                }
                (&PropertyType::List { .. }, Some(_)) => {
                    return Err(format!("`{}` is a list, expected a number", property.name));
                }
                (&PropertyType::Scalar(_), None) if is_indices => {
                    return Err(format!("`{}` is a number, expected a list", property.name));
                }
                (
                    &PropertyType::List {
                        count_type,
                        data_type,
                    },
                    None,
                ) if is_indices => {
                    if element
                        .steps
                        .iter()
                        .any(|step| matches!(step, Step::Indices { .. }))
                    {
                        return Err("second list of vertex indices, expected one".to_owned());
                    }
                    Step::Indices {
                        count: count_type,
                        item: data_type,
                    }
                }
                (&PropertyType::Scalar(scalar), None) => Step::Skip(scalar),
                (
                    &PropertyType::List {
                        count_type,
                        data_type,
                    },
                    None,
                ) => Step::SkipList {
                    count: count_type,
                    item: data_type,
                },
            });
        }
        element.expect_complete()?;
        Ok(element)
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
    fn keeps(&self, wanted: usize) -> bool {
        self.steps
            .iter()
            .any(|step| matches!(step, Step::Keep { slot, .. } if *slot == wanted))
    }

    /// The least bytes that a record takes, if its lists are empty.
    fn least_bytes(&self, format: PlyFormat) -> usize {
        let size = |scalar| match format {
            // A digit and a space.
            PlyFormat::Ascii => 2,
            PlyFormat::BinaryLittleEndian | PlyFormat::BinaryBigEndian => scalar_size(scalar),
        };
        let of_step = |step: &Step| match *step {
            Step::Keep { scalar, .. } | Step::Skip(scalar) => size(scalar),
            Step::Indices { count, .. } | Step::SkipList { count, .. } => size(count),
        };
        self.steps.iter().map(of_step).sum()
    }

    /// Bytes of each record in a binary file; `None` if they differ.
    pub(super) fn stride(&self) -> Option<usize> {
        self.steps.iter().map(Step::size).sum()
    }
}

/// The names of the channels, if each is one number of every record.
fn color_names(definition: &serde_ply::ElementDef) -> Option<&'static [&'static str; 3]> {
    let is_single_number = |name: &&str| {
        let mut named = definition.properties.iter().filter(|p| p.name == **name);
        let first = named.next().map(|property| &property.property_type);
        matches!(first, Some(PropertyType::Scalar(_))) && named.next().is_none()
    };
    COLOR_NAMES
        .iter()
        .find(|names| names.iter().all(is_single_number))
}

/// Where the line after `end_header` starts, in bytes.
pub(super) fn find_end(bytes: &[u8]) -> Result<usize, Fault> {
    if bytes.is_empty() {
        return Err(Fault {
            place: Place::File,
            message: "the file is empty, expected a PLY mesh".to_owned(),
        });
    }
    let mut end = 0;
    for (i, line) in bytes.split_inclusive(|&byte| byte == b'\n').enumerate() {
        let start = end;
        end += line.len();
        let line = line.trim_ascii();
        if i == 0 && line != b"ply" {
            let message = format!("not a PLY mesh: found {}, expected `ply`", quote(line));
            return Err(Fault::text(0..line.len(), message));
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

/// The range of the header's `element` line number `wanted`, 0-based.
fn element_line(bytes: &[u8], wanted: usize) -> Range<usize> {
    let is_element =
        |line: &[u8]| line.trim_ascii_start().split(u8::is_ascii_whitespace).next() == Some(b"element");
    let line = bytes
        .split(|&byte| byte == b'\n')
        .enumerate()
        .filter(|(_, line)| is_element(line))
        .nth(wanted);
    line.map_or(0..0, |(i, _)| line_range(bytes, i))
}
