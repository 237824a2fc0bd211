//! Adaptive sampling: how many samples the pixels of a tile take.
//!
//! ```text
//! tile and a ring of one pixel -- first samples --> means --> display values
//!                                                                |
//! pixels of the tile  <-- more samples --  those that differ from a neighbour
//! ```
//!
//! After Mitchell, *Generating Antialiased Images at Low Sampling Densities*, 1987. Only colour decides, because an edge,
//! crease or shadow that does not show in it needs no more samples. Both modes share this code. The ring makes a pixel
//! independent of its tile and of the crop.

use super::{
    Pixel, Settings,
    frame::{FrameContext, TileRect},
    sums::{BLOCK, Samples, begins_block},
    tile::{PACKET, ROW},
};
use crate::{
    lanes::{F32x8, LANES},
    simd::{EightLanes, Simd},
};

/// First samples where light comes from points. They miss most of what is thinner than a pixel.
const FIRST: u32 = 1;

/// From this number of samples on, every picture takes [`FIRST_OF_SOFT`] first samples, which find thinner wires.
// Tuned: see docs/lab-notes.md#adaptive-samples
const FINE: u32 = 64;

/// First samples if light or the lens is sampled too: the first four points of a sequence, one in each quarter of the pixel
/// and of the light. After a single one, noise would look like edges everywhere.
const FIRST_OF_SOFT: u32 = 4;

/// The largest difference between neighbours that is not refined, in display values: less than that of one in four ambient
/// occlusion rays, more than the noise of soft light on a smooth surface.
// Tuned: see docs/lab-notes.md#adaptive-samples
const MAX_CONTRAST: f32 = 8.0 / 255.0;

/// Without noise, pixels of less contrast take half or a quarter of all samples, of which there are usually 16: few enough that
/// one of them changes the mean by at most [`MAX_CONTRAST`].
// Tuned: see docs/lab-notes.md#adaptive-samples
const HALF: f32 = 8.0 * MAX_CONTRAST;
const QUARTER: f32 = 4.0 * MAX_CONTRAST;

/// Pixels that take equally many samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grade {
    /// Their contrast.
    above: f32,
    most: f32,
    /// The samples they take, the first ones included.
    pub samples: u32,
}

impl FrameContext<'_> {
    /// Returns the samples that every pixel takes.
    pub fn first_samples(&self) -> u32 {
        let Settings {
            samples, adaptive, ..
        } = self.settings;
        if adaptive {
            let is_noisy = self.scene.is_sampled() || self.camera_rays.has_lens();
            samples.min(self.settings.first_of(is_noisy))
        } else {
            samples
        }
    }

    /// Returns the grades of pixels that take more than the first samples.
    pub fn grades(&self) -> impl Iterator<Item = Grade> {
        let (all, first) = (self.settings.samples, self.first_samples());
        // Noise has little contrast, too, but needs all samples; so do means of several samples.
        let [quarter, half] = if first == FIRST {
            [QUARTER, HALF]
        } else {
            [MAX_CONTRAST; 2]
        };
        [
            (MAX_CONTRAST, quarter, all.min(4.max(all / 4))),
            (quarter, half, all.min(8.max(all / 2))),
            (half, f32::INFINITY, all),
        ]
        .into_iter()
        .map(|(above, most, samples)| Grade { above, most, samples })
        .filter(move |grade| grade.above < grade.most && grade.samples > first)
    }

    /// Returns the context of the whole picture. Its tiles lie at absolute pixels.
    pub fn whole(&self) -> Self {
        let settings = Settings {
            crop: None,
            ..self.settings
        };
        Self {
            window: settings.window(),
            settings,
            ..*self
        }
    }
}

impl Settings {
    /// Returns the first samples of an adaptive picture.
    fn first_of(&self, is_noisy: bool) -> u32 {
        if is_noisy || self.samples >= FINE {
            FIRST_OF_SOFT
        } else {
            FIRST
        }
    }

    /// Returns the expected number of camera rays per pixel, from measured shares of the samples that are taken. `is_sampled`: whether
    /// light or the lens is sampled.
    #[doc(hidden)]
    pub fn expected_samples(&self, is_sampled: bool) -> f64 {
        let (first, share) = (self.first_of(is_sampled), if is_sampled { 0.6 } else { 0.03 });
        if !self.adaptive || self.samples <= first {
            return f64::from(self.samples);
        }
        f64::from(first) + share * f64::from(self.samples - first)
    }
}

