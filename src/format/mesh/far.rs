//! Meshes far from 0, such as those in the coordinates of a map: `f32` would round them in steps that show.
//!
//! ```text
//! read as f32 ── are the bounds coarse?
//!                  no, nearly always: done
//!                  yes: free the arrays, read again in f64 relative to an offset ── is any point finer than f32?
//!                                                                                     yes: done
//!                                                                                     no: move back, as read at first
//! ```

use super::{
    super::{budget::Budget, offset::Offset},
    LoadedMesh, Scalars, stray,
};
use crate::{
    error::{LoadError, clip_path},
    math::Aabb,
    scene::{Image, PlacedMesh, Transform, TriangleMesh, origin_of},
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::path::Path;

/// The least number of steps of coordinates along a mesh: with fewer, smooth surfaces look like stairs.
const LEAST_STEPS: f32 = 4000.0;

/// How often longer than the middle half of its vertices a mesh must be for the rest to be outliers, such as a vertex at 0
/// among map coordinates.
const OUTLYING: f32 = 64.0;

/// How many vertices show where the middle half is.
const SAMPLE: usize = 4096;

/// The fewest coordinates that are worth another thread.
const MIN_PIECE: usize = 1 << 14;

/// Coordinates so far from 0 for their extent that `f32` is coarse.
pub(crate) struct Coarse {
    /// The largest coordinate.
    #[cfg_attr(not(feature = "cli"), allow(dead_code, reason = "only the program warns"))]
    pub(crate) far: f32,
    /// The distance between two neighbouring values of `f32` there.
    pub(crate) step: f32,
    /// The longest side of the box.
    pub(crate) size: f32,
}

impl Coarse {
    /// Returns `None` if `f32` is fine enough for everything in these bounds.
    pub(crate) fn of(bounds: &Aabb) -> Option<Self> {
        let size = (bounds.upper - bounds.lower).max_element();
        let far = bounds.upper.abs().max(bounds.lower.abs()).max_element();
        let step = step_at(far);
        (size >= 0.0 && step * LEAST_STEPS > size).then_some(Self { far, step, size })
    }
}

/// The distance between two neighbouring values of `f32`.
fn step_at(value: f32) -> f32 {
    (value.next_up() - value).min(f32::MAX)
}

/// Reads a mesh, and again relative to an offset if its coordinates are coarse and its file may have finer ones. Stray vertices
/// are noted.
pub(in crate::format) fn read(
    budget: &Budget,
    path: &Path,
    mut read: impl FnMut() -> Result<LoadedMesh, LoadError>,
) -> Result<LoadedMesh, LoadError> {
    let before = budget.taken();
    let mut first = read()?;
    let bounds = PlacedMesh::bounds(&first.placed());
    let middle = middle_half(&first.columns);
    let stray = middle.and_then(|middle| stray::note(&first, &bounds, &middle));
    first
        .notes
        .extend(stray.map(|note| format!("{}: {note}", clip_path(path))));
    let Some(offset) = offset_of(&first, (bounds, middle), budget.single_reach()) else {
        return Ok(first);
    };
    // Its surfaces, images and notes stay; its arrays are freed before others are made.
    first.columns = TriangleMesh::default();
    (first.shared, first.surface_of, first.cloud) = Default::default();
    first.scalars = Scalars::default();
    budget.give_back_to(before);
    let images = first.images.iter().map(|image| Image::bytes(image.size()));
    // They were within the budget.
    let _ = budget.take(images.sum());
    if !first.images.is_empty() {
        budget.set_wants_images(false);
    }
    budget.set_offset(Offset::new(offset));
    let mut mesh = LoadedMesh {
        surfaces: first.surfaces,
        images: first.images,
        notes: first.notes,
        texture_files: first.texture_files,
        offset,
        ..read()?
    };
    if !mesh.is_finer_than_single() {
        mesh.move_offset(DVec3::ZERO);
    }
    Ok(mesh)
}

/// The offset of a coarse mesh: the middle of its box, without outliers, on each axis on which the box is far from 0. `None`
/// if the mesh is fine, or if coordinates that its file has as `f32` reach so far (`single_reach`) that they are coarse
/// themselves.
fn offset_of(
    mesh: &LoadedMesh,
    (mut bounds, middle): (Aabb, Option<Aabb>),
    single_reach: f32,
) -> Option<DVec3> {
    if let Some(middle) = middle
        && (bounds.upper - bounds.lower).max_element()
            > OUTLYING * (middle.upper - middle.lower).max_element()
    {
        bounds = middle;
    }
    // Coinciding points of a cloud are left alone; a mesh without extent may have been rounded to a point.
    let is_point = |coarse: &Coarse| coarse.size == 0.0 && mesh.cloud.is_some();
    let coarse = Coarse::of(&bounds).filter(|coarse| !is_point(coarse))?;
    let own = step_at(single_reach);
    if own >= coarse.step || own * LEAST_STEPS > coarse.size && coarse.size > 0.0 {
        return None;
    }
    Some(origin_of(bounds).as_dvec3()).filter(|offset| *offset != DVec3::ZERO)
}

/// The box of the middle half of the vertices on each axis. `None` if there are no vertices, or most have one place.
fn middle_half(mesh: &TriangleMesh) -> Option<Aabb> {
    let step = mesh.x.len().div_ceil(SAMPLE).max(1);
    let ends = [&mesh.x, &mesh.y, &mesh.z].map(|column| {
        let mut values: Vec<f32> = column.iter().step_by(step).copied().collect();
        values.sort_unstable_by(f32::total_cmp);
        let at = |i: usize| values.get(i).copied().unwrap_or_default();
        [at(values.len() / 4), at(values.len() * 3 / 4)]
    });
    let corner = |end: usize| Vec3::from(ends.map(|ends| ends[end]));
    let (lower, upper) = (corner(0), corner(1));
    (upper != lower).then_some(Aabb { lower, upper })
}

impl LoadedMesh {
    /// Makes the coordinates relative to another offset, and rounds them to `f32`: with 0 they are those of the file. Cameras
    /// have the file's coordinates always.
    pub fn move_offset(&mut self, offset: DVec3) {
        let by = self.offset - offset;
        self.offset = offset;
        if by == DVec3::ZERO {
            return;
        }
        let columns = [&mut self.columns.x, &mut self.columns.y, &mut self.columns.z];
        for (column, by) in columns.into_iter().zip(by.to_array()) {
            let values = column.par_iter_mut().with_min_len(MIN_PIECE);
            values.for_each(|value| *value = (f64::from(*value) + by) as f32);
        }
        for placement in self.shared.iter_mut().flat_map(|part| &mut part.placements) {
            *placement = placement.then_translate(by);
        }
        let moved = Transform::IDENTITY.then_translate(by);
        for light in self
            .lights
            .iter_mut()
            .filter(|light| light.shape.position().is_some())
        {
            *light = moved.light(light).unwrap_or(*light);
        }
    }

    /// Whether any point, in the file's coordinates, is between two neighbouring values of `f32`. Many programs write text
    /// and doubles, but compute with `f32`.
    fn is_finer_than_single(&self) -> bool {
        PlacedMesh::any(&self.placed(), |point| {
            let point = point.as_dvec3() + self.offset;
            point.as_vec3().as_dvec3() != point
        })
    }
}

#[cfg(test)]
mod tests;
