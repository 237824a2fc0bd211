//! Light from all around: a background that lights surfaces, with importance sampling.
//!
//! An image is sampled by the light of its texels (Pharr, Jakob and Humphreys, *Physically Based Rendering*, 4th edition,
//! 12.5). If some of them, its suns, are much brighter than the mean, each point gets two samples, one of the suns and one
//! of the rest, so that neither adds noise to the other.

mod suns;

use super::Background;
use crate::error::SceneError;
use glam::Vec3;
use std::{
    collections::TryReserveError,
    f32::consts::{PI, TAU},
};
use suns::Suns;

/// The largest width and height of an environment's picture, pixels.
pub const MAX_ENVIRONMENT_SIDE: u32 = 1 << 14;

/// What rays that leave the scene see, and what lights the scene.
#[derive(Debug)]
pub enum Environment {
    /// The scene's background: one colour or a gradient.
    Background(Background),
    /// An environment map.
    Picture(EnvironmentPicture),
}

/// An equirectangular image: its columns are the azimuth, its rows the polar angle. Its middle is in the direction +x, its
/// upper edge +z, unless it is [`turned`](Self::turned).
#[derive(Debug)]
pub struct EnvironmentPicture {
    width: usize,
    height: usize,
    /// Rows from the top; linear RGB, 0 or more.
    texels: Vec<[f32; 3]>,
    /// Texels that are much brighter than the mean, with separate samples.
    suns: Option<Suns>,
    /// For each row the probability that a sample of the rest is in it or in one above.
    rows: Vec<f32>,
    /// For each texel the probability that a sample of its row is in it or left of it.
    columns: Vec<f32>,
    /// Rotation, as a fraction of a full turn.
    turn: f32,
    /// Rotation and intensity as they were given.
    degrees: f64,
    intensity: f32,
    /// The directions of its axes in the scene; `None` for the scene's own.
    axes: Option<Box<[Vec3; 3]>>,
}

impl EnvironmentPicture {
    /// Makes an environment of its pixels, rows from the top, linear RGB. `degrees` turns it about +z, counterclockwise seen
    /// from above, and `intensity` multiplies it. Channels below 0 or NaN become 0, infinite ones 65504.
    ///
    /// # Errors
    /// [`SceneError::ImageSize`] if a side is 0 or above [`MAX_ENVIRONMENT_SIDE`], [`SceneError::ArrayLength`],
    /// [`SceneError::NoMemory`]; [`SceneError::NotUsable`] or [`SceneError::Negative`] for rotation and intensity.
    pub fn new(
        [width, height]: [u32; 2],
        mut texels: Vec<[f32; 3]>,
        degrees: f64,
        intensity: f32,
    ) -> Result<Self, SceneError> {
        let most = MAX_ENVIRONMENT_SIDE;
        if ![width, height].iter().all(|side| (1..=most).contains(side)) {
            return Err(SceneError::ImageSize { width, height, most });
        }
        let [width, height] = [width, height].map(|side| side as usize);
        super::builder::expect_length("pixels", texels.len(), width * height)?;
        if !degrees.is_finite() {
            let value = degrees as f32;
            return Err(SceneError::NotUsable {
                what: "rotation",
                value,
            });
        }
        super::builder::usable("intensity", intensity)?;
        if intensity < 0.0 {
            let (what, value) = ("intensity", intensity);
            return Err(SceneError::Negative { what, value });
        }
        for channel in texels.iter_mut().flatten() {
            let light = if *channel == f32::INFINITY {
                MAX_HALF
            } else {
                *channel
            };
            // NaN is not above 0.
            *channel = if light > 0.0 {
                (light * intensity).min(MAX_LIGHT)
            } else {
                0.0
            };
        }
        let (mut rows, mut columns) = (Vec::new(), Vec::new());
        let no_memory = |_| SceneError::NoMemory { what: "environment" };
        rows.try_reserve_exact(height).map_err(no_memory)?;
        columns.try_reserve_exact(texels.len()).map_err(no_memory)?;
        let mut picture = Self {
            width,
            height,
            texels,
            suns: None,
            rows,
            columns,
            turn: (degrees / 360.0).rem_euclid(1.0) as f32,
            degrees,
            intensity,
            axes: None,
        };
        picture.tabulate().map_err(no_memory)?;
        Ok(picture)
    }

