//! Sums of samples. Blocks of samples are summed in `f32`, and the sums of blocks in `f64`: a single `f32` sum of a million
//! samples is off by 1 %.

use crate::{lanes::F32x8, shade::TileColors};

/// Samples of a block: its `f32` sum is off by up to 3 millionths. Pictures with no more samples need no `f64`.
pub(super) const BLOCK: u32 = 256;

/// Returns whether sample `i` of a pixel begins a block after others.
#[inline(always)]
pub(super) fn begins_block(i: u32) -> bool {
    i != 0 && i.is_multiple_of(BLOCK)
}

/// The samples of a pixel: linear RGB and coverage.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Samples {
    /// Of the last block.
    pub sum: [f32; 4],
    /// Of the blocks before it.
    pub blocks: [f64; 4],
    pub count: u32,
}

impl Samples {
    /// Begins a sample, black at first.
    pub fn begin(&mut self) {
        if begins_block(self.count) {
            self.end_block();
        }
        self.count += 1;
    }

    /// Adds the colour of the last sample begun.
    pub fn add(&mut self, rgba: [f32; 4]) {
        for (sum, c) in self.sum.iter_mut().zip(rgba) {
            *sum += c;
        }
    }

    fn end_block(&mut self) {
        for (block, sum) in self.blocks.iter_mut().zip(&mut self.sum) {
            *block += f64::from(std::mem::take(sum));
        }
    }

    /// Returns linear RGB and alpha.
    // Of equal samples a little less than each: see docs/lab-notes.md#equal-samples
    pub fn mean(mut self) -> [f32; 4] {
        if self.count <= BLOCK {
            return self.sum.map(|sum| sum / self.count as f32);
        }
        self.end_block();
        self.blocks.map(|sum| mean(sum, self.count))
    }
}

fn mean(sum: f64, count: u32) -> f32 {
    (sum / f64::from(count)) as f32
}

/// The sums of the blocks of a tile's pixels, in the order of [`TileColors`]; empty before the first.
#[derive(Debug, Default)]
pub(super) struct Blocks(Vec<f64>);

impl Blocks {
    /// Begins a tile.
    pub fn restart(&mut self) {
        self.0.clear();
    }

    /// Adds the sums of a block.
    pub fn add(&mut self, block: &TileColors) {
        let sums = block.packets.iter().flatten().chain(&block.alpha);
        let sums = sums.flat_map(|sums| sums.as_array().iter().map(|&sum| f64::from(sum)));
        if self.0.is_empty() {
            self.0.extend(sums);
        } else {
            for (block, sum) in self.0.iter_mut().zip(sums) {
                *block += sum;
            }
        }
    }

    /// Replaces the sums of the last block by the means of all `count` samples. Returns the divisor of `sum`.
    pub fn finish(&mut self, sum: &mut TileColors, count: u32) -> u32 {
        if self.0.is_empty() {
            return count;
        }
        self.add(sum);
        let sums = sum.packets.iter_mut().flatten().chain(&mut sum.alpha);
        let sums = sums.flat_map(F32x8::as_mut_array);
        for (to, &block) in sums.zip(&self.0) {
            *to = mean(block, count);
        }
        1
    }
}

#[cfg(test)]
mod tests;
