//! Meshes as wholes: from files, and as they are copied and pickled.

use crate::{
    arrays::rows,
    mesh::Mesh,
    shared::{Shared, raised},
    threads::{Threads, interruptible},
    words,
};
use numpy::{PyArray2, PyReadonlyArray2};
use octray::{Geometry, QueryError, cli::picture::mesh, glam::DVec3};
use pyo3::{exceptions::PyValueError, prelude::*};
use std::{path::PathBuf, sync::Arc};

/// Builds a mesh on its threads.
pub fn built(
    py: Python<'_>,
    threads: Option<usize>,
    build: impl FnOnce() -> PyResult<Result<Geometry, QueryError>> + Send,
) -> PyResult<Mesh> {
    let threads = Threads::new(threads)?;
    let pool = threads.pool()?;
    let geometry = interruptible(py, &pool, |_| build())??;
    let geometry = geometry.map_err(raised)?;
    Ok(Mesh(Shared::of(geometry, Arc::new(threads))))
}

/// Loads a mesh file; returns the mesh and warnings.
#[pyfunction]
pub fn load(py: Python<'_>, path: PathBuf, threads: Option<usize>) -> PyResult<(Mesh, Vec<String>)> {
    let mut notes = Vec::new();
    let loaded = built(py, threads, || {
        let mut loaded = mesh(&path).map_err(|error| words::raised(&error))?;
        notes.append(&mut loaded.notes);
        if loaded.columns.triangles.is_empty() {
            let vertices = loaded.columns.x.len();
            let why = format!("{}: no triangles, only {vertices} vertices", path.display());
            return Err(PyValueError::new_err(why));
        }
        Ok(Geometry::from_mesh_at(&loaded.columns, loaded.offset))
    })?;
    Ok((loaded, notes))
}

/// What a mesh is made of: vertices relative to a point, that point, the triangles, and the number of threads.
type Parts<'py> = (
    Bound<'py, PyArray2<f32>>,
    [f64; 3],
    Bound<'py, PyArray2<u32>>,
    Option<usize>,
);

/// Takes a mesh apart.
#[pyfunction]
pub fn parts<'py>(py: Python<'py>, mesh: PyRef<'_, Mesh>) -> PyResult<Parts<'py>> {
    let geometry = mesh.0.now(py);
    let (vertices, middle) = geometry.vertices();
    let triangles = rows(py, geometry.triangles().to_vec())?;
    Ok((
        rows(py, vertices)?,
        middle.to_array(),
        triangles,
        mesh.0.threads().own,
    ))
}

/// Makes a mesh of its parts.
#[pyfunction]
pub fn of_parts(
    py: Python<'_>,
    vertices: PyReadonlyArray2<'_, f32>,
    middle: [f64; 3],
    triangles: PyReadonlyArray2<'_, u32>,
    threads: Option<usize>,
) -> PyResult<Mesh> {
    let wrong = |_| PyValueError::new_err("the array is not contiguous");
    let vertices = vertices.as_slice().map_err(wrong)?.as_chunks().0;
    let triangles = triangles.as_slice().map_err(wrong)?.as_chunks().0;
    built(py, threads, || {
        Ok(Geometry::from_relative(vertices, DVec3::from(middle), triangles))
    })
}
