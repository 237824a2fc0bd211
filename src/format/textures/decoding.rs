//! Decodes images, within limits of size and memory.

use super::{Budget, Content, Encoded, Image, Made, heights};
use crate::{
    error::{decoder_reason, in_bytes},
    format::{reason::Reason, tiff::Tiff},
    scene::MAX_IMAGE_SIDE,
};
use image::{
    DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits, RgbaImage,
    imageops::{self, FilterType},
};
use rayon::prelude::*;
use std::{
    borrow::Cow,
    io::Cursor,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

/// Memory of a decoder beside the pixels, bytes.
pub(in crate::format) const DECODER_BYTES: u64 = 1 << 20;

/// Memory for all that comes before the pixels, such as colour profiles, bytes.
pub(in crate::format) const HEADER_BYTES: u64 = 8 << 20;

/// An image whose header was read.
#[derive(Clone, Copy)]
struct Header<'a> {
    bytes: &'a [u8],
    format: ImageFormat,
    tiff: Option<Tiff>,
    size: [u32; 2],
    /// What decoding it takes until the image is made, bytes.
    needed: u64,
}

/// An image that will be decoded.
struct Known<'a> {
    header: Header<'a>,
    content: Content<'a>,
    /// That of the base colour for highlights of metal.
    base: Option<Header<'a>>,
    /// What the image takes, bytes.
    kept: usize,
    /// What decoding all takes, bytes.
    needed: u64,
}

/// Decodes each image that is the first of equal ones; what they are is in `contents`.
pub(super) fn all(
    encoded: &[Option<&Encoded<'_>>],
    first: &[Option<usize>],
    contents: &[Content<'_>],
    budget: &Budget,
) -> Vec<Option<Result<Made, String>>> {
    // In order, so that it does not depend on threads which images fit.
    let known: Vec<Option<Result<Known<'_>, String>>> = encoded
        .iter()
        .enumerate()
        .map(|(i, encoded)| {
            let encoded = encoded.as_ref()?;
            if first[i].is_some_and(|first| first != i) {
                return None;
            }
            Some(known(encoded, contents[i], budget))
        })
        .collect();
    let largest = known
        .iter()
        .flatten()
        .flatten()
        .map(|known| known.needed)
        .max()
        .unwrap_or(0);
    let decode = |known: Option<Result<Known<'_>, String>>| {
        Some(known?.and_then(|known| {
            let decoded = catch_unwind(AssertUnwindSafe(|| decode(&known)));
            let decoded = decoded.unwrap_or_else(|_| Err("its decoder failed".to_owned()));
            decoded.inspect_err(|_| budget.give_back(known.kept))
        }))
    };
    let at_once = rayon::current_num_threads() as u64;
    if largest.saturating_mul(at_once) <= budget.left() {
        known.into_par_iter().with_max_len(1).map(decode).collect()
    } else {
        known.into_iter().map(decode).collect()
    }
}

/// Reads the headers and takes the image from the budget.
fn known<'a>(encoded: &Encoded<'a>, content: Content<'a>, budget: &Budget) -> Result<Known<'a>, String> {
    let header = header(encoded)?;
    let base = match content {
        // Its own role tells what is wrong with it.
        Content::Highlight(_, Some(base)) => self::header(base).ok(),
        _ => None,
    };
    // The colours are scaled to the map's size.
    let scaled = base.map_or(0, |base| base.needed + Image::bytes(header.size) as u64);
    let needed = header.needed + scaled;
    let kept = Image::bytes(header.size);
    if needed + kept as u64 > budget.left() {
        return Err(format!(
            "it takes {}, but {} of the memory limit are left",
            in_bytes(needed + kept as u64),
            in_bytes(budget.left())
        ));
    }
    budget.take(kept).map_err(|error| error.to_string())?;
    Ok(Known {
        header,
        content,
        base,
        kept,
        needed,
    })
}

fn header<'a>(encoded: &Encoded<'a>) -> Result<Header<'a>, String> {
    use ImageFormat::{Bmp, Gif, Jpeg, Png, Tga, WebP};
    let bytes = encoded.bytes.clone()?;
    let by_name = || ImageFormat::from_path(Path::new(&encoded.name)).ok();
    let format = image::guess_format(bytes).ok().or_else(by_name);
    let format =
        format.filter(|format| matches!(format, Png | Jpeg | WebP | Bmp | Tga | Gif | ImageFormat::Tiff));
    let expected = "unknown kind of picture, expected PNG, JPEG, WebP, BMP, TGA, GIF or TIFF";
    let format = format.ok_or(expected)?;
    let tiff = (format == ImageFormat::Tiff)
        .then(|| Tiff::of(bytes))
        .transpose()?;
    let readable = readable(bytes, tiff.as_ref());
    let mut reader = ImageReader::with_format(Cursor::new(&*readable), format);
    reader.limits(limits(HEADER_BYTES));
    let decoder = reader.into_decoder().map_err(|error| fault(&error, bytes))?;
    let (width, height) = decoder.dimensions();
    if width.max(height) > MAX_IMAGE_SIDE || width.min(height) == 0 {
        return Err(format!(
            "it has {width}x{height} pixels, expected at most {MAX_IMAGE_SIDE}x{MAX_IMAGE_SIDE}"
        ));
    }
    let pixels = u64::from(width) * u64::from(height);
    let beside = tiff.map_or(0, |tiff| tiff.bytes_beside(bytes.len(), pixels));
    Ok(Header {
        bytes,
        format,
        tiff,
        size: [width, height],
        // Decoded, as RGBA, and what a decoder keeps beside: coefficients or planes.
        needed: decoder.total_bytes().saturating_mul(2) + 4 * pixels + beside + DECODER_BYTES,
    })
}