    /// Multiplies it so that the mean of its light over all directions has this luminance; NaN and numbers below 0 count as 0.
    /// A black one stays black.
    #[must_use]
    pub fn with_mean(mut self, mean: f32) -> Self {
        let mean = if mean > 0.0 { mean.min(MAX_LIGHT) } else { 0.0 };
        let (mut light, mut shares) = (0.0, 0.0);
        for (y, row) in self.texels.chunks_exact(self.width).enumerate() {
            let share = share_of_row(y, self.height);
            light += share * row.iter().map(luminance).sum::<f64>();
            shares += share * self.width as f64;
        }
        if light > 0.0 {
            let factor = f64::from(mean) * shares / light;
            self.intensity *= factor as f32;
            for channel in self.texels.iter_mut().flatten() {
                *channel = (f64::from(*channel) * factor).min(f64::from(MAX_LIGHT)) as f32;
            }
        }
        self
    }

    /// Turns its middle from +x to the direction `middle`, and its upper edge from +z towards `up`, for scenes in which another
    /// direction is up. Lengths are from 1e-15 to 1e15; `up` gives way if they are not at right angles.
    #[must_use]
    pub fn turned(self, middle: Vec3, up: Vec3) -> Self {
        let x = middle.normalize_or(Vec3::X);
        let z = up
            .reject_from_normalized(x)
            .normalize_or(x.any_orthonormal_vector());
        Self {
            axes: Some(Box::new([x, z.cross(x), z])),
            ..self
        }
    }

    /// A direction of the scene relative to the image's axes.
    fn inward(&self, direction: Vec3) -> Vec3 {
        let relative = |axes: &[Vec3; 3]| Vec3::from(axes.map(|axis| axis.dot(direction)));
        self.axes.as_deref().map_or(direction, relative)
    }

    /// The opposite of [`Self::inward`].
    fn outward(&self, direction: Vec3) -> Vec3 {
        let absolute = |[x, y, z]: &[Vec3; 3]| *x * direction.x + *y * direction.y + *z * direction.z;
        self.axes.as_deref().map_or(direction, absolute)
    }

