//! Cells of a piece: their types, faces, numbers and colours.

use super::{
    array::File,
    cells::{Cells, Polyhedra, faces_of},
    outer::{Excess, Faces},
    shapes::{HEXAHEDRON, Shape, VOXEL},
};
use crate::{
    error::LoadErrorKind,
    format::{budget::Budget, mesh::channels, place::TextFault},
};

/// The bit of marks of cells that are left out: those beside them have an outer face there.
pub(super) const HIDDEN: u8 = 32;

/// What cells of a piece show.
pub(super) enum Paint {
    Nothing,
    Values(Vec<f64>),
    Colors(Vec<[f32; 3]>),
}

impl Paint {
    /// What a cell gives to its points.
    pub(super) fn color(&self, cell: usize) -> Option<[f32; 3]> {
        match self {
            Self::Nothing => None,
            Self::Values(values) => values.get(cell).map(|&value| channels(value)),
            Self::Colors(colors) => colors.get(cell).copied(),
        }
    }

    /// Frees the numbers or colours.
    pub(super) fn give_back(self, budget: &Budget) {
        budget.give_back(match self {
            Self::Nothing => 0,
            Self::Values(values) => values.capacity() * size_of::<f64>(),
            Self::Colors(colors) => colors.capacity() * size_of::<[f32; 3]>(),
        });
    }
}

/// Cells of a piece.
pub(super) struct Group<'g, 'a> {
    pub(super) cells: &'g Cells<'a>,
    /// The type of each, or of all.
    pub(super) types: Vec<u8>,
    pub(super) polyhedra: Option<&'g Polyhedra<'a>>,
    pub(super) points: usize,
    /// The number of cells before these.
    pub(super) first: usize,
    pub(super) paint: &'g Paint,
    pub(super) ghosts: &'g [u8],
}

impl Group<'_, '_> {
    pub(super) fn cell(&self, i: usize) -> u8 {
        let each = self.types.get(i).or(self.types.first());
        each.copied().unwrap_or_default()
    }

    /// The marks of a cell that is not shown, otherwise 0.
    pub(super) fn ghost(&self, i: usize) -> u8 {
        self.ghosts.get(self.first + i).copied().unwrap_or_default()
    }

    /// The numbers of the faces that belong to one body only.
    pub(super) fn outer(&self, file: &File<'_>) -> Result<Vec<u32>, TextFault> {
        let has_bodies = self
            .types
            .iter()
            .any(|&cell| Shape::of(cell).is_some_and(Shape::is_body));
        if !has_bodies {
            return Ok(Vec::new());
        }
        let mut faces = Faces::default();
        let mut reader = self.cells.read(self.polyhedra, file)?;
        for i in 0..self.cells.count {
            let cell = self.cell(i);
            let points = reader.next(cell, self.points)?;
            if let Some(shape) = Shape::of(cell).filter(|shape| shape.is_body())
                && points.len() >= shape.least()
                && self.ghost(i) & HIDDEN == 0
            {
                let added = each_face(shape, points, |corners, _| faces.add(corners, file.budget));
                added.map_err(|excess| match excess {
                    Excess::Memory(error) => error.into(),
                    Excess::TooMany => {
                        let message = format!("the cells have more than {} faces", u32::MAX);
                        TextFault::of_file(message).with_kind(LoadErrorKind::Limit)
                    }
                })?;
            }
        }
        Ok(faces.outer(file.budget)?)
    }
}

/// Visits the faces of a body: the corners of each, and the points in the middle of its sides, if there are some. Corners that
/// repeat the next one are left out, so that collapsed faces equal those of other bodies; lines are no faces.
pub(super) fn each_face<E>(
    shape: Shape,
    points: &[u32],
    mut visit: impl FnMut(&[u32], &[u32]) -> Result<(), E>,
) -> Result<(), E> {
    let ordered: [u32; 8];
    let (body, is_curved, points) = match shape {
        Shape::Solid { body, is_curved } => (body, is_curved, points),
        Shape::Voxel => {
            ordered = VOXEL.map(|i| points[i]);
            (&HEXAHEDRON, false, &ordered[..])
        }
        _ => {
            let faces = faces_of(points);
            return faces
                .filter(|face| face.len() > 2)
                .try_for_each(|face| visit(face, &[]));
        }
    };
    for face in body.faces {
        let (mut corners, mut middles) = ([0; 6], [0; 6]);
        let mut count = 0;
        for (i, &corner) in face.iter().enumerate() {
            let next = face[(i + 1) % face.len()];
            if points[corner as usize] == points[next as usize] {
                continue;
            }
            corners[count] = points[corner as usize];
            let edge = |edge: &[u8; 2]| *edge == [corner, next] || *edge == [next, corner];
            if is_curved && let Some(edge) = body.edges.iter().position(edge) {
                middles[count] = points[body.corners + edge];
            }
            count += 1;
        }
        let middles = if is_curved { &middles[..count] } else { &[] };
        if count > 2 {
            visit(&corners[..count], middles)?;
        }
    }
    Ok(())
}
