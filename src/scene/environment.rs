//! Light from all around: a background that lights surfaces, with importance sampling.
//!
//! A picture is sampled by the light of its texels (Pharr, Jakob and Humphreys, *Physically Based Rendering*, 4th edition,
//! 12.5).

use super::Background;
use crate::error::SceneError;
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// The largest width and height of an environment's picture, pixels.
pub const MAX_ENVIRONMENT_SIDE: u32 = 1 << 14;

/// What rays that leave the scene see, which lights its surfaces, too.
#[derive(Debug)]
pub enum Environment {
    /// The scene's background: one colour or a gradient.
    Background(Background),
    /// A picture of all directions.
    Picture(EnvironmentPicture),
}

/// An equirectangular picture: its columns are the azimuth, its rows the polar angle. Its middle is in the direction +x, its
/// upper edge +z.
#[derive(Debug)]
pub struct EnvironmentPicture {
    width: usize,
    height: usize,
    /// Rows from the top; linear RGB, 0 or more.
    texels: Vec<[f32; 3]>,
    /// For each row the probability that a sample is in it or in one above.
    rows: Vec<f32>,
    /// For each texel the probability that a sample of its row is in it or left of it.
    columns: Vec<f32>,
    /// The part of a full turn by which the picture is turned.
    turn: f32,
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
        let no_memory = |_| SceneError::NoMemory {
            what: "the environment",
        };
        rows.try_reserve_exact(height).map_err(no_memory)?;
        columns.try_reserve_exact(texels.len()).map_err(no_memory)?;
        let mut picture = Self {
            width,
            height,
            texels,
            rows,
            columns,
            turn: (degrees / 360.0).rem_euclid(1.0) as f32,
        };
        picture.tabulate();
        Ok(picture)
    }

    /// Returns width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.width as u32, self.height as u32]
    }

    /// Returns the memory of a picture of this size, bytes.
    #[must_use]
    pub fn bytes([width, height]: [u32; 2]) -> usize {
        let texel = size_of::<[f32; 3]>() + size_of::<f32>();
        (width as usize * texel + size_of::<f32>()).saturating_mul(height as usize)
    }

    /// Fills the tables of probabilities. They are sums in `f64`, in one order.
    fn tabulate(&mut self) {
        let mut total = 0.0;
        let mut sums = Vec::with_capacity(self.height);
        for y in 0..self.height {
            let first = self.columns.len();
            let mut sum = 0.0;
            let mut along: Vec<f64> = Vec::with_capacity(self.width);
            for x in 0..self.width {
                sum += self.brightness(x, y);
                along.push(sum);
            }
            for (x, part) in along.into_iter().enumerate() {
                let even = (x + 1) as f64 / self.width as f64;
                self.columns
                    .push(if sum > 0.0 { part / sum } else { even } as f32);
            }
            self.columns[first + self.width - 1] = 1.0;
            // Rows near the poles fill less of the sphere.
            let polar = (y as f64 + 0.5) / self.height as f64 * std::f64::consts::PI;
            total += sum * libm::sin(polar);
            sums.push(total);
        }
        for (y, sum) in sums.into_iter().enumerate() {
            let even = (y + 1) as f64 / self.height as f64;
            self.rows
                .push(if total > 0.0 { sum / total } else { even } as f32);
        }
        self.rows[self.height - 1] = 1.0;
    }

    /// The mean brightness in a texel's square of the interpolated picture.
    fn brightness(&self, x: usize, y: usize) -> f64 {
        let mut sum = 0.0;
        for (dy, share_y) in [(-1_isize, 0.125), (0, 0.75), (1, 0.125)] {
            for (dx, share_x) in [(-1_isize, 0.125), (0, 0.75), (1, 0.125)] {
                let [r, g, b] = self.texel(x as isize + dx, y as isize + dy).map(f64::from);
                sum += share_x * share_y * (0.2126 * r + 0.7152 * g + 0.0722 * b);
            }
        }
        sum
    }

    /// The texel; columns repeat, rows end.
    fn texel(&self, x: isize, y: isize) -> [f32; 3] {
        let x = x.rem_euclid(self.width as isize) as usize;
        let y = y.clamp(0, self.height as isize - 1) as usize;
        self.texels[y * self.width + x]
    }

    /// Where a direction is in the picture: from 0 to 1 from left to right and from top to bottom.
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

    /// A direction, with a probability by the light from it.
    fn sample(&self, [s, t]: [f32; 2]) -> Vec3 {
        let (y, v) = find(&self.rows, t);
        let (_, u) = find(self.row(y), s);
        let azimuth = TAU * (0.5 + self.turn - u);
        let polar = PI * v;
        let across = libm::sinf(polar);
        Vec3::new(
            across * libm::cosf(azimuth),
            across * libm::sinf(azimuth),
            libm::cosf(polar),
        )
    }

    /// The probability of a direction in samples, per steradian.
    fn density(&self, direction: Vec3) -> f32 {
        let [u, v] = self.place(direction);
        let cell = |share: f32, count: usize| ((share * count as f32) as usize).min(count - 1);
        let (x, y) = (cell(u, self.width), cell(v, self.height));
        let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let in_square = step(&self.rows, y) * step(self.row(y), x) * (self.width * self.height) as f32;
        in_square / (2.0 * PI * PI * across.max(1e-6))
    }

    fn row(&self, y: usize) -> &[f32] {
        &self.columns[y * self.width..][..self.width]
    }
}

