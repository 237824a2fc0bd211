//! Wavefront OBJ: `v`, also with a colour, `vn`, `f`, `usemtl` and `mtllib`. A file without faces shows its lines and points
//! (`l`, `p`), or all vertices as points. A note lists whatever else the file holds.
//!
//! Polygons become fans; concave ones become triangles that fill them.
//!
//! Why not tobj: it panics at `Kd 0.8` and, in debug builds, at a very negative normal index. It assigns normals to the
//! wrong corners if only some have one. It rejects names that are not UTF-8, comments after a face and continued lines.
//! Its errors have no line. Tests compare with it on files that both read.
//!
//! Format: *Wavefront Object Files*, appendix B1 of the Advanced Visualizer manual, 1995.

mod colors;
mod corners;
mod elements;
mod libraries;
mod mtl;
mod texture_files;
mod textures;

use super::{
    OpenMesh,
    budget::{Budget, BudgetError},
    left_out::LeftOut,
    mesh::{Cloud, LoadedMesh, MeshFormat, Surface, Unusable, UpAxis, UpSource, usable_normal},
    offset::Offset,
    place::{TextFault, Words, after_mark, refuse_binary},
    textures::Images,
};
use crate::{
    error::{LoadError, SceneError, SourcePos, clip_path, quote},
    scene::{TriangleMesh, is_usable},
};
use colors::Colors;
use corners::Corners;
use elements::Elements;
use glam::Vec3;
use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
    ops::Range,
    path::{Path, PathBuf},
};

/// A triangle without a known material.
const NO_SURFACE: u32 = u32::MAX;
/// Surfaces from this number on, and below [`NO_SURFACE`], stand for names that no library has had yet.
const FIRST_NAME: u32 = 1 << 31;

/// After this many notes no further library is read.
const MOST_NOTES: usize = 20;
/// The most material libraries of a mesh.
const MOST_LIBRARIES: usize = 1024;
/// The most bytes of all material libraries of a mesh. One file may have many names.
const MOST_LIBRARY_BYTES: usize = 1 << 28;

/// Reads a mesh; `open` gives the .mtl files that it names. A missing one becomes a note.
///
/// # Errors
/// [`LoadError`], with line and column: a number that does not parse or is not usable, an index out of range.
pub(super) fn parse(
    bytes: &[u8],
    path: &Path,
    open: OpenMesh<'_>,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let located = |fault: TextFault| fault.into_error(bytes, path);
    let (mut mesh, unusable) = read(bytes, path, open, budget).map_err(located)?;
    mesh.keep_used(unusable.map(located), path, budget)?;
    Ok(mesh)
}

/// The mesh, and its unusable vertices, which are in it.
fn read(
    bytes: &[u8],
    path: &Path,
    open: OpenMesh<'_>,
    budget: &Budget,
) -> Result<(LoadedMesh, Unusable<TextFault>), TextFault> {
    if bytes.is_empty() {
        return Err(TextFault::new(0..0, "the file is empty, expected an OBJ mesh"));
    }
    refuse_binary(bytes, "the text of an OBJ mesh")?;
    let text = &join_lines(bytes, budget)?[..];
    let before = budget.taken();
    let mut obj = Obj::new(budget);
    obj.lines(text, path, open, None)?;
    if obj.x.is_empty()
        && obj.corners.is_empty()
        && let Some(range) = obj.unknown.clone()
    {
        let found = quote(bytes.get(range.clone()).unwrap_or_default());
        return Err(TextFault::new(
            range,
            format!(
                "found {found} and no vertices, expected an OBJ mesh with lines such as `v 0 0 0` and `f 1 2 3`"
            ),
        ));
    }
    if obj.uvs_are_late {
        // Read again to keep the texture coordinates before the library.
        obj = Obj::new(budget);
        budget.give_back_to(before);
        obj.keeps_uvs = true;
        obj.lines(text, path, open, None)?;
    }
    let keeps_uvs = obj.keeps_uvs;
    let limits = [obj.x.len(), obj.normals.len()];
    obj.lacks_normals = obj.normals.is_empty() && obj.corners.have_normals();
    if obj.lacks_normals {
        obj.corners.drop_normals();
    }
    if obj.corners.are_beyond(limits) {
        // Read again to find the line.
        obj = Obj::new(budget);
        budget.give_back_to(before);
        obj.keeps_uvs = keeps_uvs;
        obj.lines(text, path, open, Some(limits))?;
    }
    let elements = if !obj.corners.has_faces() && obj.line_elements + obj.point_elements > 0 {
        let (positions, surfaces) = (obj.x.len(), &obj.surface_by_name);
        Some(Elements::read(text, positions, surfaces, budget)?)
    } else {
        None
    };
    obj.find_late_materials(path);
    obj.note_left_out(text, path);
    let unusable = std::mem::take(&mut obj.unusable);
    Ok((obj.finish(elements, path, open)?, unusable))
}

