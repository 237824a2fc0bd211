//! `--compare`: compares a picture with a reference.

use super::{
    decode::Source,
    output::Output,
    picture::{Picture, Pixels},
};
use crate::{
    cli::{CliError, plan::CompareOptions},
    error::clip_path,
    render::{ByteFilm, Film, Transfer},
};
use image::DynamicImage;
use std::{
    borrow::Cow,
    path::{Path, PathBuf},
};

/// A reference, and how a rendered picture is compared with it.
#[derive(Debug)]
pub struct Comparison {
    reference: PathBuf,
    tolerance: f32,
    allow_pixels: f64,
    width: u32,
    height: u32,
    /// For the difference.
    pub output: Output,
}

/// The result of a comparison.
pub struct Verdict {
    pub agrees: bool,
    /// One line.
    pub text: String,
}

impl Comparison {
    /// Checks that the reference exists and has the right size. A difference picture goes to `difference`.
    ///
    /// # Errors
    /// [`CliError::Failed`] if the reference cannot be read or has another size.
    pub fn prepare(
        options: &CompareOptions<'_>,
        reference: PathBuf,
        difference: Output,
        (width, height): (u32, u32),
    ) -> Result<Self, CliError> {
        if difference.is_exr() {
            return Err(CliError::Usage(format!(
                "{}: a difference picture has 8 bits, which EXR cannot hold; use .png or another format",
                difference.name()
            )));
        }
        let size = (width, height);
        let found = source(&reference, size).dimensions()?;
        if found != (width, height) {
            return Err(CliError::Failed(format!(
                "cannot compare pictures of different sizes: the picture has {width}x{height} pixels, the reference {} \
                 has {}x{}",
                clip_path(&reference),
                found.0,
                found.1
            )));
        }
        Ok(Self {
            reference,
            tolerance: options.tolerance,
            allow_pixels: options.allow_pixels,
            width,
            height,
            output: difference,
        })
    }

    /// The file of the reference.
    pub fn reference(&self) -> &Path {
        &self.reference
    }

    /// Compares the picture of an output, and writes the difference picture if they differ. If only one of the two files has
    /// floats, they become bytes by `transfer`.
    ///
    /// # Errors
    /// [`CliError`]; a difference is not an error here.
    pub fn run(&self, picture: &Picture, output: &Output, transfer: Transfer) -> Result<Verdict, CliError> {
        let reference = self.read()?;
        let floats = output.is_exr() && has_floats(&reference);
        let reference = Reference::new(reference, floats, transfer)?;
        let ours = Ours::new(picture, floats, transfer);
        let both = |i| [ours.levels(i), reference.levels(i)];
        let levels = |i| {
            let [ours, theirs] = both(i);
            seen_distances(ours, theirs, floats)
        };
        let pixels = self.width as usize * self.height as usize;
        let is_opaque = (0..pixels).flat_map(both).all(|[.., alpha]| alpha == 255.0);
        let figures = Figures::new(pixels, is_opaque, self.tolerance, levels);
        let agrees = figures.differing as f64 <= self.allow_pixels * figures.pixels as f64;
        let mut shown = (!agrees).then(|| self.difference(figures.largest, levels));
        let mut text = figures.text(output.name(), &self.reference, self.tolerance, shown.is_none());
        if let Some(shown) = &mut shown {
            self.output.write(shown)?;
            text.push_str(&format!("; shown in {}", self.output.name()));
        }
        Ok(Verdict {
            agrees: shown.is_none(),
            text,
        })
    }

    fn read(&self) -> Result<DynamicImage, CliError> {
        let picture = source(&self.reference, (self.width, self.height)).decode(None)?;
        // The file may have changed since it was checked.
        if (picture.width(), picture.height()) != (self.width, self.height) {
            return Err(CliError::Failed(format!(
                "the reference {} has changed its size since it was checked",
                clip_path(&self.reference)
            )));
        }
        Ok(picture)
    }

    /// The difference of each channel, scaled so that `largest` is white.
    fn difference(&self, largest: f32, levels: impl Fn(usize) -> [f32; 4]) -> Picture {
        let factor = 255.0 / largest.min(f32::MAX);
        let mut film = ByteFilm::black(self.width, self.height);
        for (i, pixel) in film.pixels_mut().iter_mut().enumerate() {
            let [r, g, b, alpha] = levels(i);
            *pixel = [r, g, b].map(|channel| {
                let level = channel.max(alpha);
                // NaN in a picture gives an infinite difference, shown as white. The cast saturates.
                if level.is_finite() {
                    (level * factor).round() as u8
                } else {
                    255
                }
            });
        }
        Pixels::Bytes(film).into()
    }
}

fn source(path: &Path, size: (u32, u32)) -> Source<'_> {
    Source {
        path,
        role: "reference",
        size,
    }
}

/// A decoded picture with alpha.
enum Reference {
    Bytes(Vec<u8>),
    Floats(image::Rgba32FImage),
}

fn has_floats(picture: &DynamicImage) -> bool {
    matches!(
        picture,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    )
}

