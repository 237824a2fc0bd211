//! Images of environments: Radiance HDR, OpenEXR, or any format of textures.

#[cfg(feature = "textures")]
pub(super) use decoding::decode;

#[cfg(feature = "textures")]
mod radiance;

use super::left_out::counted;
#[cfg(not(feature = "textures"))]
use super::reason::Reason;
#[cfg(feature = "cli")]
use super::{Limits, budget::Budget, files};
#[cfg(feature = "cli")]
use crate::error::LoadError;
use crate::error::clip_path;
use std::path::Path;

/// Width, height and the pixels, rows from the top.
pub(crate) type Decoded = ([u32; 2], Vec<[f32; 3]>);

/// Reads an environment's image; also returns what there is to note.
///
/// # Errors
/// [`LoadError`].
#[cfg(feature = "cli")]
pub(crate) fn load(path: &Path, limits: impl Into<Limits>) -> Result<(Decoded, Option<String>), LoadError> {
    let budget = Budget::new(limits);
    let bytes = files::read(path, &budget).map_err(|error| files::load_error(path, &error))?;
    let decoded = decode(&bytes, path, &budget).map_err(|reason| reason.of_file(path))?;
    let note = odd_note(path, &decoded);
    Ok((decoded, note))
}

/// What there is to note about the pixels of a file.
pub(super) fn odd_note(path: &Path, (_, texels): &Decoded) -> Option<String> {
    let is_odd = |light: &&f32| light.is_nan() || **light < 0.0;
    let odd = texels.iter().flatten().filter(is_odd).count();
    let channels = counted(odd, "channel of a pixel is", "channels of pixels are");
    (odd > 0).then(|| format!("{}: {channels} negative or NaN: taken as 0", clip_path(path)))
}

#[cfg(feature = "textures")]
mod decoding {
    use super::{Decoded, radiance::Radiance};
    use crate::{
        error::{decoder_reason, in_bytes},
        format::{
            budget::Budget,
            reason::Reason,
            textures::decoding::{DECODER_BYTES, HEADER_BYTES, limits, readable, reason},
            tiff,
        },
        scene::{EnvironmentPicture, MAX_ENVIRONMENT_SIDE},
    };
    use image::{ImageDecoder, ImageFormat, ImageReader};
    use std::{
        io::Cursor,
        panic::{AssertUnwindSafe, catch_unwind},
        path::Path,
    };

    /// Decodes an image, and takes the environment's memory from the budget. The error is a sentence.
    pub(in crate::format) fn decode(bytes: &[u8], path: &Path, budget: &Budget) -> Result<Decoded, Reason> {
        let decoded = catch_unwind(AssertUnwindSafe(|| decode_within(bytes, path, budget)));
        decoded.unwrap_or_else(|_| Err("its decoder failed".into()))
    }

    fn decode_within(bytes: &[u8], path: &Path, budget: &Budget) -> Result<Decoded, Reason> {
        use ImageFormat::{Bmp, Hdr, Jpeg, OpenExr, Png, Tga, Tiff, WebP};
        let by_name = || ImageFormat::from_path(path).ok();
        let is_radiance = bytes.starts_with(b"#?").then_some(Hdr);
        let format = is_radiance.or_else(|| image::guess_format(bytes).ok().or_else(by_name));
        let format =
            format.filter(|format| matches!(format, Hdr | OpenExr | Png | Jpeg | WebP | Bmp | Tga | Tiff));
        let unknown = "unknown kind of picture, expected HDR, OpenEXR, PNG, JPEG, WebP, BMP, TGA or TIFF";
        let format = format.ok_or_else(|| Reason::unsupported(unknown))?;
        let most_block = match format {
            OpenExr => exr_block(bytes)?,
            _ => 0,
        };
        let radiance = (format == Hdr).then(|| Radiance::read(bytes)).transpose()?;
        let tiff = (format == Tiff).then(|| tiff::Tiff::of(bytes));
        let tiff = tiff.transpose().map_err(Reason::unsupported)?;
        let readable = readable(bytes, tiff.as_ref());
        let pixels = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        let (size, decoded) = if let Some(radiance) = &radiance {
            (radiance.size, 12 * pixels(radiance.size))
        } else {
            let mut reader = ImageReader::with_format(Cursor::new(&*readable), format);
            reader.limits(limits(HEADER_BYTES));
            let decoder = reader.into_decoder().map_err(|error| reason(&error, bytes))?;
            (decoder.dimensions().into(), decoder.total_bytes())
        };
        let [width, height] = size;
        check_size(width, height)?;
        // The decoded image, RGB floats, and the decoder's own memory.
        let beside = tiff.map_or(0, |tiff| tiff.bytes_beside(bytes.len(), pixels(size)));
        let needed = decoded.saturating_mul(2) + 12 * pixels(size) + most_block + beside + DECODER_BYTES;
        let kept = EnvironmentPicture::bytes(size);
        if needed + kept as u64 > budget.left() {
            return Err(Reason::limit(format!(
                "it takes {}, but {} of the memory limit are left",
                in_bytes(needed + kept as u64),
                in_bytes(budget.left())
            )));
        }
        budget.take(kept)?;
        if let Some(radiance) = radiance {
            return Ok((size, radiance.decode()?));
        }
        let mut reader = ImageReader::with_format(Cursor::new(&*readable), format);
        reader.limits(limits(needed));
        let decoded = reader.decode().map_err(|error| reason(&error, bytes))?;
        let decoded = match tiff {
            Some(tiff) => tiff.straight(decoded),
            None => decoded,
        };
        let floats = decoded.into_rgb32f().into_raw();
        let texels = bytemuck::allocation::try_cast_vec(floats);
        let texels = texels.map_err(|_| Reason::limit("it does not fit into memory".to_owned()))?;
        Ok((size, texels))
    }

    fn check_size(width: u32, height: u32) -> Result<(), String> {
        if (1..=MAX_ENVIRONMENT_SIDE).contains(&width) && (1..=MAX_ENVIRONMENT_SIDE).contains(&height) {
            return Ok(());
        }
        Err(format!(
            "it has {width}x{height} pixels, expected 1x1 to {MAX_ENVIRONMENT_SIDE}x{MAX_ENVIRONMENT_SIDE}"
        ))
    }

    /// Memory of the parts of an EXR file, whose sizes may differ from the image's: twice the bytes of their samples.
    fn exr_block(bytes: &[u8]) -> Result<u64, String> {
        let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false);
        let meta = meta.map_err(|error| decoder_reason(&error.to_string()))?;
        let mut most = 0;
        for header in &meta.headers {
            let exr::math::Vec2(width, height) = header.layer_size;
            let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
            check_size(side(width), side(height))?;
            if let exr::meta::BlockDescription::Tiles(tiles) = header.blocks {
                let exr::math::Vec2(width, height) = tiles.tile_size;
                check_size(side(width), side(height))?;
            }
            let pixel = header.channels.bytes_per_pixel as u64;
            most = most.max(2 * width as u64 * height as u64 * pixel);
        }
        Ok(most)
    }
}

#[cfg(not(feature = "textures"))]
pub(super) fn decode(_: &[u8], _: &Path, _: &super::budget::Budget) -> Result<Decoded, Reason> {
    Err(Reason::unsupported(
        "octray was built without its feature `textures`",
    ))
}
