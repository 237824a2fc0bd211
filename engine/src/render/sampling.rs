//! Pixel sampling: a sample pattern in the unit square, warped by a pixel filter.
//!
//! Filters are importance-sampled: a point goes through the inverse of the filter's distribution, and every sample has
//! weight 1 (Ernst, Stamminger and Greiner, *Filter Importance Sampling*, 2006). So pixels do not depend on their
//! neighbours. Patterns that differ from pixel to pixel are seeded by a hash of the absolute pixel, so that a crop equals
//! its part of the whole picture.

use super::{Edges, Settings};
use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{Ray, RayPacket},
    reference,
    scene::{Camera, EdgeLines, PixelRays, RayCone, Scene},
    shade,
    simd::Simd,
    sobol::{self, hash, scrambled, seed_of, unit},
};
use glam::Vec3;
use std::{f64::consts::TAU, sync::OnceLock};

/// The positions of a pixel's samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pattern {
    /// The cell centres of a regular grid, the same in every pixel.
    #[default]
    Grid,
    /// One random point in each cell of a regular grid.
    Stratified,
    /// The two-dimensional Sobol' sequence with Owen scrambling per pixel (Burley, *Practical Hash-based Owen
    /// Scrambling*, JCGT 2020). Best with a power of 4 samples.
    Sobol,
}

/// The reconstruction filter of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filter {
    /// A box of 1 pixel.
    #[default]
    Box,
    /// A tent of radius 1 pixel.
    Tent,
    /// The four-term Blackman-Harris window (Harris 1978) of radius 1.5 pixels.
    BlackmanHarris,
}

/// Radius of the Blackman-Harris filter, pixels.
const REACH: f64 = 1.5;
/// Steps of its tabulated inverse distribution.
const STEPS: usize = 1024;

/// The camera rays of one picture.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct CameraRays {
    pixel_rays: PixelRays,
    /// Columns and rows of the samples; a sequence is one row.
    samples: [u32; 2],
    /// `None` for the grid with the box filter, whose offsets are integers.
    offsets: Option<SampleOffsets>,
    /// The samples of each pixel, if there is a lens.
    lens_samples: Option<u32>,
}

/// The sample dimensions of points of the lens. Those of shading count from 0.
const LENS: u32 = u32::MAX;

#[derive(Clone, Copy)]
struct SampleOffsets {
    pattern: Pattern,
    filter: Filter,
    samples_per_axis: u32,
    blackman_harris: &'static [f32; STEPS + 1],
}

impl CameraRays {
    /// Makes the rays of `camera` for a picture of `scene`.
    pub fn new(scene: &Scene, camera: &Camera, settings: &Settings) -> Self {
        let &Settings {
            width,
            height,
            samples,
            pattern,
            filter,
            ..
        } = settings;
        let samples_per_axis = samples.isqrt();
        let regular = (pattern, filter) == (Pattern::Grid, Filter::Box);
        Self {
            pixel_rays: camera.pixel_rays(scene, width, height, if regular { samples_per_axis } else { 1 }),
            samples: match pattern {
                Pattern::Sobol => [samples, 1],
                Pattern::Grid | Pattern::Stratified => [samples_per_axis; 2],
            },
            offsets: (!regular).then(|| SampleOffsets {
                pattern,
                filter,
                samples_per_axis,
                blackman_harris: inverse_blackman_harris(),
            }),
            lens_samples: camera.has_lens().then_some(samples),
        }
    }

    /// Returns the edges that pictures of the settings show.
    pub fn edges(&self, settings: &Settings) -> Option<EdgeLines> {
        let Edges { width, color } = settings.edges?;
        Some(EdgeLines::new(self.pixel_rays, width, color, settings.samples))
    }

    /// Returns whether the camera has a lens.
    pub fn has_lens(&self) -> bool {
        self.lens_samples.is_some()
    }