/// The samples of the pixels of a tile and of the ring around it within the picture, as a structure of arrays, so that
/// loops over rows vectorise.
#[derive(Debug, Default)]
pub(super) struct Neighborhood {
    /// Absolute.
    area: TileRect,
    /// The distance of rows, whole packets.
    stride: usize,
    /// Linear red, green and blue, and coverage.
    sums: [Vec<f32>; 4],
    /// See [`Samples::blocks`]; empty if pixels have no more samples than a block.
    blocks: Vec<[f64; 4]>,
    counts: Vec<u32>,
    /// How much each pixel and its neighbours differ.
    contrast: Vec<f32>,
    scratch: Scratch,
}

#[derive(Debug, Default)]
struct Scratch {
    /// The display values of one channel.
    display: Vec<f32>,
    /// Extremes over each row and its neighbours, with one more entry at each end.
    low: Vec<f32>,
    high: Vec<f32>,
}

impl Neighborhood {
    /// Reserves memory for tiles of `width` x `height` pixels.
    pub fn reserve(&mut self, [width, height]: [u32; 2]) {
        self.resize([width + 2, height + 2]);
    }

    fn resize(&mut self, [width, height]: [u32; 2]) {
        self.stride = width.next_multiple_of(PACKET[0]) as usize;
        // Eight more, because rows are read eight by eight.
        let pixels = self.stride * height.next_multiple_of(PACKET[1]) as usize + LANES;
        for plane in &mut self.sums {
            plane.resize(pixels, 0.0);
        }
        self.counts.resize(pixels, 0);
        self.contrast.resize(pixels, 0.0);
        self.scratch.display.resize(pixels, 0.0);
        for row in [&mut self.scratch.low, &mut self.scratch.high] {
            row.resize(width as usize + 2, 0.0);
        }
    }

    /// Begins with a tile whose pixels will have `count` first samples. Returns the pixels around it, its own included;
    /// both are absolute.
    pub fn restart(&mut self, tile: TileRect, settings: &Settings, count: u32) -> TileRect {
        let (x, y) = (tile.x.saturating_sub(1), tile.y.saturating_sub(1));
        self.area = TileRect {
            x,
            y,
            width: settings.width.min(tile.x + tile.width + 1) - x,
            height: settings.height.min(tile.y + tile.height + 1) - y,
        };
        self.resize([self.area.width, self.area.height]);
        self.counts.fill(count);
        self.blocks.clear();
        if settings.samples > BLOCK {
            self.blocks.resize(self.counts.len(), [0.0; 4]);
        }
        self.area
    }

    fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y - self.area.y) as usize * self.stride + (x - self.area.x) as usize
    }

    /// Returns the samples of an absolute pixel.
    pub fn samples(&self, pixel: [u32; 2]) -> Samples {
        let i = self.index(pixel);
        Samples {
            sum: self.sums.each_ref().map(|plane| plane[i]),
            blocks: self.blocks.get(i).copied().unwrap_or_default(),
            count: self.counts[i],
        }
    }

    /// Sets the samples of an absolute pixel.
    pub fn set(&mut self, pixel: [u32; 2], samples: Samples) {
        let i = self.index(pixel);
        for (plane, sum) in self.sums.iter_mut().zip(samples.sum) {
            plane[i] = sum;
        }
        self.counts[i] = samples.count;
        if let Some(blocks) = self.blocks.get_mut(i) {
            *blocks = samples.blocks;
        }
    }

    /// Replaces the samples of an absolute pixel by their mean, if they are more than a block.
    pub fn average(&mut self, pixel: [u32; 2]) {
        let samples = self.samples(pixel);
        if samples.count > BLOCK {
            let mean = Samples {
                sum: samples.mean(),
                count: 1,
                ..Samples::default()
            };
            self.set(pixel, mean);
        }
    }

    /// Sets the sums of the packet at column `x` and row `y` of the area.
    #[inline(always)]
    pub fn set_packet(&mut self, [x, y]: [u32; 2], sums: [&F32x8; 4]) {
        let start = y as usize * self.stride + x as usize;
        for (plane, sums) in self.sums.iter_mut().zip(sums) {
            let (rows, _) = sums.as_array().as_chunks::<ROW>();
            for (row, start) in rows.iter().zip([start, start + self.stride]) {
                plane[start..start + ROW].copy_from_slice(row);
            }
        }
    }

    /// Compares the means of the first samples.
    #[inline(always)]
    pub fn compare(&mut self) {
        let count = self.counts[0] as f32;
        let (width, height) = (self.area.width as usize, self.area.height as usize);
        self.contrast.fill(0.0);
        let Scratch { display, low, high } = &mut self.scratch;
        for plane in &self.sums {
            for (display, sum) in display.iter_mut().zip(plane) {
                *display = display_value(sum / count);
            }
            for y in 0..height {
                let row = |y: usize| &display[y * self.stride..][..width];
                let (above, own, below) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(height - 1)));
                let (inner_low, inner_high) = (&mut low[1..=width], &mut high[1..=width]);
                for x in 0..width {
                    inner_low[x] = less(less(above[x], own[x]), below[x]);
                    inner_high[x] = more(more(above[x], own[x]), below[x]);
                }
                (low[0], high[0]) = (low[1], high[1]);
                (low[width + 1], high[width + 1]) = (low[width], high[width]);
                let (low, high) = (&low[..width + 2], &high[..width + 2]);
                let contrast = &mut self.contrast[y * self.stride..][..width];
                for x in 0..width {
                    let low = less(less(low[x], low[x + 1]), low[x + 2]);
                    let high = more(more(high[x], high[x + 1]), high[x + 2]);
                    contrast[x] = more(high - low, contrast[x]);
                }
            }
        }
    }

    /// Returns whether an absolute pixel of the tile is of a grade.
    pub fn is_of(&self, pixel: [u32; 2], grade: Grade) -> bool {
        let contrast = self.contrast[self.index(pixel)];
        grade.above < contrast && contrast <= grade.most
    }

    /// Adds samples of up to eight absolute pixels: colours, and coverage if there is any.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, simd: S, pixels: &[[u32; 2]], colors: &[[F32x8; 3]], alpha: &[F32x8]) {
        let (mut indices, first) = ([0; LANES], self.counts[self.index(pixels[0])]);
        for (index, &pixel) in indices.iter_mut().zip(pixels) {
            *index = self.index(pixel);
            self.counts[*index] += colors.len() as u32;
        }
        let indices = &indices[..pixels.len()];
        for (channel, plane) in self.sums.iter_mut().enumerate() {
            let mut sums = F32x8::ZERO;
            for (sum, &index) in sums.as_mut_array().iter_mut().zip(indices) {
                *sum = plane[index];
            }
            let mut sum = simd.load(&sums);
            let of_channel = |i: usize| match colors.get(i) {
                Some(color) if channel < 3 => Some(&color[channel]),
                _ => alpha.get(i),
            };
            for (i, color) in (0..colors.len()).map_while(|i| Some((i, of_channel(i)?))) {
                if begins_block(first + i as u32) {
                    for (sum, &index) in sum.to8().as_array().iter().zip(indices) {
                        self.blocks[index][channel] += f64::from(*sum);
                    }
                    sum = simd.splat(0.0);
                }
                sum = sum + simd.load(color);
            }
            for (sum, &index) in sum.to8().as_array().iter().zip(indices) {
                plane[index] = *sum;
            }
        }
    }

    /// Writes the means of a tile's samples to its columns of `band`, of rows of `row_length`.
    #[inline(always)]
    pub fn store<S: Simd, P: Pixel>(
        &self,
        simd: S,
        tile: TileRect,
        column: u32,
        row_length: usize,
        band: &mut [P],
    ) {
        let rows = band.chunks_exact_mut(row_length).take(tile.height as usize);
        for (row, y) in rows.zip(tile.y..) {
            let start = self.index([tile.x, y]);
            let columns = &mut row[column as usize..][..tile.width as usize];
            for (to, start) in columns.chunks_mut(LANES).zip((start..).step_by(LANES)) {
                let mut counts = [0.0; LANES];
                for (to, &count) in counts.iter_mut().zip(&self.counts[start..]) {
                    *to = count as f32;
                }
                let counts = simd.load(&F32x8::new(counts));
                let mut means = [simd.splat(0.0); 4];
                for (mean, plane) in means.iter_mut().zip(&self.sums) {
                    let mut sums = [0.0; LANES];
                    sums.copy_from_slice(&plane[start..start + LANES]);
                    *mean = simd.load(&F32x8::new(sums)) / counts;
                }
                let pixels = P::from_lanes(simd, means);
                to.copy_from_slice(&pixels[..to.len()]);
            }
        }
    }
}

/// Returns the square root, an approximation of the sRGB curve. Where linear values are shown, it refines more than is
/// needed in dark areas, and as little as half in bright ones.
#[inline(always)]
fn display_value(channel: f32) -> f32 {
    less(more(channel, 0.0), 1.0).sqrt()
}

// One instruction; `f32::min` would also take care of NaN.
#[inline(always)]
fn less(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline(always)]
fn more(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests;
