//! Shows numbers of a mesh as colours.

use super::input::failed;
use crate::{
    cli::{
        CliError,
        plan::{COLORS, ColorBy, Shading, color_of},
    },
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

/// Gives a mesh the colours of its numbers, instead of all others, and the finish of `surface`. Coordinates reach as far as in
/// `framed`, which is the mesh or its poses.
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
    let of_each = 1 + usize::from(of_faces.is_empty());
    let vectors = loaded
        .arrays()
        .map(|columns| of_each * columns.x.len() + columns.normals.len())
        .sum();
    let triangles = loaded.arrays().map(|columns| columns.triangles.len()).sum();
    let fits = check_memory([triangles, 0, vectors], memory);
    fits.map_err(|error| failed(path, &error))?;
    let found = if let Shading::Coordinate(axis) = by.values {
        let bounds = PlacedMesh::bounds(&framed.unwrap_or(loaded).placed());
        let offset = loaded.offset[axis];
        for columns in loaded.arrays_mut() {
            let values = [&columns.x, &columns.y, &columns.z][axis].par_iter();
            let value = |&value: &f32| channels(f64::from(value) + offset);
            columns.colors = values.with_min_len(MIN_PIECE).map(value).collect();
        }
        let ends = [bounds.lower[axis], bounds.upper[axis]];
        Range::of(ends.into_iter().map(|end| f64::from(end) + offset))
    } else if of_faces.is_empty() {
        let of_part = |columns: &TriangleMesh| {
            let pieces = columns.colors.par_chunks(MIN_PIECE);
            let ranges = pieces.map(|piece| Range::of(piece.iter().copied().map(value_of)));
            ranges.reduce(Range::default, Range::and)
        };
        loaded.arrays().map(of_part).fold(Range::default(), Range::and)
    } else {
        Range::of(of_faces.iter().copied())
    };
    let range = by.range.or(found.0);
    let place = |value| color_of(value, range.unwrap_or_default());
    let colors = by.map.colors();
    let shown = |place: Option<usize>| place.map_or(GREY, |i| colors[i]);
    let owner = if of_faces.is_empty() {
        for columns in loaded.arrays_mut() {
            let all = columns.colors.par_iter_mut().with_min_len(MIN_PIECE);
            all.for_each(|color| *color = shown(place(value_of(*color))));
        }
        loaded.show_only_colors(Surface {
            diffuse: [1.0; 3],
            ..surface
        });
        Owner::Vertices
    } else {
        let surfaces = (0..=COLORS).map(|i| Surface {
            diffuse: shown((i < COLORS).then_some(i)),
            ..surface
        });
        loaded.paint(surface);
        loaded.surfaces = surfaces.collect();
        let numbers = of_faces
            .into_iter()
            .map(|value| place(value).unwrap_or(COLORS) as u32);
        loaded.surface_of = numbers.collect();
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
