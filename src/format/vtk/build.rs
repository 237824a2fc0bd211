//! Makes a mesh of pieces.

use super::{
    Piece,
    array::File,
    cells::{Types, faces_of},
    data::{Chosen, read_colors},
    group::{Group, HIDDEN, Paint, each_face},
    shapes::Shape,
};
use crate::{
    error::{LoadErrorKind, SceneError},
    format::{
        budget::{Budget, BudgetError},
        mesh::{Owner, Unusable, channels, usable_normal},
        place::TextFault,
        polygon::Fans,
    },
    scene::{TriangleMesh, is_usable},
};
use glam::DVec3;
use std::collections::BTreeMap;

/// Bits of marks of cells that another piece shows, or that nothing shows.
const NOT_SHOWN: u8 = 1 | 8 | HIDDEN;

/// The mesh so far.
pub(super) struct Build<'a, 'f> {
    file: &'f File<'a>,
    budget: &'a Budget,
    /// Numbers that are shown instead of colours.
    chosen: Option<Chosen>,
    pub(super) columns: TriangleMesh,
    pub(super) fans: Fans,
    pub(super) lines: Vec<[u32; 2]>,
    /// Points that are cells.
    pub(super) dots: Vec<u32>,
    /// The number or the colour of each triangle, if cells have some.
    pub(super) values: Vec<f64>,
    pub(super) colors: Vec<[f32; 3]>,
    /// Whether colours of points may be those of their cells.
    pub(super) has_cell_colors: bool,
    pub(super) unusable: Unusable<TextFault>,
    pub(super) odd_normals: usize,
    pub(super) cells: usize,
    /// Cells with too few points, and others that are not shown, by type.
    pub(super) small: usize,
    pub(super) unknown: BTreeMap<u8, usize>,
    /// The first point of the piece.
    base: u32,
}

impl<'a, 'f> Build<'a, 'f> {
    pub(super) fn new(file: &'f File<'a>, chosen: Option<Chosen>) -> Self {
        Self {
            file,
            budget: file.budget,
            chosen,
            columns: TriangleMesh::default(),
            fans: Fans::default(),
            lines: Vec::new(),
            dots: Vec::new(),
            values: Vec::new(),
            colors: Vec::new(),
            has_cell_colors: false,
            unusable: Unusable::default(),
            odd_normals: 0,
            cells: 0,
            small: 0,
            unknown: BTreeMap::new(),
            base: 0,
        }
    }

    /// Adds a piece. `colors` is what has colours in the file.
    pub(super) fn add(&mut self, piece: &Piece<'a>, colors: Option<Owner>) -> Result<(), TextFault> {
        self.base = self.columns.x.len() as u32;
        self.positions(piece)?;
        self.normals(piece)?;
        self.point_colors(piece, colors)?;
        let count = piece.cells();
        let paint = self.paint(piece, count, colors)?;
        let ghosts = self.ghosts(piece, count)?;
        let mut first = 0;
        for (cells, types) in &piece.groups {
            let group = Group {
                cells,
                types: self.types(types, cells.count)?,
                polyhedra: piece.polyhedra.as_ref(),
                points: piece.points,
                first,
                paint: &paint,
                ghosts: &ghosts,
            };
            self.group(&group)?;
            self.budget.give_back(group.types.capacity());
            first += cells.count;
        }
        self.cells += count;
        self.budget.give_back(ghosts.capacity());
        paint.give_back(self.budget);
        Ok(())
    }