/// The mesh so far.
struct Obj<'b> {
    budget: &'b Budget,
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    unusable: Unusable<TextFault>,
    /// Zero where they are NaN or too large.
    normals: Vec<Vec3>,
    odd_normals: usize,
    colors: Colors,
    corners: Corners,
    surfaces: Vec<Surface>,
    surface_of: Vec<u32>,
    surface_by_name: HashMap<Vec<u8>, u32>,
    /// How surfaces place their textures, if not as the file's coordinates say.
    shifts: HashMap<u32, textures::Shift>,
    current: Option<u32>,
    /// The libraries that have been read, or could not be.
    libraries: HashSet<PathBuf>,
    library_bytes: usize,
    /// Names of materials that no library had when they were used, with their numbers: a library may come late.
    missing_materials: HashMap<Vec<u8>, u32>,
    /// How many `vt` lines there are.
    texture_coordinates: usize,
    /// Empty unless `keeps_uvs`.
    uvs: Vec<[f32; 2]>,
    /// How many of them are not finite.
    odd_uvs: usize,
    /// Whether a material shows an image.
    keeps_uvs: bool,
    /// Whether the first such material came after texture coordinates or faces.
    uvs_are_late: bool,
    has_smoothing_groups: bool,
    /// How many `l` and `p` lines there are.
    line_elements: usize,
    point_elements: usize,
    /// How many lines begin with an unknown word, and the first of these words.
    unknown_lines: usize,
    unknown: Option<Range<usize>>,
    /// Whether corners name normals, but the file has no normals.
    lacks_normals: bool,
    notes: Vec<String>,
    texture_files: Vec<PathBuf>,
    /// The images that `surfaces` number.
    images: Images,
}

impl<'b> Obj<'b> {
    fn new(budget: &'b Budget) -> Self {
        Self {
            budget,
            x: Vec::new(),
            y: Vec::new(),
            z: Vec::new(),
            unusable: Unusable::default(),
            normals: Vec::new(),
            odd_normals: 0,
            colors: Colors::default(),
            corners: Corners::default(),
            surfaces: Vec::new(),
            surface_of: Vec::new(),
            surface_by_name: HashMap::new(),
            shifts: HashMap::new(),
            current: None,
            libraries: HashSet::new(),
            library_bytes: 0,
            missing_materials: HashMap::new(),
            texture_coordinates: 0,
            uvs: Vec::new(),
            odd_uvs: 0,
            keeps_uvs: false,
            uvs_are_late: false,
            has_smoothing_groups: false,
            line_elements: 0,
            point_elements: 0,
            unknown_lines: 0,
            unknown: None,
            lacks_normals: false,
            notes: Vec::new(),
            texture_files: Vec::new(),
            images: Images::default(),
        }
    }

    /// Reads all lines. With `limits`, the numbers of positions and normals, indices beyond them are errors.
    fn lines(
        &mut self,
        text: &[u8],
        path: &Path,
        open: OpenMesh<'_>,
        limits: Option<[usize; 2]>,
    ) -> Result<(), TextFault> {
        let mut start = after_mark(text);
        let mut progress = self.budget.parsing(text.len());
        for line in text[start..].split_inclusive(|&byte| byte == b'\n') {
            progress.at(start);
            let end = start + line.len();
            self.line(Words::new(text, start..end), path, open, limits)?;
            start = end;
        }
        Ok(())
    }

