//! `--compare`: a picture against another one.

use super::{
    CliError,
    batch_args::CompareArgs,
    interrupt::Interrupt,
    output::Output,
    picture::{Picture, Pixels},
};
use crate::render::{ByteFilm, Film, Transfer, quantize};
use image::{DynamicImage, ImageReader, Limits};
use std::{
    borrow::Cow,
    fs::{self, File},
    io::{self, BufReader},
    path::{Path, PathBuf},
};

/// What a decoder may take besides the picture, bytes.
const DECODER_BYTES: u64 = 1 << 26;
/// The largest pixel of a decoded picture: four floats.
const PIXEL_BYTES: u64 = 16;

/// Two pictures that are to be compared: the one that will be rendered, and its reference.
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

/// What a comparison found.
pub struct Verdict {
    pub agrees: bool,
    /// One line.
    pub text: String,
}

impl Comparison {
    /// Checks that there is a reference of the right size. The difference, if any, goes to `difference`.
    ///
    /// # Errors
    /// [`CliError::Failed`] for a reference that cannot be read or has another size.
    pub fn prepare(
        args: &CompareArgs,
        reference: PathBuf,
        difference: Output,
        (width, height): (u32, u32),
    ) -> Result<Self, CliError> {
        if difference.is_linear() {
            return Err(CliError::Usage(format!(
                "{}: differences are shown in 8 bits, which EXR does not hold; expected .png or another format",
                difference.name()
            )));
        }
        let found = open(&reference)?
            .into_dimensions()
            .map_err(|error| unreadable(&reference, &error))?;
        if found != (width, height) {
            return Err(CliError::Failed(format!(
                "the picture is to have {width}x{height} pixels, and the reference {} has {}x{}: pictures of different \
                 sizes cannot be compared",
                reference.display(),
                found.0,
                found.1
            )));
        }
        Ok(Self {
            reference,
            tolerance: args.tolerance,
            allow_pixels: args.allow_pixels,
            width,
            height,
            output: difference,
        })
    }

    /// Whether the picture would take the reference's place.
    pub fn would_replace_reference(&self, output: &Output) -> bool {
        fs::canonicalize(&self.reference).is_ok_and(|reference| output.place() == reference)
    }

    /// Compares the picture, which is called `name`, and writes the difference if there is one.
    ///
    /// # Errors
    /// [`CliError`]; pictures that differ are none.
    pub fn run(&self, picture: &Picture, name: &str, interrupt: &Interrupt) -> Result<Verdict, CliError> {
        let work = || -> Result<_, CliError> {
            let reference = self.read()?;
            let floats = has_floats(&reference)
                && picture.transfer == Transfer::Linear
                && !matches!(picture.pixels, Pixels::Bytes(_));
            let reference = Reference::new(reference);
            let ours = Ours::new(picture, floats);
            let levels = |i| distances(ours.levels(i), reference.levels(i, floats));
            let figures = Figures::new((self.width, self.height), self.tolerance, levels);
            let agrees = figures.differing as f64 <= self.allow_pixels * figures.pixels as f64;
            let shown = (!agrees).then(|| self.difference(figures.largest, levels));
            Ok((figures, shown))
        };
        let (figures, shown) = interrupt.exit_at_once_during(work)??;
        let mut text = figures.text(name, &self.reference, self.tolerance, shown.is_none());
        if let Some(shown) = &shown {
            self.output.write(shown, interrupt)?;
            text.push_str(&format!("; shown in {}", self.output.name()));
        }
        Ok(Verdict {
            agrees: shown.is_none(),
            text,
        })
    }

    fn read(&self) -> Result<DynamicImage, CliError> {
        let mut reader = open(&self.reference)?;
        let mut limits = Limits::default();
        let pixels = u64::from(self.width) * u64::from(self.height);
        limits.max_alloc = Some(DECODER_BYTES + 2 * PIXEL_BYTES * pixels);
        limits.max_image_width = Some(self.width);
        limits.max_image_height = Some(self.height);
        reader.limits(limits);
        let picture = reader
            .decode()
            .map_err(|error| unreadable(&self.reference, &error))?;
        // The file may have changed since its size was looked at.
        if (picture.width(), picture.height()) != (self.width, self.height) {
            return Err(CliError::Failed(format!(
                "the reference {} has changed its size",
                self.reference.display()
            )));
        }
        Ok(picture)
    }

