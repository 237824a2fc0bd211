//! Encodes a picture as the bytes of a file.

use super::{
    exr_layers,
    mark::add_mark,
    picture::{Picture, Pixels},
    place::{PNG_KEYWORD, Place},
};
use crate::{
    cli::CliError,
    error::clip_path,
    render::{SOFTWARE, write_png},
};
use image::{
    ExtendedColorType, ImageEncoder, ImageError, ImageFormat, ImageResult,
    codecs::{
        bmp::BmpEncoder,
        jpeg::JpegEncoder,
        pnm::{PnmEncoder, PnmSubtype, SampleEncoding},
        qoi::QoiEncoder,
    },
    error::{EncodingError, ImageFormatHint},
};
use std::{ffi::OsStr, io::Cursor, path::Path};
use tiff::{
    encoder::{
        TiffEncoder,
        colortype::{ColorType, RGB8, RGBA8},
    },
    tags::{ExtraSamples, Tag},
};

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
    /// An animation, as those below.
    Gif,
    Apng,
    Y4m,
}

/// Whether the name of a file is that of an animation.
pub fn is_animation(path: &Path) -> bool {
    path.extension()
        .and_then(Format::from_extension)
        .is_some_and(Format::is_animation)
}

impl Format {
    /// All extensions, for messages.
    pub const EXTENSIONS: &'static str = ".png, .ppm, .qoi, .jpg, .jpeg, .bmp, .tiff, .tif or .exr";

    /// Those of tiles.
    pub const MERGED: &'static str = ".png, .ppm, .qoi, .bmp, .tiff, .tif or .exr";

    /// The error about a file name without one of these extensions.
    pub fn unknown(path: &Path) -> CliError {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let name = clip_path(path);
        CliError::Usage(match extension.to_str() {
            Some("mp4" | "m4v" | "mov" | "webm" | "mkv" | "avi") => format!(
                "{name}: octray does not encode video; use -o - | ffmpeg -i - {name}, or name a .gif, .apng or .y4m"
            ),
            Some(
                other @ ("avif" | "dds" | "hdr" | "heic" | "heif" | "jp2" | "jxl" | "pam" | "pdf" | "pgm"
                | "pnm" | "psd" | "svg" | "tga" | "webp"),
            ) => format!(
                "{name}: octray does not write .{other}, expected {}",
                Self::EXTENSIONS
            ),
            Some("scn" | "ply" | "obj" | "off" | "stl" | "gltf" | "glb" | "3mf") => format!(
                "{name} is a scene or a mesh, not a picture: expected {}",
                Self::EXTENSIONS
            ),
            _ => format!(
                "cannot tell the format of {name} from its extension: expected {}",
                Self::EXTENSIONS
            ),
        })
    }

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

    /// Whether a file's pixels are not exactly those that were written.
    pub fn is_lossy(self) -> bool {
        matches!(self, Self::Jpeg | Self::Gif)
    }

    /// Whether octray knows its own files of this format again.
    pub fn has_mark(self) -> bool {
        self != Self::Qoi
    }

    /// Whether a file holds all frames of a turntable.
    pub fn is_animation(self) -> bool {
        matches!(self, Self::Gif | Self::Apng | Self::Y4m)
    }

