//! Arrays of points and cells: which are shown, as normals, colours or numbers.

use super::{
    Piece,
    array::{Array, File, Kind},
};
use crate::{
    error::quote,
    format::{
        mesh::{Owner, Range, Scalar, scalars},
        place::TextFault,
        reason::Reason,
    },
};
use std::collections::HashMap;

/// Arrays with more numbers for each point or cell have no names of their own.
const MOST_COMPONENTS: usize = 16;

/// Names of arrays of colours, in lower case.
const COLORS: [&str; 4] = ["rgb", "rgba", "color", "colors"];

/// The array that marks cells which other pieces have, too.
const GHOSTS: &str = "vtkGhostType";

/// Arrays of points or cells.
#[derive(Default)]
pub(super) struct Attributes<'a> {
    pub(super) arrays: Vec<Array<'a>>,
    /// The names of the active scalars and normals.
    pub(super) scalars: Option<String>,
    pub(super) normals: Option<String>,
}

impl<'a> Attributes<'a> {
    pub(super) fn find(&self, name: &str) -> Option<&Array<'a>> {
        self.arrays.iter().find(|array| array.name == name)
    }

    /// The normals.
    pub(super) fn normals(&self) -> Option<&Array<'a>> {
        let active = self.normals.as_deref().and_then(|name| self.find(name));
        active
            .or_else(|| self.find("Normals"))
            .filter(|array| array.components == 3)
    }

    /// The colours: bytes that are active or have such a name. Those of legacy files may be shares of 1.
    pub(super) fn colors(&self) -> Option<&Array<'a>> {
        self.arrays.iter().find(|array| {
            let is_active = self.scalars.as_ref() == Some(&array.name);
            let is_named = || COLORS.contains(&array.name.to_ascii_lowercase().as_str());
            let has_bytes = array.kind == Some(Kind::U8) && (is_active || is_named());
            matches!(array.components, 3 | 4) && (has_bytes || array.is_color)
        })
    }

    /// The marks of cells that other pieces have, too.
    pub(super) fn ghosts(&self) -> Option<&Array<'a>> {
        self.find(GHOSTS)
    }

    /// The arrays that are neither colours nor normals of points; normals of cells are not shown.
    pub(super) fn others(&self, owner: Owner) -> impl Iterator<Item = &Array<'a>> {
        let normals = self.normals().filter(|_| owner == Owner::Vertices);
        let shown = [normals, self.colors(), self.ghosts()].map(|array| array.map(|array| &array.name));
        let others = self.arrays.iter();
        others.filter(move |array| array.kind.is_some() && !shown.contains(&Some(&array.name)))
    }
}

/// What is shown of an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Part {
    Component(usize),
    Magnitude,
}

/// The names of an array's numbers.
fn parts(array: &Array<'_>) -> Vec<(String, Part)> {
    let name = &array.name;
    let component = |(i, end): (usize, &str)| (format!("{name}.{end}"), Part::Component(i));
    match array.components {
        1 => vec![(name.clone(), Part::Component(0))],
        count @ (2 | 3) => {
            let ends = ["x", "y", "z"].into_iter().enumerate().take(count);
            let magnitude = (format!("{name}.magnitude"), Part::Magnitude);
            ends.map(component).chain([magnitude]).collect()
        }
        count @ ..=MOST_COMPONENTS => {
            let numbers = (0..count).map(|i| (i, i.to_string()));
            numbers.map(|(i, end)| component((i, &end))).collect()
        }
        _ => Vec::new(),
    }
}

/// The numbers that are shown.
pub(super) struct Chosen {
    pub(super) owner: Owner,
    array: String,
    part: Part,
}

impl Chosen {
    /// The numbers with this name: those of points, or else of cells.
    pub(super) fn of<'p>(wanted: &str, pieces: &'p [Piece<'_>]) -> Result<Self, Reason> {
        let all = || {
            pieces.iter().flat_map(|piece| {
                let both = [
                    (Owner::Vertices, &piece.of_points),
                    (Owner::Faces, &piece.of_cells),
                ];
                let others = |(owner, of): (Owner, &'p Attributes<'_>)| {
                    of.others(owner).map(move |array| (owner, array))
                };
                both.into_iter().flat_map(others)
            })
        };
        for wanted_owner in [Owner::Vertices, Owner::Faces] {
            for (owner, array) in all().filter(|(owner, _)| *owner == wanted_owner) {
                if !wanted.starts_with(&array.name) {
                    continue;
                }
                if let Some((_, part)) = parts(array).into_iter().find(|(name, _)| name == wanted) {
                    let array = array.name.clone();
                    return Ok(Self { owner, array, part });
                }
            }
        }
        if let Some((owner, array)) = all().find(|(_, array)| array.name == wanted) {
            let names: Vec<String> = parts(array)
                .iter()
                .map(|(name, _)| quote(name.as_bytes()))
                .collect();
            let use_one = names
                .last()
                .map_or_else(String::new, |last| format!(", such as {last}"));
            return Err(scalars::refused(format!(
                "{} of {} has {} numbers for each, expected one of them{use_one}",
                array.quoted(),
                owner.name(),
                array.components
            )));
        }
        let names: Vec<(Owner, String)> = all()
            .flat_map(|(owner, array)| parts(array).into_iter().map(move |(name, _)| (owner, name)))
            .collect();
        let mut has: Vec<(Owner, &str)> = Vec::new();
        for (owner, name) in names.iter().take(4 * MOST_COMPONENTS * MOST_COMPONENTS) {
            if !has.contains(&(*owner, name)) {
                has.push((*owner, name));
            }
        }
        Err(scalars::absent(wanted, &has))
    }

