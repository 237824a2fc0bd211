//! Pictures in memory.

use crate::{
    camera::Camera,
    mesh::Mesh,
    solid::{self, Colors},
    threads,
    words::{in_python, raised},
};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use octray::{
    cli::picture::{self, AovKind, Backdrop, MeshOptions, Picture, Request, Subject, Values},
    format::mesh::Moment,
    glam::DVec3,
};
use pyo3::{exceptions::PyValueError, prelude::*, pybacked::PyBackedBytes, types::PyDict};
use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::atomic::Ordering,
};

/// A mesh, a file, or the bytes of one with its name.
#[derive(FromPyObject)]
pub enum Source<'py> {
    Mesh(PyRef<'py, Mesh>),
    File(PathBuf),
    Bytes(PyBackedBytes, PathBuf),
}

/// The options of a picture, as `octray.render` has checked them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Options<'py> {
    samples: Option<String>,
    style: Option<String>,
    aov: Vec<String>,
    vertex_colors: Option<PyReadonlyArray2<'py, f32>>,
    face_colors: Option<PyReadonlyArray2<'py, f32>>,
    background: String,
    floats: bool,
    srgb: Option<bool>,
    max_depth: u32,
    shadows: bool,
    edges: Option<f32>,
    frame: Option<u32>,
    ground: bool,
    up_axis: Option<String>,
    smooth_angle: Option<f64>,
    point_size: Option<f32>,
    lit_from: Option<[f64; 3]>,
    environment: Option<PathBuf>,
    environment_rotate: f64,
    animation: Option<String>,
    animation_time: Option<f64>,
}

impl Options<'_> {
    fn backdrop(&self) -> PyResult<Backdrop> {
        let parsed = self.background.parse();
        parsed.map_err(|expected: String| {
            PyValueError::new_err(format!("background: {expected}, found {:?}", self.background))
        })
    }

    /// How a mesh is shown.
    fn mesh(&self) -> PyResult<MeshOptions> {
        let has_moment = self.animation.is_some() || self.animation_time.is_some();
        let environment = self.environment.clone();
        Ok(MeshOptions {
            up_axis: solid::up_axis(self.up_axis.as_deref())?,
            ground: self.ground,
            smooth_degrees: self.smooth_angle,
            point_size: self.point_size,
            moment: has_moment.then(|| Moment {
                animation: self.animation.clone(),
                seconds: self.animation_time.unwrap_or(0.0),
            }),
            lit_from: self.lit_from.map(DVec3::from),
            environment: environment.map(|path| (path, self.environment_rotate)),
            ..solid::styled(self.style.as_deref())?
        })
    }

    /// The colours of a mesh.
    fn colors(&self) -> Colors {
        let rows = |colors: &PyReadonlyArray2<'_, f32>| {
            let rows = colors.as_array();
            rows.rows()
                .into_iter()
                .map(|row| [row[0], row[1], row[2]])
                .collect()
        };
        match (&self.vertex_colors, &self.face_colors) {
            (Some(colors), _) => Colors::Vertices(rows(colors)),
            (None, Some(colors)) => Colors::Faces(rows(colors)),
            (None, None) => Colors::None,
        }
    }

    /// The AOVs of these names.
    fn aovs(&self) -> PyResult<Vec<AovKind>> {
        let of_name = |name: &String| {
            let found = AovKind::ALL.into_iter().find(|kind| kind.name() == name);
            found.ok_or_else(|| PyValueError::new_err(format!("aov: unknown name {name:?}")))
        };
        self.aov.iter().map(of_name).collect()
    }
}

/// Renders a scene, a mesh file or a mesh; returns the arrays by name, and warnings.
#[pyfunction]
pub fn render<'py>(
    py: Python<'py>,
    source: Source<'_>,
    size: [u32; 2],
    camera: Camera,
    options: Options<'_>,
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let (geometry, pool) = match &source {
        Source::Mesh(mesh) => (Some(mesh.0.now(py)), mesh.0.threads().pool()?),
        Source::File(_) | Source::Bytes(..) => (None, threads::shared()?),
    };
    let middle = geometry
        .as_ref()
        .map_or(DVec3::ZERO, |geometry| geometry.middle());
    let request = Request {
        size,
        camera: camera.options(middle),
        mesh: options.mesh()?,
        aovs: options.aovs()?,
        max_depth: options.max_depth,
        shadows: options.shadows,
        edges: options.edges,
        backdrop: options.backdrop()?,
        srgb: options.srgb,
        floats: options.floats,
        frame: options.frame,
        samples: options.samples.clone(),
    };
    let colors = options.colors();
    let file: (&[u8], &Path) = match &source {
        Source::Mesh(_) => (&[], Path::new("")),
        Source::File(path) => (&[], path),
        Source::Bytes(bytes, name) => (bytes, name),
    };
    let is_path = matches!(source, Source::File(_));
    let done = threads::interruptible(py, &pool, |cancelled| {
        let subject = match (&geometry, file) {
            (Some(geometry), _) => Subject::Mesh(solid::copied(geometry, colors)),
            (None, (_, path)) if is_path => Subject::File(path),
            (None, (bytes, name)) => Subject::Bytes(bytes, name),
        };
        picture::picture(subject, request, &|_| {
            if cancelled.load(Ordering::Relaxed) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        })
    })?;
    let picture = done.map_err(|error| raised(&error))?;
    arrays(py, picture, size)
}

/// The arrays of a picture.
fn arrays<'py>(
    py: Python<'py>,
    Picture { color, aovs, notes }: Picture,
    size: [u32; 2],
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let arrays = PyDict::new(py);
    for (name, values) in [("color", color)].into_iter().chain(aovs) {
        let array = match values {
            Values::Bytes(bytes) => shaped(bytes.into_pyarray(py), size)?,
            Values::Floats(floats) => shaped(floats.into_pyarray(py), size)?,
            Values::Whole(numbers) => shaped(numbers.into_pyarray(py), size)?,
            Values::Flags(flags) => shaped(flags.into_pyarray(py), size)?,
        };
        arrays.set_item(name, array)?;
    }
    Ok((arrays, notes.iter().map(|note| in_python(note)).collect()))
}

/// An array of height, width and, if there are several, the values of a pixel.
fn shaped<'py, T: numpy::Element>(
    values: Bound<'py, PyArray1<T>>,
    [width, height]: [u32; 2],
) -> PyResult<Bound<'py, PyAny>> {
    let (width, height) = (width as usize, height as usize);
    Ok(match values.len()? / (width * height) {
        1 => values.reshape([height, width])?.into_any(),
        channels => values.reshape([height, width, channels])?.into_any(),
    })
}
