//! The picture in memory: linear colour, and how it becomes bytes.

use rayon::prelude::*;

/// A picture of linear RGB, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<[f32; 3]>,
}

impl Film {
    /// A black picture.
    #[must_use]
    pub fn new(width: u32, height: u32) -> Self {
        Self {
            width,
            height,
            pixels: vec![[0.0; 3]; width as usize * height as usize],
        }
    }

    /// Makes the picture `width` x `height` pixels large. Its colours are of no use then, unless it has that size
    /// already; memory is reused.
    pub fn resize(&mut self, width: u32, height: u32) {
        (self.width, self.height) = (width, height);
        self.pixels.resize(width as usize * height as usize, [0.0; 3]);
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

    /// Linear RGB of all pixels, row by row, row 0 on top.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// The same, to write to.
    pub fn pixels_mut(&mut self) -> &mut [[f32; 3]] {
        &mut self.pixels
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
