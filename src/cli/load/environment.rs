//! An environment map that lights a mesh.

use crate::{
    error::{LoadError, SceneError},
    format::{self, Limits, mesh::UpAxis},
    scene::EnvironmentPicture,
};
use std::path::Path;

/// The mean light from all directions, so that most surfaces are neither dark nor white.
const MEAN_LIGHT: f64 = 0.5;

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
    let intensity = match mean_light(size, &texels) {
        mean if mean > 0.0 => (MEAN_LIGHT / mean).min(f64::from(f32::MAX)) as f32,
        _ => 1.0,
    };
    let picture = EnvironmentPicture::new(size, texels, degrees, intensity);
    let picture = picture.map_err(|error: SceneError| LoadError::whole_file(path, error.to_string()))?;
    Ok(picture.turned(-up.front().as_vec3(), up.vector().as_vec3()))
}

/// The mean luminance over all directions. Rows near the poles cover less of them.
fn mean_light([width, height]: [u32; 2], texels: &[[f32; 3]]) -> f64 {
    let (mut light, mut weights) = (0.0, 0.0);
    for (y, row) in texels.chunks_exact(width as usize).enumerate() {
        let weight = libm::sin((y as f64 + 0.5) / f64::from(height) * std::f64::consts::PI);
        let positive = |channel: f32| f64::from(channel).clamp(0.0, 65504.0);
        let luminance =
            |[r, g, b]: [f32; 3]| 0.2126 * positive(r) + 0.7152 * positive(g) + 0.0722 * positive(b);
        light += weight
            * row
                .iter()
                .map(|&texel| luminance(texel))
                .filter(|light| !light.is_nan())
                .sum::<f64>();
        weights += weight * row.len() as f64;
    }
    light / weights
}