    fn positions(&mut self, piece: &Piece<'a>) -> Result<(), TextFault> {
        let Some(points) = &piece.coordinates else {
            let message = format!("a piece has {} points, but no array of points", piece.points);
            return Err(TextFault::of_file(message));
        };
        if points.components != 3 {
            let message = format!("points have {} coordinates, expected 3", points.components);
            return Err(points.fault(message));
        }
        if self.columns.x.len().saturating_add(piece.points) > u32::MAX as usize {
            let message = format!("more than {} points", u32::MAX);
            return Err(points.fault(message).with_kind(LoadErrorKind::Limit));
        }
        let mut numbers = points.open(piece.points.saturating_mul(3), self.file)?;
        if numbers.is_single() {
            self.budget.add_single_reach(f32::MAX);
        }
        let columns = &mut self.columns;
        for column in [&mut columns.x, &mut columns.y, &mut columns.z] {
            self.budget.reserve(column, piece.points)?;
        }
        let offset = self.budget.offset();
        for _ in 0..piece.points {
            let mut is_point = true;
            let axes = [&mut columns.x, &mut columns.y, &mut columns.z];
            for (axis, column) in axes.into_iter().enumerate() {
                let value = numbers.next_as(
                    |word| offset.parse(axis, word),
                    |value| offset.relative(axis, value),
                )?;
                if !is_usable(value) {
                    is_point = false;
                    let what = ["x", "y", "z"][axis];
                    self.unusable
                        .keep_first(|| numbers.fault(SceneError::NotUsable { what, value }.to_string()));
                }
                column.push(value);
            }
            self.unusable.count += usize::from(!is_point);
        }
        Ok(())
    }

    fn normals(&mut self, piece: &Piece<'a>) -> Result<(), TextFault> {
        let Some(normals) = piece.of_points.normals() else {
            return Ok(());
        };
        let mut numbers = normals.open(piece.points.saturating_mul(3), self.file)?;
        self.budget.reserve(&mut self.columns.normals, piece.points)?;
        for _ in 0..piece.points {
            let normal = [numbers.real()?, numbers.real()?, numbers.real()?].map(|value| value as f32);
            self.columns
                .normals
                .push(usable_normal(normal, &mut self.odd_normals));
        }
        Ok(())
    }

    /// Reads numbers or colours of points, and pads them before those of the piece.
    fn point_colors(&mut self, piece: &Piece<'a>, colors: Option<Owner>) -> Result<(), TextFault> {
        let all = self.columns.x.len();
        if let Some(chosen) = self
            .chosen
            .as_ref()
            .filter(|chosen| chosen.owner == Owner::Vertices)
        {
            let values = chosen.values(&piece.of_points, piece.points, self.file)?;
            self.budget.reserve(&mut self.columns.colors, values.len())?;
            self.columns
                .colors
                .extend(values.iter().map(|&value| channels(value)));
            self.budget.give_back(values.capacity() * size_of::<f64>());
        } else if colors == Some(Owner::Vertices) {
            let read = read_colors(&piece.of_points, piece.points, self.file)?;
            let missing = all - self.columns.colors.len();
            self.budget.reserve(&mut self.columns.colors, missing)?;
            self.columns.colors.extend_from_slice(&read);
            self.columns.colors.resize(all, [1.0; 3]);
            self.budget.give_back(read.capacity() * size_of::<[f32; 3]>());
        }
        Ok(())
    }

    /// What the cells of a piece show.
    fn paint(&self, piece: &Piece<'a>, count: usize, colors: Option<Owner>) -> Result<Paint, TextFault> {
        if count == 0 {
            return Ok(Paint::Nothing);
        }
        if let Some(chosen) = self.chosen.as_ref().filter(|chosen| chosen.owner == Owner::Faces) {
            return chosen
                .values(&piece.of_cells, count, self.file)
                .map(Paint::Values);
        }
        if colors == Some(Owner::Faces) {
            let mut read = read_colors(&piece.of_cells, count, self.file)?;
            let missing = count - read.len();
            self.budget.reserve(&mut read, missing)?;
            read.resize(count, [1.0; 3]);
            return Ok(Paint::Colors(read));
        }
        Ok(Paint::Nothing)
    }

    /// Which cells are not shown: other than 0. Empty if all are.
    fn ghosts(&self, piece: &Piece<'a>, count: usize) -> Result<Vec<u8>, TextFault> {
        let mut ghosts = Vec::new();
        if let Some(array) = piece.of_cells.ghosts().filter(|array| array.components == 1) {
            let mut numbers = array.open(count, self.file)?;
            self.budget.reserve(&mut ghosts, count)?;
            for _ in 0..count {
                ghosts.push(numbers.index(256, "the mark of a cell is")? as u8 & NOT_SHOWN);
            }
        }
        Ok(ghosts)
    }