impl Reference {
    /// With floats as they are, or as bytes by `transfer`, which are straight.
    fn new(picture: DynamicImage, floats: bool, transfer: Transfer) -> Result<Self, CliError> {
        if !has_floats(&picture) {
            return Ok(Self::Bytes(picture.into_rgba8().into_raw()));
        }
        let picture = picture.into_rgba32f();
        if floats {
            return Ok(Self::Floats(picture));
        }
        let mut film = Film::<[f32; 4]>::black(0, 0);
        film.try_resize(picture.width(), picture.height())
            .map_err(|_| CliError::Memory("not enough memory for the reference".into()))?;
        film.pixels_mut().copy_from_slice(picture.as_raw().as_chunks().0);
        Ok(Self::Bytes(film.to_bytes(transfer)))
    }

    fn levels(&self, i: usize) -> [f32; 4] {
        match self {
            Self::Bytes(bytes) => bytes.as_chunks().0[i].map(f32::from),
            Self::Floats(picture) => picture.as_raw().as_chunks().0[i].map(level),
        }
    }
}

/// The rendered picture's values as they are compared.
enum Ours<'a> {
    /// Bytes, and channels per pixel.
    Bytes(Cow<'a, [u8]>, usize),
    Floats(&'a Film),
    FloatsWithAlpha(&'a Film<[f32; 4]>),
}

impl<'a> Ours<'a> {
    fn new(picture: &'a Picture, floats: bool, transfer: Transfer) -> Self {
        match &picture.pixels {
            Pixels::Bytes(film) => Self::Bytes(film.pixels().as_flattened().into(), 3),
            Pixels::Linear(film) if floats => Self::Floats(film),
            Pixels::Linear(film) => Self::Bytes(film.to_bytes(transfer).into(), 3),
            Pixels::Transparent(film) if floats => Self::FloatsWithAlpha(film),
            Pixels::Transparent(film) => Self::Bytes(film.to_bytes(transfer).into(), 4),
            Pixels::Gray {
                bytes, pixel_bytes, ..
            } => Self::Bytes(bytes.into(), *pixel_bytes),
        }
    }

    fn levels(&self, i: usize) -> [f32; 4] {
        match self {
            Self::Bytes(bytes, channels) => {
                let mut levels = [255.0; 4];
                for (level, &byte) in levels.iter_mut().zip(&bytes[i * channels..][..*channels]) {
                    *level = f32::from(byte);
                }
                levels
            }
            Self::Floats(film) => {
                let [r, g, b] = film.pixels()[i].map(level);
                [r, g, b, 255.0]
            }
            Self::FloatsWithAlpha(film) => film.pixels()[i].map(level),
        }
    }
}

/// Floats are compared with floats as they are, with bytes as the bytes that they would become.
fn level(channel: f32) -> f32 {
    255.0 * channel
}

/// [`distances`]; none if neither pixel shows anything. The colours of floats count without alpha, too: they are premultiplied,
/// so programs add them.
fn seen_distances(a: [f32; 4], b: [f32; 4], floats: bool) -> [f32; 4] {
    if !floats && a[3] == 0.0 && b[3] == 0.0 {
        [0.0; 4]
    } else {
        distances(a, b)
    }
}

/// The difference of each channel, levels; infinite for NaN.
fn distances(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    std::array::from_fn(|channel| {
        let distance = (a[channel] - b[channel]).abs();
        if distance.is_nan() {
            f32::INFINITY
        } else {
            distance
        }
    })
}

/// What a comparison counts.
struct Figures {
    pixels: u64,
    differing: u64,
    /// Of all channels, levels.
    largest: f32,
    /// Over the channels of all pixels, levels. Of opaque pictures alpha is no channel.
    mean: f64,
}

impl Figures {
    /// Counts pixels; their alpha is in the mean unless both pictures are opaque.
    fn new(pixels: usize, is_opaque: bool, tolerance: f32, levels: impl Fn(usize) -> [f32; 4]) -> Self {
        let (mut differing, mut largest, mut sum) = (0, 0.0_f32, 0.0);
        for i in 0..pixels {
            let [r, g, b, alpha] = levels(i);
            let most = r.max(g).max(b).max(alpha);
            differing += u64::from(most > tolerance);
            largest = largest.max(most);
            sum += f64::from(r) + f64::from(g) + f64::from(b) + f64::from(alpha);
        }
        let (pixels, channels) = (pixels as u64, if is_opaque { 3 } else { 4 });
        Self {
            pixels,
            differing,
            largest,
            mean: sum / (channels * pixels) as f64,
        }
    }

    fn text(&self, name: &str, reference: &Path, tolerance: f32, agrees: bool) -> String {
        format!(
            "{name} {} {}: {} of {} pixels ({:.3} %) differ by more than {tolerance} of 255 levels, the most by {}, \
             {:.4} on average",
            if agrees { "agrees with" } else { "differs from" },
            clip_path(reference),
            self.differing,
            self.pixels,
            100.0 * self.differing as f64 / self.pixels as f64,
            (f64::from(self.largest) * 1e3).round() / 1e3,
            self.mean
        )
    }
}

#[cfg(test)]
mod tests;
