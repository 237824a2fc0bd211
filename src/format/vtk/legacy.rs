//! Legacy files (.vtk): text, whose numbers are text or big-endian binary.

use super::{
    Piece,
    array::{Array, File, Kind, Source},
    cells::{Cells, Layout, Types},
    data::Attributes,
    encoded::Encoding,
    foreign_kind,
    shapes::{POLY_LINE, POLY_VERTEX, POLYGON, TRIANGLE_STRIP},
};
use crate::{
    error::{LoadErrorKind, quote},
    format::{budget::Budget, place::TextFault},
};
use percent_encoding::percent_decode;
use std::{cell::Cell, ops::Range};

/// What files begin with.
const START: &[u8] = b"# vtk DataFile Version ";

/// Memory of an array's description besides its name, bytes.
const ARRAY_BYTES: usize = 256;

/// Whether bytes begin as a legacy file does.
pub(super) fn is_legacy(head: &[u8]) -> bool {
    let start = head.get(..START.len()).unwrap_or_default();
    start.eq_ignore_ascii_case(START)
}

/// Reads the description of all arrays.
pub(super) fn read<'a>(text: &'a [u8], budget: &'a Budget) -> Result<(File<'a>, Piece<'a>), TextFault> {
    let mut reader = Reader {
        text,
        at: 0,
        budget,
        is_binary: false,
        has_offsets: false,
        components: 1,
    };
    let piece = reader.file()?;
    let encoding = Encoding {
        is_big: true,
        ..Encoding::default()
    };
    let file = File {
        text,
        budget,
        encoding,
        work: Cell::new(0),
    };
    Ok((file, piece))
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
    budget: &'a Budget,
    is_binary: bool,
    /// Whether cells are stored by offsets, as from version 5 on.
    has_offsets: bool,
    /// Numbers in each tuple of the last array.
    components: usize,
}

/// What data belong to.
#[derive(Clone, Copy, PartialEq)]
enum Owner {
    Nothing,
    Points,
    Cells,
}

type Word<'a> = (&'a [u8], Range<usize>);

