//! VTK files: `PolyData` (.vtp), `UnstructuredGrid` (.vtu), and both in the legacy form (.vtk).
//!
//! Surfaces are shown as they are, bodies by their outer faces. A first pass only finds the arrays of a file; those that are
//! shown are read in place, number by number.
//!
//! Why not vtkio: it makes a tree of all arrays of a file, whose memory is not limited, its errors have no place, and it
//! brings a second version of quick-xml, nom and decoders of lz4 and lzma.
//!
//! Format: *VTK File Formats*, Kitware.

mod array;
mod build;
mod cells;
mod data;
mod document;
mod encoded;
mod group;
mod legacy;
mod outer;
mod shapes;

use super::{
    budget::Budget,
    files::MAX_BYTES,
    left_out::LeftOut,
    mesh::{Cloud, LoadedMesh, MeshFormat, Owner, Scalars, UpAxis, UpSource, Wanted},
    place::TextFault,
    ply,
    polygon::fans_note,
};
use crate::error::{LoadError, quote};
use array::Array;
use build::Build;
use cells::{Cells, Polyhedra, Types};
use data::{Attributes, Chosen};
use std::path::Path;

/// Points and their cells.
#[derive(Default)]
struct Piece<'a> {
    points: usize,
    coordinates: Option<Array<'a>>,
    groups: Vec<(Cells<'a>, Types<'a>)>,
    polyhedra: Option<Polyhedra<'a>>,
    of_points: Attributes<'a>,
    of_cells: Attributes<'a>,
}

impl Piece<'_> {
    /// The number of cells.
    fn cells(&self) -> usize {
        let counts = self.groups.iter().map(|(cells, _)| cells.count);
        counts.fold(0, usize::saturating_add)
    }
}

/// How many bytes the arrays of a file may have: they may overlap, or inflate to much more than the file.
fn most_decoded(size: usize) -> u64 {
    let size = size as u64;
    MAX_BYTES
        .max(size.saturating_mul(8))
        .min(size.saturating_mul(1032))
}

/// The error about other kinds of data, by the name that the file has for them.
fn foreign_kind(name: &[u8]) -> String {
    format!(
        "this is a VTK file of the type {}, which octray does not read; convert it to .vtp, for example with ParaView's \
         filter Extract Surface",
        quote(name)
    )
}

/// Reads a mesh.
///
/// # Errors
/// [`LoadError`], with line and column, except in binary parts of legacy files.
pub(super) fn parse(bytes: &[u8], path: &Path, budget: &Budget) -> Result<LoadedMesh, LoadError> {
    let located = |fault: TextFault| fault.into_error(bytes, path);
    let (file, pieces, has_steps) = if legacy::is_legacy(bytes) {
        let (file, piece) = legacy::read(bytes, budget).map_err(located)?;
        (file, vec![piece], false)
    } else if bytes.is_empty() {
        return Err(LoadError::whole_file(
            path,
            "the file is empty, expected a VTK mesh",
        ));
    } else {
        document::read(bytes, budget).map_err(located)?
    };
    let chosen = match budget.scalars().name() {
        Some(name) => Some(Chosen::of(name, &pieces).map_err(|reason| reason.of_file(path))?),
        None => None,
    };
    let colors = if budget.scalars().shows_colors() {
        colors(&pieces)
    } else {
        None
    };
    let mut build = Build::new(&file, chosen);
    for piece in pieces.iter().filter(|piece| piece.points > 0) {
        build.add(piece, colors).map_err(located)?;
    }
    let listed = if *budget.scalars() == Wanted::Ranges {
        data::ranges(&pieces, &file)
    } else {
        Vec::new()
    };
    let mut left_out = LeftOut::default();
    if budget.scalars().shows_colors() {
        arrays_left_out(&pieces, colors, &mut left_out);
    }
    if has_steps {
        left_out.add("time steps after the first");
    }
    let unusable = std::mem::take(&mut build.unusable).map(located);
    let mut mesh = finish(build, left_out, path, budget)?;
    mesh.scalars.listed = listed;
    mesh.keep_used(unusable, path, budget)?;
    Ok(mesh)
}