    /// A position, perhaps with a colour.
    fn vertex(&mut self, words: &mut Words<'_>, place: &Range<usize>) -> Result<(), TextFault> {
        let names = ["x", "y", "z"];
        let (position, places) = vector(words, place, names, self.budget.offset())?;
        let [x, y, z] = position;
        if let Some(i) = position.iter().position(|&value| !is_usable(value)) {
            self.unusable.count += 1;
            self.unusable.keep_first(|| {
                let error = SceneError::NotUsable {
                    what: names[i],
                    value: position[i],
                };
                TextFault::new(places[i].clone(), error.to_string())
            });
        }
        for column in [&mut self.x, &mut self.y, &mut self.z] {
            self.budget.reserve(column, 1)?;
        }
        self.x.push(x);
        self.y.push(y);
        self.z.push(z);
        self.colors.read(words, self.x.len() - 1, self.budget)?;
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
            b"v" => self.vertex(&mut words, &place)?,
            b"vn" => {
                let (normal, _) = vector(&mut words, &place, ["nx", "ny", "nz"], Offset::NONE)?;
                self.budget.reserve(&mut self.normals, 1)?;
                self.normals.push(usable_normal(normal, &mut self.odd_normals));
            }
            b"f" => {
                let sizes = [self.x.len(), self.normals.len()];
                let uvs = self.keeps_uvs.then_some(self.uvs.len());
                let triangles = self.corners.face(words, sizes, uvs, limits, self.budget)?;
                let surface = self.current.unwrap_or(NO_SURFACE);
                self.budget.reserve(&mut self.surface_of, triangles)?;
                self.surface_of.resize(self.surface_of.len() + triangles, surface);
            }
            b"usemtl" => {
                let name = name(&words);
                let known = self.surface_by_name.get(name);
                let known = known.or_else(|| self.missing_materials.get(name)).copied();
                self.current = Some(match known {
                    Some(known) => known,
                    None => self.missing(name)?,
                });
            }
            // The second pass only looks for an index.
            b"mtllib" if limits.is_none() => {
                let read = self.library(name(&words), path, open);
                read.map_err(|reason| {
                    let range = place.start..words.end_of_words();
                    TextFault::new(range, reason.message).with_kind(reason.kind)
                })?;
            }
            b"vt" => {
                self.texture_coordinates += 1;
                if self.keeps_uvs {
                    self.budget.reserve(&mut self.uvs, 1)?;
                    let uv = self.uv(words);
                    self.uvs.push(uv);
                }
            }
            b"l" => self.line_elements += 1,
            b"p" => self.point_elements += 1,
            b"s" => {
                let group = words.next().map_or(&b"off"[..], |(word, _)| word);
                self.has_smoothing_groups |= !matches!(group, b"off" | b"0");
            }
            [b'#', ..] | b"mtllib" | b"g" | b"o" => {}
            _ => {
                self.unknown_lines += 1;
                self.unknown.get_or_insert(place);
            }
        }
        Ok(())
    }

    /// Notes what is not read.
    fn note_left_out(&mut self, text: &[u8], path: &Path) {
        let mut left_out = LeftOut::default();
        left_out.small_faces(self.corners.small);
        left_out.odd_normals(self.odd_normals);
        if self.lacks_normals {
            left_out.add("indices of normals, since there are no normals");
        }
        if !self.corners.is_empty() {
            left_out.count(self.line_elements, "line element", "line elements");
            left_out.count(self.point_elements, "point element", "point elements");
        }
        left_out.count(
            self.odd_uvs,
            "texture coordinate that is NaN or too large",
            "texture coordinates that are NaN or too large",
        );
        // With normals, smoothing groups change nothing.
        if self.has_smoothing_groups && self.normals.is_empty() {
            left_out.add("smoothing groups");
        }
        if !self.corners.has_faces() && self.line_elements + self.point_elements == 0 && !self.x.is_empty() {
            let signs = [
                ("usemtl", self.current.is_some()),
                ("mtllib", !self.libraries.is_empty()),
                ("vt", self.texture_coordinates > 0),
                ("vn", !self.normals.is_empty()),
            ];
            let sign = signs.iter().find(|(_, is_there)| *is_there);
            self.notes.extend(sign.map(|(word, _)| {
                let path = clip_path(path);
                format!(
                    "{path}: no faces, but `{word}`: its vertices are shown as balls; is the file cut short?"
                )
            }));
        }
        if let Some(first) = self.unknown.clone() {
            let at = SourcePos::in_text(path, text, first.start);
            let what = |lines: &str| {
                let word = quote(text.get(first.clone()).unwrap_or_default());
                format!("unknown {lines} (first: {word} in line {})", at.line)
            };
            left_out.count(self.unknown_lines, &what("line"), &what("lines"));
        }
        self.notes.extend(left_out.note(path));
    }

    fn finish(
        mut self,
        elements: Option<Elements<'_>>,
        path: &Path,
        open: OpenMesh<'_>,
    ) -> Result<LoadedMesh, BudgetError> {
        let (colors, color_note) = self.colors.finish(self.x.len(), path, self.budget)?;
        self.corners
            .count_colors_once(&mut self.surfaces, &self.surface_of, &colors, self.budget)?;
        let (corners, count) = (&self.corners, self.uvs.len());
        let untextured = super::textures::leave_untextured(&mut self.surfaces, &mut self.surface_of, |i| {
            corners.lacks_uvs(i, count)
        });
        self.notes
            .extend(super::textures::untextured_note(untextured, path));
        let shown = (&mut self.surfaces[..], &self.surface_of[..]);
        let images = self.images.read(shown, path, open, self.budget, &mut self.notes);
        if images.is_empty() && self.budget.wants_images() {
            self.corners.drop_uvs();
        }
        self.notes.extend(color_note);
        let is_cloud = !self.corners.has_faces() && !self.x.is_empty();
        if self.surfaces.is_empty() {
            self.surface_of = Vec::new();
        } else if self.surface_of.contains(&NO_SURFACE) {
            let neutral = self.surfaces.len() as u32;
            self.budget.reserve(&mut self.surfaces, 1)?;
            self.surfaces.push(Surface::without_material(!colors.is_empty()));
            for surface in self.surface_of.iter_mut().filter(|s| **s == NO_SURFACE) {
                *surface = neutral;
            }
        }
        let mut columns = TriangleMesh {
            x: self.x,
            y: self.y,
            z: self.z,
            colors,
            ..TriangleMesh::default()
        };
        let lines = match elements {
            Some(elements) => elements.keep(&mut columns, &mut self.surfaces)?,
            None => Vec::new(),
        };
        let fans = self.corners.cut_concave(&columns, self.budget)?;
        self.notes.extend(super::polygon::fans_note(fans, path));
        let moved = (&mut self.uvs, &self.surface_of[..], &self.shifts);
        self.corners.move_uvs(moved, self.budget)?;
        self.corners
            .into_columns(&self.normals, &self.uvs, &mut columns, self.budget)?;
        Ok(LoadedMesh {
            columns,
            surfaces: self.surfaces,
            surface_of: self.surface_of,
            cloud: is_cloud.then_some(Cloud { radius: None, lines }),
            up: UpAxis::Y,
            up_source: UpSource::Assumed(MeshFormat::Obj),
            notes: self.notes,
            images,
            texture_files: self.texture_files,
            ..LoadedMesh::default()
        })
    }
}