impl<'a> Reader<'a> {
    fn file(&mut self) -> Result<Piece<'a>, TextFault> {
        self.at = START.len();
        let (version, place) = self.word("a version")?;
        let major = version.split(|&byte| byte == b'.').next().unwrap_or_default();
        let major: Option<u32> = std::str::from_utf8(major)
            .ok()
            .and_then(|major| major.parse().ok());
        let major = major.ok_or_else(|| self.wrong(version, place, "a version such as `4.2`"))?;
        self.has_offsets = major >= 5;
        self.end_line();
        // The title.
        self.end_line();
        let (coding, place) = self.word("`ASCII` or `BINARY`")?;
        self.is_binary = match &*coding.to_ascii_uppercase() {
            b"ASCII" => false,
            b"BINARY" => true,
            _ => return Err(self.wrong(coding, place, "`ASCII` or `BINARY`")),
        };
        let (keyword, place) = self.word("`DATASET`")?;
        if !keyword.eq_ignore_ascii_case(b"DATASET") {
            return Err(self.wrong(keyword, place, "`DATASET`"));
        }
        let (kind, place) = self.word("`POLYDATA` or `UNSTRUCTURED_GRID`")?;
        let kind = kind.to_ascii_uppercase();
        if kind != b"POLYDATA" && kind != b"UNSTRUCTURED_GRID" {
            let message = foreign_kind(&kind);
            return Err(TextFault::new(place, message).with_kind(LoadErrorKind::Unsupported));
        }
        self.sections()
    }

    fn sections(&mut self) -> Result<Piece<'a>, TextFault> {
        let mut piece = Piece::default();
        let mut groups: [Option<Cells<'a>>; 4] = [const { None }; 4];
        let (mut grid, mut types) = (None, None);
        let mut owner = Owner::Nothing;
        while let Some((keyword, place)) = self.next_word() {
            let mut slot = None;
            match &*keyword.to_ascii_uppercase() {
                b"POINTS" => {
                    piece.points = self.count("points")?;
                    let kind = self.kind()?;
                    piece.coordinates =
                        Some(self.values(b"POINTS", &kind, [piece.points, 3], place.clone())?);
                }
                b"CELLS" => slot = Some(&mut grid),
                b"VERTICES" => slot = groups.get_mut(0),
                b"LINES" => slot = groups.get_mut(1),
                b"POLYGONS" => slot = groups.get_mut(2),
                b"TRIANGLE_STRIPS" => slot = groups.get_mut(3),
                b"CELL_TYPES" => {
                    let count = self.count("types")?;
                    types = Some(self.values(b"CELL_TYPES", b"int", [count, 1], place.clone())?);
                }
                b"POINT_DATA" => owner = self.data_of(Owner::Points)?,
                b"CELL_DATA" => owner = self.data_of(Owner::Cells)?,
                b"METADATA" => self.metadata(),
                b"FIELD" if owner == Owner::Nothing => {
                    self.field(&mut Vec::new())?;
                }
                upper => {
                    let (attributes, count) = match owner {
                        Owner::Points => (&mut piece.of_points, piece.points),
                        Owner::Cells => {
                            let all = groups.iter().chain([&grid]).flatten();
                            (&mut piece.of_cells, all.map(|cells| cells.count).sum())
                        }
                        Owner::Nothing => {
                            return Err(self.wrong(keyword, place, "a section such as `POINTS`"));
                        }
                    };
                    self.attribute(upper, (keyword, place), attributes, count)?;
                    continue;
                }
            }
            if let Some(slot) = slot {
                *slot = Some(self.cells(keyword, place)?);
            }
        }
        if let Some(cells) = grid {
            let missing = || TextFault::of_file("the file has `CELLS`, but no `CELL_TYPES`");
            piece
                .groups
                .push((cells, Types::Each(types.ok_or_else(missing)?)));
        }
        let known = [POLY_VERTEX, POLY_LINE, POLYGON, TRIANGLE_STRIP];
        for (cells, cell) in groups.into_iter().zip(known) {
            piece.groups.extend(cells.map(|cells| (cells, Types::All(cell))));
        }
        Ok(piece)
    }

    /// Reads the count after `POINT_DATA` or `CELL_DATA`, which other counts make superfluous.
    fn data_of(&mut self, owner: Owner) -> Result<Owner, TextFault> {
        self.count("values")?;
        Ok(owner)
    }

    fn cells(&mut self, keyword: &[u8], place: Range<usize>) -> Result<Cells<'a>, TextFault> {
        let [count, size] = [self.count("cells")?, self.count("numbers")?];
        if !self.has_offsets {
            let points = self.values(keyword, b"int", [size, 1], place)?;
            let layout = Layout::Counted(points);
            return Ok(Cells { count, layout });
        }
        let before = self.at;
        let next = self.next_word();
        self.at = before;
        let has_arrays = next.is_some_and(|(word, _)| word.eq_ignore_ascii_case(b"OFFSETS"));
        if [count, size] == [0, 0] && !has_arrays {
            let layout = Layout::Counted(self.values(keyword, b"int", [0, 1], place)?);
            return Ok(Cells { count, layout });
        }
        let mut arrays = Vec::new();
        for (name, count) in [(&b"OFFSETS"[..], count), (b"CONNECTIVITY", size)] {
            let (word, place) = self.word("`OFFSETS`")?;
            if !word.eq_ignore_ascii_case(name) {
                return Err(self.wrong(word, place, &quote(name)));
            }
            let kind = self.kind()?;
            arrays.push(self.values(name, &kind, [count, 1], place)?);
        }
        let [offsets, points] =
            <[Array<'a>; 2]>::try_from(arrays).map_err(|_| TextFault::of_file("cells without `OFFSETS`"))?;
        let layout = Layout::Offsets {
            offsets,
            points,
            begins: true,
        };
        Ok(Cells {
            // One more offset than cells.
            count: count.saturating_sub(1),
            layout,
        })
    }

    /// Reads an attribute of points or cells, of which there are `count`.
    fn attribute(
        &mut self,
        upper: &[u8],
        (keyword, place): Word<'a>,
        attributes: &mut Attributes<'a>,
        count: usize,
    ) -> Result<(), TextFault> {
        if upper == b"FIELD" {
            return self.field(&mut attributes.arrays);
        }
        let known: [&[u8]; 11] = [
            b"SCALARS",
            b"COLOR_SCALARS",
            b"LOOKUP_TABLE",
            b"VECTORS",
            b"NORMALS",
            b"TEXTURE_COORDINATES",
            b"TENSORS",
            b"TENSORS6",
            b"GLOBAL_IDS",
            b"PEDIGREE_IDS",
            b"EDGE_FLAGS",
        ];
        if !known.contains(&upper) {
            return Err(self.wrong(keyword, place, "an attribute such as `SCALARS`"));
        }
        let (name, _) = self.word("a name")?;
        let mut count = count;
        let mut components = 1;
        let kind = match upper {
            b"COLOR_SCALARS" => {
                components = self.count("components")?;
                self.color_kind()
            }
            b"LOOKUP_TABLE" => {
                (count, components) = (self.count("colours")?, 4);
                self.color_kind()
            }
            b"TEXTURE_COORDINATES" => {
                components = self.count("components")?;
                self.kind()?
            }
            _ => self.kind()?,
        };
        components = match upper {
            b"VECTORS" | b"NORMALS" => 3,
            b"TENSORS" => 9,
            b"TENSORS6" => 6,
            _ => components,
        };
        if upper == b"SCALARS" {
            if self.is_more_in_line() {
                components = self.count("components")?;
            }
            let before = self.at;
            let table = self.next_word();
            if table.is_some_and(|(word, _)| word.eq_ignore_ascii_case(b"LOOKUP_TABLE")) {
                self.word("a name")?;
            } else {
                self.at = before;
            }
        }
        let mut array = self.values(name, &kind, [count, components], place)?;
        array.is_color = upper == b"COLOR_SCALARS";
        let name = &array.name;
        match upper {
            b"SCALARS" | b"COLOR_SCALARS" => _ = attributes.scalars.get_or_insert_with(|| name.clone()),
            b"NORMALS" => attributes.normals = Some(name.clone()),
            b"LOOKUP_TABLE" => return Ok(()),
            _ => {}
        }
        attributes.arrays.push(array);
        Ok(())
    }

    /// The type of colours, which binary files store as bytes and others as shares of 1.
    fn color_kind(&self) -> Vec<u8> {
        if self.is_binary {
            b"unsigned_char".to_vec()
        } else {
            b"float".to_vec()
        }
    }

    /// Reads the arrays of a field.
    fn field(&mut self, arrays: &mut Vec<Array<'a>>) -> Result<(), TextFault> {
        self.word("a name")?;
        let mut left = self.count("arrays")?;
        while left > 0 {
            let (name, place) = self.word("the name of an array")?;
            if name.eq_ignore_ascii_case(b"METADATA") {
                self.metadata();
                continue;
            }
            let [components, tuples] = [self.count("components")?, self.count("tuples")?];
            let kind = self.kind()?;
            arrays.push(self.values(name, &kind, [tuples, components], place)?);
            left -= 1;
        }
        Ok(())
    }

    /// Skips information about the last array, up to an empty line. Names of components may be empty lines, too.
    fn metadata(&mut self) {
        self.end_line();
        let mut names = 0;
        while self.at < self.text.len() {
            let start = self.at;
            self.end_line();
            let line = self.text.get(start..self.at).unwrap_or_default().trim_ascii();
            if names > 0 {
                names -= 1;
            } else if line.eq_ignore_ascii_case(b"COMPONENT_NAMES") {
                names = self.components;
            } else if line.is_empty() {
                return;
            }
        }
    }

    /// An array of tuples of numbers, which are skipped.
    fn values(
        &mut self,
        name: &[u8],
        kind: &[u8],
        [tuples, components]: [usize; 2],
        place: Range<usize>,
    ) -> Result<Array<'a>, TextFault> {
        self.components = components;
        let count = tuples.saturating_mul(components);
        let number = Kind::of_legacy(kind);
        let known = number.is_some() || matches!(kind, b"string" | b"bit" | b"utf8_string" | b"variant");
        if !known {
            let found = quote(kind);
            let message = format!("{found} is not a type that octray reads, expected one such as `float`");
            return Err(self.fault(place, message).with_kind(LoadErrorKind::Unsupported));
        }
        let place_of_array = (!self.is_binary).then(|| place.clone());
        let source = match number {
            Some(_) if !self.is_binary => Source::Words(self.skip_words(count, place)?),
            Some(number) => Source::Bytes(self.bytes(count.saturating_mul(number.size()), place)?),
            None if kind == b"bit" && self.is_binary => Source::Bytes(self.bytes(count.div_ceil(8), place)?),
            None if kind == b"bit" => Source::Words(self.skip_words(count, place)?),
            None => {
                // Each of a variant array is a line with its type.
                self.strings(count, place, !self.is_binary || kind == b"variant")?;
                Source::Bytes(&[])
            }
        };
        let name = percent_decode(name).decode_utf8_lossy().into_owned();
        self.budget.take(ARRAY_BYTES + name.len())?;
        Ok(Array {
            name,
            kind: number,
            components: components.max(1),
            is_color: false,
            source,
            place: place_of_array,
        })
    }

    fn skip_words(&mut self, count: usize, place: Range<usize>) -> Result<Range<usize>, TextFault> {
        let start = self.at;
        // Before they are counted: a number has a digit and a space.
        let most = (self.text.len() - start).div_ceil(2);
        let is_all = count <= most && (0..count).all(|_| self.next_word().is_some());
        if is_all {
            Ok(start..self.at)
        } else {
            Err(self.ended(count, "numbers", place))
        }
    }

    /// The bytes that follow this line.
    fn bytes(&mut self, count: usize, place: Range<usize>) -> Result<&'a [u8], TextFault> {
        self.end_line();
        let rest = self.text.get(self.at..).unwrap_or_default();
        let bytes = rest
            .get(..count)
            .ok_or_else(|| self.ended(count, "bytes", place))?;
        self.at += count;
        Ok(bytes)
    }

    /// Skips strings: lines of text, or after their lengths.
    fn strings(&mut self, count: usize, place: Range<usize>, are_lines: bool) -> Result<(), TextFault> {
        self.end_line();
        for _ in 0..count {
            let Some(&first) = self.text.get(self.at) else {
                return Err(self.ended(count, "strings", place));
            };
            if are_lines {
                self.end_line();
                continue;
            }
            // The upper bits say how many bytes the length has.
            let size = [8, 4, 2, 1][usize::from(first >> 6)];
            let bytes = self.text.get(self.at..self.at + size).unwrap_or_default();
            let length = bytes
                .iter()
                .fold(0_usize, |sum, &byte| sum << 8 | usize::from(byte));
            let length = length & (usize::MAX >> (66 - 8 * size as u32));
            self.at = self.at.saturating_add(size).saturating_add(length);
        }
        Ok(())
    }

    /// Goes to the next line.
    fn end_line(&mut self) {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|&byte| byte == b'\n');
        self.at += length.map_or(rest.len(), |length| length + 1);
    }

    /// Whether a word follows in this line.
    fn is_more_in_line(&self) -> bool {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let next = rest.iter().find(|byte| !matches!(byte, b' ' | b'\t' | b'\r'));
        next.is_some_and(|byte| *byte != b'\n')
    }

    fn next_word(&mut self) -> Option<Word<'a>> {
        let rest = self.text.get(self.at..)?;
        let start = self.at + rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let rest = self.text.get(start..)?;
        let length = rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len());
        self.at = start + length;
        Some((rest.get(..length)?, start..self.at))
    }

    fn word(&mut self, what: &str) -> Result<Word<'a>, TextFault> {
        self.next_word().ok_or_else(|| {
            let end = self.text.len();
            self.fault(end..end, format!("the file ends before {what}"))
        })
    }

    /// A type in lower case.
    fn kind(&mut self) -> Result<Vec<u8>, TextFault> {
        let (word, _) = self.word("a type such as `float`")?;
        Ok(word.to_ascii_lowercase())
    }

    fn count(&mut self, what: &str) -> Result<usize, TextFault> {
        let (word, place) = self.word(&format!("the number of {what}"))?;
        let count = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        count.ok_or_else(|| self.wrong(word, place, &format!("the number of {what}")))
    }

    fn ended(&self, count: usize, what: &str, place: Range<usize>) -> TextFault {
        let name = quote(self.text.get(place.clone()).unwrap_or_default());
        self.fault(
            place,
            format!("the file ends before the {count} {what} of {name}"),
        )
    }

    fn wrong(&self, word: &[u8], place: Range<usize>, expected: &str) -> TextFault {
        self.fault(place, format!("found {}, expected {expected}", quote(word)))
    }

    /// A fault. After binary data there are no lines.
    fn fault(&self, place: Range<usize>, message: String) -> TextFault {
        if self.is_binary {
            TextFault::of_file(message)
        } else {
            TextFault::new(place, message)
        }
    }
}
