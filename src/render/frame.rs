//! One frame on its own, and what the tiles of a frame share.

use super::{
    Crop, Film, Frame, FrameStats, OnProgress, RenderError, Renderer, Settings, sampling::CameraRays,
};
use crate::{
    accel::Bvh,
    scene::{Camera, Scene},
};

/// A tile's place in the film, pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct TileRect {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

/// What all tiles of a frame share.
#[derive(Clone, Copy)]
pub(super) struct FrameContext<'a> {
    pub scene: &'a Scene,
    pub bvh: &'a Bvh,
    pub camera_rays: CameraRays,
    /// The film's place in the picture.
    pub window: Crop,
    pub settings: Settings,
}

/// Renders `scene` as `camera` sees it. `bvh` must have been built from `scene`. For several frames of a scene a
/// [`Renderer`] is faster: it keeps threads and memory.
///
/// # Errors
/// [`RenderError`]: a size out of its limits, threads that do not start, or cancelled by `on_progress`.
pub fn render(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    settings: &Settings,
    on_progress: OnProgress<'_>,
) -> Result<Frame, RenderError> {
    settings.validate()?;
    let window = settings.window();
    let mut film = Film::new(window.width(), window.height());
    let stats = Renderer::new(scene, bvh).render(camera, settings, &mut film, on_progress)?;
    let FrameStats {
        rays,
        elapsed,
        tile_times,
    } = stats;
    Ok(Frame {
        film,
        rays,
        elapsed,
        tile_times,
    })
}