/// Joins lines that end with a backslash: spaces replace it and the newline, so that all offsets stay. If carriage
/// returns alone end the lines, as on Macs before 2001, they become newlines.
fn join_lines<'a>(text: &'a [u8], budget: &Budget) -> Result<Cow<'a, [u8]>, BudgetError> {
    let copy = || {
        let mut copy = Vec::new();
        budget.reserve(&mut copy, text.len())?;
        copy.extend_from_slice(text);
        Ok(copy)
    };
    let mut joined = Cow::Borrowed(text);
    if !text.contains(&b'\n') && text.contains(&b'\r') {
        let mut lines: Vec<u8> = copy()?;
        for byte in lines.iter_mut().filter(|byte| **byte == b'\r') {
            *byte = b'\n';
        }
        joined = Cow::Owned(lines);
    }
    let backslashes = text.iter().enumerate().filter(|&(_, &byte)| byte == b'\\');
    for (i, _) in backslashes {
        let newline = match text.get(i + 1..) {
            Some([b'\n', ..]) => i + 1,
            Some([b'\r', b'\n', ..]) => i + 2,
            _ => continue,
        };
        if let Cow::Borrowed(_) = joined {
            joined = Cow::Owned(copy()?);
        }
        joined.to_mut()[i..=newline].fill(b' ');
    }
    Ok(joined)
}

/// The rest of a line as one name.
fn name<'a>(words: &Words<'a>) -> &'a [u8] {
    words.text(words.rest())
}

/// Three numbers, less an offset, and their places.
fn vector(
    words: &mut Words<'_>,
    keyword: &Range<usize>,
    names: [&'static str; 3],
    offset: Offset,
) -> Result<([f32; 3], [Range<usize>; 3]), TextFault> {
    let (mut vector, mut places) = ([0.0; 3], [0..0, 0..0, 0..0]);
    for (axis, ((value, of), what)) in vector.iter_mut().zip(&mut places).zip(names).enumerate() {
        let Some((word, place)) = words.next() else {
            let message = format!("the line ends before `{what}`, expected three numbers");
            return Err(TextFault::new(keyword.start..words.rest().end, message));
        };
        *value = offset.parse(axis, word).map_err(|_| {
            let message = format!("`{what}` is {}, expected a number", quote(word));
            TextFault::new(place.clone(), message)
        })?;
        *of = place;
    }
    Ok((vector, places))
}

#[cfg(test)]
mod tests;
