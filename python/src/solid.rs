//! The meshes of pictures: their arrays, and options of how they are shown.

use crate::{
    mesh::Mesh,
    scene::{Placed, Scene},
    shared::numbers,
    threads::Threads,
};
use numpy::PyReadonlyArray1;
use octray::{
    Geometry,
    cli::picture::{MeshArrays, MeshOptions, MeshShows, PlacedArrays, Style},
    format::mesh::UpAxis,
    glam::DVec3,
    scene::{Transform, TriangleMesh},
};
use pyo3::{exceptions::PyValueError, prelude::*};
use std::sync::Arc;

/// A mesh, or a scene with its meshes and the mesh of each instance.
#[derive(FromPyObject)]
pub enum Solid<'py> {
    Mesh(PyRef<'py, Mesh>),
    Scene(
        PyRef<'py, Scene>,
        Vec<PyRef<'py, Mesh>>,
        PyReadonlyArray1<'py, i64>,
    ),
}

/// A solid as it is now.
pub enum Shown {
    Mesh(Arc<Geometry>),
    Scene {
        placed: Arc<Placed>,
        meshes: Vec<Arc<Geometry>>,
        indices: Vec<i64>,
    },
}

impl Solid<'_> {
    pub fn now(&self, py: Python<'_>) -> PyResult<Shown> {
        Ok(match self {
            Self::Mesh(mesh) => Shown::Mesh(mesh.0.now(py)),
            Self::Scene(scene, meshes, indices) => Shown::Scene {
                placed: scene.0.now(py),
                meshes: meshes.iter().map(|mesh| mesh.0.now(py)).collect(),
                indices: numbers(indices)?.to_vec(),
            },
        })
    }

    pub fn threads(&self) -> &Threads {
        match self {
            Self::Mesh(mesh) => mesh.0.threads(),
            Self::Scene(scene, ..) => scene.0.threads(),
        }
    }
}

impl Shown {
    /// The point that its arrays are relative to.
    pub fn middle(&self) -> DVec3 {
        match self {
            Self::Mesh(geometry) => geometry.middle(),
            Self::Scene { placed, .. } => placed.geometry.middle(),
        }
    }

    /// Its meshes that have triangles and are placed; `arrays` copies the one of an index.
    pub fn parts(&self, mut arrays: impl FnMut(usize, &Geometry) -> MeshArrays) -> Vec<PlacedArrays> {
        let (placed, meshes, indices) = match self {
            Self::Mesh(geometry) => {
                return vec![PlacedArrays {
                    mesh: arrays(0, geometry),
                    placements: vec![Transform::IDENTITY],
                    ..PlacedArrays::default()
                }];
            }
            Self::Scene {
                placed,
                meshes,
                indices,
            } => (placed, meshes, indices),
        };
        let middle = self.middle();
        let mut parts: Vec<PlacedArrays> = meshes.iter().map(|_| PlacedArrays::default()).collect();
        for (instance, (&mesh, matrix)) in (0..).zip(indices.iter().zip(&placed.matrices)) {
            let from_middle = Transform::IDENTITY.then_translate(meshes[mesh as usize].middle());
            let transform = from_middle.then_transform(&crate::scene::transform(matrix));
            let part = &mut parts[mesh as usize];
            part.placements.push(transform.then_translate(-middle));
            part.instances.push(instance);
        }
        for (i, (part, mesh)) in parts.iter_mut().zip(meshes).enumerate() {
            if !part.placements.is_empty() && mesh.triangle_count() > 0 {
                part.mesh = arrays(i, mesh);
            }
        }
        parts.retain(|part| !part.mesh.columns.x.is_empty());
        parts
    }
}

/// What the vertices or faces of a mesh show: colours, display values from 0 to 1, or numbers.
#[derive(Default)]
pub enum Colors {
    #[default]
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
fn points(geometry: &Geometry) -> TriangleMesh {
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

/// Those positions, for a camera.
pub fn outline(geometry: &Geometry) -> MeshArrays {
    MeshArrays {
        columns: points(geometry),
        ..MeshArrays::default()
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
