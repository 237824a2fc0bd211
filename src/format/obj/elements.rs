//! Lines and points (`l`, `p`), which are read in a second pass over a file without faces. In files with faces they are
//! left out and not checked.

use super::{
    super::{
        budget::{Budget, BudgetError},
        left_out::counted,
        mesh::Surface,
        place::{TextFault, Words, after_mark},
        textures::untextured,
        vertices::{NONE, Vertices},
    },
    NO_SURFACE,
    corners::{corner, resolve},
    name,
};
use crate::{error::quote, scene::TriangleMesh};
use std::collections::HashMap;

/// The lines and points of a file.
pub(super) struct Elements<'a> {
    budget: &'a Budget,
    /// The vertices at the ends of each segment.
    lines: Vec<[u32; 2]>,
    /// How many positions there are.
    positions: usize,
    /// The vertices, with their surface and position. One that has several surfaces becomes several.
    vertices: Vertices<'a>,
    /// The current surface.
    surface: u32,
}

impl<'a> Elements<'a> {
    /// Reads all `l` and `p` of a text that has this many positions.
    pub(super) fn read(
        text: &[u8],
        positions: usize,
        surface_by_name: &HashMap<Vec<u8>, u32>,
        budget: &'a Budget,
    ) -> Result<Self, TextFault> {
        let mut elements = Self {
            budget,
            lines: Vec::new(),
            positions,
            vertices: Vertices::new(positions, budget)?,
            surface: NO_SURFACE,
        };
        let (mut start, mut so_far) = (after_mark(text), 0);
        for line in text[start..].split_inclusive(|&byte| byte == b'\n') {
            let end = start + line.len();
            let mut words = Words::new(text, start..end);
            match words.next() {
                Some((b"v", _)) => so_far += 1,
                Some((b"usemtl", _)) => {
                    let surface = surface_by_name.get(name(&words));
                    elements.surface = surface.copied().unwrap_or(NO_SURFACE);
                }
                Some((b"l", place)) => {
                    let whole_line = place.start..words.end_of_words();
                    let count = elements.element(words, so_far, true)?;
                    if count < 2 {
                        let vertices = counted(count, "vertex", "vertices");
                        let message = format!("line with {vertices}, expected 2 or more");
                        return Err(TextFault::new(whole_line, message));
                    }
                }
                Some((b"p", _)) => {
                    elements.element(words, so_far, false)?;
                }
                _ => {}
            }
            start = end;
        }
        Ok(elements)
    }

    /// Adds the words of a line or point; `so_far` is the number of positions. Returns how many words there are.
    fn element(&mut self, words: Words<'_>, so_far: usize, is_line: bool) -> Result<usize, TextFault> {
        let (mut count, mut last) = (0, NONE);
        for (word, place) in words {
            if word.starts_with(b"#") {
                break;
            }
            let Some(corner) = corner(word) else {
                let message = format!("vertex {}, expected an index such as `1` or `1/2`", quote(word));
                return Err(TextFault::new(place, message));
            };
            let what = ["vertex", "vertices"];
            let position = resolve(corner.position, so_far, what, Some(self.positions))
                .map_err(|message| TextFault::new(place, message))?;
            let vertex = self.vertices.vertex(position, [self.surface, position])?;
            if is_line && count > 0 {
                self.budget.reserve(&mut self.lines, 1)?;
                self.lines.push([last, vertex]);
            }
            (count, last) = (count + 1, vertex);
        }
        Ok(count)
    }

    /// Keeps only the vertices of lines and points, if there are any, and returns the lines between them. Several surfaces
    /// become colours.
    pub(super) fn keep(
        mut self,
        mesh: &mut TriangleMesh,
        surfaces: &mut Vec<Surface>,
    ) -> Result<Vec<[u32; 2]>, BudgetError> {
        let (budget, vertices) = (self.budget, self.vertices.into_attributes());
        let named = || vertices.iter().flatten();
        let Some(&[first, _]) = named().next() else {
            return Ok(self.lines);
        };
        let mut numbers = Vec::new();
        budget.reserve(&mut numbers, vertices.len())?;
        let mut next = 0;
        numbers.extend(vertices.iter().map(|vertex| {
            next += u32::from(vertex.is_some());
            next - u32::from(vertex.is_some())
        }));
        for index in self.lines.as_flattened_mut() {
            *index = numbers[*index as usize];
        }
        budget.give_back(numbers.capacity() * size_of::<u32>());
        let count = next as usize;
        for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
            let mut kept = Vec::new();
            budget.reserve(&mut kept, count)?;
            kept.extend(named().map(|&[_, position]| column[position as usize]));
            budget.give_back(column.capacity() * size_of::<f32>());
            *column = kept;
        }
        let is_one = named().all(|&[surface, _]| surface == first);
        if !(is_one && mesh.colors.is_empty()) {
            let (colors, mut kept) = (&mesh.colors, Vec::new());
            budget.reserve(&mut kept, count)?;
            kept.extend(named().map(|&[surface, position]| {
                let color = colors.get(position as usize).copied();
                let tint = surfaces.get(surface as usize).filter(|_| !is_one);
                match (color, tint.map(|surface| untextured(surface).diffuse)) {
                    (Some(color), Some(tint)) => [0, 1, 2].map(|i| color[i] * tint[i]),
                    (color, tint) => color.or(tint).unwrap_or(Surface::NEUTRAL.diffuse),
                }
            }));
            mesh.colors = kept;
        }
        let one = surfaces.get(first as usize).filter(|_| is_one);
        *surfaces = one.map(untextured).into_iter().collect();
        budget.give_back(vertices.capacity() * size_of::<Option<[u32; 2]>>());
        Ok(self.lines)
    }
}
