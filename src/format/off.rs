//! OFF: text with vertices, polygons, and colours of either.
//!
//! Why not a crate: the existing ones read neither colours nor the headers of common data sets, allocate whatever a header
//! promises, and report no line and column.
//!
//! Format: *OFF*, Geomview manual, The Geometry Center, 1992.

mod free;

use super::{
    budget::Budget,
    left_out::LeftOut,
    mesh::{
        Cloud, LoadedMesh, MeshFormat, Surface, Unusable, UpAxis, UpSource, clamp_colors, clamped_note,
        usable_normal,
    },
    place::{TextFault, Words, after_mark, refuse_binary},
    polygon::{Fans, fans_note},
};
use crate::{
    error::{LoadError, LoadErrorKind, SceneError, quote},
    scene::{MAX_MATERIALS, TriangleMesh, is_usable},
};
use free::Vertices;
use std::{collections::HashMap, ops::Range, path::Path};

/// Whether text begins as OFF does.
pub(super) fn is_off(text: &[u8]) -> bool {
    let first = Lines { text, at: 0 }.next().and_then(|mut words| words.next());
    first.is_some_and(|(word, _)| {
        let at = word.windows(3).position(|part| part == b"OFF");
        at.is_some_and(|at| {
            let (before, after) = (word.get(..at), word.get(at + 3..));
            before.is_some_and(|before| before.iter().all(|letter| b"STCN4n".contains(letter)))
                && after.is_some_and(|after| after.iter().all(u8::is_ascii_digit))
        })
    })
}

/// Reads a mesh.
///
/// # Errors
/// [`LoadError`], with line and column.
pub(super) fn parse(bytes: &[u8], path: &Path, budget: &Budget) -> Result<LoadedMesh, LoadError> {
    let located = |fault: TextFault| fault.into_error(bytes, path);
    let before = budget.taken();
    let read = read(bytes, path, budget).or_else(|fault| {
        budget.give_back_to(before);
        read_free(bytes, path, budget).unwrap_or(Err(fault))
    });
    let (mut mesh, unusable) = read.map_err(located)?;
    mesh.keep_used(unusable.map(located), path, budget)?;
    Ok(mesh)
}

/// A mesh, and its points that are not usable.
type Read = Result<(LoadedMesh, Unusable<TextFault>), TextFault>;

/// Reads a mesh in free format; `None` if it is in no format.
fn read_free(text: &[u8], path: &Path, budget: &Budget) -> Option<Read> {
    let before = budget.taken();
    for vertices in [Vertices::All, Vertices::Lines, Vertices::Numbers] {
        if let Err(error) = budget.take(text.len()) {
            return Some(Err(error.into()));
        }
        let read = free::in_lines(text, vertices).map(|text| read(&text, path, budget));
        match read {
            Some(Ok(read)) => {
                budget.give_back(text.len());
                return Some(Ok(read));
            }
            Some(Err(fault)) if fault.is_limit() => return Some(Err(fault)),
            _ => budget.give_back_to(before),
        }
    }
    None
}

fn read(text: &[u8], path: &Path, budget: &Budget) -> Read {
    if text.is_empty() {
        return Err(TextFault::new(0..0, "the file is empty, expected an OFF mesh"));
    }
    let mut lines = Lines {
        text,
        at: after_mark(text),
    };
    let header = Header::read(&mut lines)?;
    refuse_binary(text, "the text of an OFF mesh")?;
    let mut off = Off::new(budget, header);
    let mut progress = budget.parsing(text.len());
    for _ in 0..header.vertices {
        let line = lines.expect("vertex", header.vertices)?;
        progress.at(lines.at);
        off.vertex(line)?;
    }
    for _ in 0..header.faces {
        let line = lines.expect("face", header.faces)?;
        progress.at(lines.at);
        off.face(line)?;
    }
    let unusable = std::mem::take(&mut off.unusable);
    Ok((off.finish(path)?, unusable))
}

