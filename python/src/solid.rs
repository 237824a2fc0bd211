//! The meshes of pictures: their arrays, and options of how they are shown.

use octray::{
    Geometry,
    cli::picture::{MeshArrays, MeshOptions, MeshShows, Style},
    format::mesh::UpAxis,
    scene::TriangleMesh,
};
use pyo3::{exceptions::PyValueError, prelude::*};

/// What the vertices or faces of a mesh show: colours, display values from 0 to 1, or numbers.
pub enum Colors {
    None,
    Vertices(Vec<[f32; 3]>),
    Faces(Vec<[f32; 3]>),
    /// Numbers instead.
    VertexValues(Vec<f64>),
    FaceValues(Vec<f64>),
}

/// Which vertices a triangle uses.
fn used(geometry: &Geometry) -> Vec<bool> {
    let mut is_used = vec![false; geometry.vertex_count()];
    for &corner in geometry.triangles().as_flattened() {
        is_used[corner as usize] = true;
    }
    is_used
}

/// The positions of vertices that a triangle uses, relative to the geometry's middle.
pub fn points(geometry: &Geometry) -> TriangleMesh {
    let is_used = used(geometry);
    let vertices = geometry.scene().vertices();
    let column = |column: &[f32]| {
        let used = column.iter().zip(&is_used).filter(|(_, is_used)| **is_used);
        used.map(|(&coordinate, _)| coordinate).collect()
    };
    TriangleMesh {
        x: column(&vertices.x),
        y: column(&vertices.y),
        z: column(&vertices.z),
        ..TriangleMesh::default()
    }
}

/// A copy of the mesh relative to its middle. Vertices that no triangle uses are left out, as when a file is loaded: they would
/// change the framing.
pub fn copied(geometry: &Geometry, colors: Colors) -> MeshArrays {
    let is_used = used(geometry);
    let mut columns = points(geometry);
    columns.triangles = geometry.triangles().to_vec();
    if is_used.contains(&false) {
        let before = is_used.iter().scan(0, |count, &used| {
            let before = *count;
            *count += u32::from(used);
            Some(before)
        });
        let moved: Vec<u32> = before.collect();
        for corner in columns.triangles.as_flattened_mut() {
            *corner = moved[*corner as usize];
        }
    }
    let mut shown = MeshShows::Nothing;
    match colors {
        Colors::None => {}
        Colors::Faces(colors) => shown = MeshShows::FaceColors(colors),
        Colors::FaceValues(values) => shown = MeshShows::FaceValues(values),
        Colors::Vertices(colors) => columns.colors = only(&is_used, colors),
        Colors::VertexValues(values) => shown = MeshShows::VertexValues(only(&is_used, values)),
    }
    MeshArrays { columns, shown }
}

/// The elements of the vertices that are used.
fn only<T>(is_used: &[bool], mut elements: Vec<T>) -> Vec<T> {
    let mut used = is_used.iter();
    elements.retain(|_| used.next() == Some(&true));
    elements
}

/// The options of a mesh in a style.
pub fn styled(style: Option<&str>) -> PyResult<MeshOptions> {
    let is_style_given = style.is_some();
    let style = match style {
        None | Some("studio") => Style::Studio,
        Some("plain") => Style::Plain,
        Some("clay") => Style::Clay,
        Some(other) => {
            let why = format!("style: expected plain, studio or clay, found {other:?}");
            return Err(PyValueError::new_err(why));
        }
    };
    Ok(MeshOptions {
        style,
        is_style_given,
        ..MeshOptions::default()
    })
}

/// The axis of that name.
pub fn up_axis(name: Option<&str>) -> PyResult<Option<UpAxis>> {
    let parsed = name.map(str::parse).transpose();
    parsed.map_err(|expected: String| {
        let found = name.unwrap_or_default();
        PyValueError::new_err(format!("up_axis: {expected}, found {found:?}"))
    })
}
