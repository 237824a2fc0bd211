//! The picture on its way to a file, in the pixels that the file will hold.

use super::encode::Format;
use crate::{
    render::{ByteFilm, Film, FrameStats, OnProgress, RenderError, Renderer, Settings},
    scene::Camera,
};

/// A picture of bytes, or of linear floats for the formats that hold them.
pub enum Picture {
    Bytes(ByteFilm),
    Linear(Film),
}

impl Picture {
    /// An empty picture for a file of that format. Rendering gives it its size.
    pub fn new(format: Format) -> Self {
        match format {
            Format::Exr => Self::Linear(Film::new(0, 0)),
            _ => Self::Bytes(ByteFilm::black(0, 0)),
        }
    }

    /// Renders into the picture.
    ///
    /// # Errors
    /// [`RenderError`]. The picture is of no use then.
    pub fn render(
        &mut self,
        renderer: &mut Renderer<'_>,
        camera: &Camera,
        settings: &Settings,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        match self {
            Self::Bytes(film) => renderer.render(camera, settings, film, on_progress),
            Self::Linear(film) => renderer.render(camera, settings, film, on_progress),
        }
    }
}