    fn types(&self, types: &Types<'a>, count: usize) -> Result<Vec<u8>, TextFault> {
        let mut all = Vec::new();
        match types {
            Types::All(cell) => {
                self.budget.reserve(&mut all, 1)?;
                all.push(*cell);
            }
            Types::Each(array) => {
                let mut numbers = array.open(count, self.file)?;
                self.budget.reserve(&mut all, count)?;
                for _ in 0..count {
                    all.push(numbers.index(256, "the type of a cell is")? as u8);
                }
            }
        }
        Ok(all)
    }

    fn group(&mut self, group: &Group<'_, 'a>) -> Result<(), TextFault> {
        let outer = group.outer(self.file)?;
        let mut next_outer = outer.iter().copied().peekable();
        let mut number = 0;
        let mut reader = group.cells.read(group.polyhedra, self.file)?;
        for i in 0..group.cells.count {
            let cell = group.cell(i);
            let points = reader.next(cell, group.points)?;
            if group.ghost(i) & HIDDEN != 0 {
                continue;
            }
            let Some(shape) = Shape::of(cell) else {
                *self.unknown.entry(cell).or_default() += 1;
                continue;
            };
            if points.len() < shape.least() {
                self.small += 1;
                continue;
            }
            let is_shown = group.ghost(i) == 0;
            let before = self.columns.triangles.len();
            if shape.is_body() {
                let center = self.center(shape, points);
                each_face(shape, points, |corners, middles| {
                    let is_outer = next_outer.next_if_eq(&number).is_some();
                    number += 1;
                    if is_outer && is_shown {
                        self.face(corners, middles, center)?;
                    }
                    Ok::<(), BudgetError>(())
                })?;
            } else if is_shown {
                let color = group.paint.color(group.first + i);
                self.surface(shape, points, color)?;
            }
            self.paint_from(before, group.paint, group.first + i)?;
        }
        self.budget.give_back(outer.capacity() * size_of::<u32>());
        Ok(())
    }

    /// Gives the triangles from `before` on the number or colour of their cell.
    fn paint_from(&mut self, before: usize, paint: &Paint, cell: usize) -> Result<(), BudgetError> {
        let all = self.columns.triangles.len();
        match paint {
            Paint::Values(values) if before < all => {
                let missing = all - self.values.len();
                self.budget.reserve(&mut self.values, missing)?;
                self.values
                    .resize(all, values.get(cell).copied().unwrap_or(f64::NAN));
            }
            Paint::Colors(colors) if before < all => {
                let missing = all - self.colors.len();
                self.budget.reserve(&mut self.colors, missing)?;
                self.colors
                    .resize(all, colors.get(cell).copied().unwrap_or([1.0; 3]));
            }
            _ => {}
        }
        Ok(())
    }