/// The lines of a text that are neither empty nor comments.
struct Lines<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<Words<'a>> {
        loop {
            let rest = self.text.get(self.at..).filter(|rest| !rest.is_empty())?;
            let length = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r');
            let length = length.unwrap_or(rest.len());
            let line = rest.get(..length)?;
            let comment = line.iter().position(|&byte| byte == b'#').unwrap_or(length);
            let words = Words::new(self.text, self.at..self.at + comment);
            self.at += length + 1;
            if !words.rest().is_empty() {
                return Some(words);
            }
        }
    }

    /// The line of one of `count` things.
    fn expect(&mut self, what: &str, count: usize) -> Result<Words<'a>, TextFault> {
        let end = self.text.len();
        self.next().ok_or_else(|| {
            let message = format!("the file ends before the last {what}: the header promises {count}");
            TextFault::new(end..end, message)
        })
    }
}

/// The header.
#[derive(Clone, Copy, Default)]
struct Header {
    has_normals: bool,
    has_colors: bool,
    has_uvs: bool,
    vertices: usize,
    faces: usize,
}

impl Header {
    /// Reads the word `OFF` with its prefixes, which may be missing, and the counts, which may follow it at once.
    fn read(lines: &mut Lines<'_>) -> Result<Self, TextFault> {
        let start = lines.at;
        let empty = || TextFault::new(start..start, "the file has no counts, expected an OFF mesh");
        let mut words = lines.next().ok_or_else(empty)?;
        let mut header = Self::default();
        let mut after = words.clone();
        if let Some((word, place)) = after.next()
            && let Some(at) = word.windows(3).position(|part| part == b"OFF")
        {
            let mut prefix = word.get(..at).unwrap_or_default();
            header.has_uvs = take_prefix(&mut prefix, b"ST");
            header.has_colors = take_prefix(&mut prefix, b"C");
            header.has_normals = take_prefix(&mut prefix, b"N");
            let is_binary = after.clone().next().is_some_and(|(word, _)| word == b"BINARY");
            if is_binary || !prefix.is_empty() {
                let word = quote(words.text(place.start..after.rest().end));
                let message = format!("{word} is not supported, expected text in three dimensions");
                return Err(TextFault::new(place, message).with_kind(LoadErrorKind::Unsupported));
            }
            // Some data sets have no space before the counts.
            words = Words::new(lines.text, place.start + at + 3..words.end_of_words());
            if words.rest().is_empty() {
                words = lines.next().ok_or_else(empty)?;
            }
        }
        header.vertices = count(&mut words, "vertices")?;
        header.faces = count(&mut words, "faces")?;
        Ok(header)
    }
}

fn take_prefix(word: &mut &[u8], prefix: &[u8]) -> bool {
    let rest = word.strip_prefix(prefix);
    *word = rest.unwrap_or(word);
    rest.is_some()
}

/// The next word as a count.
fn count(words: &mut Words<'_>, what: &str) -> Result<usize, TextFault> {
    let end = words.rest().end;
    let Some((word, place)) = words.next() else {
        let message = format!(
            "the line ends before the number of {what}, expected an OFF mesh with lines such as `8 6 0`"
        );
        return Err(TextFault::new(end..end, message));
    };
    let number = std::str::from_utf8(word)
        .ok()
        .and_then(|word| word.parse::<u32>().ok());
    let number = number.map(|number| number as usize);
    number.ok_or_else(|| {
        let message = format!(
            "found {}, expected the number of {what} of an OFF mesh",
            quote(word)
        );
        TextFault::new(place, message)
    })
}

/// The next word as a usable number.
fn number(words: &mut Words<'_>, what: &'static str) -> Result<f32, TextFault> {
    let (value, place) = any_number(words, what, |word| fast_float2::parse(word))?;
    if is_usable(value) {
        Ok(value)
    } else {
        Err(unusable(what, value, place))
    }
}

fn unusable(what: &'static str, value: f32, place: Range<usize>) -> TextFault {
    TextFault::new(place, SceneError::NotUsable { what, value }.to_string())
}

/// The next word as a number, and its place.
fn any_number(
    words: &mut Words<'_>,
    what: &'static str,
    parse: impl Fn(&[u8]) -> Result<f32, fast_float2::Error>,
) -> Result<(f32, Range<usize>), TextFault> {
    let end = words.rest().end;
    let Some((word, place)) = words.next() else {
        return Err(TextFault::new(
            end..end,
            format!("the line ends before `{what}`, expected a number"),
        ));
    };
    let value = parse(word).map_err(|_| {
        let message = format!("`{what}` is {}, expected a number", quote(word));
        TextFault::new(place.clone(), message)
    })?;
    Ok((value, place))
}