    /// Returns width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.width as u32, self.height as u32]
    }

    /// Returns its rotation, degrees.
    #[must_use]
    pub fn degrees(&self) -> f64 {
        self.degrees
    }

    /// Returns what its pixels were multiplied by.
    #[must_use]
    pub fn intensity(&self) -> f32 {
        self.intensity
    }

    /// Returns the memory of a picture of this size, bytes.
    #[must_use]
    pub fn bytes([width, height]: [u32; 2]) -> usize {
        let texel = size_of::<[f32; 3]>() + size_of::<f32>() + suns::BYTES_PER_TEXEL;
        (width as usize * texel + size_of::<f32>()).saturating_mul(height as usize)
    }

    /// Fills the tables of probabilities. They are sums in `f64`, in one order.
    fn tabulate(&mut self) -> Result<(), TryReserveError> {
        // Brightness first, in the memory of the probabilities.
        self.columns
            .extend(self.texels.iter().map(|texel| luminance(texel) as f32));
        self.suns = Suns::cut_out(self.width, &mut self.columns)?;
        let mut total = 0.0;
        let mut sums = Vec::with_capacity(self.height);
        for (y, row) in self.columns.chunks_exact_mut(self.width).enumerate() {
            total += accumulate(row) * share_of_row(y, self.height);
            sums.push(total);
        }
        for (y, sum) in sums.into_iter().enumerate() {
            let even = (y + 1) as f64 / self.height as f64;
            self.rows
                .push(if total > 0.0 { sum / total } else { even } as f32);
        }
        self.rows[self.height - 1] = 1.0;
        Ok(())
    }

    /// The texel; columns repeat, rows end.
    fn texel(&self, x: isize, y: isize) -> [f32; 3] {
        let [x, y] = self.wrapped(x, y);
        self.texels[y * self.width + x]
    }

    fn wrapped(&self, x: isize, y: isize) -> [usize; 2] {
        let x = x.rem_euclid(self.width as isize) as usize;
        [x, y.clamp(0, self.height as isize - 1) as usize]
    }

    /// The position of a direction in the image: from 0 to 1 from left to right and from top to bottom.
    fn place(&self, direction: Vec3) -> [f32; 2] {
        let azimuth = libm::atan2f(direction.y, direction.x);
        let u = 0.5 - azimuth / TAU + self.turn;
        // More exact near the poles than the arc cosine.
        let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let v = libm::atan2f(across, direction.z) / PI;
        [u - u.floor(), v]
    }

    /// The light from a direction, interpolated between four texels.
    fn color(&self, direction: Vec3) -> [f32; 3] {
        let [u, v] = self.place(direction);
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (right_share, lower_share) = (x - left, y - top);
        let (left, top) = (left as isize, top as isize);
        let [a, b, c, d] = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| self.texel(left + dx, top + dy));
        std::array::from_fn(|i| {
            let upper = a[i] + right_share * (b[i] - a[i]);
            let lower = c[i] + right_share * (d[i] - c[i]);
            upper + lower_share * (lower - upper)
        })
    }

    /// The direction of a random point around the centre of a texel. Points are distributed as interpolation spreads the
    /// texel's light: by a tent, which is folded at the upper and lower edge.
    fn around(&self, [x, y]: [usize; 2], within: [f32; 2]) -> ([f32; 2], Vec3) {
        let [right, down] = within.map(tent);
        let (width, height) = (self.width as f32, self.height as f32);
        let (x, y) = (x as f32 + 0.5 + right, (y as f32 + 0.5 + down).abs());
        let y = y.min(2.0 * height - y);
        let (u, v) = (x / width, y / height);
        let azimuth = TAU * (0.5 + self.turn - u);
        let polar = PI * v;
        let across = libm::sinf(polar);
        let direction = Vec3::new(
            across * libm::cosf(azimuth),
            across * libm::sinf(azimuth),
            libm::cosf(polar),
        );
        ([u - u.floor(), v], direction)
    }

    /// Samples a direction by the light from it, without the suns.
    fn sample(&self, [s, t]: [f32; 2]) -> Vec3 {
        let (y, v) = find(&self.rows, t);
        let (x, u) = find(self.row(y), s);
        self.around([x, y], [u, v]).1
    }

    /// The light from a direction and its position in the image, and the probability density per steradian. Both are
    /// interpolated between the texels that have a `probability`.
    fn part(
        &self,
        direction: Vec3,
        [u, v]: [f32; 2],
        probability: impl Fn([usize; 2]) -> Option<f32>,
    ) -> ([f32; 3], f32) {
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (right_share, lower_share) = (x - left, y - top);
        let (mut color, mut density) = ([0.0; 3], 0.0);
        for (dx, share_x) in [(0, 1.0 - right_share), (1, right_share)] {
            for (dy, share_y) in [(0, 1.0 - lower_share), (1, lower_share)] {
                let at = self.wrapped(left as isize + dx, top as isize + dy);
                let Some(probability) = probability(at) else {
                    continue;
                };
                let share = share_x * share_y;
                density += share * probability;
                for (sum, channel) in color.iter_mut().zip(self.texels[at[1] * self.width + at[0]]) {
                    *sum += share * channel;
                }
            }
        }
        let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let texels = (self.width * self.height) as f32;
        (color, density * texels / (2.0 * PI * PI * across.max(1e-6)))
    }

    /// [`Self::part`] of all but the suns.
    fn rest(&self, direction: Vec3) -> ([f32; 3], f32) {
        self.part(direction, self.place(direction), |[x, y]| {
            let is_sun = (self.suns.as_ref()).is_some_and(|suns| suns.probability([x, y]).is_some());
            (!is_sun).then(|| step(&self.rows, y) * step(self.row(y), x))
        })
    }

    /// Samples a direction by the light of the suns from it; returns it and that light over the probability density.
    fn sample_suns(&self, suns: &Suns, point: [f32; 2]) -> (Vec3, [f32; 3]) {
        let (texel, within) = suns.sample(point);
        let (place, direction) = self.around(texel, within);
        let (color, density) = self.part(direction, place, |texel| suns.probability(texel));
        let factor = if density > 0.0 { 1.0 / density } else { 0.0 };
        (direction, color.map(|channel| channel * factor))
    }

    fn row(&self, y: usize) -> &[f32] {
        &self.columns[y * self.width..][..self.width]
    }
}

/// The shares of directions that are sampled by the light. Only by the cosine, highlights at grazing angles would be noisy,
/// and so would images with bright parts that are too large for suns.
// Tuned: see docs/lab-notes.md#suns
const BACKGROUND_SHARE: f32 = 1.0 / 32.0;
const PICTURE_SHARE: f32 = 1.0 / 8.0;

/// Maximum brightness of a texel.
const MAX_LIGHT: f32 = 1e9;

/// The largest half float; files store larger values as infinite.
const MAX_HALF: f32 = 65504.0;

