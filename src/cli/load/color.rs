//! Shows numbers of a mesh as colours.

use super::input::failed;
use crate::{
    cli::{
        CliError,
        plan::{COLORS, ColorBy, Shading, color_of},
    },
    error::SceneError,
    format::mesh::{LoadedMesh, Owner, Range, Surface, channels, value_of},
    scene::{PlacedMesh, TriangleMesh, check_memory},
};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// The colour of what has no finite number.
const GREY: [f32; 3] = [128.0 / 255.0; 3];

/// The fewest numbers that are worth another thread.
const MIN_PIECE: usize = 1 << 14;

/// What colours mean in a picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Legend {
    /// The property, or the coordinate.
    pub name: String,
    /// `vertices` or `faces`.
    pub of: &'static str,
    pub map: &'static str,
    /// The numbers with the first and the last colour; `None` if no number is finite.
    pub low: Option<f64>,
    pub high: Option<f64>,
}

/// Gives a mesh the colours of its numbers, instead of all others, and the finish of a `surface`, which is white. The range of
/// coordinates is that of `framed` if there is more than this pose.
///
/// # Errors
/// [`CliError`] if the colours take more than `memory` bytes.
pub(super) fn color(
    loaded: &mut LoadedMesh,
    framed: Option<&LoadedMesh>,
    by: &ColorBy,
    surface: Surface,
    (path, memory): (&Path, u64),
) -> Result<Option<Legend>, CliError> {
    let Some(name) = by.values.name() else {
        return Ok(None);
    };
    let of_faces = std::mem::take(&mut loaded.scalars.of_faces);
    check_room(loaded, of_faces.is_empty(), memory).map_err(|error| failed(path, &error))?;
    let found = match by.values {
        Shading::Coordinate(axis) => put_coordinates(loaded, framed, axis),
        _ if of_faces.is_empty() => loaded.arrays().map(range_of).fold(Range::default(), Range::and),
        _ => Range::of(of_faces.iter().copied()),
    };
    let range = by.range.or(found.0);
    let place = |value| color_of(value, range.unwrap_or_default());
    let colors = by.map.colors();
    let owner = if of_faces.is_empty() {
        for columns in loaded.arrays_mut() {
            let all = columns.colors.par_iter_mut().with_min_len(MIN_PIECE);
            all.for_each(|color| *color = place(value_of(*color)).map_or(GREY, |i| colors[i]));
        }
        loaded.show_only_colors(surface);
        Owner::Vertices
    } else {
        loaded.paint(surface);
        let shown = colors.into_iter().chain([GREY]);
        loaded.surfaces = shown.map(|diffuse| Surface { diffuse, ..surface }).collect();
        let places = of_faces
            .into_iter()
            .map(|value| place(value).unwrap_or(COLORS) as u32);
        loaded.surface_of = places.collect();
        Owner::Faces
    };
    Ok(Some(Legend {
        name: name.to_owned(),
        of: owner.name(),
        map: by.map.name(),
        low: range.map(|[low, _]| low),
        high: range.map(|[_, high]| high),
    }))
}

/// Checks that the mesh fits into `memory` bytes if each vertex gets a colour, or none does.
fn check_room(loaded: &LoadedMesh, has_colors: bool, memory: u64) -> Result<(), SceneError> {
    let (mut triangles, mut vectors) = (0, 0);
    for columns in loaded.arrays() {
        triangles += columns.triangles.len();
        vectors += columns.x.len() + columns.normals.len();
        vectors += if has_colors { columns.x.len() } else { 0 };
    }
    check_memory([triangles, 0, vectors], 0, memory)
}

/// Puts a coordinate of each vertex, in the file's own, in the place of its colour. Returns their range.
fn put_coordinates(loaded: &mut LoadedMesh, framed: Option<&LoadedMesh>, axis: usize) -> Range {
    let bounds = PlacedMesh::bounds(&framed.unwrap_or(loaded).placed());
    let offset = loaded.offset[axis];
    for columns in loaded.arrays_mut() {
        let values = [&columns.x, &columns.y, &columns.z][axis].par_iter();
        let value = |&value: &f32| channels(f64::from(value) + offset);
        columns.colors = values.with_min_len(MIN_PIECE).map(value).collect();
    }
    let ends = [bounds.lower[axis], bounds.upper[axis]];
    Range::of(ends.into_iter().map(|end| f64::from(end) + offset))
}

/// The range of the numbers in the place of colours.
fn range_of(columns: &TriangleMesh) -> Range {
    let pieces = columns.colors.par_chunks(MIN_PIECE);
    let ranges = pieces.map(|piece| Range::of(piece.iter().copied().map(value_of)));
    ranges.reduce(Range::default, Range::and)
}