    /// The mean of a body's corners.
    fn center(&self, shape: Shape, points: &[u32]) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0);
        if let Shape::Polyhedron = shape {
            for point in faces_of(points).flatten() {
                sum += self.position(*point);
                count += 1;
            }
        } else {
            for point in points.get(..shape.least()).unwrap_or(points) {
                sum += self.position(*point);
                count += 1;
            }
        }
        sum / f64::from(count.max(1))
    }

    fn position(&self, point: u32) -> DVec3 {
        let at = (self.base + point) as usize;
        let [x, y, z] = [&self.columns.x, &self.columns.y, &self.columns.z]
            .map(|column| column.get(at).copied().unwrap_or_default());
        DVec3::new(x.into(), y.into(), z.into())
    }

    /// Adds an outer face of a body, which faces away from its centre.
    fn face(&mut self, corners: &[u32], middles: &[u32], center: DVec3) -> Result<(), BudgetError> {
        let first = self.position(corners[0]);
        let sides = corners.windows(2).skip(1);
        let normal: DVec3 = sides
            .map(|pair| (self.position(pair[0]) - first).cross(self.position(pair[1]) - first))
            .sum();
        let middle =
            corners.iter().map(|&corner| self.position(corner)).sum::<DVec3>() / corners.len() as f64;
        if normal.dot(middle - center) >= 0.0 {
            return self.polygon(corners, middles);
        }
        let turned = |points: &[u32]| points.iter().rev().copied().collect::<Vec<u32>>();
        let mut between = turned(middles);
        // The middle after the last corner stays so.
        if !between.is_empty() {
            between.rotate_left(1);
        }
        self.polygon(&turned(corners), &between)
    }

    /// Adds a polygon with these corners, and perhaps points in the middle of its sides.
    fn polygon(&mut self, corners: &[u32], middles: &[u32]) -> Result<(), BudgetError> {
        if middles.is_empty() {
            let triangles = corners.len().saturating_sub(2);
            self.budget.reserve(&mut self.columns.triangles, triangles)?;
            self.fans
                .add(self.columns.triangles.len(), triangles, 1, self.budget)?;
            let base = self.base;
            if let [first, others @ ..] = corners {
                let fan = others
                    .windows(2)
                    .map(|pair| [first + base, pair[0] + base, pair[1] + base]);
                self.columns.triangles.extend(fan);
            }
            return Ok(());
        }
        self.budget.reserve(&mut self.columns.triangles, corners.len())?;
        let last = middles.last().copied().unwrap_or_default();
        let before = std::iter::once(last).chain(middles.iter().copied());
        for ((&corner, &after), before) in corners.iter().zip(middles).zip(before) {
            self.columns
                .triangles
                .push([corner, after, before].map(|point| point + self.base));
        }
        self.polygon(middles, &[])
    }

    /// Adds a cell that is no body. Points and lines get its colour, unless they have one.
    fn surface(&mut self, shape: Shape, points: &[u32], color: Option<[f32; 3]>) -> Result<(), BudgetError> {
        let half = points.len() / 2;
        match shape {
            Shape::Points => {
                self.budget.reserve(&mut self.dots, points.len())?;
                self.dots.extend(points.iter().map(|point| point + self.base));
                return self.color_points(points, color);
            }
            Shape::Lines => {
                points
                    .windows(2)
                    .try_for_each(|pair| self.line([pair[0], pair[1]]))?;
                return self.color_points(points, color);
            }
            Shape::Curve => {
                let ends = [&points[..1], &points[2..], &points[1..2]];
                let points = ends.concat();
                points
                    .windows(2)
                    .try_for_each(|pair| self.line([pair[0], pair[1]]))?;
                return self.color_points(&points, color);
            }
            Shape::Strip => {
                for (i, corners) in points.windows(3).enumerate() {
                    let [a, b, c] = [corners[0], corners[1], corners[2]];
                    self.polygon(&if i % 2 == 0 { [a, b, c] } else { [b, a, c] }, &[])?;
                }
            }
            Shape::Pixel => self.polygon(&[points[0], points[1], points[3], points[2]], &[])?,
            Shape::Polygon => self.polygon(points, &[])?,
            Shape::Corners(count) => self.polygon(&points[..count], &[])?,
            Shape::Curved(count) => self.polygon(&points[..count], &points[count..2 * count])?,
            Shape::CurvedPolygon => self.polygon(&points[..half], &points[half..2 * half])?,
            Shape::Nothing | Shape::Solid { .. } | Shape::Voxel | Shape::Polyhedron => {}
        }
        Ok(())
    }

    fn line(&mut self, ends: [u32; 2]) -> Result<(), BudgetError> {
        self.budget.reserve(&mut self.lines, 1)?;
        self.lines.push(ends.map(|end| end + self.base));
        Ok(())
    }

    /// Gives points the colour or number of their cell.
    fn color_points(&mut self, points: &[u32], color: Option<[f32; 3]>) -> Result<(), BudgetError> {
        let Some(color) = color else { return Ok(()) };
        let (all, colors) = (self.columns.x.len(), &mut self.columns.colors);
        let none = if self.chosen.is_some() {
            channels(f64::NAN)
        } else {
            [1.0; 3]
        };
        self.has_cell_colors = true;
        self.budget.reserve(colors, all - colors.len())?;
        colors.resize(all, none);
        for &point in points {
            if let Some(place) = colors.get_mut((point + self.base) as usize) {
                *place = color;
            }
        }
        Ok(())
    }
}
