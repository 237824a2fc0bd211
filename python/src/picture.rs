//! Pictures in memory.

use crate::{
    camera::Camera,
    solid::{self, Colors, Shown, Solid},
    threads,
    words::{in_python, raised},
};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use octray::{
    cli::picture::{
        self, AovKind, Backdrop, ColorBy, ColorMap, MeshOptions, Picture, Request, Shading, Subject, Values,
    },
    format::mesh::Moment,
    glam::DVec3,
};
use pyo3::{exceptions::PyValueError, prelude::*, pybacked::PyBackedBytes, types::PyDict};
use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::atomic::Ordering,
};

/// A mesh, a scene of meshes, a file, or the bytes of one with its name.
#[derive(FromPyObject)]
pub enum Source<'py> {
    Solid(Solid<'py>),
    File(PathBuf),
    Bytes(PyBackedBytes, PathBuf),
}

/// The colours of each mesh; none of a file.
type MeshColors<'py> = Vec<Option<PyReadonlyArray2<'py, f32>>>;

/// The options of a picture, as `octray.render` has checked them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Options<'py> {
    samples: Option<String>,
    style: Option<String>,
    aov: Vec<String>,
    vertex_colors: MeshColors<'py>,
    face_colors: MeshColors<'py>,
    vertex_values: Option<PyReadonlyArray1<'py, f64>>,
    face_values: Option<PyReadonlyArray1<'py, f64>>,
    color_by: Option<String>,
    color_map: Option<String>,
    color_range: Option<[f64; 2]>,
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

    /// Which numbers are colours. Those of a mesh in memory are relative to its `middle`.
    fn color_by(&self, middle: DVec3) -> PyResult<ColorBy> {
        let map = self.color_map.as_deref().unwrap_or(ColorMap::default().name());
        let map = ColorMap::named(map).ok_or_else(|| {
            let names = ColorMap::ALL.map(ColorMap::name).join(", ");
            PyValueError::new_err(format!("color_map: expected {names}, found {map:?}"))
        })?;
        let values = self.color_by.as_deref().map_or(Shading::Own, Shading::named);
        let offset = match values {
            Shading::Coordinate(axis) => middle[axis],
            _ => 0.0,
        };
        Ok(ColorBy {
            values,
            map,
            range: self.color_range.map(|range| range.map(|end| end - offset)),
        })
    }

    /// How a mesh is shown.
    fn mesh(&self, middle: DVec3) -> PyResult<MeshOptions> {
        let has_moment = self.animation.is_some() || self.animation_time.is_some();
        let environment = self.environment.clone();
        Ok(MeshOptions {
            up_axis: solid::up_axis(self.up_axis.as_deref())?,
            ground: self.ground,
            smooth_degrees: self.smooth_angle,
            point_size: self.point_size,
            color_by: self.color_by(middle)?,
            moment: has_moment.then(|| Moment {
                animation: self.animation.clone(),
                seconds: self.animation_time.unwrap_or(0.0),
            }),
            lit_from: self.lit_from.map(DVec3::from),
            environment: environment.map(|path| (path, self.environment_rotate)),
            ..solid::styled(self.style.as_deref())?
        })
    }

    /// The colours or numbers of each mesh.
    fn colors(&self) -> Vec<Colors> {
        let numbers = |values: &PyReadonlyArray1<'_, f64>| values.as_array().to_vec();
        if let Some(values) = &self.vertex_values {
            return vec![Colors::VertexValues(numbers(values))];
        }
        if let Some(values) = &self.face_values {
            return vec![Colors::FaceValues(numbers(values))];
        }
        let rows = |colors: &PyReadonlyArray2<'_, f32>| {
            let rows = colors.as_array();
            rows.rows()
                .into_iter()
                .map(|row| [row[0], row[1], row[2]])
                .collect()
        };
        let of_mesh = |both: (&Option<_>, &Option<_>)| match both {
            (Some(colors), _) => Colors::Vertices(rows(colors)),
            (None, Some(colors)) => Colors::Faces(rows(colors)),
            (None, None) => Colors::None,
        };
        self.vertex_colors
            .iter()
            .zip(&self.face_colors)
            .map(of_mesh)
            .collect()
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

/// Renders a scene, a mesh file, a mesh or placed meshes; returns the arrays by name, and warnings.
#[pyfunction]
pub fn render<'py>(
    py: Python<'py>,
    source: Source<'_>,
    size: [u32; 2],
    camera: Camera,
    options: Options<'_>,
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let (shown, pool) = match &source {
        Source::Solid(solid) => (Some(solid.now(py)?), solid.threads().pool()?),
        Source::File(_) | Source::Bytes(..) => (None, threads::shared()?),
    };
    let middle = shown.as_ref().map_or(DVec3::ZERO, Shown::middle);
    let request = Request {
        size,
        camera: camera.options(middle),
        mesh: options.mesh(middle)?,
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
    let mut colors = options.colors();
    let file: (&[u8], &Path) = match &source {
        Source::Solid(_) => (&[], Path::new("")),
        Source::File(path) => (&[], path),
        Source::Bytes(bytes, name) => (bytes, name),
    };
    let is_path = matches!(source, Source::File(_));
    let done = threads::interruptible(py, &pool, |cancelled| {
        let mut of_mesh = |i: usize| colors.get_mut(i).map_or(Colors::None, std::mem::take);
        let subject = match (&shown, file) {
            (Some(Shown::Mesh(geometry)), _) => Subject::Mesh(solid::copied(geometry, of_mesh(0))),
            (Some(scene), _) => Subject::Scene(scene.parts(|i, mesh| solid::copied(mesh, of_mesh(i)))),
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
