//! The film: a picture in memory, and its conversion to bytes.

use super::Transfer;
use crate::{
    lanes::LANES,
    simd::{EightLanes, Simd},
};
use rayon::prelude::*;
use std::collections::TryReserveError;

/// The pixel format of a film; other crates cannot add one.
pub trait Pixel: FromLanes + Copy + Default + Send + Sync {
    /// Whether it stores coverage. If so, camera rays that hit nothing are transparent instead of background.
    const HAS_ALPHA: bool = false;

    /// Converts linear RGB, premultiplied by alpha, the share of the samples that hit something.
    fn from_linear(rgb: [f32; 3], alpha: f32) -> Self;
}

/// The conversion of lanes, separate from [`Pixel`] because vectors are not public.
pub trait FromLanes: Sized {
    /// Converts eight pixels, red, green, blue and alpha; lane by lane the result is that of [`Pixel::from_linear`].
    fn from_lanes<S: Simd>(simd: S, rgba: [S::V8; 4]) -> [Self; LANES];
}

/// Linear RGB.
impl Pixel for [f32; 3] {
    fn from_linear(rgb: [f32; 3], _: f32) -> Self {
        rgb
    }
}

impl FromLanes for [f32; 3] {
    #[inline(always)]
    fn from_lanes<S: Simd>(_: S, [r, g, b, _]: [S::V8; 4]) -> [Self; LANES] {
        let (r8, g8, b8) = (r.to8().to_array(), g.to8().to_array(), b.to8().to_array());
        let mut pixels = [[0.0; 3]; LANES];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = [r8[i], g8[i], b8[i]];
        }
        pixels
    }
}

/// Linear premultiplied RGBA, as in EXR.
impl Pixel for [f32; 4] {
    const HAS_ALPHA: bool = true;

    fn from_linear([r, g, b]: [f32; 3], alpha: f32) -> Self {
        [r, g, b, alpha]
    }
}

impl FromLanes for [f32; 4] {
    #[inline(always)]
    fn from_lanes<S: Simd>(_: S, [r, g, b, alpha]: [S::V8; 4]) -> [Self; LANES] {
        let (r8, g8, b8) = (r.to8().to_array(), g.to8().to_array(), b.to8().to_array());
        let alpha8 = alpha.to8().to_array();
        let mut pixels = [[0.0; 4]; LANES];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = [r8[i], g8[i], b8[i], alpha8[i]];
        }
        pixels
    }
}

/// 8 bits per channel by [`quantize`].
impl Pixel for [u8; 3] {
    fn from_linear(rgb: [f32; 3], _: f32) -> Self {
        rgb.map(quantize)
    }
}

impl FromLanes for [u8; 3] {
    #[inline(always)]
    fn from_lanes<S: Simd>(_: S, [r, g, b, _]: [S::V8; 4]) -> [Self; LANES] {
        // Tuned: see docs/lab-notes.md#film-bytes
        let pairs = S::V8::byte_pairs([to_bytes(r), to_bytes(g), to_bytes(b)]);
        // Two pixels of 48 bits in each pair; two of these make three words.
        let mut words = [0_u32; 6];
        for half in 0..2 {
            let (low, high) = (pairs[2 * half], pairs[2 * half + 1]);
            let first = low | high << 48;
            words[3 * half] = (first as u32).to_le();
            words[3 * half + 1] = ((first >> 32) as u32).to_le();
            words[3 * half + 2] = ((high >> 16) as u32).to_le();
        }
        bytemuck::must_cast(words)
    }
}

/// A picture of [`Pixel`]s, linear RGB by default; row 0 is the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film<P = [f32; 3]> {
    width: u32,
    height: u32,
    pixels: Vec<P>,
}

/// A picture of bytes, a quarter of the memory of [`Film`].
pub type ByteFilm = Film<[u8; 3]>;

