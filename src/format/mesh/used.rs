//! Drops what would not be shown but be framed: vertices that no triangle uses, and vertices whose coordinates are NaN or
//! too large, with the triangles and lines that use them.

use super::LoadedMesh;
use crate::{
    error::LoadError,
    format::{
        budget::{Budget, BudgetError},
        left_out::{add_to_note, counted},
    },
    scene::{TriangleMesh, is_usable},
};
use glam::Vec3;
use rayon::prelude::*;
use std::{
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
};

/// The fewest elements that are worth another thread.
const MIN_PIECE: usize = 1 << 14;

/// The mesh without vertices that no triangle uses.
#[cfg(any(feature = "gltf", feature = "threemf"))]
pub(super) fn only(mut mesh: LoadedMesh, path: &Path, budget: &Budget) -> Result<LoadedMesh, LoadError> {
    mesh.drop_unused(budget).map_err(|error| error.into_error(path))?;
    Ok(mesh)
}

/// The vertices of a file whose coordinates are NaN or too large.
#[derive(Debug)]
pub(in crate::format) struct Unusable<F> {
    /// How many vertices there are.
    pub(in crate::format) count: usize,
    /// The error about the first one, if nothing else is in the file.
    first: Option<F>,
}

impl<F> Default for Unusable<F> {
    fn default() -> Self {
        Self {
            count: 0,
            first: None,
        }
    }
}

impl<F> Unusable<F> {
    /// Keeps the first fault. The vertex is not counted.
    #[cold]
    pub(in crate::format) fn keep_first(&mut self, fault: impl FnOnce() -> F) {
        self.first.get_or_insert_with(fault);
    }

    /// Converts the fault.
    pub(in crate::format) fn map<G>(self, convert: impl FnOnce(F) -> G) -> Unusable<G> {
        Unusable {
            count: self.count,
            first: self.first.map(convert),
        }
    }
}

/// A normal, or zero, which stands for none, if it is NaN or too large; these are counted.
#[inline]
pub(in crate::format) fn usable_normal(normal: [f32; 3], odd: &mut usize) -> Vec3 {
    if normal.into_iter().all(is_usable) {
        return Vec3::from_array(normal);
    }
    *odd += 1;
    Vec3::ZERO
}

impl LoadedMesh {
    /// Drops unusable vertices, the triangles and lines that use them, and vertices that no triangle uses.
    ///
    /// # Errors
    /// The first fault if nothing remains; too little memory.
    pub(in crate::format) fn keep_used(
        &mut self,
        unusable: Unusable<LoadError>,
        path: &Path,
        budget: &Budget,
    ) -> Result<(), LoadError> {
        if let Some(first) = unusable.first {
            self.leave_out(first, unusable.count, path, budget)?;
        }
        self.drop_unused(budget).map_err(|error| error.into_error(path))
    }

    /// Drops unusable vertices, and the triangles and lines that use them, if there is an error about the first one.
    ///
    /// # Errors
    /// As [`LoadedMesh::keep_used`].
    #[cfg(any(feature = "gltf", feature = "threemf"))]
    pub(in crate::format) fn leave_out_unusable(
        &mut self,
        first: Option<LoadError>,
        path: &Path,
        budget: &Budget,
    ) -> Result<(), LoadError> {
        let Some(first) = first else { return Ok(()) };
        let points = self.arrays().flat_map(points);
        match points.filter(|&point| !has_place(point)).count() {
            0 => Ok(()),
            count => self.leave_out(first, count, path, budget),
        }
    }

    fn leave_out(
        &mut self,
        first: LoadError,
        count: usize,
        path: &Path,
        budget: &Budget,
    ) -> Result<(), LoadError> {
        let dropped = self.drop_unusable(budget);
        let dropped = dropped.map_err(|error| error.into_error(path))?;
        let has_triangles = self.arrays().any(|columns| !columns.triangles.is_empty());
        if !has_triangles && (self.cloud.is_none() || self.columns.x.is_empty()) {
            return Err(first);
        }
        self.note_unusable(count, dropped, path);
        Ok(())
    }

