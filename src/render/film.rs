//! The picture in memory: linear colour, and how it becomes bytes.

use crate::simd::{F32x8, LANES, lane, max, min, splat, truncate};
use rayon::prelude::*;

/// What a film keeps of each pixel's colour.
pub trait Pixel: Copy + Default + Send + Sync {
    /// From linear RGB.
    fn from_linear(rgb: [f32; 3]) -> Self;

    /// From eight colours, a column a channel. Gives what [`Pixel::from_linear`] gives.
    fn from_lanes(rgb8: &[F32x8; 3]) -> [Self; LANES];
}

/// Linear RGB, as it is.
impl Pixel for [f32; 3] {
    fn from_linear(rgb: [f32; 3]) -> Self {
        rgb
    }

    #[inline(always)]
    fn from_lanes([r8, g8, b8]: &[F32x8; 3]) -> [Self; LANES] {
        let mut pixels = [[0.0; 3]; LANES];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = [lane(r8, i), lane(g8, i), lane(b8, i)];
        }
        pixels
    }
}

/// Eight bits a channel, see [`quantize`].
impl Pixel for [u8; 3] {
    fn from_linear(rgb: [f32; 3]) -> Self {
        rgb.map(quantize)
    }

    #[inline(always)]
    fn from_lanes(rgb8: &[F32x8; 3]) -> [Self; LANES] {
        let [r8, g8, b8] = quantize8(rgb8);
        let mut pixels = [[0; 3]; LANES];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            *pixel = [r8[i] as u8, g8[i] as u8, b8[i] as u8];
        }
        pixels
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
        const CHUNK: usize = 1 << 16;
        let channels = self.pixels.as_flattened();
        let mut bytes = vec![0; channels.len()];
        bytes
            .par_chunks_mut(CHUNK)
            .zip(channels.par_chunks(CHUNK))
            .for_each(|(bytes, channels)| {
                for (byte, &channel) in bytes.iter_mut().zip(channels) {
                    *byte = quantize(channel);
                }
            });
        bytes
    }
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
            let lanes = <[u8; 3]>::from_lanes(&rgb.map(splat));
            assert_eq!(lanes, [<[u8; 3]>::from_linear(rgb); LANES], "{rgb:?}");
        }
    }
}
