//! Wavefront OBJ: `v`, `vn`, `f`, `usemtl`, `mtllib`; what else there is (texture coordinates, groups, lines,
//! curves) is passed over. Polygons become fans, concave ones whatever triangles fill them.
//!
//! Read by loops of our own. tobj, the usual crate, does not fit: it ends the program at `Kd 0.8` and, in builds that
//! check arithmetic, at a normal's index that is too negative; it gives normals to the wrong corners where only some
//! have one, refuses names that are not UTF-8, comments behind a face and continued lines, and never says which line
//! is at fault. Tests compare with it where both read a file.
//!
//! Format: *Wavefront Object Files*, appendix B1 of the Advanced Visualizer manual, 1995.

mod corners;
mod mtl;

use super::{
    OpenMesh, files,
    mesh::{LoadedMesh, Surface, UpAxis},
    place::{TextFault, Words, refuse_binary},
};
use crate::{
    error::{LoadError, SceneError, quote},
    scene::{MeshColumns, is_usable},
};
use corners::{Corner, Corners};
use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
    ops::Range,
    path::Path,
};

/// A triangle whose material is not known.
const NO_SURFACE: u32 = u32::MAX;

/// After so many notes no further library is read.
const MOST_NOTES: usize = 20;

/// Reads a mesh; `open` gives the .mtl files that it names. One that is missing is a note and no error.
///
/// # Errors
/// [`LoadError`], with line and column: a number that is none or not usable, an index of a vertex that is not there.
pub(super) fn parse(bytes: &[u8], path: &Path, open: OpenMesh<'_>) -> Result<LoadedMesh, LoadError> {
    read(bytes, path, open).map_err(|fault| fault.into_error(bytes, path))
}

fn read(bytes: &[u8], path: &Path, open: OpenMesh<'_>) -> Result<LoadedMesh, TextFault> {
    if bytes.is_empty() {
        return Err(TextFault::new(0..0, "the file is empty, expected an OBJ mesh"));
    }
    refuse_binary(bytes, "the text of an OBJ mesh")?;
    let text = &join_lines(bytes)[..];
    let mut obj = Obj::default();
    obj.lines(text, path, open, None)?;
    if obj.x.is_empty()
        && obj.corners.is_empty()
        && let Some(range) = obj.unknown
    {
        let found = quote(bytes.get(range.clone()).unwrap_or_default());
        return Err(TextFault::new(
            range,
            format!(
                "found {found}, and no vertices: expected an OBJ mesh with lines such as `v 0 0 0` and `f 1 2 3`"
            ),
        ));
    }
    let limits = [obj.x.len(), obj.normals.len()];
    if obj.corners.are_beyond(limits) {
        // Once more, to find out where.
        Obj::default().lines(text, path, open, Some(limits))?;
    }
    obj.finish().map_err(|message| TextFault::new(0..0, message))
}

/// What has been read so far.
#[derive(Default)]
struct Obj {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    normals: Vec<[f32; 3]>,
    corners: Corners,
    surfaces: Vec<Surface>,
    surface_of: Vec<u32>,
    surface_by_name: HashMap<Vec<u8>, u32>,
    current: Option<u32>,
    /// The names of the libraries that have been read.
    libraries: HashSet<Vec<u8>>,
    has_colors: bool,
    /// The first word of the first line that is not understood.
    unknown: Option<Range<usize>>,
    notes: Vec<String>,
}

impl Obj {
    /// Reads all lines; with `limits`, the numbers of positions and normals, indices are held against them.
    fn lines(
        &mut self,
        text: &[u8],
        path: &Path,
        open: OpenMesh<'_>,
        limits: Option<[usize; 2]>,
    ) -> Result<(), TextFault> {
        let mut start = 0;
        for line in text.split_inclusive(|&byte| byte == b'\n') {
            let end = start + line.len();
            self.line(Words::new(text, start..end), path, open, limits)?;
            start = end;
        }
        Ok(())
    }

    fn line(
        &mut self,
        mut words: Words<'_>,
        path: &Path,
        open: OpenMesh<'_>,
        limits: Option<[usize; 2]>,
    ) -> Result<(), TextFault> {
        let Some((keyword, place)) = words.next() else {
            return Ok(());
        };
        match keyword {
            b"v" => {
                let [x, y, z] = vector(&mut words, &place, ["x", "y", "z"])?;
                self.x.push(x);
                self.y.push(y);
                self.z.push(z);
                // A fourth number is a weight; three more are a colour, as many programs write it.
                let is_number = |(word, _): &(&[u8], _)| fast_float2::parse::<f32, _>(word).is_ok();
                self.has_colors |= words.take(3).filter(is_number).count() == 3;
            }
            b"vn" => {
                let normal = vector(&mut words, &place, ["nx", "ny", "nz"])?;
                self.normals.push(normal);
            }
            b"f" => {
                let sizes = [self.x.len(), self.normals.len()];
                let triangles = self.corners.face(words, &place, sizes, limits)?;
                let surface = self.current.unwrap_or(NO_SURFACE);
                self.surface_of.resize(self.surface_of.len() + triangles, surface);
            }
            b"usemtl" => {
                let name = name(&words);
                self.current = self.surface_by_name.get(name).copied();
            }
            // The second reading is for indices alone.
            b"mtllib" if limits.is_none() => self.library(name(&words), path, open),
            [b'#', ..] | b"mtllib" | b"vt" | b"vp" | b"g" | b"o" | b"s" | b"l" | b"p" => {}
            _ => {
                self.unknown.get_or_insert(place);
            }
        }
        Ok(())
    }