    /// Keeps only these points of a cloud and those of its lines, or all.
    #[cfg(feature = "vtk")]
    pub(in crate::format) fn keep_points(
        &mut self,
        points: &[u32],
        all: bool,
        budget: &Budget,
    ) -> Result<(), BudgetError> {
        let Some(cloud) = self.cloud.as_mut().filter(|_| !all) else {
            return Ok(());
        };
        let mut used: Vec<bool> = Vec::new();
        budget.reserve(&mut used, self.columns.x.len())?;
        used.resize(self.columns.x.len(), false);
        for &point in points.iter().chain(cloud.lines.as_flattened()) {
            if let Some(used) = used.get_mut(point as usize) {
                *used = true;
            }
        }
        keep(&mut self.columns, cloud.lines.as_flattened_mut(), &used, budget)?;
        budget.give_back(used.capacity());
        Ok(())
    }

    /// Drops the vertices that no triangle uses from each mesh that has triangles.
    pub(in crate::format) fn drop_unused(&mut self, budget: &Budget) -> Result<(), BudgetError> {
        self.arrays_mut()
            .filter(|columns| !columns.triangles.is_empty())
            .try_for_each(|columns| drop_unused(columns, budget))
    }

    /// Drops the unusable points of a cloud and the lines that end there, or the triangles with unusable corners. Returns the
    /// number of lines or triangles dropped.
    fn drop_unusable(&mut self, budget: &Budget) -> Result<usize, BudgetError> {
        if let Some(cloud) = &mut self.cloud {
            let usable = usable_vertices(&self.columns, budget)?;
            let before = cloud.lines.len();
            cloud
                .lines
                .retain(|ends| ends.iter().all(|&end| is_in(&usable, end)));
            let lines = cloud.lines.as_flattened_mut();
            let dropped = before - lines.len() / 2;
            keep(&mut self.columns, lines, &usable, budget)?;
            budget.give_back(usable.capacity());
            return Ok(dropped);
        }
        let of_faces = &mut self.scalars.of_faces;
        let mut dropped = drop_triangles(&mut self.columns, &mut self.surface_of, of_faces, budget)?;
        for part in &mut self.shared {
            dropped += drop_triangles(&mut part.columns, &mut part.surface_of, &mut Vec::new(), budget)?;
        }
        self.shared.retain(|part| !part.columns.triangles.is_empty());
        Ok(dropped)
    }

    /// Adds what was dropped to the note "left out".
    fn note_unusable(&mut self, vertices: usize, dropped: usize, path: &Path) {
        let [one, many, user, users] = match &self.cloud {
            None => ["vertex", "vertices", "triangle", "triangles"],
            Some(cloud) if cloud.lines.is_empty() && dropped == 0 => ["point", "points", "", ""],
            Some(_) => ["vertex", "vertices", "line", "lines"],
        };
        let are = if vertices == 1 {
            "that is NaN or too large"
        } else {
            "that are NaN or too large"
        };
        let mut what = format!("{} {are}", counted(vertices, one, many));
        if dropped > 0 {
            let (use_it, it) = (
                if dropped == 1 { "uses" } else { "use" },
                if vertices == 1 { "it" } else { "them" },
            );
            what += &format!(", {} that {use_it} {it}", counted(dropped, user, users));
        }
        add_to_note(&mut self.notes, path, &what);
    }
}

fn points(columns: &TriangleMesh) -> impl Iterator<Item = [f32; 3]> {
    let TriangleMesh { x, y, z, .. } = columns;
    x.iter().zip(y).zip(z).map(|((&x, &y), &z)| [x, y, z])
}

fn has_place(point: [f32; 3]) -> bool {
    point.into_iter().all(is_usable)
}

