//! XML files: PolyData (.vtp) and UnstructuredGrid (.vtu).

use super::{
    Piece,
    array::{Array, File, Kind, Source},
    cells::{Cells, Layout, Polyhedra, Types},
    data::Attributes,
    encoded::Encoding,
    foreign_kind,
    shapes::{POLY_LINE, POLY_VERTEX, POLYGON, TRIANGLE_STRIP},
};
use crate::{
    error::{LoadErrorKind, quote},
    format::{
        budget::Budget,
        place::{TextFault, refuse_binary},
        xml::{Tag, Xml},
    },
};
use std::cell::Cell;

/// Memory of an array's description besides its name, bytes.
const ARRAY_BYTES: usize = 256;

/// The element before appended data, which need not be text.
const APPENDED: &[u8] = b"<AppendedData";

/// The compressors of files, and what to do about those that octray does not read.
const ZLIB: &[u8] = b"vtkZLibDataCompressor";

/// Cells of PolyData: their element, the attribute of their number, and their type.
const GROUPS: [(&str, &str, u8); 4] = [
    ("Verts", "NumberOfVerts", POLY_VERTEX),
    ("Lines", "NumberOfLines", POLY_LINE),
    ("Polys", "NumberOfPolys", POLYGON),
    ("Strips", "NumberOfStrips", TRIANGLE_STRIP),
];

/// Reads the description of all arrays of the first time step, and whether there are more steps.
pub(super) fn read<'a>(
    text: &'a [u8],
    budget: &'a Budget,
) -> Result<(File<'a>, Vec<Piece<'a>>, bool), TextFault> {
    let end = appended_at(text).unwrap_or(text.len());
    let head = text.get(..end).unwrap_or_default();
    refuse_binary(head, "the XML of a VTK file")?;
    let mut reader = Reader {
        xml: Xml::new(head)?,
        text,
        budget,
        step: None,
        has_steps: false,
    };
    let root = reader.xml.root("VTKFile")?;
    let kind = root.get("type")?;
    let is_grid = match kind.value {
        b"PolyData" => false,
        b"UnstructuredGrid" => true,
        other => {
            let message = foreign_kind(other);
            return Err(kind.fault(message).with_kind(LoadErrorKind::Unsupported));
        }
    };
    let mut encoding = encoding(&root)?;
    let mut pieces = Vec::new();
    while let Some(tag) = reader.xml.child()? {
        match tag.name() {
            name if name == kind.value => reader.pieces(&tag, is_grid, &mut pieces)?,
            b"AppendedData" => {
                let coding = tag.find("encoding")?;
                encoding.is_base64 = coding.is_none_or(|coding| coding.value == b"base64");
                let rest = text.get(end..).unwrap_or_default();
                let mark = rest.len() - rest.trim_ascii_start().len();
                if rest.get(mark) != Some(&b'_') {
                    let message = "the appended data do not begin with `_`";
                    return Err(TextFault::new(tag.place, message));
                }
                encoding.appended = rest.get(mark + 1..);
                break;
            }
            _ => reader.xml.skip()?,
        }
    }
    let file = File {
        text,
        budget,
        encoding,
        work: Cell::new(super::most_decoded(text.len())),
    };
    Ok((file, pieces, reader.has_steps))
}

/// Where the start tag of appended data ends.
fn appended_at(text: &[u8]) -> Option<usize> {
    let mut at = 0;
    loop {
        let rest = text.get(at..)?;
        at += rest.iter().position(|&byte| byte == b'<')?;
        let rest = text.get(at..)?;
        if rest.starts_with(APPENDED) {
            return Some(at + rest.iter().position(|&byte| byte == b'>')? + 1);
        }
        at += 1;
    }
}

/// What the root element says about binary data.
fn encoding<'a>(root: &Tag<'a>) -> Result<Encoding<'a>, TextFault> {
    let mut encoding = Encoding::default();
    if let Some(order) = root.find("byte_order")? {
        encoding.is_big = match order.value {
            b"LittleEndian" => false,
            b"BigEndian" => true,
            other => {
                let found = quote(other);
                return Err(order.fault(format!("found {found}, expected `LittleEndian` or `BigEndian`")));
            }
        };
    }
    if let Some(header) = root.find("header_type")? {
        encoding.has_wide_headers = match header.value {
            b"UInt32" => false,
            b"UInt64" => true,
            other => {
                let found = quote(other);
                return Err(header.fault(format!("found {found}, expected `UInt32` or `UInt64`")));
            }
        };
    }
    if let Some(compressor) = root.find("compressor")?
        && !compressor.value.is_empty()
    {
        if compressor.value != ZLIB {
            let [found, zlib] = [compressor.value, ZLIB].map(quote);
            let message = format!("compressed by {found}, which octray does not read; write it with {zlib}");
            return Err(compressor.fault(message).with_kind(LoadErrorKind::Unsupported));
        }
        encoding.is_compressed = true;
    }
    Ok(encoding)
}