    /// Reads the materials of a library. The name may hold blanks, or be several names.
    fn library(&mut self, names: &[u8], path: &Path, open: OpenMesh<'_>) {
        // Ten thousand lines that name one library cost no more than one.
        if !self.libraries.insert(names.to_vec()) || self.notes.len() > MOST_NOTES {
            return;
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        let mut read = |name: &[u8]| {
            let name = folder.join(String::from_utf8_lossy(name).as_ref());
            (open)(&name)
                .map(|bytes| (bytes, name.clone()))
                .map_err(|error| (error, name))
        };
        let several = || {
            names
                .split(u8::is_ascii_whitespace)
                .filter(|name| !name.is_empty())
        };
        let mut libraries = vec![read(names)];
        if libraries.iter().all(Result::is_err) && several().nth(1).is_some() {
            let single: Vec<_> = several().map(&mut read).collect();
            if single.iter().any(Result::is_ok) {
                libraries = single;
            }
        }
        for library in libraries {
            match library {
                Ok((bytes, name)) => {
                    let materials = mtl::parse(&bytes, &name, &mut self.notes);
                    for (name, surface) in materials {
                        self.surface_by_name.insert(name, self.surfaces.len() as u32);
                        self.surfaces.push(surface);
                    }
                }
                Err((error, name)) => self.notes.push(format!(
                    "{}, so its colours are not used",
                    files::load_error(&name, &error)
                )),
            }
        }
    }

    fn finish(mut self) -> Result<LoadedMesh, String> {
        if self.surfaces.is_empty() {
            self.surface_of = Vec::new();
        } else if self.surface_of.contains(&NO_SURFACE) {
            let neutral = self.surfaces.len() as u32;
            self.surfaces.push(Surface::NEUTRAL);
            for surface in self.surface_of.iter_mut().filter(|s| **s == NO_SURFACE) {
                *surface = neutral;
            }
        }
        let mut columns = MeshColumns {
            x: self.x,
            y: self.y,
            z: self.z,
            ..MeshColumns::default()
        };
        if self.has_colors {
            self.notes.push("left out: vertex colours".to_owned());
        }
        self.corners.cut_concave(&columns);
        self.corners.into_columns(&self.normals, &mut columns)?;
        Ok(LoadedMesh {
            columns,
            surfaces: self.surfaces,
            surface_of: self.surface_of,
            up: UpAxis::Y,
            notes: self.notes,
            ..LoadedMesh::default()
        })
    }
}

/// Makes one line of lines that a backslash joins: blanks in place of it and the newline, so that nothing moves. Where
/// carriage returns alone end the lines (as on Macs before 2001), they become newlines.
fn join_lines(text: &[u8]) -> Cow<'_, [u8]> {
    let mut joined = Cow::Borrowed(text);
    if !text.contains(&b'\n') && text.contains(&b'\r') {
        let newline = |&byte: &u8| if byte == b'\r' { b'\n' } else { byte };
        joined = text.iter().map(newline).collect::<Vec<u8>>().into();
    }
    let backslashes = text.iter().enumerate().filter(|&(_, &byte)| byte == b'\\');
    for (i, _) in backslashes {
        let newline = match text.get(i + 1..) {
            Some([b'\n', ..]) => i + 1,
            Some([b'\r', b'\n', ..]) => i + 2,
            _ => continue,
        };
        joined.to_mut()[i..=newline].fill(b' ');
    }
    joined
}

/// The rest of a line as one name.
fn name<'a>(words: &Words<'a>) -> &'a [u8] {
    words.text(words.rest())
}

fn vector(
    words: &mut Words<'_>,
    keyword: &Range<usize>,
    names: [&'static str; 3],
) -> Result<[f32; 3], TextFault> {
    let mut vector = [0.0; 3];
    for (value, what) in vector.iter_mut().zip(names) {
        let Some((word, place)) = words.next() else {
            let message = format!("the line ends where `{what}` should be, expected three numbers");
            return Err(TextFault::new(keyword.start..words.rest().end, message));
        };
        let number: f32 = fast_float2::parse(word).map_err(|_| {
            let message = format!("`{what}` is {}, expected a number", quote(word));
            TextFault::new(place.clone(), message)
        })?;
        if !is_usable(number) {
            let error = SceneError::NotUsable { what, value: number };
            return Err(TextFault::new(place, error.to_string()));
        }
        *value = number;
    }
    Ok(vector)
}

/// A corner's word: `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn corner(word: &[u8]) -> Option<Corner> {
    let mut parts = word.split(|&byte| byte == b'/');
    let position = whole(parts.next()?)?;
    let texture = parts.next();
    let normal = parts.next();
    if parts.next().is_some() || texture.is_some_and(|word| !word.is_empty() && whole(word).is_none()) {
        return None;
    }
    let normal = match normal {
        None | Some([]) => None,
        Some(word) => Some(whole(word)?),
    };
    Some(Corner { position, normal })
}

#[inline]
fn whole(word: &[u8]) -> Option<i64> {
    let (sign, digits) = match word {
        [b'-', digits @ ..] => (-1, digits),
        [b'+', digits @ ..] | digits => (1, digits),
    };
    // Longer ones are no index, and could not be counted.
    if digits.is_empty() || digits.len() > 18 {
        return None;
    }
    let mut value = 0;
    for digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    Some(sign * value)
}

#[cfg(test)]
mod tests;