    /// Returns a sample's point of a lens of radius 1.
    #[inline(always)]
    fn lens_point(&self, pixel: [u32; 2], sample: [u32; 2]) -> [f32; 2] {
        self.lens_samples.map_or([0.0; 2], |samples| {
            let first = sobol::first_point(pixel, samples);
            reference::disc(sobol::point(LENS, first.wrapping_add(self.index(sample))))
        })
    }

    /// [`Self::lens_point`] for eight pixels.
    #[inline(always)]
    fn lens_points<S: Simd>(&self, simd: S, pixels: &[[u32; 2]; LANES], sample: [u32; 2]) -> [S::V8; 2] {
        let Some(samples) = self.lens_samples else {
            return [simd.splat(0.0); 2];
        };
        let (mut u, mut v) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let first = sobol::first_point(pixels[lane], samples);
            [u[lane], v[lane]] = sobol::point(LENS, first.wrapping_add(self.index(sample)));
        }
        shade::disc(simd, [simd.load(&F32x8::new(u)), simd.load(&F32x8::new(v))])
    }

    /// Returns the shared origin, scene units; `None` for separate ones.
    pub fn shared_origin(&self) -> Option<Vec3> {
        self.pixel_rays.shared_origin()
    }

    /// Returns the cone of a sample.
    pub fn cone(&self) -> RayCone {
        let cone = self.pixel_rays.cone();
        match &self.offsets {
            None => cone,
            Some(_) => cone.shared_by(self.samples[0] as f32 * self.samples[1] as f32),
        }
    }

    /// Returns every sample of a pixel, as column and row.
    pub fn samples(&self) -> impl Iterator<Item = [u32; 2]> + use<> {
        let [columns, rows] = self.samples;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]))
    }

    /// Returns the directions of a sample of eight absolute pixels anywhere, for patterns other than the grid and without
    /// distortion.
    #[inline(always)]
    pub fn directions_of<S: Simd>(&self, simd: S, pixels: &[[u32; 2]; LANES], sample: [u32; 2]) -> Vec3x8 {
        let offset = self.offsets_of(pixels, sample);
        self.pixel_rays.directions_of(simd, pixels, &offset)
    }

    /// See [`PixelRays::is_distorted`].
    pub fn is_distorted(&self) -> bool {
        self.pixel_rays.is_distorted()
    }

    /// Returns the rays of a sample of eight absolute pixels anywhere, which end at `t_max`. For a camera with distortion.
    // Not inlined: cameras without distortion keep their code.
    #[inline(never)]
    pub fn distorted(&self, pixels: &[[u32; 2]; LANES], sample: [u32; 2], t_max: F32x8) -> RayPacket {
        let (sample, offset) = match &self.offsets {
            None => (sample, [F32x8::ZERO; 2]),
            Some(offsets) => ([0, 0], offsets.at8(pixels, sample)),
        };
        self.pixel_rays.distorted(pixels, sample, &offset, t_max)
    }

    /// Returns the origins and directions of the samples of [`Self::directions_of`].
    #[inline(always)]
    pub fn rays_of<S: Simd>(
        &self,
        simd: S,
        pixels: &[[u32; 2]; LANES],
        sample: [u32; 2],
    ) -> (Vec3x8, Vec3x8) {
        let offset = self.offsets_of(pixels, sample);
        let lens = self.lens_points(simd, pixels, sample);
        self.pixel_rays.rays_of(simd, pixels, &offset, lens)
    }

    #[inline(always)]
    fn offsets_of(&self, pixels: &[[u32; 2]; LANES], sample: [u32; 2]) -> [F32x8; 2] {
        match &self.offsets {
            Some(offsets) => offsets.at8(pixels, sample),
            None => [F32x8::ZERO; 2],
        }
    }

    /// Returns the index of a sample in its pixel.
    pub fn index(&self, [column, row]: [u32; 2]) -> u32 {
        row * self.samples[0] + column
    }

    /// See [`PixelRays::corners`].
    pub fn corners(&self, first: [u32; 2], size: [u32; 2]) -> [Vec3; 4] {
        self.pixel_rays.corners(first, size)
    }

    /// Returns the ray of a sample of an absolute pixel.
    #[inline(always)]
    pub fn ray<S: Simd>(&self, simd: S, pixel: [u32; 2], sample: [u32; 2]) -> Ray {
        let lens = self.lens_point(pixel, sample);
        let (sample, offset) = match &self.offsets {
            None => (sample, [0.0; 2]),
            Some(offsets) => ([0, 0], offsets.at(pixel, sample)),
        };
        self.pixel_rays.ray_at(simd, pixel, sample, offset, lens)
    }

    /// Returns the directions of [`CameraRays::ray`] for the 4x2 pixels from (`x`, `y`); lane `4 * row + column`. For a
    /// shared origin and without distortion.
    #[inline(always)]
    pub fn directions8<S: Simd>(&self, simd: S, pixel: [u32; 2], sample: [u32; 2]) -> Vec3x8 {
        let (sample, offset) = self.offsets8(pixel, sample);
        self.pixel_rays.directions(simd, pixel, sample, &offset)
    }

    /// Returns the origins and directions of [`CameraRays::ray`] for pixels as in [`CameraRays::directions8`].
    #[inline(always)]
    pub fn rays8<S: Simd>(&self, simd: S, pixel: [u32; 2], sample: [u32; 2]) -> (Vec3x8, Vec3x8) {
        let lens = self.lens_points(simd, &packet(pixel), sample);
        let (sample, offset) = self.offsets8(pixel, sample);
        self.pixel_rays.rays(simd, pixel, sample, &offset, lens)
    }

    /// Returns the sample of the pixel's grid, and offsets from there.
    #[inline(always)]
    fn offsets8(&self, pixel: [u32; 2], sample: [u32; 2]) -> ([u32; 2], [F32x8; 2]) {
        match &self.offsets {
            None => (sample, [F32x8::ZERO; 2]),
            Some(offsets) => ([0, 0], offsets.at8(&packet(pixel), sample)),
        }
    }
}

