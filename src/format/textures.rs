//! The images of a mesh's textures: decoded once the mesh is known, on all threads.
//!
//! A texture that cannot be shown is a note, never an error: the shape is there all the same.

use super::{budget::Budget, mesh::Surface};
use crate::{
    error::{LoadError, clip, clip_path},
    scene::{CutOut, Image, Texture},
};
use std::path::Path;

/// An image that surfaces name, and its file's bytes.
pub(super) struct Encoded<'a> {
    /// What notes call it.
    pub(super) name: String,
    /// Its bytes, or why there are none.
    pub(super) bytes: Result<&'a [u8], String>,
}

/// Why a file could not be read, without its name.
pub(super) fn reason(error: &LoadError) -> String {
    error
        .chain()
        .last()
        .map_or_else(String::new, |error| error.message.clone())
}

/// Which of `count` images any of these surfaces shows.
pub(super) fn used_images<'a>(count: usize, surfaces: impl Iterator<Item = &'a Surface>) -> Vec<bool> {
    let mut used = vec![false; count];
    for surface in surfaces {
        for texture in textures(surface).into_iter().flatten() {
            if let Some(used) = used.get_mut(texture.image as usize) {
                *used = true;
            }
        }
    }
    used
}

/// Which surfaces any triangle has.
pub(super) fn used_surfaces(count: usize, surface_of: &[u32]) -> Vec<bool> {
    let mut used = vec![false; count];
    for &surface in surface_of {
        if let Some(used) = used.get_mut(surface as usize) {
            *used = true;
        }
    }
    used
}

fn textures(surface: &Surface) -> [Option<Texture>; 3] {
    let all = &surface.textures;
    [
        all.base,
        all.cut_out.map(|cut_out| cut_out.texture),
        all.emission_map,
    ]
}

