//! Mipmaps: each level is half of the one before, by a box filter that keeps the mean.
//!
//! ```text
//! even side:  [a b][c d][e f]     pairs
//! odd side:   [a b c' ][ c'd e]   three texels, shared in parts: each of m covers n / m = 2 + 1 / m of n
//! ```
//!
//! After Guthe and Heckbert, *Non-Power-of-Two Mipmapping*, NVIDIA 2005.

use super::{Level, Means, WORTH_THREADS, Weighted, display, whole_light};
use crate::error::SceneError;
use rayon::prelude::*;

/// The texels of one axis that a texel of the next level covers: the first one and the weights, in nths of an odd side n.
struct Taps {
    first: usize,
    weights: [u64; 3],
}

impl Taps {
    fn of(side: usize, i: usize) -> Self {
        let half = side / 2;
        let weights = if side == 1 {
            [1, 0, 0]
        } else if side.is_multiple_of(2) {
            [1, 1, 0]
        } else {
            [half - i, half, i + 1].map(|weight| weight as u64)
        };
        Self {
            first: 2 * i,
            weights,
        }
    }

    /// The texels with a weight, and their weights.
    fn each(&self) -> impl Iterator<Item = (usize, u64)> {
        (self.first..).zip(self.weights).filter(|&(_, weight)| weight > 0)
    }
}

impl Level {
    /// The next level: each texel is the mean of 2x2, or of what it covers of an odd number of columns or rows.
    pub(super) fn half(&self, means: Means) -> Result<Self, SceneError> {
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let mut texels = Vec::new();
        let reserved = texels.try_reserve_exact(width * height);
        reserved.map_err(|_| SceneError::NoMemory { what: "texels" })?;
        texels.resize(width * height, [0; 4]);
        let in_pairs = [self.width, self.height]
            .iter()
            .all(|&side| side == 1 || side.is_multiple_of(2));
        let fill = |(row, to): (usize, &mut [[u8; 4]])| {
            for (column, texel) in to.iter_mut().enumerate() {
                *texel = if in_pairs {
                    (means.of_four)(self.four(2 * column, 2 * row))
                } else {
                    self.covered([column, row], means)
                };
            }
        };
        if texels.len() < WORTH_THREADS {
            texels.chunks_exact_mut(width).enumerate().for_each(fill);
        } else {
            texels.par_chunks_exact_mut(width).enumerate().for_each(fill);
        }
        Ok(Self {
            width,
            height,
            texels,
        })
    }

    /// The 2x2 texels from here on.
    fn four(&self, column: usize, row: usize) -> [[u8; 4]; 4] {
        let rows = [row, (row + 1).min(self.height - 1)];
        let columns = [column, (column + 1).min(self.width - 1)];
        [0, 1, 2, 3].map(|i| self.texels[rows[i / 2] * self.width + columns[i % 2]])
    }

    /// The mean of up to 3x3 texels that one of the next level covers.
    fn covered(&self, [column, row]: [usize; 2], means: Means) -> [u8; 4] {
        let (columns, rows) = (Taps::of(self.width, column), Taps::of(self.height, row));
        let (mut taps, mut count) = ([(0, [0; 4]); 9], 0);
        for (y, down) in rows.each() {
            for (x, across) in columns.each() {
                taps[count] = (across * down, self.texels[y * self.width + x]);
                count += 1;
            }
        }
        (means.weighted)(&taps[..count])
    }
}

impl Means {
    /// Means of light.
    pub(super) const OF_COLORS: Self = Self {
        of_four: mean,
        weighted: weighted_mean,
    };
    /// Means of bytes.
    pub(super) const OF_NUMBERS: Self = Self {
        of_four: mean_of_numbers,
        weighted: weighted_mean_of_numbers,
    };
}

fn mean_of_numbers(four: [[u8; 4]; 4]) -> [u8; 4] {
    std::array::from_fn(|channel| {
        let sum: u32 = four.iter().map(|texel| u32::from(texel[channel])).sum();
        ((sum + 2) / 4) as u8
    })
}

fn weighted_mean_of_numbers(taps: &[Weighted]) -> [u8; 4] {
    let all: u64 = taps.iter().map(|(weight, _)| weight).sum();
    std::array::from_fn(|channel| {
        let sum: u64 = taps
            .iter()
            .map(|(weight, texel)| weight * u64::from(texel[channel]))
            .sum();
        ((sum + all / 2) / all) as u8
    })
}

/// The mean of the light of four texels.
fn mean(four: [[u8; 4]; 4]) -> [u8; 4] {
    if four == [four[0]; 4] {
        return four[0];
    }
    let light = whole_light();
    let alpha: u32 = four.iter().map(|texel| u32::from(texel[3])).sum();
    let mut mean = [0, 0, 0, ((alpha + 2) / 4) as u8];
    for (channel, mean) in mean[..3].iter_mut().enumerate() {
        let weight = |texel: &[u8; 4]| if alpha == 0 { 1 } else { u32::from(texel[3]) };
        let weighted = |texel: &[u8; 4]| weight(texel) * light[usize::from(texel[channel])];
        let all = if alpha == 0 { 4 } else { alpha };
        *mean = display((four.iter().map(weighted).sum::<u32>() + all / 2) / all);
    }
    mean
}

/// [`mean`] by weights. They add up to less than 2^28, so that sums with alpha and light stay below 2^52.
fn weighted_mean(taps: &[Weighted]) -> [u8; 4] {
    if taps.iter().all(|(_, texel)| *texel == taps[0].1) {
        return taps[0].1;
    }
    let light = whole_light();
    let all: u64 = taps.iter().map(|(weight, _)| weight).sum();
    let alpha: u64 = taps
        .iter()
        .map(|(weight, texel)| weight * u64::from(texel[3]))
        .sum();
    let mut mean = [0, 0, 0, ((alpha + all / 2) / all) as u8];
    let total = if alpha == 0 { all } else { alpha };
    for (channel, mean) in mean[..3].iter_mut().enumerate() {
        let weighted = |(weight, texel): &(u64, [u8; 4])| {
            let opacity = if alpha == 0 { 1 } else { u64::from(texel[3]) };
            weight * opacity * u64::from(light[usize::from(texel[channel])])
        };
        *mean = display(((taps.iter().map(weighted).sum::<u64>() + total / 2) / total) as u32);
    }
    mean
}