/// Which vertices are usable.
fn usable_vertices(columns: &TriangleMesh, budget: &Budget) -> Result<Vec<bool>, BudgetError> {
    let mut usable: Vec<bool> = Vec::new();
    budget.reserve(&mut usable, columns.x.len())?;
    usable.extend(points(columns).map(has_place));
    Ok(usable)
}

fn is_in(usable: &[bool], vertex: u32) -> bool {
    usable.get(vertex as usize).is_some_and(|&usable| usable)
}

/// Drops the triangles with unusable corners, and all vertices if no triangle is left. Returns the number of triangles
/// dropped.
fn drop_triangles(
    columns: &mut TriangleMesh,
    surface_of: &mut Vec<u32>,
    values: &mut Vec<f64>,
    budget: &Budget,
) -> Result<usize, BudgetError> {
    let usable = usable_vertices(columns, budget)?;
    let stays = |corners: &[u32; 3]| corners.iter().all(|&corner| is_in(&usable, corner));
    let triangles = &mut columns.triangles;
    let before = triangles.len();
    let mut all = triangles.iter();
    surface_of.retain(|_| all.next().is_none_or(stays));
    let mut all = triangles.iter();
    values.retain(|_| all.next().is_none_or(stays));
    triangles.retain(stays);
    let dropped = before - triangles.len();
    budget.give_back(usable.capacity());
    if triangles.is_empty() {
        *columns = TriangleMesh::default();
    }
    Ok(dropped)
}

/// Drops the vertices that no triangle uses. Mostly all are used: then this is one pass over the triangles.
fn drop_unused(columns: &mut TriangleMesh, budget: &Budget) -> Result<(), BudgetError> {
    let mut used: Vec<AtomicBool> = Vec::new();
    budget.reserve(&mut used, columns.x.len())?;
    used.resize_with(columns.x.len(), AtomicBool::default);
    let triangles = columns.triangles.par_iter().with_min_len(MIN_PIECE);
    triangles.for_each(|corners| {
        for &corner in corners {
            // Nearly all are marked already; threads would take each other's cache lines.
            if let Some(mark) = used.get(corner as usize)
                && !mark.load(Ordering::Relaxed)
            {
                mark.store(true, Ordering::Relaxed);
            }
        }
    });
    let used: Vec<bool> = used.into_iter().map(AtomicBool::into_inner).collect();
    if used.contains(&false) {
        let mut triangles = std::mem::take(&mut columns.triangles);
        keep(columns, triangles.as_flattened_mut(), &used, budget)?;
        columns.triangles = triangles;
    }
    budget.give_back(used.capacity());
    Ok(())
}

/// Keeps these vertices of a mesh, in their order, and renumbers `indices`.
fn keep(
    columns: &mut TriangleMesh,
    indices: &mut [u32],
    kept: &[bool],
    budget: &Budget,
) -> Result<(), BudgetError> {
    let mut numbers: Vec<u32> = Vec::new();
    budget.reserve(&mut numbers, kept.len())?;
    let mut next = 0;
    numbers.extend(kept.iter().map(|&kept| {
        next += u32::from(kept);
        next - u32::from(kept)
    }));
    let pieces = indices.par_iter_mut().with_min_len(MIN_PIECE);
    pieces.for_each(|index| *index = numbers.get(*index as usize).copied().unwrap_or(*index));
    budget.give_back(numbers.capacity() * size_of::<u32>());
    drop(numbers);
    let TriangleMesh {
        x,
        y,
        z,
        normals,
        colors,
        uvs,
        tangents,
        triangles: _,
    } = columns;
    for column in [x, y, z] {
        keep_elements(column, kept);
    }
    keep_elements(normals, kept);
    keep_elements(colors, kept);
    keep_elements(uvs, kept);
    keep_elements(tangents, kept);
    Ok(())
}

fn keep_elements<T>(column: &mut Vec<T>, kept: &[bool]) {
    let mut kept = kept.iter();
    column.retain(|_| kept.next().is_none_or(|&kept| kept));
}

#[cfg(test)]
mod tests;