    /// The number of each of `count` points or cells; NaN where the piece has none.
    pub(super) fn values(
        &self,
        attributes: &Attributes<'_>,
        count: usize,
        file: &File<'_>,
    ) -> Result<Vec<f64>, TextFault> {
        let mut values = Vec::new();
        file.budget.reserve(&mut values, count)?;
        let Some(array) = attributes.find(&self.array).filter(|array| array.kind.is_some()) else {
            values.resize(count, f64::NAN);
            return Ok(values);
        };
        let mut numbers = array.open(count.saturating_mul(array.components), file)?;
        for _ in 0..count {
            let (mut found, mut squares) = (f64::NAN, 0.0);
            for i in 0..array.components {
                let number = numbers.real()?;
                squares += number * number;
                if self.part == Part::Component(i) {
                    found = number;
                }
            }
            values.push(if self.part == Part::Magnitude {
                squares.sqrt()
            } else {
                found
            });
        }
        Ok(values)
    }
}

/// The ranges of all numbers. Arrays that cannot be read are left out.
pub(super) fn ranges(pieces: &[Piece<'_>], file: &File<'_>) -> Vec<Scalar> {
    let mut all: Vec<Scalar> = Vec::new();
    let mut known: HashMap<(bool, String), usize> = HashMap::new();
    for piece in pieces {
        for (of, attributes, count) in [
            (Owner::Vertices, &piece.of_points, piece.points),
            (Owner::Faces, &piece.of_cells, piece.cells()),
        ] {
            for array in attributes.others(of) {
                let parts = parts(array);
                // Each name takes memory.
                let room = parts.len().saturating_mul(128 + 4 * array.name.len());
                if file.budget.take(room).is_err() {
                    return all;
                }
                let Ok(ranges) = ranges_of(array, &parts, count, file) else {
                    continue;
                };
                for ((name, _), range) in parts.into_iter().zip(ranges) {
                    let index = *known
                        .entry((of == Owner::Faces, name.clone()))
                        .or_insert(all.len());
                    match all.get_mut(index) {
                        Some(scalar) => scalar.range = scalar.range.and(range),
                        None => all.push(Scalar { name, of, range }),
                    }
                }
            }
        }
    }
    all
}

fn ranges_of(
    array: &Array<'_>,
    parts: &[(String, Part)],
    count: usize,
    file: &File<'_>,
) -> Result<Vec<Range>, TextFault> {
    let mut ranges = vec![Range::default(); parts.len()];
    if parts.is_empty() {
        return Ok(ranges);
    }
    let mut numbers = array.open(count.saturating_mul(array.components), file)?;
    for _ in 0..count {
        let mut squares = 0.0;
        for range in ranges.iter_mut().take(array.components) {
            let number = numbers.real()?;
            squares += number * number;
            *range = range.with(number);
        }
        if let Some(range) = ranges.get_mut(array.components) {
            *range = range.with(squares.sqrt());
        }
    }
    Ok(ranges)
}

/// The colours of points or cells; empty if the piece has none.
pub(super) fn read_colors(
    attributes: &Attributes<'_>,
    count: usize,
    file: &File<'_>,
) -> Result<Vec<[f32; 3]>, TextFault> {
    let mut colors = Vec::new();
    let Some(array) = attributes.colors() else {
        return Ok(colors);
    };
    let scale = if array.is_color && array.kind != Some(Kind::U8) {
        1.0
    } else {
        255.0
    };
    let mut numbers = array.open(count.saturating_mul(array.components), file)?;
    file.budget.reserve(&mut colors, count)?;
    for _ in 0..count {
        let color = [numbers.real()?, numbers.real()?, numbers.real()?];
        numbers.skip(array.components - 3)?;
        colors.push(color.map(|channel| (channel / scale).clamp(0.0, 1.0) as f32));
    }
    Ok(colors)
}