/// The mesh so far.
struct Off<'b> {
    budget: &'b Budget,
    header: Header,
    columns: TriangleMesh,
    fans: Fans,
    /// Colours of faces; the first is that of faces without one.
    surfaces: Vec<Surface>,
    surface_of: Vec<u32>,
    surface_by_color: HashMap<[u32; 3], u32>,
    /// The corners of the current face.
    corners: Vec<u32>,
    unusable: Unusable<TextFault>,
    odd_normals: usize,
    /// How many faces have fewer than three corners, and how many have the number of a colour.
    small: usize,
    numbered: usize,
}

impl<'b> Off<'b> {
    fn new(budget: &'b Budget, header: Header) -> Self {
        Self {
            budget,
            header,
            columns: TriangleMesh::default(),
            fans: Fans::default(),
            surfaces: Vec::new(),
            surface_of: Vec::new(),
            surface_by_color: HashMap::new(),
            corners: Vec::new(),
            unusable: Unusable::default(),
            odd_normals: 0,
            small: 0,
            numbered: 0,
        }
    }

    fn vertex(&mut self, mut words: Words<'_>) -> Result<(), TextFault> {
        let columns = &mut self.columns;
        let axes = [&mut columns.x, &mut columns.y, &mut columns.z];
        let mut is_point = true;
        let offset = self.budget.offset();
        for (axis, (column, what)) in axes.into_iter().zip(["x", "y", "z"]).enumerate() {
            let (value, place) = any_number(&mut words, what, |word| offset.parse(axis, word))?;
            if !is_usable(value) {
                is_point = false;
                self.unusable.keep_first(|| unusable(what, value, place));
            }
            self.budget.reserve(column, 1)?;
            column.push(value);
        }
        self.unusable.count += usize::from(!is_point);
        if self.header.has_normals {
            let [x, y, z] =
                ["nx", "ny", "nz"].map(|what| any_number(&mut words, what, |word| fast_float2::parse(word)));
            self.budget.reserve(&mut columns.normals, 1)?;
            let normal = usable_normal([x?.0, y?.0, z?.0], &mut self.odd_normals);
            columns.normals.push(normal);
        }
        // Many programs write colours without the prefix.
        let left = words.clone().count();
        if self.header.has_colors || (3..=4).contains(&left) && !self.header.has_uvs {
            let [red, green, blue] = ["red", "green", "blue"].map(|what| number(&mut words, what));
            let vertices = columns.x.len();
            let missing = vertices - columns.colors.len();
            self.budget.reserve(&mut columns.colors, missing)?;
            columns.colors.resize(vertices - 1, [1.0; 3]);
            columns.colors.push([red?, green?, blue?]);
        }
        Ok(())
    }

    fn face(&mut self, mut words: Words<'_>) -> Result<(), TextFault> {
        let size = count(&mut words, "corners")?;
        self.corners.clear();
        let vertices = self.columns.x.len();
        for _ in 0..size {
            let end = words.rest().end;
            let Some((word, place)) = words.next() else {
                return Err(TextFault::new(
                    end..end,
                    format!("the line ends before corner {}", self.corners.len() + 1),
                ));
            };
            let index = std::str::from_utf8(word)
                .ok()
                .and_then(|word| word.parse::<u32>().ok());
            let Some(index) = index.filter(|&index| (index as usize) < vertices) else {
                let message = format!(
                    "vertex index {}, but the file has only {vertices} vertices",
                    quote(word)
                );
                return Err(TextFault::new(place, message));
            };
            self.budget.reserve(&mut self.corners, 1)?;
            self.corners.push(index);
        }
        let [first, others @ ..] = &self.corners[..] else {
            self.small += 1;
            return Ok(());
        };
        let triangles = others.len().saturating_sub(1);
        if triangles == 0 {
            self.small += 1;
            return Ok(());
        }
        self.budget.reserve(&mut self.columns.triangles, triangles)?;
        self.fans
            .add(self.columns.triangles.len(), triangles, 1, self.budget)?;
        let fan = others.windows(2).map(|pair| [*first, pair[0], pair[1]]);
        self.columns.triangles.extend(fan);
        let surface = self.surface(words)?;
        self.budget.reserve(&mut self.surface_of, triangles)?;
        self.surface_of.resize(self.columns.triangles.len(), surface);
        Ok(())
    }

