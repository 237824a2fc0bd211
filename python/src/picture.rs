//! Pictures in memory.

use crate::{
    arrays::rows,
    mesh::{self, Mesh},
    threads,
};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods};
use octray::{
    cli::{
        CliError,
        picture::{self, CameraOptions, Picture, Side, StartView, Style, Subject},
    },
    error::LoadErrorKind,
    glam::DVec3,
    query::CameraRays,
    scene::{Projection, TriangleMesh, View},
};
use pyo3::{
    exceptions::{PyFileNotFoundError, PyMemoryError, PyValueError},
    prelude::*,
    types::PyDict,
};
use std::{
    io::ErrorKind,
    ops::ControlFlow,
    path::{Path, PathBuf},
    sync::atomic::Ordering,
};

/// A file, or a mesh.
#[derive(FromPyObject)]
pub enum Source<'py> {
    Mesh(PyRef<'py, Mesh>),
    File(PathBuf),
}

/// A camera: a classic viewpoint, one of the file by name, or an eye.
#[derive(FromPyObject)]
pub enum Camera {
    Number(u32),
    Name(String),
    Eye([f64; 3]),
    /// Azimuth and elevation, degrees.
    Side([f64; 2]),
}

/// What errors about arguments say to users of the program, and to those of the package.
const WORDS: [(&str, &str); 6] = [
    (
        "use --view or --eye",
        "choose a viewpoint from 1 to 6, or give a dictionary, such as {\"from\": \"front\"} or {\"eye\": (4, 3, 2)}",
    ),
    ("choose it with --camera 1", "choose it with camera=\"1\""),
    (
        "--focus needs a lens: give its diameter with --aperture",
        "focus needs a lens: give its diameter as aperture",
    ),
    ("--up 0,1,0", "\"up\": (0, 1, 0)"),
    ("--style applies", "style applies"),
    ("--from", "from"),
];

/// The error for Python.
pub fn raised(error: &CliError) -> PyErr {
    let text = error.text().unwrap_or_else(|| "interrupted".to_owned());
    match error {
        CliError::Memory(_) => PyMemoryError::new_err(text),
        CliError::Load(error)
            if error.cause.is_none() && error.kind() == LoadErrorKind::Io(ErrorKind::NotFound) =>
        {
            PyFileNotFoundError::new_err(text)
        }
        CliError::Usage(text) => {
            let replace = |text: String, (theirs, ours): &(&str, &str)| text.replace(theirs, ours);
            PyValueError::new_err(WORDS.iter().fold(text.clone(), replace))
        }
        _ => PyValueError::new_err(text),
    }
}

/// A copy of the mesh relative to its origin, and that origin. Vertices that no triangle uses are left out, as when a file
/// is loaded: they would change the framing.
fn copied(py: Python<'_>, mesh: &Mesh) -> (TriangleMesh, DVec3) {
    let geometry = mesh.geometry(py);
    let (mut positions, middle) = geometry.vertices();
    let mut triangles = geometry.triangles().to_vec();
    let mut is_used = vec![false; positions.len()];
    for &corner in triangles.as_flattened() {
        is_used[corner as usize] = true;
    }
    if is_used.contains(&false) {
        let before = is_used.iter().scan(0, |count, &used| {
            let before = *count;
            *count += u32::from(used);
            Some(before)
        });
        let moved: Vec<u32> = before.collect();
        for corner in triangles.as_flattened_mut() {
            *corner = moved[*corner as usize];
        }
        let mut used = is_used.into_iter();
        positions.retain(|_| used.next() == Some(true));
    }
    let axis = |axis: usize| positions.iter().map(|position| position[axis]).collect();
    let mesh = TriangleMesh {
        x: axis(0),
        y: axis(1),
        z: axis(2),
        normals: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        triangles,
    };
    (mesh, middle)
}

/// The camera's options, relative to `middle`.
fn options(
    camera: Option<Camera>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    [fov, ortho, aperture, focus]: [Option<f64>; 4],
    middle: DVec3,
) -> CameraOptions {
    // Classic viewpoints are near 0, wherever the mesh is.
    let classic = match camera {
        Some(Camera::Number(number)) if middle != DVec3::ZERO => View::classic(number),
        _ => None,
    };
    CameraOptions {
        start: match (camera, classic) {
            (_, Some(view)) => StartView::Eye(view.eye - middle),
            (None, _) => StartView::Default,
            (Some(Camera::Number(number)), _) => StartView::Classic(number),
            (Some(Camera::Name(name)), _) => StartView::Named(name),
            (Some(Camera::Eye(eye)), _) => StartView::Eye(DVec3::from(eye) - middle),
            (Some(Camera::Side([azimuth, elevation])), _) => StartView::Side(Side { azimuth, elevation }),
        },
        target: target
            .map(DVec3::from)
            .or(classic.map(|view| view.target))
            .map(|target| target - middle),
        up: up.map(DVec3::from).or(classic.map(|view| view.up)),
        projection: match (fov, ortho) {
            (_, Some(height)) => Some(Projection::Orthographic { height }),
            (Some(fov_degrees), None) => Some(Projection::Perspective { fov_degrees }),
            (None, None) => classic.map(|view| view.projection),
        },
        fits_ortho: false,
        aperture,
        focus,
        ..CameraOptions::default()
    }
}

