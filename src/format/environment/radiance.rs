//! Radiance HDR files. The `image` crate decodes their pixels, but knows only the head `#?RADIANCE` and rows from the top, and
//! leaves the exposure in the values.
//!
//! Format: *Radiance File Formats*, Greg Ward.

use crate::{error::quote, format::textures::decoding::sentence};
use image::{DynamicImage, codecs::hdr::HdrDecoder};
use std::io::{Cursor, Read};

/// The most bytes of a header, whose end is an empty line.
const MOST_HEADER: usize = 1 << 16;

/// The most bytes of the line after the header.
const MOST_SIZE_LINE: usize = 256;

/// A file whose header was read.
pub(super) struct Radiance<'a> {
    /// Width and height.
    pub(super) size: [u32; 2],
    /// Whether scanlines are columns.
    is_turned: bool,
    /// Whether x runs to the left, and y upwards.
    is_reversed: [bool; 2],
    /// What a value of 1 became, for each channel.
    exposure: [f32; 3],
    pixels: &'a [u8],
}

impl<'a> Radiance<'a> {
    /// Reads the header. The error is a sentence.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, String> {
        if ![&b"#?RADIANCE"[..], b"#?RGBE"]
            .iter()
            .any(|head| bytes.starts_with(head))
        {
            return Err("it begins neither with `#?RADIANCE` nor with `#?RGBE`".to_owned());
        }
        let head = bytes.get(..MOST_HEADER).unwrap_or(bytes);
        let mut exposure = [1.0; 3];
        let mut end = 0;
        loop {
            let line = head[end..].split_inclusive(|&byte| byte == b'\n').next();
            let line = line.filter(|line| line.ends_with(b"\n"));
            let line = line.ok_or_else(|| format!("its header has no end within {MOST_HEADER} bytes"))?;
            end += line.len();
            if line.trim_ascii().is_empty() {
                break;
            }
            check_format(line)?;
            // Each line is one more step that the values went through.
            if let Some(factor) = line.strip_prefix(b"EXPOSURE=") {
                let [factor] = factors("EXPOSURE", factor)?;
                exposure = exposure.map(|exposure| exposure * factor);
            } else if let Some(all) = line.strip_prefix(b"COLORCORR=") {
                let all: [f32; 3] = factors("COLORCORR", all)?;
                exposure = std::array::from_fn(|channel| exposure[channel] * all[channel]);
            }
        }
        if !exposure.iter().all(|exposure| exposure.is_normal()) {
            return Err(
                "its EXPOSURE and COLORCORR multiply to a number that is too small or too large".to_owned(),
            );
        }
        let rest = &bytes[end..];
        let line = rest.get(..MOST_SIZE_LINE).unwrap_or(rest);
        let line = line.split(|&byte| byte == b'\n').next().unwrap_or_default();
        let found = Self::of_size_line(line, rest.get(line.len() + 1..).unwrap_or_default());
        let found = found.ok_or_else(|| {
            let line = quote(line.trim_ascii());
            format!("the line of its size is {line}, expected for example `-Y 512 +X 1024`")
        })?;
        Ok(Self { exposure, ..found })
    }

    /// `-Y 512 +X 1024`: 512 scanlines downwards, with 1024 pixels each, to the right.
    fn of_size_line(line: &[u8], pixels: &'a [u8]) -> Option<Self> {
        let mut words = std::str::from_utf8(line).ok()?.split_ascii_whitespace();
        let mut next = || Some((words.next()?, words.next()?.parse::<u32>().ok()?));
        let ((slow, scanlines), (fast, length)) = (next()?, next()?);
        let is_turned = matches!(slow, "-X" | "+X");
        let (x, y, size) = if is_turned {
            (slow, fast, [scanlines, length])
        } else {
            (fast, slow, [length, scanlines])
        };
        let is_known = matches!(x, "-X" | "+X") && matches!(y, "-Y" | "+Y");
        (is_known && words.next().is_none()).then_some(Self {
            size,
            is_turned,
            is_reversed: [x == "-X", y == "+Y"],
            exposure: [1.0; 3],
            pixels,
        })
    }

    /// The pixels, rows from the top. Takes 24 bytes for each.
    pub(super) fn decode(&self) -> Result<Vec<[f32; 3]>, String> {
        let [width, height] = self.size;
        let (scanlines, length) = if self.is_turned {
            (width, height)
        } else {
            (height, width)
        };
        let head = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {scanlines} +X {length}\n");
        let reader = Cursor::new(head).chain(self.pixels);
        let decoder = HdrDecoder::new(reader).map_err(|error| sentence(&error))?;
        let decoded = DynamicImage::from_decoder(decoder).map_err(|error| sentence(&error))?;
        let texels = bytemuck::allocation::try_cast_vec(decoded.into_rgb32f().into_raw());
        let mut texels: Vec<[f32; 3]> = texels.map_err(|_| "it does not fit into memory".to_owned())?;
        let [width, height] = [width as usize, height as usize];
        if self.is_turned {
            let columns = texels;
            let row = |y: usize| columns.iter().skip(y).step_by(height);
            texels = (0..height).flat_map(row).copied().collect();
        }
        if self.is_reversed[0] {
            texels.chunks_exact_mut(width).for_each(<[_]>::reverse);
        }
        if self.is_reversed[1] {
            // All pixels reversed, and each row once more.
            texels.reverse();
            texels.chunks_exact_mut(width).for_each(<[_]>::reverse);
        }
        if self.exposure != [1.0; 3] {
            for texel in &mut texels {
                *texel = std::array::from_fn(|channel| texel[channel] / self.exposure[channel]);
            }
        }
        Ok(texels)
    }
}

/// Refuses a line that names another format.
fn check_format(line: &[u8]) -> Result<(), String> {
    match line.strip_prefix(b"FORMAT=").map(<[u8]>::trim_ascii) {
        None | Some(b"32-bit_rle_rgbe") => Ok(()),
        Some(b"32-bit_rle_xyze") => {
            Err("its colours are XYZ, expected RGB; Radiance's `ra_xyze -r` converts it".to_owned())
        }
        Some(other) => {
            let other = quote(other);
            Err(format!("its format is {other}, expected `32-bit_rle_rgbe`"))
        }
    }
}

/// The numbers of a line that values were multiplied by.
fn factors<const N: usize>(name: &str, text: &[u8]) -> Result<[f32; N], String> {
    let words = text
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    let numbers = words.map(|word| fast_float2::parse(word).ok());
    let all: Option<Vec<f32>> = numbers.take(N + 1).collect();
    let all = all.filter(|all| all.iter().all(|factor| factor.is_normal() && *factor > 0.0));
    all.and_then(|all| all.try_into().ok()).ok_or_else(|| {
        let expected = if N == 1 { "a number" } else { "three numbers" };
        let found = quote(text.trim_ascii());
        format!("its {name} is {found}, expected {expected} above 0")
    })
}

#[cfg(test)]
mod tests;