    /// The surface of a face with this colour: whole numbers to 255, or others to 1.
    fn surface(&mut self, words: Words<'_>) -> Result<u32, TextFault> {
        let mut numbers: [Option<(f32, bool, Range<usize>)>; 4] = [const { None }; 4];
        for (number, (word, place)) in numbers.iter_mut().zip(words) {
            let value: Option<f32> = fast_float2::parse(word).ok();
            *number = value.map(|value| (value, word.iter().all(u8::is_ascii_digit), place));
        }
        let color = match &numbers {
            [Some(red), Some(green), Some(blue), _] => {
                let is_whole = red.1 && green.1 && blue.1;
                let scale = if is_whole { 255.0 } else { 1.0 };
                [red.0, green.0, blue.0].map(|value| (value / scale).clamp(0.0, 1.0))
            }
            [None, ..] => return Ok(0),
            _ => {
                self.numbered += 1;
                return Ok(0);
            }
        };
        if color.iter().any(|channel| channel.is_nan()) {
            let places = numbers.iter().flatten().map(|(_, _, place)| place.clone());
            let place = places.reduce(|all, place| all.start..place.end).unwrap_or(0..0);
            return Err(TextFault::new(place, "the colour is not a number"));
        }
        if self.surfaces.is_empty() {
            self.budget.reserve(&mut self.surfaces, 1)?;
            self.surfaces.push(Surface::NEUTRAL);
        }
        let next = self.surfaces.len() as u32;
        let bits = color.map(f32::to_bits);
        let surface = *self.surface_by_color.entry(bits).or_insert(next);
        if surface == next {
            if self.surfaces.len() >= MAX_MATERIALS {
                let message = format!("more than {MAX_MATERIALS} colours of faces");
                return Err(TextFault::new(0..0, message).with_kind(LoadErrorKind::Limit));
            }
            // The entry of the map, too.
            self.budget.take(64)?;
            self.budget.reserve(&mut self.surfaces, 1)?;
            self.surfaces.push(Surface {
                diffuse: color,
                ..Surface::WHITE
            });
        }
        Ok(surface)
    }

    fn finish(mut self, path: &Path) -> Result<LoadedMesh, TextFault> {
        let mut colors = std::mem::take(&mut self.columns.colors);
        if !colors.is_empty() {
            let missing = self.columns.x.len() - colors.len();
            self.budget.reserve(&mut colors, missing)?;
            colors.resize(self.columns.x.len(), [1.0; 3]);
            // Bytes, unless all are shares.
            if colors.as_flattened().iter().any(|&channel| channel > 1.0) {
                let channels = colors.as_flattened_mut().iter_mut();
                channels.for_each(|channel| *channel /= 255.0);
            }
        }
        let mut notes: Vec<String> = clamped_note(clamp_colors(&mut colors), path)
            .into_iter()
            .collect();
        self.columns.colors = colors;
        let mut left_out = LeftOut::default();
        left_out.small_faces(self.small);
        left_out.odd_normals(self.odd_normals);
        left_out.count(self.numbered, "numbered colour", "numbered colours");
        if self.header.has_uvs {
            left_out.add("texture coordinates");
        }
        notes.extend(left_out.note(path));
        if self.surfaces.is_empty() {
            self.surface_of = Vec::new();
        } else if let Some(first) = self.surfaces.first_mut() {
            *first = Surface::without_material(!self.columns.colors.is_empty());
        }
        let fans = self.fans.cut_concave(&mut self.columns, self.budget)?;
        notes.extend(fans_note(fans, path));
        let is_cloud = self.columns.triangles.is_empty() && !self.columns.x.is_empty();
        Ok(LoadedMesh {
            columns: self.columns,
            surfaces: self.surfaces,
            surface_of: self.surface_of,
            cloud: is_cloud.then(Cloud::default),
            up: UpAxis::Y,
            up_source: UpSource::Assumed(MeshFormat::Off),
            notes,
            ..LoadedMesh::default()
        })
    }
}

#[cfg(test)]
mod tests;