/// Returns the 4x2 pixels from (`x`, `y`).
#[inline(always)]
fn packet([x, y]: [u32; 2]) -> [[u32; 2]; LANES] {
    let mut pixels = [[x, y]; LANES];
    for (lane, pixel) in (0..).zip(&mut pixels) {
        *pixel = [x + lane % 4, y + lane / 4];
    }
    pixels
}

impl SampleOffsets {
    /// Returns a sample's offset from the pixel's centre, right and up, in half pixels.
    #[inline(always)]
    fn at(&self, pixel: [u32; 2], sample: [u32; 2]) -> [f32; 2] {
        let [right, down] = self.point(pixel, sample);
        [self.warp(right), -self.warp(down)]
    }

    /// [`Self::at`] for eight pixels. Loops over lanes have no branches, so that they vectorise.
    #[inline(always)]
    fn at8(&self, pixels: &[[u32; 2]; LANES], sample: [u32; 2]) -> [F32x8; 2] {
        let (mut right, mut up) = ([0.0; LANES], [0.0; LANES]);
        if self.pattern == Pattern::Sobol {
            let sample_i = sample[1] * self.samples_per_axis + sample[0];
            for lane in 0..LANES {
                [right[lane], up[lane]] = sobol_point(pixels[lane], sample_i);
            }
        } else {
            for lane in 0..LANES {
                [right[lane], up[lane]] = self.point(pixels[lane], sample);
            }
        }
        match self.filter {
            Filter::Box => {
                for lane in 0..LANES {
                    (right[lane], up[lane]) = (spread(right[lane]), spread(up[lane]));
                }
            }
            Filter::Tent => {
                for lane in 0..LANES {
                    (right[lane], up[lane]) = (tent(right[lane]), tent(up[lane]));
                }
            }
            Filter::BlackmanHarris => {
                for lane in 0..LANES {
                    (right[lane], up[lane]) = (self.warp(right[lane]), self.warp(up[lane]));
                }
            }
        }
        for up in &mut up {
            *up = -*up;
        }
        [F32x8::new(right), F32x8::new(up)]
    }

