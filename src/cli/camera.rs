//! Which camera a command takes: the options', the scene's own, or the course's.

use super::{CliError, args::CameraArgs};
use crate::{
    course,
    error::escape,
    scene::{Camera, NamedCamera, Scene, View},
};
use clap::error::{ContextKind, ContextValue, ErrorKind};

impl CameraArgs {
    /// The camera, where it does not depend on the scene: so that its faults are told before anything is loaded.
    ///
    /// # Errors
    /// [`CliError::Usage`], where the options make no view.
    pub fn without_scene(&self) -> Result<Option<Camera>, CliError> {
        let view = match (self.eye, self.view) {
            (Some(eye), _) => View {
                eye,
                target: course::TARGET,
                up: View::UP,
                fov_degrees: View::FOV_DEGREES,
            },
            (None, Some(number)) => viewpoint(number)?,
            (None, None) => return Ok(None),
        };
        self.applied_to(view).map(Some)
    }

    /// The camera for a scene: that of --eye or --view, else the one that --camera names, else the scene's first one,
    /// else the course's first viewpoint. --target, --up and --fov change it.
    ///
    /// # Errors
    /// [`CliError::Usage`]: no such camera, or the options make no view.
    pub fn for_scene(&self, scene: &Scene) -> Result<Camera, CliError> {
        if let Some(camera) = self.without_scene()? {
            return Ok(camera);
        }
        let cameras = scene.cameras();
        let view = match &self.camera {
            Some(name) => named(cameras, name)?.camera.view(),
            None => match cameras.first() {
                Some(first) => first.camera.view(),
                None => viewpoint(1)?,
            },
        };
        self.applied_to(view)
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
    View::course(number)
        .ok_or_else(|| CliError::Usage(format!("there is no viewpoint {number}, expected 1 to 6")))
}

fn named<'a>(cameras: &'a [NamedCamera], name: &str) -> Result<&'a NamedCamera, CliError> {
    let found = cameras.iter().find(|camera| camera.name.as_deref() == Some(name));
    found.ok_or_else(|| CliError::Usage(no_camera(cameras, name)))
}

/// What is said where a scene has no camera of that name.
fn no_camera(cameras: &[NamedCamera], name: &str) -> String {
    const MOST_NAMES: usize = 8;
    let found = escape(name);
    let names: Vec<&str> = cameras
        .iter()
        .filter_map(|camera| camera.name.as_deref())
        .collect();
    let near = names
        .iter()
        .map(|other| (strsim::damerau_levenshtein(name, other), other))
        .min()
        .filter(|(distance, other)| *distance <= other.len().div_ceil(3));
    if let Some((_, near)) = near {
        return format!(
            "the scene has no camera `{found}`, did you mean `{}`?",
            escape(near)
        );
    }
    if names.is_empty() {
        return format!(
            "the scene has no camera `{found}`, nor any other with a name: leave --camera out, or take --view or --eye"
        );
    }
    let mut list: Vec<String> = names
        .iter()
        .take(MOST_NAMES)
        .map(|name| format!("`{}`", escape(name)))
        .collect();
    if names.len() > MOST_NAMES {
        list.push("...".into());
    }
    format!("the scene has no camera `{found}`, expected {}", list.join(", "))
}

/// Adds to clap's word on options that exclude each other which of them would do.
pub fn explain_conflict(error: &mut clap::Error) {
    const PLACES: [&str; 3] = ["--camera", "--view", "--eye"];
    let is_place = |value: Option<&ContextValue>| {
        let options = match value {
            Some(ContextValue::String(option)) => std::slice::from_ref(option),
            Some(ContextValue::Strings(options)) => options,
            _ => &[],
        };
        !options.is_empty()
            && options
                .iter()
                .all(|option| PLACES.iter().any(|place| option.starts_with(place)))
    };
    if error.kind() == ErrorKind::ArgumentConflict
        && is_place(error.get(ContextKind::InvalidArg))
        && is_place(error.get(ContextKind::PriorArg))
    {
        let tip = "each of --camera, --view and --eye says where the camera stands: give one of them, and --target, \
                   --up or --fov to change the rest";
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
}
