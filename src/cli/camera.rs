//! Which camera a command takes: the options', the file's own, the course's, or one that frames a mesh.

use super::{CliError, camera_args::CameraArgs};
use crate::{
    classic,
    error::escape,
    format::mesh::{LoadedMesh, UpAxis},
    scene::{Camera, FitView, Scene, View},
};
use glam::DVec3;

/// From where a mesh is shown: this far to the right of its front, degrees, ...
const AZIMUTH_DEGREES: f64 = 35.0;
/// ... and this far above.
const ELEVATION_DEGREES: f64 = 20.0;

impl CameraArgs {
    /// Refuses what makes no view whatever is loaded.
    ///
    /// # Errors
    /// [`CliError::Usage`].
    pub fn check(&self) -> Result<(), CliError> {
        let eye = self.eye.unwrap_or(DVec3::new(1.0, 2.0, 3.0));
        let target = self.target.filter(|_| self.eye.is_some());
        let target = target.unwrap_or(eye + DVec3::new(0.3, 0.5, 0.7));
        // Any axis that is not along the view.
        let across = (target - eye)
            .try_normalize()
            .map_or(DVec3::Z, DVec3::any_orthonormal_vector);
        let fov = self.fov.unwrap_or(View::FOV_DEGREES);
        Camera::look_at(eye, target, self.up.unwrap_or(across), fov)?;
        Ok(())
    }

    /// The camera, where it does not depend on the scene: so that its faults are told before anything is loaded.
    ///
    /// # Errors
    /// [`CliError::Usage`], where the options make no view.
    pub fn without_scene(&self) -> Result<Option<Camera>, CliError> {
        let view = match (self.eye, self.view) {
            (Some(eye), _) => View {
                eye,
                target: classic::TARGET,
                up: View::UP,
                fov_degrees: View::FOV_DEGREES,
            },
            (None, Some(number)) => viewpoint(number)?,
            (None, None) => return Ok(None),
        };
        self.applied_to(view).map(Some)
    }

    /// The camera for a scene: that of --eye or --view, else the one that --camera names, of the scene or of a mesh in it,
    /// else the scene's own first one, else the course's first viewpoint. --target, --up and --fov change it.
    ///
    /// # Errors
    /// [`CliError::Usage`]: no such camera, or the options make no view.
    pub fn for_scene(&self, scene: &Scene) -> Result<Camera, CliError> {
        if let Some(camera) = self.without_scene()? {
            return Ok(camera);
        }
        let view = match &self.camera {
            Some(name) => {
                let cameras: Vec<_> = scene.cameras().iter().chain(scene.mesh_cameras()).collect();
                let names: Vec<&str> = cameras
                    .iter()
                    .map(|camera| camera.name.as_deref().unwrap_or_default())
                    .collect();
                cameras[find("the scene", &names, name)?].camera.view()
            }
            None => match scene.cameras().first() {
                Some(first) => first.camera.view(),
                None => viewpoint(1)?,
            },
        };
        self.applied_to(view)
    }

    /// The camera for a mesh whose `up` axis points up: the one of the file that --camera names, that of --view, else
    /// one that frames the mesh for a picture of that aspect (width over height). --eye, --target, --up and --fov
    /// change it. `turning`: the framing is to hold all the way round the up axis.
    ///
    /// # Errors
    /// [`CliError::Usage`]: no such camera, or the options make no view.
    pub fn for_mesh(
        &self,
        mesh: &LoadedMesh,
        up: UpAxis,
        aspect: f64,
        turning: bool,
    ) -> Result<Camera, CliError> {
        if let Some(name) = &self.camera {
            let names: Vec<&str> = mesh.cameras.iter().map(|camera| camera.name.as_str()).collect();
            let camera = &mesh.cameras[find("the mesh", &names, name)?];
            return self.applied_to(camera.view());
        }
        if let Some(number) = self.view {
            return self.applied_to(viewpoint(number)?);
        }
        let framed = FitView {
            towards_viewer: three_quarter(up),
            up: self.up.unwrap_or(up.vector()),
            fov_degrees: self.fov.unwrap_or(View::FOV_DEGREES),
            aspect,
        };
        let fit = if turning {
            framed.fit_turning(&mesh.columns)?
        } else {
            framed.fit(&mesh.columns)?
        };
        let target = self.target.unwrap_or(fit.target);
        self.applied_to(View {
            // Without an eye of its own, a target moves the view and leaves its direction.
            eye: self.eye.unwrap_or(target + fit.eye - fit.target),
            target,
            up: framed.up,
            fov_degrees: framed.fov_degrees,
        })
    }

    fn applied_to(&self, view: View) -> Result<Camera, CliError> {
        Ok(Camera::new(&View {
            eye: view.eye,
            target: self.target.unwrap_or(view.target),
            up: self.up.unwrap_or(view.up),
            fov_degrees: self.fov.unwrap_or(view.fov_degrees),
        })?)
    }
}

fn viewpoint(number: u32) -> Result<View, CliError> {
    View::classic(number)
        .ok_or_else(|| CliError::Usage(format!("there is no viewpoint {number}, expected 1 to 6")))
}

/// From the front, the right and above. A mesh's front is where it looks in Blender's and glTF's conventions.
fn three_quarter(axis: UpAxis) -> DVec3 {
    let (sin_a, cos_a) = libm::sincos(AZIMUTH_DEGREES.to_radians());
    let rise = libm::tan(ELEVATION_DEGREES.to_radians());
    axis.right() * sin_a + axis.front() * cos_a + axis.vector() * rise
}

/// Which camera of `owner` is called so; one without a name (empty) goes by its number from 1 on.
fn find(owner: &str, names: &[&str], wanted: &str) -> Result<usize, CliError> {
    let by_number = || {
        wanted
            .parse::<usize>()
            .ok()?
            .checked_sub(1)
            .filter(|&i| i < names.len())
    };
    names
        .iter()
        .position(|&name| name == wanted && !name.is_empty())
        .or_else(by_number)
        .ok_or_else(|| CliError::Usage(no_camera(owner, names, wanted)))
}

/// What is said where there is no camera of that name.
fn no_camera(owner: &str, names: &[&str], wanted: &str) -> String {
    const MOST_NAMES: usize = 8;
    let found = escape(wanted);
    if names.is_empty() {
        return format!(
            "{owner} has no camera `{found}`, nor any other: leave --camera out, or take --view or --eye"
        );
    }
    let near = names
        .iter()
        .filter(|other| !other.is_empty())
        .map(|other| (strsim::damerau_levenshtein(wanted, other), other))
        .min()
        .filter(|(distance, other)| *distance <= other.len().div_ceil(3));
    if let Some((_, near)) = near {
        return format!(
            "{owner} has no camera `{found}`, did you mean `{}`?",
            escape(near)
        );
    }
    let mut list: Vec<String> = (1..)
        .zip(names)
        .take(MOST_NAMES)
        .map(|(number, &name)| match name {
            "" => format!("{number} (it has no name)"),
            name => format!("`{}`", escape(name)),
        })
        .collect();
    if names.len() > MOST_NAMES {
        list.push("...".into());
    }
    format!("{owner} has no camera `{found}`, expected {}", list.join(", "))
}
