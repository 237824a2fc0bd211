//! The picture in memory: linear colour, and how it becomes bytes.

use super::Transfer;
use crate::simd::{F32x8, LANES, lane, max, min, pack_pairs, splat, truncate};
use rayon::prelude::*;
use std::collections::TryReserveError;

/// What a film keeps of each pixel's colour.
pub trait Pixel: Copy + Default + Send + Sync {
    /// Whether it keeps how much of the pixel is covered. Camera rays that hit nothing then bring no colour; else they
    /// bring the background's.
    const HAS_ALPHA: bool = false;

    /// From linear RGB, and the share of the samples that hit something: by that share the colour is multiplied
    /// already.
    fn from_linear(rgb: [f32; 3], alpha: f32) -> Self;

    /// From eight colours, a column a channel. Gives what [`Pixel::from_linear`] gives.
    fn from_lanes(rgb8: &[F32x8; 3], alpha8: &F32x8) -> [Self; LANES];
}

/// Linear RGB, as it is.
impl Pixel for [f32; 3] {
    fn from_linear(rgb: [f32; 3], _: f32) -> Self {
        rgb
    }

    #[inline(always)]
    fn from_lanes([r8, g8, b8]: &[F32x8; 3], _: &F32x8) -> [Self; LANES] {
        let mut pixels = [[0.0; 3]; LANES];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = [lane(r8, i), lane(g8, i), lane(b8, i)];
        }
        pixels
    }
}

/// Linear RGB times alpha, and alpha: premultiplied, as EXR has it.
impl Pixel for [f32; 4] {
    const HAS_ALPHA: bool = true;

    fn from_linear([r, g, b]: [f32; 3], alpha: f32) -> Self {
        [r, g, b, alpha]
    }

    #[inline(always)]
    fn from_lanes([r8, g8, b8]: &[F32x8; 3], alpha8: &F32x8) -> [Self; LANES] {
        let mut pixels = [[0.0; 4]; LANES];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = [lane(r8, i), lane(g8, i), lane(b8, i), lane(alpha8, i)];
        }
        pixels
    }
}

/// Eight bits a channel, see [`quantize`].
impl Pixel for [u8; 3] {
    fn from_linear(rgb: [f32; 3], _: f32) -> Self {
        rgb.map(quantize)
    }

    #[inline(always)]
    fn from_lanes(rgb8: &[F32x8; 3], _: &F32x8) -> [Self; LANES] {
        // Two pixels a number, then four in two: the second two begin in the first number. (In numbers of 128 bits, put
        // together pixel by pixel, the course's frames took 2 % longer, on Zen 3.)
        let [a, b, c, d] = pack_pairs(quantize8(rgb8));
        let mut bytes = [0; 3 * LANES];
        for (bytes, [low, high]) in bytes.as_chunks_mut::<12>().0.iter_mut().zip([[a, b], [c, d]]) {
            bytes[..8].copy_from_slice(&(low | high << 48).to_le_bytes());
            bytes[8..].copy_from_slice(&((high >> 16) as u32).to_le_bytes());
        }
        bytemuck::cast(bytes)
    }
}

/// A picture of linear RGB, or of what else a [`Pixel`] may be; row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film<P = [f32; 3]> {
    width: u32,
    height: u32,
    pixels: Vec<P>,
}

/// A picture of bytes: a quarter of the memory, which is what pays in large pictures.
pub type ByteFilm = Film<[u8; 3]>;

impl<P: Pixel> Film<P> {
    /// A black picture of any kind of pixels.
    #[must_use]
    pub fn black(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            pixels: vec![P::default(); width as usize * height as usize],
        }
    }

    /// Makes the picture `width` x `height` pixels large. Its colours are of no use then, unless it has that size
    /// already; memory is reused.
    pub fn resize(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width, height);
        self.pixels.resize(width as usize * height as usize, P::default());
    }

    /// As [`Film::resize`].
    ///
    /// # Errors
    /// [`TryReserveError`], where there is no memory for it; the picture is as it was then.
    pub fn try_resize(&mut self, width: u32, height: u32) -> Result<(), TryReserveError> {
        let more = (width as usize * height as usize).saturating_sub(self.pixels.len());
        self.pixels.try_reserve_exact(more)?;
        self.resize(width, height);
        Ok(())
    }

    /// Pixels across.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All pixels, row by row, row 0 on top.
    #[must_use]
    pub fn pixels(&self) -> &[P] {
        &self.pixels
    }

    /// The same, to write to.
    pub fn pixels_mut(&mut self) -> &mut [P] {
        &mut self.pixels
    }
}

impl Film {
    /// A black picture of linear RGB.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self::black(width, height)
    }

    /// Eight bits a channel, as the course does: trunc(255 x clamp(c)), no gamma. On the threads of the current
    /// rayon pool.
    #[must_use]
    pub fn to_rgb8(&self) -> Vec<u8> {
        self.to_bytes(Transfer::Linear)
    }

    /// Eight bits a channel, row by row. On the threads of the current rayon pool.
    #[must_use]
    pub fn to_bytes(&self, transfer: Transfer) -> Vec<u8> {
        in_parallel(&self.pixels, |rgb: [f32; 3]| transfer.encode(rgb))
    }
}

impl Film<[f32; 4]> {
    /// Eight bits a channel, row by row: red, green and blue not multiplied by alpha any more, as PNG has it, and
    /// trunc(255 x alpha). On the threads of the current rayon pool.
    #[must_use]
    pub fn to_bytes(&self, transfer: Transfer) -> Vec<u8> {
        in_parallel(&self.pixels, |[r, g, b, alpha]: [f32; 4]| {
            let whole = if alpha > 0.0 { alpha } else { 1.0 };
            let [r, g, b] = transfer.encode([r / whole, g / whole, b / whole]);
            [r, g, b, quantize(alpha)]
        })
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

/// trunc(255 x clamp(c, 0, 1)).
#[inline]
#[must_use]
pub fn quantize(channel: f32) -> u8 {
    // The cast saturates and truncates; 255 * 1.0 is exact.
    (channel.clamp(0.0, 1.0) * 255.0) as u8
}

/// Twin of [`quantize`], a column a channel.
#[inline(always)]
fn quantize8(rgb8: &[F32x8; 3]) -> [[u32; LANES]; 3] {
    let byte8 = |c8: F32x8| truncate(min(max(c8, splat(0.0)), splat(1.0)) * splat(255.0));
    let [r8, g8, b8] = *rgb8;
    [byte8(r8), byte8(g8), byte8(b8)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_lanes_are_bytes_of_scalars() {
        let hundredths = (-150..350).map(|i| i as f32 / 100.0);
        let exact = (0..=255).map(|i| i as f32 / 255.0);
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-40, 1e9];
        for c in hundredths.chain(exact).chain(odd) {
            let rgb = [c, 1.0 - c, c * 0.5];
            let lanes = <[u8; 3]>::from_lanes(&rgb.map(splat), &splat(1.0));
            assert_eq!(lanes, [<[u8; 3]>::from_linear(rgb, 1.0); LANES], "{rgb:?}");
        }
    }

    #[test]
    fn lanes_become_pixels_in_their_order() {
        let byte = |i: usize| (i as f32 + 0.5) / 255.0;
        let channel = |c: usize| crate::simd::from_lanes(|lane| byte(3 * lane + c));
        let lanes = <[u8; 3]>::from_lanes(&[channel(0), channel(1), channel(2)], &splat(1.0));
        let bytes: Vec<u8> = (0..3 * LANES as u8).collect();
        assert_eq!(lanes.as_flattened(), bytes);
    }
}
