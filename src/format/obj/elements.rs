//! Lines and points (`l`, `p`), which are read in a second pass over a file without faces. In files with faces they are
//! left out and not checked.

use super::{
    super::{
        budget::{Budget, BudgetError},
        left_out::counted,
        place::{TextFault, Words, after_mark},
        vertices::NONE,
    },
    corner,
    corners::resolve,
};
use crate::{error::quote, scene::TriangleMesh};

/// The lines and points of a file.
#[derive(Default)]
pub(super) struct Elements {
    /// The vertices at the ends of each segment.
    pub(super) lines: Vec<[u32; 2]>,
    /// For each vertex whether it is shown: whether a line or point has it, or there are none.
    is_shown: Vec<bool>,
}

impl Elements {
    /// Reads all `l` and `p` of a text that has this many vertices.
    pub(super) fn read(text: &[u8], vertices: usize, budget: &Budget) -> Result<Self, TextFault> {
        let mut elements = Self::default();
        budget.reserve(&mut elements.is_shown, vertices)?;
        elements.is_shown.resize(vertices, false);
        let (mut start, mut so_far) = (after_mark(text), 0);
        for line in text[start..].split_inclusive(|&byte| byte == b'\n') {
            let end = start + line.len();
            let mut words = Words::new(text, start..end);
            match words.next() {
                Some((b"v", _)) => so_far += 1,
                Some((b"l", place)) => {
                    let whole_line = place.start..words.end_of_words();
                    let count = elements.element(words, so_far, true, budget)?;
                    if count < 2 {
                        let vertices = counted(count, "vertex", "vertices");
                        let message = format!("line with {vertices}, expected 2 or more");
                        return Err(TextFault::new(whole_line, message));
                    }
                }
                Some((b"p", _)) => {
                    elements.element(words, so_far, false, budget)?;
                }
                _ => {}
            }
            start = end;
        }
        Ok(elements)
    }

    /// Adds the words of a line or point; `size` is the number of vertices so far. Returns how many there are.
    fn element(
        &mut self,
        words: Words<'_>,
        size: usize,
        is_line: bool,
        budget: &Budget,
    ) -> Result<usize, TextFault> {
        let (mut count, mut last) = (0, NONE);
        for (word, place) in words {
            if word.starts_with(b"#") {
                break;
            }
            let Some(corner) = corner(word) else {
                let message = format!("vertex {}, expected an index such as `1` or `1/2`", quote(word));
                return Err(TextFault::new(place, message));
            };
            let limit = Some(self.is_shown.len());
            let vertex = resolve(corner.position, size, ["vertex", "vertices"], limit)
                .map_err(|message| TextFault::new(place, message))?;
            self.is_shown[vertex as usize] = true;
            if is_line && count > 0 {
                budget.reserve(&mut self.lines, 1)?;
                self.lines.push([last, vertex]);
            }
            (count, last) = (count + 1, vertex);
        }
        Ok(count)
    }

    /// Drops the vertices that are not shown, and returns the lines between the others.
    pub(super) fn keep_shown(
        mut self,
        mesh: &mut TriangleMesh,
        budget: &Budget,
    ) -> Result<Vec<[u32; 2]>, BudgetError> {
        if self.is_shown.contains(&true) && self.is_shown.contains(&false) {
            let mut numbers = Vec::new();
            budget.reserve(&mut numbers, self.is_shown.len())?;
            let mut next = 0;
            numbers.extend(self.is_shown.iter().map(|&is_shown| {
                next += u32::from(is_shown);
                next - u32::from(is_shown)
            }));
            for index in self.lines.as_flattened_mut() {
                *index = numbers[*index as usize];
            }
            budget.give_back(numbers.capacity() * size_of::<u32>());
            let is_shown = &self.is_shown;
            for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
                retain(column, is_shown);
            }
            retain(&mut mesh.colors, is_shown);
        }
        budget.give_back(self.is_shown.capacity());
        Ok(self.lines)
    }
}

/// Keeps the elements that are shown.
fn retain<T>(array: &mut Vec<T>, is_shown: &[bool]) {
    let mut shown = is_shown.iter();
    array.retain(|_| shown.next().is_none_or(|&is_shown| is_shown));
}
