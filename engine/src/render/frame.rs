//! Rendering a single frame, and the state that its tiles share.

use super::{
    Crop, Film, Frame, FrameStats, OnProgress, RenderError, Renderer, Settings, sampling::CameraRays,
};
use crate::{
    accel::Bvh,
    scene::{Camera, EdgeLines, MaterialId, Scene},
};

/// A tile's rectangle in the film, pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TileRect {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl TileRect {
    /// Returns the rectangle of a tile of `window` in the whole picture.
    pub fn absolute(self, window: Crop) -> Self {
        Self {
            x: window.x0 + self.x,
            y: window.y0 + self.y,
            ..self
        }
    }

    /// Returns every pixel, row by row.
    pub fn each_pixel(self) -> impl Iterator<Item = [u32; 2]> {
        let rows = self.y..self.y + self.height;
        rows.flat_map(move |y| (self.x..self.x + self.width).map(move |x| [x, y]))
    }

    /// Returns the number of pixels.
    pub fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }
}

/// The state that all tiles of a frame share.
#[derive(Clone, Copy)]
pub(super) struct FrameContext<'a> {
    pub scene: &'a Scene,
    pub bvh: &'a Bvh,
    pub camera_rays: CameraRays,
    /// The tinted glass that the camera's eye is in.
    pub medium: Option<MaterialId>,
    /// The edges that are drawn.
    pub edges: Option<EdgeLines>,
    /// The film's rectangle in the picture.
    pub window: Crop,
    pub settings: Settings,
}

/// Renders one frame of `scene`; `bvh` must have been built from it. For several frames a [`Renderer`] is faster,
/// because it keeps threads and memory.
///
/// # Errors
/// [`RenderError`], as [`Renderer::render`].
pub fn render(
    scene: &Scene,
    bvh: &Bvh,
    camera: &Camera,
    settings: &Settings,
    on_progress: OnProgress<'_>,
) -> Result<Frame, RenderError> {
    let mut film = Film::new(0, 0);
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
