//! Cameras, and the rays of their pictures.

use crate::{
    arrays::rows,
    shared,
    solid::{self, Solid},
    threads,
    words::raised,
};
use numpy::PyArray2;
use octray::{
    QueryError,
    cli::picture::{self, CameraOptions, MeshOptions, Side, StartView},
    format::mesh::UpAxis,
    glam::DVec3,
    scene::{Projection, View},
};
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rays in a band of rows, between two checks for Ctrl-C: a few milliseconds.
const BAND: u32 = 1 << 18;

/// Where a camera starts: a classic viewpoint, one of the file by name, or an eye.
#[derive(FromPyObject)]
pub enum Start {
    Number(u32),
    Name(String),
    Eye([f64; 3]),
    /// Azimuth and elevation, degrees.
    Side([f64; 2]),
}

/// A camera, as `octray.render` has checked it.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Camera {
    start: Option<Start>,
    target: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    fov: Option<f64>,
    ortho: Option<f64>,
    /// Whether an orthographic view frames the mesh.
    fits: bool,
    aperture: Option<f64>,
    focus: Option<f64>,
}

impl Camera {
    /// The camera of a picture without a mesh, which would have the `up` axis; as it is where it frames a mesh.
    fn without_mesh(self, up: UpAxis) -> Self {
        match self.start {
            Some(Start::Eye(_)) => Self {
                up: self.up.or(Some(up.vector().to_array())),
                ..self
            },
            _ => self,
        }
    }

    /// Whether it is the same for every mesh with the same up axis.
    fn needs_no_mesh(&self) -> bool {
        match self.start {
            Some(Start::Number(_)) => true,
            Some(Start::Eye(_)) => self.target.is_some(),
            _ => false,
        }
    }

    /// The program's options, relative to `middle`.
    pub fn options(self, middle: DVec3) -> CameraOptions {
        // Classic viewpoints are near 0, wherever the mesh is.
        let classic = match self.start {
            Some(Start::Number(number)) if middle != DVec3::ZERO => View::classic(number),
            _ => None,
        };
        CameraOptions {
            start: match (self.start, classic) {
                (_, Some(view)) => StartView::Eye(view.eye - middle),
                (None, _) => StartView::Default,
                (Some(Start::Number(number)), _) => StartView::Classic(number),
                (Some(Start::Name(name)), _) => StartView::Named(name),
                (Some(Start::Eye(eye)), _) => StartView::Eye(DVec3::from(eye) - middle),
                (Some(Start::Side([azimuth, elevation])), _) => StartView::Side(Side { azimuth, elevation }),
            },
            target: self
                .target
                .map(DVec3::from)
                .or(classic.map(|view| view.target))
                .map(|target| target - middle),
            up: self.up.map(DVec3::from).or(classic.map(|view| view.up)),
            projection: match (self.fov, self.ortho) {
                _ if self.fits => None,
                (_, Some(height)) => Some(Projection::Orthographic { height }),
                (Some(fov_degrees), None) => Some(Projection::Perspective { fov_degrees }),
                (None, None) => classic.map(|view| view.projection),
            },
            fits_ortho: self.fits,
            aperture: self.aperture,
            focus: self.focus,
            ..CameraOptions::default()
        }
    }
}

/// Origins and directions, a row each.
type Rays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f32>>);

/// Returns the origins and directions of the rays through the pixels' centres.
#[pyfunction]
pub fn camera_rays<'py>(
    py: Python<'py>,
    mesh: Option<Solid<'_>>,
    size: [u32; 2],
    camera: Camera,
    style: Option<&str>,
    up_axis: Option<&str>,
) -> PyResult<Rays<'py>> {
    let shown = MeshOptions {
        up_axis: solid::up_axis(up_axis)?,
        ..solid::styled(style)?
    };
    let shown_mesh = mesh.as_ref().map(|mesh| mesh.now(py)).transpose()?;
    let middle = match (&shown_mesh, &camera.start) {
        (Some(mesh), _) => mesh.middle(),
        // Origins are rounded around the eye.
        (None, Some(Start::Eye(eye))) => DVec3::from(*eye),
        (None, _) => DVec3::ZERO,
    };
    // Framing a large mesh takes time.
    let is_alone = camera.needs_no_mesh();
    let shown_mesh = shown_mesh.filter(|_| !is_alone);
    let camera = if is_alone {
        camera.without_mesh(shown.up_axis.unwrap_or(UpAxis::Z))
    } else {
        camera
    };
    let pool = match &mesh {
        Some(mesh) => mesh.threads().pool()?,
        None => threads::shared()?,
    };
    let view = camera.options(middle);
    let found = threads::interruptible(py, &pool, |cancelled| {
        let points = shown_mesh.map(|mesh| mesh.parts(|_, geometry| solid::outline(geometry)));
        let camera = picture::camera(points, &view, &shown, size);
        camera.map(|camera| rays_of(&camera, middle, size, cancelled))
    })?;
    let (origins, directions) = found.map_err(|error| raised(&error))?.map_err(shared::raised)?;
    Ok((rows(py, origins)?, rows(py, directions)?))
}

/// Origins, world space, and directions.
type Arrays = (Vec<[f64; 3]>, Vec<[f32; 3]>);

/// The rays of a camera that is relative to `middle`, in bands of rows until the call is cancelled.
fn rays_of(
    camera: &octray::scene::Camera,
    middle: DVec3,
    size: [u32; 2],
    cancelled: &AtomicBool,
) -> Result<Arrays, QueryError> {
    let [width, height] = size;
    let is_parallel = matches!(camera.view().projection, Projection::Orthographic { .. });
    let count = width as usize * height as usize;
    let (mut origins, mut directions) = (Vec::new(), Vec::new());
    let no_memory = |_| QueryError::NoMemory {
        what: "the rays of the camera",
    };
    origins
        .try_reserve_exact(if is_parallel { count } else { 1 })
        .map_err(no_memory)?;
    directions.try_reserve_exact(count).map_err(no_memory)?;
    let band = (BAND / width).max(1);
    for top in (0..height).step_by(band as usize) {
        if cancelled.load(Ordering::Relaxed) {
            break;
        }
        let rays = camera.rays_of_rows(DVec3::ZERO, size, top..top.saturating_add(band))?;
        if is_parallel || top == 0 {
            origins.par_extend(
                rays.origins
                    .par_iter()
                    .map(|&origin| (origin + middle).to_array()),
            );
        }
        directions.par_extend(rays.directions.par_iter().map(|direction| direction.to_array()));
    }
    Ok((origins, directions))
}