/// Origins and directions, a row each.
type Rays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f32>>);

/// Returns the origins and directions of the rays through the pixels' centres.
#[pyfunction]
pub fn camera_rays<'py>(
    py: Python<'py>,
    mesh: Option<PyRef<'_, Mesh>>,
    size: [u32; 2],
    camera: Option<Camera>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    lens: [Option<f64>; 4],
) -> PyResult<Rays<'py>> {
    let (columns, middle) = match &mesh {
        Some(mesh) => {
            let (columns, middle) = copied(py, mesh);
            (Some(columns), middle)
        }
        // Origins are rounded around the eye.
        None => match &camera {
            Some(Camera::Eye(eye)) => (None, DVec3::from(*eye)),
            _ => (None, DVec3::ZERO),
        },
    };
    let view = options(camera, target, up, lens, middle);
    let pool = match &mesh {
        Some(mesh) => mesh.threads().pool()?,
        None => threads::shared()?,
    };
    let found = threads::interruptible(py, |_| {
        pool.install(|| {
            let camera = picture::camera(columns, &view, size);
            camera.map(|camera| camera.rays(size[0], size[1]))
        })
    })?;
    let CameraRays { origins, directions } = found.map_err(|error| raised(&error))?.map_err(mesh::raised)?;
    let origins = origins.into_iter().map(|origin| (origin + middle).to_array());
    let directions = directions.into_iter().map(|direction| direction.to_array());
    Ok((rows(py, origins.collect())?, rows(py, directions.collect())?))
}

/// Renders a scene, a mesh file or a mesh; returns the requested arrays by name, and warnings.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "those of the Python function")]
pub fn render<'py>(
    py: Python<'py>,
    source: Source<'_>,
    size: [u32; 2],
    camera: Option<Camera>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    lens: [Option<f64>; 4],
    style: Option<&str>,
    samples: Option<&str>,
    with_aovs: bool,
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let style = match style {
        None => None,
        Some("plain") => Some(Style::Plain),
        Some("studio") => Some(Style::Studio),
        Some("clay") => Some(Style::Clay),
        Some(other) => {
            let why = format!("style: expected plain, studio or clay, found {other:?}");
            return Err(PyValueError::new_err(why));
        }
    };
    let (mesh, middle) = match &source {
        Source::Mesh(mesh) => {
            let (mesh, middle) = copied(py, mesh);
            (Some(mesh), middle)
        }
        Source::File(_) => (None, DVec3::ZERO),
    };
    let view = options(camera, target, up, lens, middle);
    let path = match &source {
        Source::File(path) => path.clone(),
        Source::Mesh(_) => PathBuf::new(),
    };
    let pool = match &source {
        Source::Mesh(mesh) => mesh.threads().pool()?,
        Source::File(_) => threads::shared()?,
    };
    let done = threads::interruptible(py, |cancelled| {
        let subject = match mesh {
            Some(mesh) => Subject::Mesh(mesh),
            None => Subject::File(Path::new(&path)),
        };
        pool.install(|| {
            picture::picture(subject, view, size, style, samples, with_aovs, &|_| {
                if cancelled.load(Ordering::Relaxed) {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            })
        })
    })?;
    let picture = done.map_err(|error| raised(&error))?;
    arrays(py, picture, size)
}

/// The arrays of a picture.
fn arrays<'py>(
    py: Python<'py>,
    picture: Picture,
    [width, height]: [u32; 2],
) -> PyResult<(Bound<'py, PyDict>, Vec<String>)> {
    let (width, height) = (width as usize, height as usize);
    let arrays = PyDict::new(py);
    arrays.set_item(
        "color",
        picture.color.into_pyarray(py).reshape([height, width, 3])?,
    )?;
    if let Some(aovs) = picture.aovs {
        let pixels = &aovs.pixels;
        let depth: Vec<f32> = pixels.iter().map(|pixel| pixel.depth).collect();
        let normal: Vec<f32> = pixels.iter().flat_map(|pixel| pixel.normal).collect();
        let albedo: Vec<f32> = pixels.iter().flat_map(|pixel| pixel.albedo).collect();
        let id: Vec<u32> = pixels.iter().map(|pixel| pixel.primitive.0).collect();
        arrays.set_item("depth", depth.into_pyarray(py).reshape([height, width])?)?;
        arrays.set_item("normal", normal.into_pyarray(py).reshape([height, width, 3])?)?;
        arrays.set_item("albedo", albedo.into_pyarray(py).reshape([height, width, 3])?)?;
        arrays.set_item("id", id.into_pyarray(py).reshape([height, width])?)?;
    }
    Ok((arrays, picture.notes))
}
