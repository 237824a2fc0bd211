//! Suns of an environment map: the texels that are much brighter than the mean.
//!
//! A sun is a small solid angle with much of the light. If one sample served both it and the rest, the few samples that
//! meet the sun would be much brighter than the others: noise.

use super::{accumulate, find, share_of_row, step};
use std::collections::TryReserveError;

/// Brightness of suns, relative to the mean.
// Tuned: see docs/lab-notes.md#suns
const TIMES_THE_MEAN: f64 = 4.0;

/// The least share of the light that is worth separate rays.
const LEAST_LIGHT: f64 = 1.0 / 256.0;

/// At most one of this many texels is of a sun, which bounds the memory.
const TEXELS_PER_SUN: usize = 8;

/// The most memory for each texel of the picture, bytes.
pub(super) const BYTES_PER_TEXEL: usize = size_of::<[u32; 2]>() / TEXELS_PER_SUN;

/// The suns row by row: a table of probabilities in which most rows are empty.
#[derive(Debug)]
pub(super) struct Suns {
    /// For each row the probability that a sample is in it or in one above.
    row_sums: Vec<f32>,
    /// For each row the number of its texels and of those above.
    ends: Vec<u32>,
    /// The columns of texels, row by row from the left.
    columns: Vec<u32>,
    /// For each texel the probability that a sample of its row is in it or left of it.
    column_sums: Vec<f32>,
}

impl Suns {
    /// Takes suns out of a picture's `brightness`, rows from the top, and leaves 0 there; `None` if the picture has no suns.
    ///
    /// # Errors
    /// If there is no memory.
    pub(super) fn cut_out(width: usize, brightness: &mut [f32]) -> Result<Option<Self>, TryReserveError> {
        let height = brightness.len() / width;
        let (mut light, mut area) = (0.0, 0.0);
        for (y, row) in brightness.chunks_exact(width).enumerate() {
            let share = share_of_row(y, height);
            light += share * row.iter().map(|&b| f64::from(b)).sum::<f64>();
            area += share * width as f64;
        }
        let least = (TIMES_THE_MEAN * light / area) as f32;
        let (mut own_light, mut count) = (0.0, 0);
        for (y, row) in brightness.chunks_exact(width).enumerate() {
            for &b in row.iter().filter(|&&b| b > least) {
                own_light += share_of_row(y, height) * f64::from(b);
                count += 1;
            }
        }
        // Around a pole many texels may be bright in a small part of all directions.
        if own_light <= LEAST_LIGHT * light || count > brightness.len() / TEXELS_PER_SUN {
            return Ok(None);
        }
        Self::of_brightest(width, brightness, least, (own_light, count)).map(Some)
    }

    /// Takes the `count` texels that are brighter than `least`, which have `light` together.
    fn of_brightest(
        width: usize,
        brightness: &mut [f32],
        least: f32,
        (light, count): (f64, usize),
    ) -> Result<Self, TryReserveError> {
        let height = brightness.len() / width;
        let (mut columns, mut column_sums) = (Vec::new(), Vec::new());
        columns.try_reserve_exact(count)?;
        column_sums.try_reserve_exact(count)?;
        let (mut ends, mut row_sums) = (Vec::new(), Vec::new());
        for (y, row) in brightness.chunks_exact_mut(width).enumerate() {
            let start = columns.len();
            for (x, b) in row.iter_mut().enumerate().filter(|(_, b)| **b > least) {
                columns.push(x as u32);
                column_sums.push(std::mem::take(b));
            }
            let of_row = accumulate(&mut column_sums[start..]) * share_of_row(y, height);
            ends.push(columns.len() as u32);
            // As a share, so that the light of dark pictures does not round to 0.
            row_sums.push((of_row / light) as f32);
        }
        accumulate(&mut row_sums);
        Ok(Self {
            row_sums,
            ends,
            columns,
            column_sums,
        })
    }

    /// The texels of a row.
    fn texels(&self, y: usize) -> std::ops::Range<usize> {
        let start = if y == 0 { 0 } else { self.ends[y - 1] };
        start as usize..self.ends[y] as usize
    }

    /// Samples a texel by its light; also returns a point of the unit square.
    pub(super) fn sample(&self, [s, t]: [f32; 2]) -> ([usize; 2], [f32; 2]) {
        let (y, v) = find(&self.row_sums, t);
        let texels = self.texels(y);
        let (i, u) = find(&self.column_sums[texels.clone()], s);
        ([self.columns[texels][i] as usize, y], [u, v])
    }

    /// The probability of a texel; `None` if it is not part of a sun.
    pub(super) fn probability(&self, [x, y]: [usize; 2]) -> Option<f32> {
        let texels = self.texels(y);
        let i = self.columns[texels.clone()].binary_search(&(x as u32)).ok()?;
        Some(step(&self.row_sums, y) * step(&self.column_sums[texels], i))
    }
}
