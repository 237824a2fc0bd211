//! Cells: each a list of points.

use super::{
    array::{Array, File, Numbers},
    shapes::POLYHEDRON,
};
use crate::format::{budget::Budget, place::TextFault};

/// How many bodies may share each face, on average.
const MOST_SHARED: usize = 4;

/// Where a file stores the points of cells.
#[derive(Clone)]
pub(super) struct Cells<'a> {
    pub(super) count: usize,
    pub(super) layout: Layout<'a>,
}

#[derive(Clone)]
pub(super) enum Layout<'a> {
    /// The number of points before the points of each cell.
    Counted(Array<'a>),
    /// The points of all cells, and where those of each end in the list.
    Offsets {
        offsets: Array<'a>,
        points: Array<'a>,
        /// Whether 0 precedes the first end.
        begins: bool,
    },
}

/// The type of each cell.
pub(super) enum Types<'a> {
    All(u8),
    Each(Array<'a>),
}

/// The faces of polyhedra, unless their lists of points are these.
#[derive(Clone)]
pub(super) enum Polyhedra<'a> {
    /// For each polyhedron in turn: the number of faces, then the number of points and the points of each.
    Stream(Array<'a>),
    /// Where the faces of each cell end in a list of faces, that list, where the points of each face end, and these points.
    Indexed(Box<[Array<'a>; 4]>),
}

/// Reads cells in turn.
pub(super) struct Reader<'a> {
    budget: &'a Budget,
    points: Numbers<'a>,
    /// The ends of cells, unless each begins with its length.
    ends: Option<Numbers<'a>>,
    last_end: u64,
    polyhedra: Option<PolyhedronReader<'a>>,
    /// The current cell.
    cell: Vec<u32>,
}

impl<'a> Cells<'a> {
    /// Starts at the first cell.
    pub(super) fn read(
        &self,
        polyhedra: Option<&Polyhedra<'a>>,
        file: &File<'a>,
    ) -> Result<Reader<'a>, TextFault> {
        let (points, ends, last_end) = match &self.layout {
            Layout::Counted(points) => (points.open(self.count, file)?, None, 0),
            Layout::Offsets {
                offsets,
                points,
                begins,
            } => {
                let begins = *begins && self.count > 0;
                let mut ends = offsets.open(self.count.saturating_add(begins.into()), file)?;
                let first = if begins {
                    ends.index(1, "the first offset is")?
                } else {
                    0
                };
                (points.open(0, file)?, Some(ends), first)
            }
        };
        Ok(Reader {
            budget: file.budget,
            points,
            ends,
            last_end,
            polyhedra: polyhedra
                .map(|polyhedra| PolyhedronReader::new(polyhedra, self.count, file))
                .transpose()?,
            cell: Vec::new(),
        })
    }
}

impl Reader<'_> {
    /// The next cell, of this type, whose points are below `most`. That of a polyhedron is the number of faces, then the number
    /// of points and the points of each.
    pub(super) fn next(&mut self, cell: u8, most: usize) -> Result<&[u32], TextFault> {
        self.cell.clear();
        // Counts are among the points.
        let counts_too = cell == POLYHEDRON && self.polyhedra.is_none();
        let limit = if counts_too { 1 << 32 } else { most as u64 };
        let length = match &mut self.ends {
            None => self.points.index(1 << 32, "the number of points is")?,
            Some(ends) => {
                let end = ends.index(1 << 40, "an offset is")?;
                let length = end.checked_sub(self.last_end).ok_or_else(|| {
                    ends.fault(format!(
                        "offset {end} follows {}, expected no smaller one",
                        self.last_end
                    ))
                })?;
                self.last_end = end;
                length
            }
        };
        if let Some(polyhedra) = &mut self.polyhedra
            && cell == POLYHEDRON
        {
            self.points.skip(length as usize)?;
            polyhedra.next(&mut self.cell, most, self.budget)?;
            return Ok(&self.cell);
        }
        if let Some(polyhedra) = &mut self.polyhedra {
            polyhedra.pass()?;
        }
        for _ in 0..length {
            let point = self.points.index(limit, "vertex")? as u32;
            self.budget.reserve(&mut self.cell, 1)?;
            self.cell.push(point);
        }
        if counts_too {
            self.check_faces(most)?;
        }
        Ok(&self.cell)
    }

    /// Checks the points of a polyhedron's faces.
    fn check_faces(&self, most: usize) -> Result<(), TextFault> {
        for face in faces_of(&self.cell) {
            if let Some(point) = face.iter().find(|&&point| point as usize >= most) {
                let message = format!(
                    "vertex {point} of a polyhedron, expected 0 to {}",
                    most as i64 - 1
                );
                return Err(self.points.fault(message));
            }
        }
        Ok(())
    }
}