/// What has colours: points, or else cells.
fn colors(pieces: &[Piece<'_>]) -> Option<Owner> {
    let has = |of: fn(&Piece<'_>) -> bool| pieces.iter().any(of);
    if has(|piece| piece.of_points.colors().is_some()) {
        Some(Owner::Vertices)
    } else if has(|piece| piece.of_cells.colors().is_some()) {
        Some(Owner::Faces)
    } else {
        None
    }
}

/// Lists the arrays that are not shown.
fn arrays_left_out(pieces: &[Piece<'_>], colors: Option<Owner>, left_out: &mut LeftOut) {
    let points = pieces
        .iter()
        .flat_map(|piece| piece.of_points.others(Owner::Vertices));
    let cells = pieces
        .iter()
        .flat_map(|piece| piece.of_cells.others(Owner::Faces));
    left_out.names("arrays of points", points.map(|array| array.name.as_str()));
    left_out.names("arrays of cells", cells.map(|array| array.name.as_str()));
    let both = pieces.iter().any(|piece| piece.of_cells.colors().is_some());
    if both && colors == Some(Owner::Vertices) {
        left_out.add("colours of cells");
    }
}

/// Makes the mesh.
fn finish(
    build: Build<'_, '_>,
    mut left_out: LeftOut,
    path: &Path,
    budget: &Budget,
) -> Result<LoadedMesh, LoadError> {
    let no_room = |error: super::budget::BudgetError| error.into_error(path);
    let Build {
        mut columns,
        fans,
        lines,
        dots,
        values,
        colors,
        ..
    } = build;
    for (cell, count) in build.unknown {
        let [one, many] = ["cell", "cells"].map(|cells| format!("{cells} of type {cell}{}", name_of(cell)));
        left_out.count(count, &one, &many);
    }
    left_out.count(
        build.small,
        "cell with too few points",
        "cells with too few points",
    );
    left_out.odd_normals(build.odd_normals);
    if columns.normals.len() != columns.x.len() {
        columns.normals = Vec::new();
    }
    let mut mesh = LoadedMesh {
        up: UpAxis::Z,
        up_source: UpSource::Assumed(MeshFormat::Vtk),
        ..LoadedMesh::default()
    };
    if columns.triangles.is_empty() {
        if build.cells == 0 || !dots.is_empty() || !lines.is_empty() {
            mesh.columns = columns;
            mesh.cloud = Some(Cloud { radius: None, lines });
            mesh.keep_points(&dots, build.cells == 0, budget)
                .map_err(no_room)?;
        }
        mesh.notes.extend(left_out.note(path));
        return Ok(mesh);
    }
    left_out.count(dots.len(), "point beside faces", "points beside faces");
    left_out.count(lines.len(), "line beside faces", "lines beside faces");
    if build.has_cell_colors {
        columns.colors = Vec::new();
    }
    let complex = fans.cut_concave(&mut columns, budget).map_err(no_room)?;
    mesh.columns = columns;
    mesh.notes.extend(left_out.note(path));
    mesh.notes.extend(fans_note(complex, path));
    if colors.is_empty() {
        mesh.scalars = Scalars {
            of_faces: values,
            listed: Vec::new(),
        };
    } else {
        ply::paint(&mut mesh, &colors, path, budget).map_err(no_room)?;
        budget.give_back(colors.capacity() * size_of::<[f32; 3]>());
    }
    Ok(mesh)
}

/// What a type of cells is called, in parentheses.
fn name_of(cell: u8) -> &'static str {
    match cell {
        41 => " (convex point sets)",
        51..=56 => " (parametric)",
        60..=67 => " (higher order)",
        _ => "",
    }
}

// Numbers as colours are the program's.
#[cfg(all(test, feature = "cli"))]
mod tests;
