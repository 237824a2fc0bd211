//! What a TIFF file says about its first picture. Its decoder takes 32-bit integers for floats and premultiplied colours for
//! straight ones, and knows no palettes, so these are found here. The decoder reads a palette's indices as grey, from a copy of
//! the file that calls them grey. Directories are read here, too, because the `tiff` crate opens no file of a kind that it does
//! not know, and does not say where a number is.
//!
//! Format: *TIFF Revision 6.0*, Adobe, 1992; *Adobe Photoshop TIFF Technical Notes 3*, 2005 (floats); BigTIFF, 2007.

mod directory;

use directory::Directory;
use image::{DynamicImage, ImageError, Rgb, RgbImage};
use std::borrow::Cow;

/// The kinds that are read.
const EXPECTED: &str = "expected grey, RGB or CMYK of 8-bit or 16-bit integers, RGB of 32-bit floats, black and white, or a \
                        palette of 2 or 256 colours";

/// Tags.
const BITS: u16 = 258;
const COMPRESSION: u16 = 259;
const INTERPRETATION: u16 = 262;
const FILL_ORDER: u16 = 266;
const CHANNELS: u16 = 277;
const COLOR_MAP: u16 = 320;
const EXTRA: u16 = 338;
const SAMPLE_FORMAT: u16 = 339;
/// Interpretations.
const GREY: u8 = 1;
const PALETTE: u64 = 3;
/// The extra channel that is alpha of premultiplied colours.
const PREMULTIPLIED: u64 = 1;
/// The most colours of a palette that is read.
const COLORS: usize = 256;

/// A TIFF file of a kind that is read.
#[derive(Clone, Copy)]
pub(crate) struct Tiff {
    palette: Option<Palette>,
    is_premultiplied: bool,
}

/// The palette of a file.
#[derive(Clone, Copy)]
struct Palette {
    /// By the grey that the decoder makes of an index: the index itself, or black and white.
    colors: [[u8; 3]; COLORS],
    /// The byte of the file that says that it has one.
    said_at: usize,
}

impl Tiff {
    /// Whether a file begins as TIFF or BigTIFF.
    #[cfg(feature = "cli")]
    pub(crate) fn is_start(bytes: &[u8]) -> bool {
        Directory::kind(bytes).is_some()
    }

    /// Reads a file's header; what is wrong with that is left to the decoder.
    ///
    /// # Errors
    /// A sentence about a kind that is not read.
    pub(crate) fn of(bytes: &[u8]) -> Result<Self, String> {
        let directory = Directory::first(bytes);
        let palette = directory.as_ref().and_then(Palette::of);
        let Some(directory) = directory.filter(|directory| directory.number(INTERPRETATION, 0).is_some())
        else {
            return Ok(Self {
                palette,
                is_premultiplied: false,
            });
        };
        let number = |tag, usual| directory.number(tag, 0).unwrap_or(usual);
        // The decoder would take them for the usual order.
        if number(FILL_ORDER, 1) != 1 {
            return Err("this is a TIFF with the bits of each byte in reverse order (FillOrder 2), expected the usual order".into());
        }
        let (bits, format, channels) = (number(BITS, 1), number(SAMPLE_FORMAT, 1), number(CHANNELS, 1));
        let is_read = match (number(INTERPRETATION, 0), format) {
            (0 | 1, 1) => channels == 1 && matches!(bits, 1 | 8 | 16),
            (2, 3) => bits == 32,
            (2 | 5, 1) => matches!(bits, 8 | 16),
            (PALETTE, _) => palette.is_some(),
            // As JPEG.
            (6, 1) => bits == 8,
            _ => false,
        };
        if !is_read {
            return Err(format!("this is a TIFF with {}, {EXPECTED}", found(&directory)));
        }
        Ok(Self {
            palette,
            is_premultiplied: number(EXTRA, 0) == PREMULTIPLIED,
        })
    }

    /// What the decoder can read: the file, or a copy with indices that are called grey.
    pub(crate) fn readable<'a>(&self, bytes: &'a [u8]) -> Cow<'a, [u8]> {
        let Some(palette) = &self.palette else {
            return bytes.into();
        };
        let mut bytes = bytes.to_vec();
        if let Some(said) = bytes.get_mut(palette.said_at) {
            *said = GREY;
        }
        bytes.into()
    }

    /// Memory that reading takes beside the decoder's: a copy of a file of `length` bytes, and the colours of indices.
    pub(crate) fn bytes_beside(&self, length: usize, pixels: u64) -> u64 {
        self.palette.map_or(0, |_| length as u64 + 3 * pixels)
    }

    /// The decoded picture with its palette's colours, and with straight ones.
    pub(crate) fn straight(&self, picture: DynamicImage) -> DynamicImage {
        let mut picture = match (&self.palette, picture) {
            (Some(palette), DynamicImage::ImageLuma8(indices)) => palette.colors(&indices).into(),
            (_, picture) => picture,
        };
        if self.is_premultiplied {
            divide_by_alpha(&mut picture);
        }
        picture
    }

    /// The same with floats premultiplied, as those of EXR files are.
    #[cfg(feature = "cli")]
    pub(crate) fn as_exr(&self, picture: DynamicImage) -> DynamicImage {
        let DynamicImage::ImageRgba32F(mut floats) = picture else {
            return self.straight(picture);
        };
        if !self.is_premultiplied {
            for pixel in floats.pixels_mut() {
                let [r, g, b, alpha] = pixel.0;
                pixel.0 = [r * alpha, g * alpha, b * alpha, alpha];
            }
        }
        floats.into()
    }

    /// What to say of a decoder's error.
    pub(crate) fn fault(bytes: &[u8], error: &ImageError) -> Option<String> {
        if !matches!(error, ImageError::Unsupported(_)) {
            return None;
        }
        let directory = Directory::first(bytes)?;
        let method = match directory.number(COMPRESSION, 0).unwrap_or(1) {
            // Those that are read.
            1 | 3..=5 | 7 | 8 | 32773 | 32946 => {
                return Some(format!("this is a TIFF with {}, {EXPECTED}", found(&directory)));
            }
            2 => "the Huffman code of fax".to_owned(),
            6 => "JPEG in the form of TIFF 6.0".to_owned(),
            34712 => "JPEG 2000".to_owned(),
            34887 => "LERC".to_owned(),
            34925 => "LZMA".to_owned(),
            50000 => "Zstandard".to_owned(),
            50001 => "WebP".to_owned(),
            method => format!("method {method}"),
        };
        Some(format!(
            "this is a TIFF that is compressed by {method}, expected LZW, Deflate, PackBits, JPEG, fax or no compression"
        ))
    }
}

