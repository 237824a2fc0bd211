//! Cameras, and the rays of their pictures.

use crate::{
    arrays::rows,
    mesh::{self, Mesh},
    solid, threads,
    words::raised,
};
use numpy::PyArray2;
use octray::{
    cli::picture::{self, CameraOptions, MeshOptions, Side, StartView},
    glam::DVec3,
    query::CameraRays,
    scene::{Projection, View},
};
use pyo3::prelude::*;

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
    /// Whether it is the same for every mesh.
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
    mesh: Option<PyRef<'_, Mesh>>,
    size: [u32; 2],
    camera: Camera,
    style: Option<&str>,
    up_axis: Option<&str>,
) -> PyResult<Rays<'py>> {
    let shown = MeshOptions {
        up_axis: solid::up_axis(up_axis)?,
        ..solid::styled(style)?
    };
    let geometry = mesh.as_ref().map(|mesh| mesh.geometry(py));
    let middle = match (&geometry, &camera.start) {
        (Some(geometry), _) => geometry.middle(),
        // Origins are rounded around the eye.
        (None, Some(Start::Eye(eye))) => DVec3::from(*eye),
        (None, _) => DVec3::ZERO,
    };
    let geometry = geometry.filter(|_| !camera.needs_no_mesh());
    let pool = match &mesh {
        Some(mesh) => mesh.threads().pool()?,
        None => threads::shared()?,
    };
    let view = camera.options(middle);
    let found = threads::interruptible(py, |_| {
        pool.install(|| {
            let points = geometry.map(|geometry| solid::points(&geometry));
            let camera = picture::camera(points, &view, &shown, size);
            camera.map(|camera| camera.rays(size[0], size[1]))
        })
    })?;
    let CameraRays { origins, directions } = found.map_err(|error| raised(&error))?.map_err(mesh::raised)?;
    let origins = origins.into_iter().map(|origin| (origin + middle).to_array());
    let directions = directions.into_iter().map(|direction| direction.to_array());
    Ok((rows(py, origins.collect())?, rows(py, directions.collect())?))
}
