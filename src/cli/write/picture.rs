//! A picture in the kind of pixels that its file will hold.

use super::{encode::Format, exr_layers::Channel, place::Place};
use crate::{
    cli::plan::PictureOptions,
    render::{ByteFilm, Film, FrameStats, OnProgress, RenderError, Renderer, Settings, Transfer},
    scene::Camera,
};
use std::borrow::Cow;

/// The picture's colours.
pub enum Pixels {
    Bytes(ByteFilm),
    Linear(Film),
    /// With alpha.
    Transparent(Film<[f32; 4]>),
    /// Grey of 8 bits, or of 16 with the high byte first: AOVs that programs read, only for PNG.
    Gray {
        size: [u32; 2],
        bytes: Vec<u8>,
        pixel_bytes: usize,
    },
}

impl Pixels {
    /// Bytes of a pixel in files other than EXR.
    pub fn pixel_bytes(&self) -> usize {
        match self {
            Self::Bytes(_) | Self::Linear(_) => 3,
            Self::Transparent(_) => 4,
            Self::Gray { pixel_bytes, .. } => *pixel_bytes,
        }
    }
}

/// A picture for one file.
pub struct Picture {
    pub pixels: Pixels,
    /// How linear channels become bytes.
    pub transfer: Transfer,
    /// Other channels of an EXR file.
    pub layers: Vec<Channel>,
    /// Where it lies in the whole picture, if it is a crop.
    pub place: Option<Place>,
}

impl Picture {
    /// An empty picture for a file of that format. Rendering gives it its size.
    pub fn new(format: Format, options: &PictureOptions) -> Self {
        let transfer = options.transfer;
        let pixels = if options.transparent {
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

    /// Renders into the picture.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn render(
        &mut self,
        renderer: &mut Renderer<'_>,
        camera: &Camera,
        settings: &Settings,
        on_progress: OnProgress<'_>,
    ) -> Result<FrameStats, RenderError> {
        self.place = Place::of(settings, self.transfer);
        match &mut self.pixels {
            Pixels::Bytes(film) => renderer.render(camera, settings, film, on_progress),
            Pixels::Linear(film) => renderer.render(camera, settings, film, on_progress),
            Pixels::Transparent(film) => renderer.render(camera, settings, film, on_progress),
            // A rendered picture has colours.
            Pixels::Gray { .. } => {
                self.pixels = Pixels::Bytes(ByteFilm::black(0, 0));
                self.render(renderer, camera, settings, on_progress)
            }
        }
    }
}

impl Picture {
    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        match &self.pixels {
            Pixels::Bytes(film) => [film.width(), film.height()],
            Pixels::Linear(film) => [film.width(), film.height()],
            Pixels::Transparent(film) => [film.width(), film.height()],
            Pixels::Gray { size, .. } => *size,
        }
    }

    /// RGB, RGBA or grey.
    pub fn bytes(&self) -> Cow<'_, [u8]> {
        match &self.pixels {
            Pixels::Bytes(film) => Cow::Borrowed(film.pixels().as_flattened()),
            Pixels::Linear(film) => Cow::Owned(film.to_bytes(self.transfer)),
            Pixels::Transparent(film) => Cow::Owned(film.to_bytes(self.transfer)),
            Pixels::Gray { bytes, .. } => Cow::Borrowed(bytes),
        }
    }
}

impl From<Pixels> for Picture {
    fn from(pixels: Pixels) -> Self {
        Self {
            pixels,
            transfer: Transfer::Linear,
            layers: Vec::new(),
            place: None,
        }
    }
}
