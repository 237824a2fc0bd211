//! The picture on its way to a file, in the pixels that the file will hold.

use super::{encode::Format, exr_layers::Channel};
use crate::{
    render::{ByteFilm, Film, FrameStats, OnProgress, RenderError, Renderer, Settings, Transfer},
    scene::Camera,
};

/// The picture's colours.
pub enum Pixels {
    Bytes(ByteFilm),
    Linear(Film),
    /// With alpha.
    Transparent(Film<[f32; 4]>),
}

/// A picture for one file.
pub struct Picture {
    pub pixels: Pixels,
    /// How channels become bytes that are not bytes already.
    pub transfer: Transfer,
    /// What an EXR file holds besides the colours.
    pub layers: Vec<Channel>,
}

impl Picture {
    /// An empty picture for a file of that format. Rendering gives it its size.
    pub fn new(format: Format, transfer: Transfer, transparent: bool) -> Self {
        let pixels = if transparent {
            Pixels::Transparent(Film::black(0, 0))
        } else if format == Format::Exr || transfer != Transfer::Linear {
            Pixels::Linear(Film::new(0, 0))
        } else {
            Pixels::Bytes(ByteFilm::black(0, 0))
        };
        Self {
            transfer,
            ..Self::from(pixels)
        }
    }

    /// How many pixels it has.
    pub fn pixel_count(&self) -> usize {
        match &self.pixels {
            Pixels::Bytes(film) => film.pixels().len(),
            Pixels::Linear(film) => film.pixels().len(),
            Pixels::Transparent(film) => film.pixels().len(),
        }
    }

    /// Renders into the picture.
    ///
    /// # Errors
    /// [`RenderError`]. After [`RenderError::Cancelled`] there is what was done until then; the rest is black, or
    /// transparent.
    pub fn render(
        &mut self,
        renderer: &mut Renderer<'_>,
        camera: &Camera,
        settings: &Settings,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        match &mut self.pixels {
            Pixels::Bytes(film) => renderer.render(camera, settings, film, on_progress),
            Pixels::Linear(film) => renderer.render(camera, settings, film, on_progress),
            Pixels::Transparent(film) => renderer.render(camera, settings, film, on_progress),
        }
    }
}

impl From<Pixels> for Picture {
    fn from(pixels: Pixels) -> Self {
        Self {
            pixels,
            transfer: Transfer::Linear,
            layers: Vec::new(),
        }
    }
}
