//! Reads pictures: references of `--compare` and tiles of `octray merge`. Their contents are untrusted.

use crate::{
    cli::CliError,
    error::{clip, clip_path, decoder_reason, in_bytes, io_reason},
    format::{self, tiff::Tiff},
};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, ImageResult, Limits};
use std::{
    fs::File,
    io::{self, Cursor, Read, Take},
    panic::{self, AssertUnwindSafe},
    path::Path,
};

/// What a decoder may take besides the picture, bytes.
const DECODER_BYTES: u64 = 1 << 26;
/// The largest pixel of a decoded picture: four floats.
const PIXEL_BYTES: u64 = 16;

/// A file to be read.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    pub path: &'a Path,
    /// What messages call it.
    pub role: &'static str,
    /// The size that the picture should have, pixels.
    pub size: (u32, u32),
}

impl Source<'_> {
    /// Reads the picture's size, pixels.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn dimensions(self) -> Result<(u32, u32), CliError> {
        self.read_bytes(PIXEL_BYTES, |bytes| {
            let (size, _) = read(bytes, None, |reader| Ok(reader.into_decoder()?.dimensions()))?;
            Ok(size)
        })
    }

    /// Decodes the picture, in `format` or in that of its first bytes. Bytes are straight, floats premultiplied.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn decode(self, format: Option<ImageFormat>) -> Result<DynamicImage, CliError> {
        let (width, height) = self.size;
        self.read_bytes(PIXEL_BYTES, |bytes| {
            let (picture, tiff) = read(bytes, format, |mut reader| {
                let mut limits = Limits::default();
                limits.max_alloc = Some(DECODER_BYTES + 2 * self.bytes(PIXEL_BYTES));
                limits.max_image_width = Some(width);
                limits.max_image_height = Some(height);
                reader.limits(limits);
                reader.decode()
            })?;
            Ok(match tiff {
                Some(tiff) => tiff.as_exr(picture),
                None => picture,
            })
        })
    }

    /// Reads a file of at most `pixel_bytes` per pixel, and decodes its bytes with `work`.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn read_bytes<T>(
        self,
        pixel_bytes: u64,
        work: impl FnOnce(&[u8]) -> ImageResult<T>,
    ) -> Result<T, CliError> {
        let mut bytes = Vec::new();
        let read = self
            .open(pixel_bytes)
            .and_then(|mut file| file.read_to_end(&mut bytes));
        let read = read.map_err(ImageError::IoError);
        read.and_then(|_| without_panic(|| work(&bytes)))
            .map_err(|error| self.unreadable(&error))
    }

    /// Opens a regular file that is no larger than a picture of this size can be. No more is read than was there when it
    /// was opened.
    fn open(self, pixel_bytes: u64) -> io::Result<Take<File>> {
        let file = format::open_file(self.path)?;
        let found = file.metadata()?;
        let most = DECODER_BYTES + self.bytes(pixel_bytes);
        if found.len() > most {
            return Err(io::Error::other(format!(
                "the file has {}, expected at most {} for a picture of {}x{}",
                in_bytes(found.len()),
                in_bytes(most),
                self.size.0,
                self.size.1
            )));
        }
        Ok(file.take(found.len()))
    }

    fn bytes(self, pixel_bytes: u64) -> u64 {
        u64::from(self.size.0) * u64::from(self.size.1) * pixel_bytes
    }

    /// Why the file cannot be read.
    pub fn unreadable(self, error: &ImageError) -> CliError {
        let reason = match error {
            ImageError::IoError(error) => io_reason(error),
            ImageError::Unsupported(_) => {
                "unknown picture format, expected PNG, PPM, QOI, JPEG, BMP, TIFF or EXR".to_owned()
            }
            error => decoder_reason(&error.to_string()),
        };
        let (role, path, reason) = (self.role, clip_path(self.path), clip(&reason));
        CliError::Failed(format!("cannot read the {role} {path}: {reason}"))
    }
}

/// Reads a picture with `work`. From bytes, like the reader of textures, because decoders are compiled for each type of source.
fn read<T>(
    bytes: &[u8],
    format: Option<ImageFormat>,
    work: impl FnOnce(ImageReader<Cursor<&[u8]>>) -> ImageResult<T>,
) -> ImageResult<(T, Option<Tiff>)> {
    let of_tiff = || Tiff::is_start(bytes).then_some(ImageFormat::Tiff);
    let format = format.or_else(|| of_tiff().or_else(|| image::guess_format(bytes).ok()));
    if format != Some(ImageFormat::Tiff) {
        let bytes = Cursor::new(bytes);
        return work(match format {
            Some(format) => ImageReader::with_format(bytes, format),
            None => ImageReader::new(bytes),
        })
        .map(|read| (read, None));
    }
    let fault = |text: String| ImageError::IoError(io::Error::other(text));
    let tiff = Tiff::of(bytes).map_err(fault)?;
    let readable = tiff.readable(bytes);
    let reader = ImageReader::with_format(Cursor::new(&*readable), ImageFormat::Tiff);
    let read = work(reader).map_err(|error| Tiff::fault(bytes, &error).map_or(error, fault))?;
    Ok((read, Some(tiff)))
}

/// Makes a panic of a decoder an error. Its message would go to standard error.
fn without_panic<T>(work: impl FnOnce() -> ImageResult<T>) -> ImageResult<T> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let done = panic::catch_unwind(AssertUnwindSafe(work));
    panic::set_hook(hook);
    done.unwrap_or_else(|_| Err(ImageError::IoError(io::Error::other("its decoder failed"))))
}
