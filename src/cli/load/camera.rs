//! The camera: a start view from the options, the file, the classic viewpoints or the framing of a mesh, then changed
//! by `--target`, `--up`, `--fov`, `--ortho`, `--aperture` and `--focus`.

use crate::{
    classic,
    cli::{
        CliError,
        plan::{CameraOptions, FOCUS, MeshOptions, Orbit, Side, StartView},
    },
    error::clip,
    format::mesh::{LoadedMesh, UpAxis, index_of, listed},
    scene::{Camera, FitView, Lens, NamedCamera, Projection, Scene, View},
};
use glam::{DMat3, DVec3};

/// A focus distance at which no usable aperture is too large.
const FAR: f64 = 1e9;

/// The side from which a mesh is shown: to the right of its front, and high enough to show the top of a box.
const THREE_QUARTER: Side = Side {
    azimuth: 35.0,
    elevation: 27.0,
};
/// The same in plain pictures.
const PLAIN: Side = Side {
    elevation: 20.0,
    ..THREE_QUARTER
};
/// The highest elevation, degrees: from straight above, the up axis would have no direction in the picture.
const STEEPEST: f64 = 89.99;

impl CameraOptions {
    /// Rejects options that make no valid view with any scene.
    ///
    /// # Errors
    /// [`CliError::Usage`].
    pub fn check(&self) -> Result<(), CliError> {
        let (eye, target) = match self.start {
            StartView::Side(Side { azimuth, elevation })
                if !azimuth.is_finite() || !(-90.0..=90.0).contains(&elevation) =>
            {
                let why = "--from: expected an elevation from -90 to 90 degrees";
                return Err(CliError::Usage(why.into()));
            }
            StartView::Eye(eye) => (eye, self.target),
            _ => (DVec3::new(1.0, 2.0, 3.0), None),
        };
        let target = target.unwrap_or(eye + DVec3::new(0.3, 0.5, 0.7));
        // Any axis that is not along the view.
        let across = (target - eye)
            .try_normalize()
            .map_or(DVec3::Z, DVec3::any_orthonormal_vector);
        if self.fits_ortho && !matches!(self.start, StartView::Default | StartView::Side(_)) {
            let why = "--ortho fit frames the mesh: give a side with --from, or the height of the view";
            return Err(CliError::Usage(why.into()));
        }
        Camera::new(&View {
            eye,
            target,
            up: self.up.unwrap_or(across),
            projection: self.projection.unwrap_or(Projection::DEFAULT),
            lens: Lens {
                aperture: self.aperture.unwrap_or(0.0),
                focus: self.focus.or(Some(FAR)),
            },
        })?;
        Ok(())
    }

    /// The camera, if it does not depend on the scene.
    ///
    /// # Errors
    /// [`CliError::Usage`] if the options make no view.
    pub fn without_scene(&self) -> Result<Option<Camera>, CliError> {
        let view = match self.start {
            StartView::Eye(eye) => View {
                eye,
                target: classic::TARGET,
                up: View::UP,
                projection: Projection::DEFAULT,
                lens: Lens::PINHOLE,
            },
            StartView::Classic(number) => viewpoint(number)?,
            StartView::Default | StartView::Named(_) | StartView::Side(_) => return Ok(None),
        };
        self.applied_to(view).map(Some)
    }

    /// The index of the selected camera among a scene's own and then those of its meshes; `None` for a viewpoint.
    fn selected(&self, scene: &Scene) -> Result<Option<usize>, CliError> {
        let StartView::Named(name) = &self.start else {
            let is_own = !matches!(self.start, StartView::Eye(_) | StartView::Classic(_));
            return Ok((is_own && !scene.cameras().is_empty()).then_some(0));
        };
        let cameras = scene.cameras().iter().chain(scene.mesh_cameras());
        let names: Vec<&str> = cameras
            .map(|camera| camera.name.as_deref().unwrap_or_default())
            .collect();
        find("the scene", &names, name).map(Some)
    }