    /// What to call the format.
    pub fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Ppm => "PPM",
            Self::Qoi => "QOI",
            Self::Jpeg => "JPEG",
            Self::Bmp => "BMP",
            Self::Tiff => "TIFF",
            Self::Exr => "EXR",
            Self::Gif => "GIF",
            Self::Apng => "animated PNG",
            Self::Y4m => "Y4M",
        }
    }

    /// Whether a picture of this size can be written.
    ///
    /// # Errors
    /// [`CliError::Failed`] with the format's limit.
    pub fn check_size(self, width: u32, height: u32) -> Result<(), CliError> {
        if matches!(self, Self::Jpeg | Self::Gif) && width.max(height) > MAX_SIDE {
            let name = self.name();
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
            .map_err(|error| failed(&error))?;
        let mut bytes = bytes.into_inner();
        if let Some(place) = picture.place {
            place.add_to(self, &mut bytes);
        }
        add_mark(self, &mut bytes);
        Ok(bytes)
    }

    /// The file's bytes from a picture's bytes, as [`Self::encode`] makes them of a whole picture.
    ///
    /// # Errors
    /// [`CliError::Failed`] if the encoder refuses the picture.
    pub fn encode_whole(self, bytes: &[u8], size: [u32; 2], pixel_bytes: usize) -> Result<Vec<u8>, CliError> {
        let mut to = Cursor::new(Vec::new());
        self.encode_bytes(bytes, size, pixel_bytes, None, &mut to)
            .map_err(|error| failed(&error))?;
        let mut bytes = to.into_inner();
        add_mark(self, &mut bytes);
        Ok(bytes)
    }

    fn encode_into(self, picture: &mut Picture, to: &mut Cursor<Vec<u8>>) -> ImageResult<()> {
        let exr = self == Self::Exr;
        let layers = std::mem::take(&mut picture.layers);
        let place = picture.place;
        match &picture.pixels {
            Pixels::Linear(film) if exr && layers.is_empty() => {
                exr_layers::write_rgb(film, place, to).map_err(exr_error)
            }
            Pixels::Linear(film) if exr => {
                exr_layers::write(film, ["R", "G", "B"], layers, place, to).map_err(exr_error)
            }
            Pixels::Transparent(film) if exr && layers.is_empty() => {
                exr_layers::write_rgba(film, place, to).map_err(exr_error)
            }
            Pixels::Transparent(film) if exr => {
                exr_layers::write(film, ["R", "G", "B", "A"], layers, place, to).map_err(exr_error)
            }
            pixels => self.encode_bytes(&picture.bytes(), picture.size(), pixels.pixel_bytes(), place, to),
        }
    }

    fn encode_bytes(
        self,
        bytes: &[u8],
        [width, height]: [u32; 2],
        pixel_bytes: usize,
        place: Option<Place>,
        to: &mut Cursor<Vec<u8>>,
    ) -> ImageResult<()> {
        // Grey is only asked of PNG.
        let color = if pixel_bytes == 4 {
            ExtendedColorType::Rgba8
        } else {
            ExtendedColorType::Rgb8
        };
        match self {
            // Tuned: see docs/lab-notes.md#png-filter
            Self::Png => {
                let place = place.map(|place| place.to_string());
                let texts: Vec<_> = place.iter().map(|place| (PNG_KEYWORD, place.as_str())).collect();
                Ok(write_png(to, [width, height], bytes, pixel_bytes, &texts)?)
            }
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
            Self::Tiff if pixel_bytes == 4 => {
                write_tiff::<RGBA8>(to, [width, height], bytes).map_err(tiff_error)
            }
            Self::Tiff => write_tiff::<RGB8>(to, [width, height], bytes).map_err(tiff_error),
            // An EXR file holds floats only, and animations are written elsewhere: neither is asked for.
            Self::Exr | Self::Gif | Self::Apng | Self::Y4m => {
                let why = "it cannot be made of the bytes of one picture";
                let format = ImageFormatHint::Name(self.name().to_owned());
                Err(ImageError::Encoding(EncodingError::new(format, why)))
            }
        }
    }
}

fn failed(error: &ImageError) -> CliError {
    CliError::Failed(format!("cannot encode the picture: {error}"))
}

/// The image crate's encoder writes neither the tag `Software` nor what alpha means. What follows texts and pixels of an odd
/// length is padded, since the directory and the values of tags have to begin at even offsets.
fn write_tiff<C: ColorType<Inner = u8>>(
    to: &mut Cursor<Vec<u8>>,
    [width, height]: [u32; 2],
    bytes: &[u8],
) -> tiff::TiffResult<()> {
    let mut encoder = TiffEncoder::new(to)?;
    let mut image = encoder.new_image::<C>(width, height)?;
    image.encoder().write_tag(Tag::Software, SOFTWARE)?;
    // The text and its 0 have 7 bytes.
    image.encoder().write_data(0_u8)?;
    if C::BITS_PER_SAMPLE.len() == 4 {
        let alpha = ExtraSamples::UnassociatedAlpha.to_u16();
        image.encoder().write_tag(Tag::ExtraSamples, alpha)?;
    }
    let mut rest = bytes;
    while let strip @ 1.. = image.next_strip_sample_count() as usize
        && let Some((pixels, others)) = rest.split_at_checked(strip)
    {
        image.write_strip(pixels)?;
        rest = others;
    }
    if bytes.len() % 2 == 1 {
        image.encoder().write_data(0_u8)?;
    }
    image.finish()
}

fn tiff_error(error: tiff::TiffError) -> ImageError {
    let format = ImageFormatHint::Exact(ImageFormat::Tiff);
    ImageError::Encoding(EncodingError::new(format, error))
}

/// An error of the exr crate as one of the image crate.
fn exr_error(error: exr::error::Error) -> ImageError {
    let format = ImageFormatHint::Exact(ImageFormat::OpenExr);
    ImageError::Encoding(EncodingError::new(format, error))
}

#[cfg(test)]
mod tests;