/// Decodes the images that are used; `path` is the mesh's. Surfaces name the images that it returns then, and those that
/// cannot be decoded become notes.
pub(super) fn decode(
    encoded: &[Option<Encoded<'_>>],
    surfaces: &mut [Surface],
    path: &Path,
    budget: &Budget,
    notes: &mut Vec<String>,
) -> Vec<Image> {
    let decoded = decoding::all(encoded, budget);
    let mut images = Vec::new();
    let mut numbers = vec![None; encoded.len()];
    for ((encoded, decoded), number) in encoded.iter().zip(decoded).zip(&mut numbers) {
        match (encoded, decoded) {
            (Some(_), Some(Ok(image))) => {
                *number = Some(images.len() as u32);
                images.push(image);
            }
            (Some(encoded), Some(Err(reason))) => {
                let (path, name) = (clip_path(path), clip(&encoded.name));
                notes.push(format!("{path}: texture {name} is missing: {}", clip(&reason)));
            }
            _ => {}
        }
    }
    for surface in surfaces {
        renumber(surface, &numbers, &images);
    }
    images
}

/// Gives a surface's textures the numbers of decoded images, and drops those that were not decoded.
fn renumber(surface: &mut Surface, numbers: &[Option<u32>], images: &[Image]) {
    let number = |texture: Texture| {
        let image = numbers.get(texture.image as usize).copied().flatten()?;
        Some(Texture { image, ..texture })
    };
    let all = &mut surface.textures;
    if all.base.is_some() && all.base.and_then(number).is_none() {
        // Textures are rarely white.
        for (channel, neutral) in surface.diffuse.iter_mut().zip(Surface::NEUTRAL.diffuse) {
            *channel *= neutral;
        }
    }
    all.base = all.base.and_then(number);
    if all.emission_map.is_some() && all.emission_map.and_then(number).is_none() {
        all.emission = [0.0; 3];
    }
    all.emission_map = all.emission_map.and_then(number);
    all.cut_out = all.cut_out.and_then(|cut_out| {
        let texture = number(cut_out.texture)?;
        let has_alpha = images.get(texture.image as usize)?.has_alpha();
        // Opacity is in alpha, or in the colour of an image without alpha.
        let channel = if has_alpha { 3 } else { cut_out.channel };
        (channel < 3 || has_alpha).then_some(CutOut {
            texture,
            channel,
            ..cut_out
        })
    });
}

#[cfg(feature = "textures")]
mod decoding {
    use super::{Budget, Encoded, Image};
    use crate::{error::in_bytes, scene::MAX_IMAGE_SIDE};
    use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};
    use rayon::prelude::*;
    use std::{
        io::Cursor,
        panic::{AssertUnwindSafe, catch_unwind},
        path::Path,
    };

    /// Memory of a decoder beside the pixels, bytes.
    const DECODER_BYTES: u64 = 1 << 20;

    /// An image whose header was read.
    struct Known<'a> {
        bytes: &'a [u8],
        format: ImageFormat,
        /// What decoding it takes until the image is made, bytes.
        needed: u64,
    }

    pub(super) fn all(
        encoded: &[Option<Encoded<'_>>],
        budget: &Budget,
    ) -> Vec<Option<Result<Image, String>>> {
        // In order, so that it does not depend on threads which images fit.
        let known: Vec<Option<Result<Known<'_>, String>>> = encoded
            .iter()
            .map(|encoded| {
                let encoded = encoded.as_ref()?;
                let bytes = encoded.bytes.clone();
                Some(bytes.and_then(|bytes| known(bytes, &encoded.name, budget)))
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
                decoded.unwrap_or_else(|_| Err("its decoder failed".to_owned()))
            }))
        };
        let at_once = rayon::current_num_threads() as u64;
        if largest.saturating_mul(at_once) <= budget.left() {
            known.into_par_iter().with_max_len(1).map(decode).collect()
        } else {
            known.into_iter().map(decode).collect()
        }
    }

    /// Reads the header and takes the image from the budget.
    fn known<'a>(bytes: &'a [u8], name: &str, budget: &Budget) -> Result<Known<'a>, String> {
        let by_name = || ImageFormat::from_path(Path::new(name)).ok();
        let format = image::guess_format(bytes).ok().or_else(by_name);
        let format = format.filter(|format| format.reading_enabled());
        let format = format.ok_or("unknown kind of picture, expected PNG, JPEG, WebP, BMP or TGA")?;
        let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder();
        let decoder = decoder.map_err(|error| sentence(&error))?;
        let (width, height) = decoder.dimensions();
        if width.max(height) > MAX_IMAGE_SIDE || width.min(height) == 0 {
            return Err(format!(
                "it has {width}x{height} pixels, expected at most {MAX_IMAGE_SIDE}x{MAX_IMAGE_SIDE}"
            ));
        }
        let pixels = u64::from(width) * u64::from(height);
        // Decoded, as RGBA, and what a decoder keeps beside: coefficients or planes.
        let needed = decoder.total_bytes().saturating_mul(2) + 4 * pixels + DECODER_BYTES;
        let kept = Image::bytes([width, height]) as u64;
        if needed + kept > budget.left() {
            return Err(format!(
                "it takes {}, above what is left of the memory limit",
                in_bytes(needed + kept)
            ));
        }
        budget.take(kept as usize).map_err(|error| error.to_string())?;
        Ok(Known {
            bytes,
            format,
            needed,
        })
    }

    fn decode(known: &Known<'_>) -> Result<Image, String> {
        let mut reader = ImageReader::with_format(Cursor::new(known.bytes), known.format);
        let mut limits = Limits::default();
        limits.max_alloc = Some(known.needed);
        reader.limits(limits);
        let decoded: DynamicImage = reader.decode().map_err(|error| sentence(&error))?;
        let image = decoded.into_rgba8();
        let (width, height) = image.dimensions();
        let pixels = bytemuck::allocation::try_cast_vec(image.into_raw());
        let pixels = pixels.map_err(|_| "it does not fit into memory".to_owned())?;
        Image::new([width, height], pixels).map_err(|error| error.to_string())
    }

    fn sentence(error: &ImageError) -> String {
        match error {
            ImageError::IoError(error) => error.to_string(),
            error => error.to_string().to_lowercase(),
        }
    }
}

#[cfg(not(feature = "textures"))]
mod decoding {
    use super::{Budget, Encoded, Image};

    pub(super) fn all(encoded: &[Option<Encoded<'_>>], _: &Budget) -> Vec<Option<Result<Image, String>>> {
        let missing = || Err("octray was built without its feature `textures`".to_owned());
        encoded
            .iter()
            .map(|encoded| encoded.as_ref().map(|_| missing()))
            .collect()
    }
}