/// The file as its decoder can read it.
pub(in crate::format) fn readable<'a>(bytes: &'a [u8], tiff: Option<&Tiff>) -> Cow<'a, [u8]> {
    tiff.map_or(bytes.into(), |tiff| tiff.readable(bytes))
}

fn rgba(header: &Header<'_>) -> Result<RgbaImage, String> {
    let tiff = header.tiff.as_ref();
    let readable = readable(header.bytes, tiff);
    let mut reader = ImageReader::with_format(Cursor::new(&*readable), header.format);
    reader.limits(limits(header.needed));
    let mut decoded: DynamicImage = reader.decode().map_err(|error| fault(&error, header.bytes))?;
    if let Some(tiff) = tiff {
        decoded = tiff.straight(decoded);
    }
    Ok(decoded.into_rgba8())
}

fn decode(known: &Known<'_>) -> Result<Made, String> {
    let mut image = rgba(&known.header)?;
    let (mut least_alpha, mut smoothness) = (u8::MAX, None);
    match known.content {
        Content::Highlight(highlight, _) => {
            let base = known.base.filter(|_| highlight.shows_metal(&image));
            let base = base.and_then(|base| rgba(&base).ok());
            let base = base.map(|base| match image.dimensions() {
                size if size == base.dimensions() => base,
                (width, height) => imageops::resize(&base, width, height, FilterType::Triangle),
            });
            smoothness = Some(highlight.apply(&mut image, base.as_deref().unwrap_or_default()));
        }
        Content::Colors => {
            for pixel in image.pixels_mut() {
                least_alpha = least_alpha.min(pixel.0[3]);
                pixel.0[3] = u8::MAX;
            }
        }
        Content::ColorsAndAlpha | Content::Normals { .. } | Content::Numbers => {}
    }
    let pixels = bytemuck::allocation::try_cast_vec(image.into_raw());
    let pixels = pixels.map_err(|_| "it does not fit into memory".to_owned())?;
    let image = match known.content {
        Content::Normals { is_sure } => normal_map(known.header.size, pixels, is_sure)?,
        Content::Numbers => {
            Image::of_numbers(known.header.size, pixels).map_err(|error| error.to_string())?
        }
        _ => Image::new(known.header.size, pixels).map_err(|error| error.to_string())?,
    };
    Ok(Made {
        image,
        loses_alpha: least_alpha < u8::MAX,
        smoothness,
    })
}

/// The image of a normal map, whose mean points away from the surface unless it `is_sure` to be one, or of a height map.
fn normal_map(size: [u32; 2], mut pixels: Vec<[u8; 4]>, is_sure: bool) -> Result<Image, String> {
    if heights::is_grey(&pixels) {
        pixels = heights::normals(size, &pixels);
    }
    let image = Image::of_numbers(size, pixels).map_err(|error| error.to_string())?;
    let [red, green, blue, _] = image.mean();
    if is_sure || blue > red.max(green).saturating_add(16) {
        Ok(image)
    } else {
        Err("it is neither a normal map nor a grey height map".to_owned())
    }
}

pub(in crate::format) fn limits(bytes: u64) -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(bytes);
    limits
}

pub(in crate::format) fn sentence(error: &ImageError) -> String {
    decoder_reason(&error.to_string())
}

/// What is wrong with a file of these bytes.
fn fault(error: &ImageError, bytes: &[u8]) -> String {
    Tiff::fault(bytes, error).unwrap_or_else(|| sentence(error))
}

pub(in crate::format) fn reason(error: &ImageError, bytes: &[u8]) -> Reason {
    let message = fault(error, bytes);
    match error {
        ImageError::Limits(_) => Reason::limit(message),
        ImageError::Unsupported(_) => Reason::unsupported(message),
        _ => message.into(),
    }
}