/// The pixels of a file, for messages.
fn found(directory: &Directory<'_>) -> String {
    let number = |tag, usual| directory.number(tag, 0).unwrap_or(usual);
    let (bits, channels) = (number(BITS, 1), number(CHANNELS, 1));
    let colors = match number(INTERPRETATION, 0) {
        0 | 1 if channels == 1 => "grey".to_owned(),
        0 | 1 => format!("grey in {channels} channels"),
        2 => "RGB".to_owned(),
        PALETTE => return format!("a palette of {} colours", directory.count(COLOR_MAP) / 3),
        4 => return "a mask".to_owned(),
        5 => "CMYK".to_owned(),
        6 => "YCbCr".to_owned(),
        8..=10 => "Lab colours".to_owned(),
        32844 | 32845 => "logarithmic light".to_owned(),
        kind => format!("colours of kind {kind}"),
    };
    let kind = match number(SAMPLE_FORMAT, 1) {
        2 => "signed integers",
        3 => "floats",
        5 | 6 => "complex numbers",
        _ => "integers",
    };
    let planes = if number(284, 1) == 2 { ", in planes" } else { "" };
    format!("{colors} of {bits}-bit {kind}{planes}")
}

impl Palette {
    /// `None` if the picture has none of 2 or 256 colours.
    fn of(directory: &Directory<'_>) -> Option<Self> {
        let bits = directory.number(BITS, 0).unwrap_or(1);
        let is_read = directory.number(INTERPRETATION, 0)? == PALETTE
            && matches!(bits, 1 | 8)
            && directory.count(COLOR_MAP) == 3 << bits;
        if !is_read {
            return None;
        }
        let count = 1 << bits;
        // All reds, then all greens, then all blues.
        let numbers = (0..3 * count).map(|i| directory.number(COLOR_MAP, i));
        let numbers: Vec<u64> = numbers.collect::<Option<_>>()?;
        // Some programs write 8 bits.
        let is_short = numbers.iter().all(|&number| number < 256);
        let shift = if is_short { 0 } else { 8 };
        let color = |i: usize| [i, i + count, i + 2 * count].map(|i| (numbers[i] >> shift) as u8);
        Some(Self {
            colors: std::array::from_fn(|grey| color(grey >> (8 - bits))),
            said_at: directory.lowest_byte(INTERPRETATION)?,
        })
    }

    fn colors(&self, indices: &image::GrayImage) -> RgbImage {
        let color = |x, y| Rgb(self.colors[usize::from(indices.get_pixel(x, y).0[0])]);
        RgbImage::from_fn(indices.width(), indices.height(), color)
    }
}

/// Makes premultiplied colours straight. Where alpha is 0, they stay.
fn divide_by_alpha(picture: &mut DynamicImage) {
    let divided = |color: u16, alpha: u16, most: u32| {
        let (color, alpha) = (u32::from(color), u32::from(alpha));
        ((color * most + alpha / 2) / alpha).min(most) as u16
    };
    match picture {
        DynamicImage::ImageRgba8(picture) => {
            for pixel in picture.pixels_mut().filter(|pixel| pixel.0[3] > 0) {
                let [r, g, b, alpha] = pixel.0.map(u16::from);
                let [r, g, b] = [r, g, b].map(|color| divided(color, alpha, 255) as u8);
                pixel.0 = [r, g, b, alpha as u8];
            }
        }
        DynamicImage::ImageRgba16(picture) => {
            for pixel in picture.pixels_mut().filter(|pixel| pixel.0[3] > 0) {
                let [r, g, b, alpha] = pixel.0;
                let [r, g, b] = [r, g, b].map(|color| divided(color, alpha, 65535));
                pixel.0 = [r, g, b, alpha];
            }
        }
        DynamicImage::ImageRgba32F(picture) => {
            for pixel in picture.pixels_mut().filter(|pixel| pixel.0[3] > 0.0) {
                let [r, g, b, alpha] = pixel.0;
                pixel.0 = [r / alpha, g / alpha, b / alpha, alpha];
            }
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests;