    /// Returns the sample's point in the unit square, from the top left.
    #[inline(always)]
    fn point(&self, [x, y]: [u32; 2], [column, row]: [u32; 2]) -> [f32; 2] {
        let n = self.samples_per_axis;
        let sample_i = row * n + column;
        let pixel = seed_of([x, y]);
        let in_cell = |cell: u32, within: f32| (cell as f32 + within) / n as f32;
        match self.pattern {
            Pattern::Grid => [in_cell(column, 0.5), in_cell(row, 0.5)],
            Pattern::Stratified => {
                let first = hash(pixel.wrapping_add(sample_i.wrapping_mul(2)));
                let second = hash(first ^ 0x5bd1_e995);
                [in_cell(column, unit(first)), in_cell(row, unit(second))]
            }
            Pattern::Sobol => sobol_point([x, y], sample_i),
        }
    }

    /// Maps [0, 1] through the inverse of the filter's distribution to half pixels from the centre.
    #[inline(always)]
    fn warp(&self, u: f32) -> f32 {
        match self.filter {
            Filter::Box => spread(u),
            Filter::Tent => tent(u),
            Filter::BlackmanHarris => {
                let at = u * STEPS as f32;
                let step = (at as usize).min(STEPS - 1);
                let (below, above) = (self.blackman_harris[step], self.blackman_harris[step + 1]);
                below + (above - below) * (at - step as f32)
            }
        }
    }
}

/// Returns a point of a pixel's sequence.
#[inline(always)]
fn sobol_point(pixel: [u32; 2], sample_i: u32) -> [f32; 2] {
    let first = seed_of(pixel);
    let second = hash(first ^ 0x5bd1_e995);
    [
        unit(scrambled(sample_i, first)),
        unit(scrambled(sobol::second(sample_i), second)),
    ]
}

/// The inverse distribution of the box filter.
#[inline(always)]
fn spread(u: f32) -> f32 {
    2.0 * u - 1.0
}

/// The inverse distribution of the tent filter, alike on both sides of the middle.
#[inline(always)]
fn tent(u: f32) -> f32 {
    if u < 0.5 {
        2.0 * (2.0 * u).sqrt() - 2.0
    } else {
        2.0 - 2.0 * (2.0 * (1.0 - u)).sqrt()
    }
}

/// Returns the inverse distribution of the Blackman-Harris filter in equal steps, half pixels from the centre.
fn inverse_blackman_harris() -> &'static [f32; STEPS + 1] {
    static TABLE: OnceLock<[f32; STEPS + 1]> = OnceLock::new();
    TABLE.get_or_init(|| {
        let mut table = [0.0; STEPS + 1];
        for (step, value) in table.iter_mut().enumerate() {
            let wanted = step as f64 / STEPS as f64;
            let (mut below, mut above) = (0.0, 1.0);
            for _ in 0..40 {
                let middle = 0.5 * (below + above);
                if blackman_harris_integral(middle) < wanted {
                    below = middle;
                } else {
                    above = middle;
                }
            }
            *value = ((below + above - 1.0) * 2.0 * REACH) as f32;
        }
        table
    })
}

/// Returns the normalised integral of the window over [0, `x`].
fn blackman_harris_integral(x: f64) -> f64 {
    const TERMS: [f64; 4] = [0.35875, -0.48829, 0.14128, -0.01168];
    let mut sum = TERMS[0] * x;
    for (k, term) in (1..).zip(&TERMS[1..]) {
        let turns = TAU * f64::from(k);
        sum += term * libm::sin(turns * x) / turns;
    }
    sum / TERMS[0]
}

#[cfg(test)]
mod tests;