impl Drop for Reader<'_> {
    fn drop(&mut self) {
        self.budget.give_back(self.cell.capacity() * size_of::<u32>());
    }
}

/// The faces of a polyhedron, as [`Reader::next`] returns it; they end where the list does.
pub(super) fn faces_of(polyhedron: &[u32]) -> impl Iterator<Item = &[u32]> {
    let (count, mut rest) = match polyhedron {
        [count, rest @ ..] => (*count, rest),
        [] => (0, &[][..]),
    };
    (0..count).map_while(move |_| {
        let (length, more) = rest.split_first()?;
        let (face, more) = more.split_at_checked(*length as usize)?;
        rest = more;
        Some(face)
    })
}

/// Reads the faces of polyhedra in turn.
enum PolyhedronReader<'a> {
    Stream(Box<Numbers<'a>>),
    Indexed(Box<Indexed<'a>>),
}

/// Polyhedra by the indices of their faces.
struct Indexed<'a> {
    ends: Numbers<'a>,
    last_end: u64,
    faces: Numbers<'a>,
    /// Where the points of each face begin, and where the last ones end.
    face_ends: Vec<u32>,
    points: Vec<u32>,
    /// How many points of faces may still be read: two bodies share a face, but a hostile file may have more.
    left: usize,
}

impl<'a> PolyhedronReader<'a> {
    fn new(polyhedra: &Polyhedra<'a>, cells: usize, file: &File<'a>) -> Result<Self, TextFault> {
        Ok(match polyhedra {
            Polyhedra::Stream(faces) => Self::Stream(Box::new(faces.open(0, file)?)),
            Polyhedra::Indexed(arrays) => {
                let [ends, faces, face_ends, points] = &**arrays;
                let points = all(points, &[], file)?;
                Self::Indexed(Box::new(Indexed {
                    ends: ends.open(cells, file)?,
                    last_end: 0,
                    faces: faces.open(0, file)?,
                    face_ends: all(face_ends, &[0], file)?,
                    left: points.len().saturating_mul(MOST_SHARED),
                    points,
                }))
            }
        })
    }

    /// A cell that is no polyhedron.
    fn pass(&mut self) -> Result<(), TextFault> {
        if let Self::Indexed(indexed) = self {
            indexed.last_end = indexed.ends.index(1 << 40, "an offset is")?.max(indexed.last_end);
        }
        Ok(())
    }

    /// Adds the next polyhedron to `cell`.
    fn next(&mut self, cell: &mut Vec<u32>, most: usize, budget: &Budget) -> Result<(), TextFault> {
        let mut add = |number: u64| {
            budget.reserve(cell, 1)?;
            cell.push(number as u32);
            Ok::<(), TextFault>(())
        };
        match self {
            Self::Indexed(indexed) => indexed.next(most, add),
            Self::Stream(numbers) => {
                let faces = numbers.index(1 << 32, "the number of faces is")?;
                add(faces)?;
                for _ in 0..faces {
                    let length = numbers.index(1 << 32, "the number of points is")?;
                    add(length)?;
                    for _ in 0..length {
                        add(numbers.index(most as u64, "vertex")?)?;
                    }
                }
                Ok(())
            }
        }
    }
}

impl Indexed<'_> {
    /// Adds the numbers of the next polyhedron.
    fn next(
        &mut self,
        most: usize,
        mut add: impl FnMut(u64) -> Result<(), TextFault>,
    ) -> Result<(), TextFault> {
        let end = self.ends.index(1 << 32, "an offset is")?;
        let count = end.saturating_sub(self.last_end);
        self.last_end = end;
        add(count)?;
        for _ in 0..count {
            let known = self.face_ends.len().saturating_sub(1) as u64;
            let face = self.faces.index(known, "face")? as usize;
            let part = self.face_ends[face] as usize..self.face_ends[face + 1] as usize;
            let fault = |message: &str| self.faces.fault(format!("face {face} {message}"));
            let part = self.points.get(part).ok_or_else(|| fault("has no points"))?;
            let left = self.left.checked_sub(part.len());
            self.left = left.ok_or_else(|| fault("belongs to too many polyhedra"))?;
            add(part.len() as u64)?;
            for &point in part {
                if point as usize >= most {
                    return Err(fault(&format!(
                        "has the vertex {point}, expected fewer than {most}"
                    )));
                }
                add(point.into())?;
            }
        }
        Ok(())
    }
}

/// All numbers of an array, after `before`.
fn all(array: &Array<'_>, before: &[u32], file: &File<'_>) -> Result<Vec<u32>, TextFault> {
    let mut numbers = array.open(0, file)?;
    let mut all = before.to_vec();
    while !numbers.is_at_end() {
        file.budget.reserve(&mut all, 1)?;
        all.push(numbers.index(1 << 32, "found")? as u32);
    }
    Ok(all)
}
