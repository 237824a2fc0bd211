//! How many rays a job traces, which decides how much work its BVH is worth.

use crate::{
    cli::{
        plan::{Job, Look},
        write::AovKind,
    },
    render::Settings,
    scene::{Camera, Scene},
};

/// The expected number of camera rays, and of shadow and ambient occlusion rays if each camera ray hits. Reflections
/// are not known beforehand.
pub(super) fn expected_rays((scene, camera): (&Scene, &Camera), look: &Look, job: &Job) -> f64 {
    let Look { settings, picture } = look;
    // The heat AOV depends on the BVH, so a crop must have the BVH of the whole picture.
    let (window, mut frames) = if picture.aovs.contains(&AovKind::Heat) {
        let whole = Settings {
            crop: None,
            ..*settings
        };
        (whole.window(), job.whole as usize)
    } else {
        (settings.window(), job.frames.len())
    };
    if job.input.mesh.playback.is_some() {
        frames = 1;
    }
    let lights = if settings.shadows {
        scene.lights().len() + usize::from(scene.ambient_reach().is_some()) + scene.environment_rays()
    } else {
        0
    };
    let pixels = f64::from(window.width()) * f64::from(window.height());
    pixels
        * frames as f64
        * settings.expected_samples(scene.is_sampled() || camera.has_lens())
        * (1.0 + lights as f64)
}