struct Reader<'a> {
    xml: Xml<'a>,
    text: &'a [u8],
    budget: &'a Budget,
    /// The first time step that an array belongs to.
    step: Option<&'a [u8]>,
    /// Whether there are later steps, which are left out.
    has_steps: bool,
}

impl<'a> Reader<'a> {
    fn pieces(
        &mut self,
        data: &Tag<'a>,
        is_grid: bool,
        pieces: &mut Vec<Piece<'a>>,
    ) -> Result<(), TextFault> {
        while let Some(tag) = self.xml.child()? {
            if tag.name() != b"Piece" {
                self.xml.skip()?;
                continue;
            }
            let piece = self.piece(&tag, is_grid)?;
            self.budget.reserve(pieces, 1)?;
            pieces.push(piece);
        }
        let times = data.find("TimeValues")?;
        let steps = times.map_or(0, |times| words(times.value).count());
        // Text has the pieces of all steps in turn, and each array is of step 0; elsewhere pieces have the arrays of all.
        if self.step.is_some() && !self.has_steps && steps > 1 && pieces.len().is_multiple_of(steps) {
            pieces.truncate(pieces.len() / steps);
            self.has_steps = true;
        }
        Ok(())
    }

    fn piece(&mut self, piece: &Tag<'a>, is_grid: bool) -> Result<Piece<'a>, TextFault> {
        let mut read = Piece {
            points: count(piece, "NumberOfPoints")?.unwrap_or(0),
            ..Piece::default()
        };
        let mut groups: [Vec<Array<'a>>; 4] = [const { Vec::new() }; 4];
        while let Some(tag) = self.xml.child()? {
            match tag.name() {
                b"PointData" => read.of_points = self.attributes(&tag)?,
                b"CellData" => read.of_cells = self.attributes(&tag)?,
                b"Points" => read.coordinates = self.arrays()?.into_iter().next(),
                b"Cells" if is_grid => groups[0] = self.arrays()?,
                name => match GROUPS.iter().position(|(group, ..)| group.as_bytes() == name) {
                    Some(group) if !is_grid => groups[group] = self.arrays()?,
                    _ => self.xml.skip()?,
                },
            }
        }
        if is_grid {
            let cells = count(piece, "NumberOfCells")?.unwrap_or(0);
            if cells > 0 {
                let [arrays, ..] = groups;
                read.polyhedra = polyhedra(&arrays);
                let types = Types::Each(named(&arrays, "types", piece)?);
                read.groups.push((read_cells(&arrays, cells, piece)?, types));
            }
            return Ok(read);
        }
        for (arrays, (_, number, cell)) in groups.iter().zip(GROUPS) {
            let cells = count(piece, number)?.unwrap_or(0);
            if cells > 0 {
                let types = Types::All(cell);
                read.groups.push((read_cells(arrays, cells, piece)?, types));
            }
        }
        Ok(read)
    }

    /// The arrays of an element of points or cells, and its active ones.
    fn attributes(&mut self, tag: &Tag<'a>) -> Result<Attributes<'a>, TextFault> {
        let active = |name: &str| -> Result<Option<String>, TextFault> {
            tag.find(name)?.map(|attribute| attribute.text()).transpose()
        };
        Ok(Attributes {
            scalars: active("Scalars")?,
            normals: active("Normals")?,
            arrays: self.arrays()?,
        })
    }

    /// The arrays in the open element.
    fn arrays(&mut self) -> Result<Vec<Array<'a>>, TextFault> {
        let mut arrays = Vec::new();
        while let Some(tag) = self.xml.child()? {
            let is_array = matches!(tag.name(), b"DataArray" | b"Array");
            if is_array && self.is_of_first_step(&tag)? {
                let array = self.array(&tag)?;
                self.budget.take(ARRAY_BYTES + array.name.len())?;
                arrays.push(array);
            } else {
                self.xml.skip()?;
            }
        }
        Ok(arrays)
    }

    /// Whether an array belongs to the first time step, perhaps among others, or to none.
    fn is_of_first_step(&mut self, tag: &Tag<'a>) -> Result<bool, TextFault> {
        let Some(steps) = tag.find("TimeStep")? else {
            return Ok(true);
        };
        let mut steps = words(steps.value).peekable();
        self.step = self.step.or(steps.peek().copied());
        let is_first = steps.any(|step| Some(step) == self.step);
        self.has_steps |= !is_first;
        Ok(is_first)
    }

    fn array(&mut self, tag: &Tag<'a>) -> Result<Array<'a>, TextFault> {
        let kind = tag.get("type")?;
        let name = tag.find("Name")?.map(|name| name.text()).transpose()?;
        let components = count(tag, "NumberOfComponents")?;
        let format = tag.find("format")?;
        let source = match format.as_ref().map_or(&b"ascii"[..], |format| format.value) {
            b"appended" => {
                let offset = tag.get("offset")?;
                let digits = std::str::from_utf8(offset.value.trim_ascii());
                let number = digits.ok().and_then(|digits| digits.parse().ok());
                let wrong = || {
                    let found = quote(offset.value);
                    offset.fault(format!("`offset` is {found}, expected a whole number"))
                };
                let number = number.ok_or_else(wrong)?;
                self.xml.skip()?;
                Source::Appended(number)
            }
            b"ascii" => Source::Words(self.content()?),
            b"binary" => Source::Inline(self.content()?),
            other => {
                let found = quote(other);
                let place = format.map_or(tag.place.clone(), |format| format.place);
                let message = format!("found {found}, expected `ascii`, `binary` or `appended`");
                return Err(TextFault::new(place, message));
            }
        };
        Ok(Array {
            name: name.unwrap_or_default(),
            kind: Kind::of_xml(kind.value),
            components: components.unwrap_or(1).max(1),
            is_color: false,
            source,
            place: Some(tag.place.clone()),
        })
    }

    /// The text of the open element, which is read to its end. Elements that describe the array are not part of it.
    fn content(&mut self) -> Result<std::ops::Range<usize>, TextFault> {
        let mut content = None;
        loop {
            let start = self.xml.position();
            let child = self.xml.child()?;
            let end = start
                + self
                    .text
                    .get(start..)
                    .and_then(|rest| rest.iter().position(|&b| b == b'<'))
                    .unwrap_or(0);
            let text = self.text.get(start..end).unwrap_or_default();
            if content.is_none() && !text.trim_ascii().is_empty() {
                content = Some(start..end);
            }
            if child.is_none() {
                return Ok(content.unwrap_or(start..start));
            }
            self.xml.skip()?;
        }
    }
}

fn words(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    let words = text.split(u8::is_ascii_whitespace);
    words.filter(|word| !word.is_empty())
}

/// An attribute that is a count; `None` if it is missing or empty.
fn count(tag: &Tag<'_>, name: &str) -> Result<Option<usize>, TextFault> {
    let attribute = tag.find(name)?;
    let Some(attribute) = attribute.filter(|attribute| !attribute.value.trim_ascii().is_empty()) else {
        return Ok(None);
    };
    let digits = std::str::from_utf8(attribute.value.trim_ascii());
    let number = digits.ok().and_then(|digits| digits.parse::<usize>().ok());
    let wrong = || {
        let found = quote(attribute.value);
        attribute.fault(format!("`{name}` is {found}, expected a whole number"))
    };
    number.ok_or_else(wrong).map(Some)
}

/// The array of this name in a piece.
fn named<'a>(arrays: &[Array<'a>], name: &str, piece: &Tag<'_>) -> Result<Array<'a>, TextFault> {
    let found = arrays.iter().find(|array| array.name == name);
    let missing = || {
        TextFault::new(
            piece.place.clone(),
            format!("the piece has cells, but no array `{name}`"),
        )
    };
    found.cloned().ok_or_else(missing)
}

fn read_cells<'a>(arrays: &[Array<'a>], count: usize, piece: &Tag<'_>) -> Result<Cells<'a>, TextFault> {
    let layout = Layout::Offsets {
        offsets: named(arrays, "offsets", piece)?,
        points: named(arrays, "connectivity", piece)?,
        begins: false,
    };
    Ok(Cells { count, layout })
}

/// The faces of polyhedra, in the form of VTK before or after 9.4.
fn polyhedra<'a>(arrays: &[Array<'a>]) -> Option<Polyhedra<'a>> {
    let find = |name: &str| arrays.iter().find(|array| array.name == name).cloned();
    if let Some(ends) = find("polyhedron_offsets") {
        let arrays = [
            ends,
            find("polyhedron_to_faces")?,
            find("face_offsets")?,
            find("face_connectivity")?,
        ];
        return Some(Polyhedra::Indexed(Box::new(arrays)));
    }
    find("faces").map(Polyhedra::Stream)
}
