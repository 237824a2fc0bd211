//! A picture in the kind of pixels that its file will hold.

use super::{color_bar::ColorBar, encode::Format, exr_layers::Channel, place::Place};
use crate::{
    cli::plan::{Backdrop, PictureOptions},
    math::srgb::decode,
    render::{
        ByteFilm, Crop, Film, FrameStats, OnProgress, RenderError, Renderer, Settings, Transfer, quantize,
    },
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
    /// The linear colour behind everything, if it is not the scene's background.
    pub behind: Option<[f32; 3]>,
}

/// Puts a picture in front of a colour.
fn in_front_of(color: [f32; 3], film: &Film<[f32; 4]>) -> Result<Film, RenderError> {
    let mut whole = Film::new(0, 0);
    let resized = whole.try_resize(film.width(), film.height());
    resized
        .map_err(|_| RenderError::Memory("not enough memory for the picture with its background".into()))?;
    for (pixel, &[r, g, b, alpha]) in whole.pixels_mut().iter_mut().zip(film.pixels()) {
        let rest = (1.0 - alpha).max(0.0);
        *pixel = [r + rest * color[0], g + rest * color[1], b + rest * color[2]];
    }
    Ok(whole)
}

/// The linear colour of these bytes.
fn linear(transfer: Transfer, color: [u8; 3]) -> [f32; 3] {
    color.map(|byte| match transfer {
        Transfer::Srgb => decode(f64::from(byte) / 255.0) as f32,
        Transfer::Linear => {
            let level = f32::from(byte) / 255.0;
            if quantize(level) < byte {
                level.next_up()
            } else {
                level
            }
        }
    })
}

impl Picture {
    /// An empty picture for a file of that format. Rendering gives it its size.
    pub fn new(format: Format, options: &PictureOptions) -> Self {
        let transfer = options.transfer;
        let behind = match options.backdrop {
            Backdrop::Color(color) => Some(linear(options.byte_transfer, color)),
            Backdrop::Scene | Backdrop::Transparent => None,
        };
        let pixels = if options.backdrop.is_transparent() {
            Pixels::Transparent(Film::black(0, 0))
        } else if format == Format::Exr || behind.is_some() || transfer != Transfer::Linear {
            Pixels::Linear(Film::new(0, 0))
        } else {
            Pixels::Bytes(ByteFilm::black(0, 0))
        };
        Self {
            transfer,
            behind,
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
        if let Some(color) = self.behind {
            let mut film = Film::<[f32; 4]>::black(0, 0);
            let stats = renderer.render(camera, settings, &mut film, on_progress)?;
            self.pixels = Pixels::Linear(in_front_of(color, &film)?);
            return Ok(stats);
        }
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
    /// Draws a bar over the picture, or over a crop of it. Its colours are bytes of that `transfer`.
    pub fn draw(&mut self, bar: &ColorBar<'_>, window: Crop, transfer: Transfer) {
        bar.draw(&mut |[x, y], color| {
            if !(window.x0..window.x1).contains(&x) || !(window.y0..window.y1).contains(&y) {
                return;
            }
            let (x, y) = (x - window.x0, y - window.y0);
            let at = y as usize * window.width() as usize + x as usize;
            match &mut self.pixels {
                Pixels::Bytes(film) => film.pixels_mut()[at] = color,
                Pixels::Linear(film) => film.pixels_mut()[at] = linear(transfer, color),
                Pixels::Transparent(film) => {
                    let [r, g, b] = linear(transfer, color);
                    film.pixels_mut()[at] = [r, g, b, 1.0];
                }
                // Only AOVs are grey.
                Pixels::Gray { .. } => {}
            }
        });
    }

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
            behind: None,
        }
    }
}

#[cfg(test)]
mod tests;