    /// How far each channel is off, such that `largest` is white.
    fn difference(&self, largest: f32, levels: impl Fn(usize) -> [f32; 4]) -> Picture {
        let factor = 255.0 / largest.min(f32::MAX);
        let mut film = ByteFilm::black(self.width, self.height);
        for (i, pixel) in film.pixels_mut().iter_mut().enumerate() {
            let [r, g, b, alpha] = levels(i);
            *pixel = [r, g, b].map(|channel| {
                let level = channel.max(alpha);
                // What is not there at all (infinite) is as different as can be. The cast saturates.
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

/// Opens a picture of a format that its first bytes say. Only files: a pipe might never say anything.
fn open(path: &Path) -> Result<ImageReader<BufReader<File>>, CliError> {
    let open = || {
        if !fs::metadata(path)?.is_file() {
            return Err(io::Error::other("it is no file"));
        }
        ImageReader::open(path)?.with_guessed_format()
    };
    open().map_err(|error| unreadable(path, &image::ImageError::IoError(error)))
}

fn unreadable(path: &Path, error: &image::ImageError) -> CliError {
    let reason = match error {
        image::ImageError::IoError(error) if error.kind() == io::ErrorKind::NotFound => {
            "there is no such file".to_owned()
        }
        image::ImageError::IoError(error) => error.to_string(),
        image::ImageError::Unsupported(_) => {
            "it is no picture that can be read, expected PNG, PPM, QOI, JPEG, BMP, TIFF or EXR".to_owned()
        }
        error => error.to_string(),
    };
    let reason = crate::error::escape(&reason).into_owned();
    CliError::Failed(format!("cannot read the reference {}: {reason}", path.display()))
}

/// A decoded picture: bytes, or floats if its file has them. Always with alpha.
enum Reference {
    Bytes(image::RgbaImage),
    Floats(image::Rgba32FImage),
}

fn has_floats(picture: &DynamicImage) -> bool {
    matches!(
        picture,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    )
}

impl Reference {
    fn new(picture: DynamicImage) -> Self {
        if has_floats(&picture) {
            Self::Floats(picture.into_rgba32f())
        } else {
            Self::Bytes(picture.into_rgba8())
        }
    }

    fn levels(&self, i: usize, floats: bool) -> [f32; 4] {
        match self {
            Self::Bytes(picture) => picture.as_raw().as_chunks().0[i].map(f32::from),
            Self::Floats(picture) => {
                let channels: [f32; 4] = picture.as_raw().as_chunks().0[i];
                channels.map(|channel| level(channel, floats))
            }
        }
    }
}

/// Our picture's numbers, as they are compared.
enum Ours<'a> {
    /// With so many channels a pixel.
    Bytes(Cow<'a, [u8]>, usize),
    Floats(&'a Film),
    FloatsWithAlpha(&'a Film<[f32; 4]>),
}

impl<'a> Ours<'a> {
    fn new(picture: &'a Picture, floats: bool) -> Self {
        match &picture.pixels {
            Pixels::Bytes(film) => Self::Bytes(film.pixels().as_flattened().into(), 3),
            Pixels::Linear(film) if floats => Self::Floats(film),
            Pixels::Linear(film) => Self::Bytes(film.to_bytes(picture.transfer).into(), 3),
            Pixels::Transparent(film) if floats => Self::FloatsWithAlpha(film),
            Pixels::Transparent(film) => Self::Bytes(film.to_bytes(picture.transfer).into(), 4),
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
                let [r, g, b] = film.pixels()[i].map(|channel| level(channel, true));
                [r, g, b, 255.0]
            }
            Self::FloatsWithAlpha(film) => film.pixels()[i].map(|channel| level(channel, true)),
        }
    }
}

/// Floats against bytes are compared as the bytes that they would become, floats with floats as they are.
fn level(channel: f32, floats: bool) -> f32 {
    if floats {
        255.0 * channel
    } else {
        f32::from(quantize(channel))
    }
}

/// How far each channel is off, levels. What is no number is infinitely far off.
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
    /// Over all colour channels, levels.
    mean: f64,
}

impl Figures {
    fn new((width, height): (u32, u32), tolerance: f32, levels: impl Fn(usize) -> [f32; 4]) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        let (mut differing, mut largest, mut sum) = (0, 0.0_f32, 0.0);
        for i in 0..pixels as usize {
            let [r, g, b, alpha] = levels(i);
            let most = r.max(g).max(b).max(alpha);
            differing += u64::from(most > tolerance);
            largest = largest.max(most);
            sum += f64::from(r) + f64::from(g) + f64::from(b);
        }
        Self {
            pixels,
            differing,
            largest,
            mean: sum / (3 * pixels) as f64,
        }
    }

    fn text(&self, name: &str, reference: &Path, tolerance: f32, agrees: bool) -> String {
        format!(
            "{name} {} {}: {} of {} pixels ({:.3} %) are off by more than {tolerance} of 255 levels, the worst by {}, \
             the mean is {:.4}",
            if agrees { "agrees with" } else { "differs from" },
            reference.display(),
            self.differing,
            self.pixels,
            100.0 * self.differing as f64 / self.pixels as f64,
            (f64::from(self.largest) * 1e3).round() / 1e3,
            self.mean
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_counts_once_and_beyond_the_tolerance() {
        let levels = [
            [2.0, 2.5, 0.0, 0.0],
            [2.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 9.0],
            [0.0; 4],
        ];
        let figures = Figures::new((2, 2), 2.0, |i| levels[i]);
        assert_eq!((figures.pixels, figures.differing, figures.largest), (4, 2, 9.0));
        assert_eq!(figures.mean, 6.5 / 12.0);
    }

    #[test]
    fn what_is_no_number_differs() {
        let figures = Figures::new((1, 1), 255.0, |_| distances([f32::NAN; 4], [0.0; 4]));
        assert_eq!(figures.differing, 1);
    }
}