    /// Whether there is a lens: that of the options, or of the selected camera of a scene, at any of its keyframes.
    pub fn has_lens(&self, scene: Option<&Scene>) -> bool {
        let own = |scene: &Scene| matches!(self.selected(scene), Ok(Some(index)) if scene.has_lens(index));
        self.aperture
            .map_or_else(|| scene.is_some_and(own), |aperture| aperture > 0.0)
    }

    /// The camera for a scene.
    ///
    /// # Errors
    /// [`CliError::Usage`]: no such camera, or the options make no view.
    pub fn for_scene(&self, scene: &Scene) -> Result<Camera, CliError> {
        self.at_time(scene, scene.cameras(), scene.time())
    }

    /// The camera for a scene at a time, at which its own cameras are `own`.
    ///
    /// # Errors
    /// As [`Self::for_scene`].
    pub fn at_time(&self, scene: &Scene, own: &[NamedCamera], time: f64) -> Result<Camera, CliError> {
        if let Some(camera) = self.without_scene()? {
            return Ok(camera);
        }
        let mut cameras = own.iter().chain(scene.mesh_cameras());
        let selected = self.selected(scene)?;
        let view = match selected.and_then(|index| cameras.nth(index)) {
            Some(selected) => selected.camera.view(),
            None => viewpoint(1)?,
        };
        let view = self.changed(view, self.has_lens(Some(scene)))?;
        Camera::new(&view).map_err(|error| match CliError::from(error) {
            CliError::Usage(why) if scene.moving_counts()[1] > 0 => {
                CliError::Usage(format!("{why} (in frame {time})"))
            }
            error => error,
        })
    }

    /// The camera for a mesh whose `up` axis points up. By default it frames the mesh for a picture of that aspect
    /// (width over height); on an orbit, from all sides. An orthographic camera stands where a
    /// perspective one would. If keys have turned the mesh, a side is framed again, and any other view is turned, too.
    ///
    /// # Errors
    /// [`CliError::Usage`]: no such camera, or the options make no view.
    pub fn for_mesh(
        &self,
        mesh: &LoadedMesh,
        up: UpAxis,
        aspect: f64,
        shown: &MeshOptions,
    ) -> Result<Camera, CliError> {
        let turned = shown.turned;
        let is_side = matches!(self.start, StartView::Default | StartView::Side(_)) && self.up.is_none();
        if is_side || turned == DMat3::IDENTITY {
            return self.for_mesh_at_start(mesh, up, aspect, shown);
        }
        let is_before = |axis: &UpAxis| turned * axis.vector() == up.vector();
        let before = UpAxis::ALL.into_iter().find(is_before).unwrap_or(up);
        let camera = self.for_mesh_at_start(mesh, before, aspect, shown)?;
        let View { eye, target, up, .. } = camera.view();
        Ok(Camera::new(&View {
            eye: target + turned * (eye - target),
            up: turned * up,
            ..camera.view()
        })?)
    }

    /// The camera for a mesh that is not turned.
    fn for_mesh_at_start(
        &self,
        mesh: &LoadedMesh,
        up: UpAxis,
        aspect: f64,
        shown: &MeshOptions,
    ) -> Result<Camera, CliError> {
        let (mut eye, mut side) = (
            None,
            if shown.style.is_soft() {
                THREE_QUARTER
            } else {
                PLAIN
            },
        );
        match &self.start {
            StartView::Named(name) => {
                let names: Vec<&str> = mesh.cameras.iter().map(|camera| camera.name.as_str()).collect();
                let camera = &mesh.cameras[find(MESH, &names, name)?];
                return self
                    .applied_to(camera.view())
                    .map_err(|error| of_camera(name, &error));
            }
            StartView::Classic(number) => return self.applied_to(viewpoint(*number)?),
            StartView::Eye(from) => eye = Some(*from),
            StartView::Side(from) => side = *from,
            StartView::Default => {}
        }
        let framed = FitView {
            towards_viewer: towards(side, up),
            up: self.up.unwrap_or(up.vector()),
            fov_degrees: match self.projection {
                _ if self.fits_ortho => None,
                Some(Projection::Perspective { fov_degrees }) => Some(fov_degrees),
                _ => Some(View::FOV_DEGREES),
            },
            aspect,
        };
        let cloud = mesh.cloud.as_ref();
        let reach = cloud.map_or(0.0, |cloud| cloud.radius(&mesh.columns).into());
        let fit = match shown.orbit {
            None => framed.fit_around(&mesh.placed(), reach)?,
            Some(Orbit::Turn) => framed.fit_turning_around(&mesh.placed(), reach)?,
            Some(Orbit::Sphere) => framed.fit_sphere_around(&mesh.placed(), reach)?,
        };
        // The mesh is relative to its offset, the camera is not.
        let target = self.target.unwrap_or(fit.target + mesh.offset);
        let projection = if self.fits_ortho {
            Projection::Orthographic { height: fit.height }
        } else {
            Projection::DEFAULT
        };
        self.applied_to(View {
            // A target without an eye moves the view and keeps its direction.
            eye: eye.unwrap_or(target + fit.eye - fit.target),
            target,
            up: framed.up,
            projection,
            lens: Lens::PINHOLE,
        })
    }

