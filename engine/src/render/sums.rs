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
mod tests {
    use super::*;
    use crate::simd::Portable;

    const MANY: u32 = 1 << 20;

    #[test]
    fn many_samples_keep_their_mean() {
        for c in [0.1_f32, 0.7, 1.0] {
            let mut samples = Samples::default();
            let mut tile = (Blocks::default(), TileColors::default());
            let one = TileColors {
                packets: vec![[F32x8::splat(c); 3]],
                alpha: vec![F32x8::splat(c)],
            };
            for i in 0..MANY {
                samples.begin();
                samples.add([c; 4]);
                add(&mut tile, &one, i);
            }
            let (mut blocks, mut sum) = tile;
            assert_eq!(blocks.finish(&mut sum, MANY), 1);
            let found = samples.mean();
            assert!((found[0] - c).abs() < 2e-6, "{} {c}", found[0]);
            assert_eq!(sum.packets, [[F32x8::splat(found[0]); 3]]);
            assert_eq!(sum.alpha, [F32x8::splat(found[3])]);
        }
    }

    /// As tiles add sample `i`.
    fn add((blocks, sum): &mut (Blocks, TileColors), one: &TileColors, i: u32) {
        if begins_block(i) {
            blocks.add(sum);
        }
        if i.is_multiple_of(BLOCK) {
            (sum.packets, sum.alpha) = (one.packets.clone(), one.alpha.clone());
        } else {
            sum.add_all(Portable, one);
        }
    }

    #[test]
    fn few_samples_are_summed_as_ever() {
        let mut samples = Samples::default();
        let mut sum = 0.0_f32;
        for i in 0..BLOCK {
            let c = 1.0 / (3.0 + i as f32);
            samples.begin();
            samples.add([c; 4]);
            sum += c;
        }
        assert_eq!(samples.mean(), [sum / BLOCK as f32; 4]);
    }
}