/// Luminance of linear RGB.
fn luminance(color: &[f32; 3]) -> f64 {
    let [r, g, b] = color.map(f64::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Solid angle of a row relative to the equator's.
fn share_of_row(y: usize, height: usize) -> f64 {
    libm::sin((y as f64 + 0.5) / height as f64 * std::f64::consts::PI)
}

/// Replaces brightness by its cumulative sums, as shares of the total, and returns the total. The sums rise evenly if it
/// is 0.
fn accumulate(row: &mut [f32]) -> f64 {
    let total: f64 = row.iter().map(|&brightness| f64::from(brightness)).sum();
    let (mut sum, count) = (0.0, row.len() as f64);
    for (i, entry) in row.iter_mut().enumerate() {
        sum += f64::from(*entry);
        let even = (i + 1) as f64 / count;
        *entry = if total > 0.0 { sum / total } else { even } as f32;
    }
    if let Some(last) = row.last_mut() {
        *last = 1.0;
    }
    total
}

/// The first entry of a table above `share`, and the position of `share` in it, from 0 to 1.
fn find(table: &[f32], share: f32) -> (usize, f32) {
    let i = table.partition_point(|&sum| sum <= share).min(table.len() - 1);
    let before = if i == 0 { 0.0 } else { table[i - 1] };
    (i, ((share - before) / step(table, i)).clamp(0.0, 1.0))
}

/// Maps [0, 1] to [-1, 1], distributed by a tent.
fn tent(share: f32) -> f32 {
    if share < 0.5 {
        (2.0 * share).sqrt() - 1.0
    } else {
        1.0 - (2.0 - 2.0 * share).sqrt()
    }
}

/// The probability of an entry of a table.
fn step(table: &[f32], i: usize) -> f32 {
    table[i] - if i == 0 { 0.0 } else { table[i - 1] }
}

impl Environment {
    /// Returns the memory of its image, bytes.
    pub(super) fn memory_bytes(&self) -> usize {
        match self {
            Self::Background(_) => 0,
            Self::Picture(picture) => EnvironmentPicture::bytes(picture.size()),
        }
    }

    /// Returns the light from a direction, a unit vector: linear RGB, 0 or more.
    #[must_use]
    pub fn color(&self, direction: Vec3) -> [f32; 3] {
        match self {
            Self::Background(background) => background.color(direction),
            Self::Picture(picture) => picture.color(picture.inward(direction)),
        }
    }

    /// Returns the share of directions that are sampled by the light; others are sampled by the cosine.
    #[inline]
    pub(crate) fn light_share(&self) -> f32 {
        match self {
            Self::Background(_) => BACKGROUND_SHARE,
            Self::Picture(_) => PICTURE_SHARE,
        }
    }

    /// Returns whether it has suns, which take a second sample.
    #[inline]
    pub(crate) fn has_suns(&self) -> bool {
        matches!(self, Self::Picture(picture) if picture.suns.is_some())
    }

    /// Returns a random unit vector for a point of the unit square, without the suns.
    // Not inlined: compiled once instead of for each level.
    #[inline(never)]
    pub(crate) fn sample(&self, point: [f32; 2]) -> Vec3 {
        match self {
            Self::Background(_) => {
                let [s, t] = point;
                let z = 1.0 - 2.0 * t;
                let (across, azimuth) = ((1.0 - z * z).max(0.0).sqrt(), TAU * s);
                Vec3::new(across * libm::cosf(azimuth), across * libm::sinf(azimuth), z)
            }
            Self::Picture(picture) => picture.outward(picture.sample(point)),
        }
    }

    /// Returns the light of all but the suns that arrives from a unit vector, drawn by [`Self::sample`] or by its cosine
    /// `n_dot_l`, over its probability (the balance heuristic; Veach and Guibas, *Optimally Combining Sampling Techniques*,
    /// 1995) and over pi.
    #[inline(never)]
    pub(crate) fn power(&self, direction: Vec3, n_dot_l: f32) -> [f32; 3] {
        let (color, density) = match self {
            Self::Background(background) => (background.color(direction), 0.25 / PI),
            Self::Picture(picture) => picture.rest(picture.inward(direction)),
        };
        let share = self.light_share();
        let probability = (1.0 - share) * n_dot_l + share * (PI * density);
        let factor = if n_dot_l > 0.0 { 1.0 / probability } else { 0.0 };
        color.map(|channel| channel * factor)
    }

    /// Returns a random unit vector to the suns for a point of the unit square, and the light that arrives from there, over
    /// its probability and over pi. Without suns there is no light.
    #[inline(never)]
    pub(crate) fn sample_suns(&self, point: [f32; 2]) -> (Vec3, [f32; 3]) {
        match self {
            Self::Picture(picture) => match &picture.suns {
                Some(suns) => {
                    let (direction, light) = picture.sample_suns(suns, point);
                    (picture.outward(direction), light.map(|channel| channel / PI))
                }
                None => (Vec3::Z, [0.0; 3]),
            },
            Self::Background(_) => (Vec3::Z, [0.0; 3]),
        }
    }
}