    /// The camera of a view without a lens.
    fn applied_to(&self, view: View) -> Result<Camera, CliError> {
        Ok(Camera::new(&self.changed(view, self.has_lens(None))?)?)
    }

    /// A view with the changes of the options. In single frames a lens may have an aperture of 0.
    fn changed(&self, view: View, has_lens: bool) -> Result<View, CliError> {
        let is_stray = !has_lens && self.defaults.contains(&FOCUS);
        let focus = self.focus.filter(|_| !is_stray);
        if focus.is_some() && !has_lens {
            let why = "--focus needs a lens: give its diameter with --aperture";
            return Err(CliError::Usage(why.into()));
        }
        Ok(View {
            eye: view.eye,
            target: self.target.unwrap_or(view.target),
            up: self.up.unwrap_or(view.up),
            projection: self.projection.unwrap_or(view.projection),
            lens: Lens {
                aperture: self.aperture.unwrap_or(view.lens.aperture),
                focus: focus.or(view.lens.focus),
            },
        })
    }
}

fn viewpoint(number: u32) -> Result<View, CliError> {
    View::classic(number).ok_or_else(|| CliError::Usage(format!("no viewpoint {number}, expected 1 to 6")))
}

/// The direction from the mesh to the viewer. The front is as in Blender and glTF.
fn towards(side: Side, axis: UpAxis) -> DVec3 {
    let (sin_a, cos_a) = libm::sincos(side.azimuth.to_radians());
    let rise = libm::tan(side.elevation.clamp(-STEEPEST, STEEPEST).to_radians());
    axis.right() * sin_a + axis.front() * cos_a + axis.vector() * rise
}

/// What messages call a mesh.
const MESH: &str = "the mesh";

/// The index of the camera of that name or number (from 1 on).
fn find(owner: &str, names: &[&str], wanted: &str) -> Result<usize, CliError> {
    index_of(names, wanted).ok_or_else(|| CliError::Usage(no_camera(owner, names, wanted)))
}

/// The error about a camera of the file that makes no picture.
fn of_camera(name: &str, error: &CliError) -> CliError {
    CliError::Usage(format!(
        "camera `{}`: {}",
        clip(name),
        error.text().unwrap_or_default()
    ))
}

/// The message for an unknown camera.
fn no_camera(owner: &str, names: &[&str], wanted: &str) -> String {
    let found = clip(wanted);
    if names.is_empty() {
        let other = if owner == MESH { "--from" } else { "--view" };
        return format!("no camera `{found}`: {owner} defines none; use {other} or --eye");
    }
    if names == [""] {
        return format!(
            "no camera `{found}`: {owner} has one camera, without a name; choose it with --camera 1"
        );
    }
    // The distance takes quadratic time and memory.
    let near = names
        .iter()
        .filter(|other| !other.is_empty() && wanted.len() < 100 && wanted.parse::<u32>().is_err())
        .map(|other| (strsim::damerau_levenshtein(wanted, other), other))
        .min()
        .filter(|(distance, other)| *distance <= other.len().div_ceil(3));
    if let Some((_, near)) = near {
        return format!("no camera `{found}` in {owner}, did you mean `{}`?", clip(near));
    }
    format!("no camera `{found}` in {owner}, expected {}", listed(names))
}
