//! A picture as the bytes of a file.

use super::{
    exr_layers,
    picture::{Picture, Pixels},
};
use crate::cli::CliError;
use crate::render::write_png;
use image::{
    ExtendedColorType, ImageEncoder, ImageError, ImageFormat, ImageResult,
    codecs::{
        bmp::BmpEncoder,
        jpeg::JpegEncoder,
        openexr::OpenExrEncoder,
        pnm::{PnmEncoder, PnmSubtype, SampleEncoding},
        qoi::QoiEncoder,
        tiff::TiffEncoder,
    },
    error::{EncodingError, ImageFormatHint},
};
use std::{ffi::OsStr, io::Cursor};

/// High enough to keep smooth shading free of visible blocks.
const JPEG_QUALITY: u8 = 92;
/// The limit of JPEG and GIF.
const MAX_SIDE: u32 = 65535;

/// A file format for pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Png,
    Ppm,
    Qoi,
    Jpeg,
    Bmp,
    Tiff,
    Exr,
    /// A film, as those below.
    Gif,
    Apng,
    Y4m,
}

impl Format {
    /// All extensions, for messages.
    pub const EXTENSIONS: &'static str = ".png, .ppm, .qoi, .jpg, .jpeg, .bmp, .tiff, .tif or .exr";

    /// The format of a file name's extension, in upper or lower case.
    pub fn from_extension(extension: &OsStr) -> Option<Self> {
        Some(match extension.to_str()?.to_ascii_lowercase().as_str() {
            "png" => Self::Png,
            "ppm" => Self::Ppm,
            "qoi" => Self::Qoi,
            "jpg" | "jpeg" => Self::Jpeg,
            "bmp" => Self::Bmp,
            "tiff" | "tif" => Self::Tiff,
            "exr" => Self::Exr,
            "gif" => Self::Gif,
            "apng" => Self::Apng,
            "y4m" => Self::Y4m,
            _ => return None,
        })
    }

    /// Whether a file can hold alpha.
    pub fn has_alpha(self) -> bool {
        matches!(self, Self::Png | Self::Qoi | Self::Tiff | Self::Exr | Self::Apng)
    }

    /// Whether octray's files of this format say who wrote them.
    pub fn has_mark(self) -> bool {
        matches!(self, Self::Png | Self::Exr | Self::Apng)
    }

    /// Whether a file holds all frames of a turntable.
    pub fn is_film(self) -> bool {
        matches!(self, Self::Gif | Self::Apng | Self::Y4m)
    }

    /// Whether a picture of this size can be written.
    ///
    /// # Errors
    /// [`CliError::Failed`] with the format's limit.
    pub fn check_size(self, width: u32, height: u32) -> Result<(), CliError> {
        let name = match self {
            Self::Jpeg => "JPEG",
            Self::Gif => "GIF",
            _ => return Ok(()),
        };
        if width.max(height) > MAX_SIDE {
            return Err(CliError::Failed(format!(
                "a picture of {width}x{height} is too large for {name}: a side has at most {MAX_SIDE} pixels"
            )));
        }
        Ok(())
    }

    /// The file's bytes. In memory, because TIFF and EXR seek back to fill in their tables, and a pipe cannot seek. Takes the
    /// picture's layers: a copy of them would be most of what an EXR file needs.
    ///
    /// # Errors
    /// [`CliError::Failed`] if the encoder refuses the picture.
    pub fn encode(self, picture: &mut Picture) -> Result<Vec<u8>, CliError> {
        let mut bytes = Cursor::new(Vec::new());
        self.encode_into(picture, &mut bytes)
            .map_err(|error| CliError::Failed(format!("cannot encode the picture: {error}")))?;
        Ok(bytes.into_inner())
    }

    fn encode_into(self, picture: &mut Picture, to: &mut Cursor<Vec<u8>>) -> ImageResult<()> {
        let exr = self == Self::Exr;
        let layers = std::mem::take(&mut picture.layers);
        match &picture.pixels {
            Pixels::Linear(film) if exr && layers.is_empty() => {
                exr_layers::write_rgb(film, to).map_err(exr_error)
            }
            Pixels::Linear(film) if exr => {
                exr_layers::write(film, ["R", "G", "B"], layers, to).map_err(exr_error)
            }
            Pixels::Transparent(film) if exr && layers.is_empty() => {
                exr_layers::write_rgba(film, to).map_err(exr_error)
            }
            Pixels::Transparent(film) if exr => {
                exr_layers::write(film, ["R", "G", "B", "A"], layers, to).map_err(exr_error)
            }
            Pixels::Transparent(_) => {
                self.encode_bytes(&picture.bytes(), picture.size(), ExtendedColorType::Rgba8, to)
            }
            Pixels::Bytes(_) | Pixels::Linear(_) => {
                self.encode_bytes(&picture.bytes(), picture.size(), ExtendedColorType::Rgb8, to)
            }
        }
    }

    fn encode_bytes(
        self,
        bytes: &[u8],
        [width, height]: [u32; 2],
        color: ExtendedColorType,
        to: &mut Cursor<Vec<u8>>,
    ) -> ImageResult<()> {
        match self {
            // Tuned: see docs/lab-notes.md#png-filter
            Self::Png => Ok(write_png(
                to,
                [width, height],
                bytes,
                color == ExtendedColorType::Rgba8,
            )?),
            Self::Ppm => {
                let subtype = PnmSubtype::Pixmap(SampleEncoding::Binary);
                PnmEncoder::new(to)
                    .with_subtype(subtype)
                    .write_image(bytes, width, height, color)
            }
            Self::Qoi => QoiEncoder::new(to).write_image(bytes, width, height, color),
            Self::Jpeg => {
                JpegEncoder::new_with_quality(to, JPEG_QUALITY).write_image(bytes, width, height, color)
            }
            Self::Bmp => BmpEncoder::new(to).write_image(bytes, width, height, color),
            Self::Tiff => TiffEncoder::new(to).write_image(bytes, width, height, color),
            // An EXR file holds floats only, and films are written elsewhere: neither is asked for.
            Self::Exr | Self::Gif | Self::Apng | Self::Y4m => {
                OpenExrEncoder::new(to).write_image(bytes, width, height, color)
            }
        }
    }
}

/// An error of the exr crate as one of the image crate.
fn exr_error(error: exr::error::Error) -> ImageError {
    let format = ImageFormatHint::Exact(ImageFormat::OpenExr);
    ImageError::Encoding(EncodingError::new(format, error))
}