impl<P: Pixel> Film<P> {
    /// Makes a black picture of any pixel format.
    #[must_use]
    pub fn black(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            pixels: vec![P::default(); width as usize * height as usize],
        }
    }

    /// Resizes the picture and reuses its memory. The pixels are unspecified afterwards unless the size is the same.
    pub fn resize(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width, height);
        self.pixels.resize(width as usize * height as usize, P::default());
    }

    /// Resizes the picture as [`Film::resize`] does.
    ///
    /// # Errors
    /// [`TryReserveError`] if there is not enough memory; the picture is unchanged then.
    pub fn try_resize(&mut self, width: u32, height: u32) -> Result<(), TryReserveError> {
        let more = (width as usize * height as usize).saturating_sub(self.pixels.len());
        self.pixels.try_reserve_exact(more)?;
        self.resize(width, height);
        Ok(())
    }

    /// Returns the width, pixels.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height, pixels.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns all pixels row by row, the top row first.
    #[must_use]
    pub fn pixels(&self) -> &[P] {
        &self.pixels
    }

    /// Returns all pixels mutably, in the order of [`Film::pixels`].
    pub fn pixels_mut(&mut self) -> &mut [P] {
        &mut self.pixels
    }
}

impl Film {
    /// Makes a black picture of linear RGB.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self::black(width, height)
    }

    /// Converts to 8 bits per channel by [`quantize`], without gamma, on the current rayon pool.
    #[must_use]
    pub fn to_rgb8(&self) -> Vec<u8> {
        self.to_bytes(Transfer::Linear)
    }

    /// Converts to 8 bits per channel, row by row, on the current rayon pool.
    #[must_use]
    pub fn to_bytes(&self, transfer: Transfer) -> Vec<u8> {
        in_parallel(&self.pixels, |rgb: [f32; 3]| transfer.encode(rgb))
    }
}

impl Film<[f32; 4]> {
    /// Converts to 8 bits per channel, row by row, on the current rayon pool: straight colours, as PNG has them, and
    /// trunc(255 x alpha). Where alpha is between 0 and 1, a colour may be 2^-18 of itself short of the next level: sums of
    /// samples are that wrong.
    #[must_use]
    pub fn to_bytes(&self, transfer: Transfer) -> Vec<u8> {
        in_parallel(&self.pixels, |[r, g, b, alpha]: [f32; 4]| {
            let [r, g, b] = transfer.encode(straight([r, g, b], alpha));
            [r, g, b, quantize(alpha)]
        })
    }
}

/// The colour of what covers a pixel by that alpha.
fn straight(rgb: [f32; 3], alpha: f32) -> [f32; 3] {
    if alpha > 0.0 && alpha < 1.0 {
        rgb.map(|c| c / alpha * (1.0 + 32.0 * f32::EPSILON))
    } else if alpha > 1.0 {
        rgb.map(|c| c / alpha)
    } else {
        rgb
    }
}

fn in_parallel<const N: usize>(pixels: &[[f32; N]], encode: impl Fn([f32; N]) -> [u8; N] + Sync) -> Vec<u8> {
    const CHUNK: usize = 1 << 14;
    let mut bytes = vec![[0; N]; pixels.len()];
    bytes
        .par_chunks_mut(CHUNK)
        .zip(pixels.par_chunks(CHUNK))
        .for_each(|(bytes, pixels)| {
            for (to, &pixel) in bytes.iter_mut().zip(pixels) {
                *to = encode(pixel);
            }
        });
    bytes.into_flattened()
}

/// Returns trunc(255 x clamp(c, 0, 1)).
#[inline]
#[must_use]
pub fn quantize(channel: f32) -> u8 {
    // The cast saturates and truncates; 255 * 1.0 is exact.
    (channel.clamp(0.0, 1.0) * 255.0) as u8
}

/// Returns 255 x clamp(c, 0, 1), rounded to the nearest: for values that are no colours, such as components of normals.
#[inline]
#[doc(hidden)]
pub fn nearest_byte(channel: f32) -> u8 {
    libm::roundf(channel.clamp(0.0, 1.0) * 255.0) as u8
}

/// [`quantize`] without truncation.
#[inline(always)]
fn to_bytes<V: EightLanes>(channel: V) -> V {
    channel.max(channel.all(0.0)).min(channel.all(1.0)) * 255.0
}

#[cfg(test)]
mod tests;