/// No texel is brighter.
const MAX_LIGHT: f32 = 1e9;

/// The largest half float, which files give as infinite beyond.
const MAX_HALF: f32 = 65504.0;

/// The first entry of a table that is above `share`, and where `share` lies in all of the table, from 0 to 1.
fn find(table: &[f32], share: f32) -> (usize, f32) {
    let i = table.partition_point(|&sum| sum <= share).min(table.len() - 1);
    let before = if i == 0 { 0.0 } else { table[i - 1] };
    let within = (share - before) / step(table, i);
    (i, (i as f32 + within.clamp(0.0, 1.0)) / table.len() as f32)
}

/// The probability of an entry of a table.
fn step(table: &[f32], i: usize) -> f32 {
    table[i] - if i == 0 { 0.0 } else { table[i - 1] }
}

impl Environment {
    /// Returns its memory beside the scene, bytes.
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
            Self::Picture(picture) => picture.color(direction),
        }
    }

    /// Returns a random unit vector for a point of the unit square.
    // Not inlined: compiled once, not for each level, it is the same arithmetic everywhere.
    #[inline(never)]
    pub(crate) fn sample(&self, point: [f32; 2]) -> Vec3 {
        match self {
            Self::Background(_) => {
                let [s, t] = point;
                let z = 1.0 - 2.0 * t;
                let (across, azimuth) = ((1.0 - z * z).max(0.0).sqrt(), TAU * s);
                Vec3::new(across * libm::cosf(azimuth), across * libm::sinf(azimuth), z)
            }
            Self::Picture(picture) => picture.sample(point),
        }
    }

    /// Returns the light that arrives from a unit vector, drawn by [`Self::sample`] or by its cosine `n_dot_l` with equal
    /// chances, over its probability (the balance heuristic; Veach and Guibas, *Optimally Combining Sampling Techniques*, 1995) and over pi.
    #[inline(never)]
    pub(crate) fn power(&self, direction: Vec3, n_dot_l: f32) -> [f32; 3] {
        let (color, density) = match self {
            Self::Background(background) => (background.color(direction), 0.25 / PI),
            Self::Picture(picture) => (picture.color(direction), picture.density(direction)),
        };
        let probability = 0.5 * (n_dot_l + PI * density);
        let factor = if n_dot_l > 0.0 { 1.0 / probability } else { 0.0 };
        color.map(|channel| channel * factor)
    }
}
