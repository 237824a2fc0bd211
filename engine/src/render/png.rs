//! PNG files, by the png crate.

use super::{Film, Transfer};
use crate::whole_file;
use ::png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Filter};
use std::{
    io::{self, Write},
    path::Path,
};

/// The text `Software` of every PNG file that octray writes: it tells octray's own pictures from other files.
pub const SOFTWARE: &str = "octray";

/// Writes pixels, row by row, as a PNG file: grey (1 byte per pixel), grey of 16 bits with the high byte first (2), RGB (3) or
/// RGBA (4). `texts` are keywords and their texts.
///
/// # Errors
/// [`io::Error`] if `out` fails, a side is 0, or `bytes` are not those of such pixels.
pub fn write_png(
    out: impl Write,
    [width, height]: [u32; 2],
    bytes: &[u8],
    pixel_bytes: usize,
    texts: &[(&str, &str)],
) -> io::Result<()> {
    let pixels = u64::from(width) * u64::from(height);
    let expected = pixels.checked_mul(pixel_bytes as u64);
    if !(1..=4).contains(&pixel_bytes) || expected != Some(bytes.len() as u64) {
        let why = format!(
            "{width}x{height} pixels of {pixel_bytes} bytes are not {} bytes",
            bytes.len()
        );
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    let write = || -> Result<(), EncodingError> {
        let mut encoder = Encoder::new(out, width, height);
        let (color, depth) = match pixel_bytes {
            1 => (ColorType::Grayscale, BitDepth::Eight),
            2 => (ColorType::Grayscale, BitDepth::Sixteen),
            4 => (ColorType::Rgba, BitDepth::Eight),
            _ => (ColorType::Rgb, BitDepth::Eight),
        };
        encoder.set_color(color);
        encoder.set_depth(depth);
        // Tuned: see docs/lab-notes.md#png-filter
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Paeth);
        encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
        for &(keyword, text) in texts {
            encoder.add_text_chunk(keyword.into(), text.into())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(bytes)?;
        writer.finish()
    };
    write().map_err(io::Error::from)
}

impl Film {
    /// Saves the film as a PNG file of 8 bits per channel. The file appears whole or not at all.
    ///
    /// # Errors
    /// [`io::Error`] if the file cannot be written or the film has no pixels.
    pub fn save_png(&self, path: impl AsRef<Path>, transfer: Transfer) -> io::Result<()> {
        let size = [self.width(), self.height()];
        whole_file::write(path.as_ref(), |out| {
            write_png(out, size, &self.to_bytes(transfer), 3, &[])
        })
    }
}

#[cfg(test)]
mod tests;
