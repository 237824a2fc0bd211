//! An environment map that lights a mesh.

use crate::{
    error::LoadError,
    format::{self, Limits, mesh::UpAxis},
    scene::EnvironmentPicture,
};
use std::path::Path;

/// The mean light from all directions, so that most surfaces are neither dark nor white.
const MEAN_LIGHT: f32 = 0.5;

/// Reads the picture of an environment, turned by some degrees: its middle is behind the mesh for a viewer who faces the front.
///
/// # Errors
/// [`LoadError`].
pub(super) fn load(
    (path, degrees): (&Path, f64),
    up: UpAxis,
    limits: impl Into<Limits>,
    notes: &mut Vec<String>,
) -> Result<EnvironmentPicture, LoadError> {
    let ((size, texels), note) = format::environment::load(path, limits)?;
    notes.extend(note);
    let picture = EnvironmentPicture::new(size, texels, degrees, 1.0);
    let picture = picture.map_err(|error| LoadError::whole_file(path, error.to_string()))?;
    let behind = -up.front().as_vec3();
    Ok(picture
        .with_mean(MEAN_LIGHT)
        .turned(behind, up.vector().as_vec3()))
}
