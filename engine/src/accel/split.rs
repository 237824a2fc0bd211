//! Divides a set of primitives: binned surface area heuristic (Wald, *On fast Construction of SAH-based Bounding
//! Volume Hierarchies*, 2007), counting leaf blocks instead of primitives, on all three axes or, for fast builds, on
//! the one with the greatest extent of centres.
//!
//! Small sets have fewer bins, as in Embree: 9 primitives have 5, 96 and more have all. Here rays have no width; the
//! tree's [later steps](super::tree) weigh the parts for bundles.

use super::{boxes::Box8, plan::WIDTH};
use crate::{
    lanes::F32x8,
    simd::{EightLanes, Portable, Simd},
};
use rayon::prelude::*;
use std::ops::Range;

/// The most bins of an axis: a power of two, so that a masked index needs no check. More find better planes in more time.
// Tuned: see docs/lab-notes.md#varied-constants
const BINS: usize = 16;

/// How thorough a build is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// The most bins of an axis, at most [`BINS`].
    pub(super) bins: usize,
    /// Whether all axes are tried, not only the one with the greatest extent of centres.
    pub(super) all_axes: bool,
    /// Whether sets that fit a block may be divided.
    pub(super) divides_blocks: bool,
}

/// Sets of more primitives are binned and divided in parallel, in chunks of half of it: idle threads against the cost of
/// tasks.
// Tuned: see docs/lab-notes.md#varied-constants
const PARALLEL: usize = 1 << 15;
const CHUNK: usize = 1 << 14;

/// Below this extent of the centres (doubled) an axis is not divided: the reciprocal might overflow.
const LEAST_EXTENT: f32 = 1e-30;

/// From the centre of a box to a bin on each axis.
#[derive(Clone)]
struct Binning {
    base: F32x8,
    scale: F32x8,
    bins: usize,
    axes: Range<usize>,
}

impl Binning {
    /// Bins over the box around the centres.
    fn new(centers: Box8, bins: usize, all_axes: bool) -> Self {
        let bounds = centers.bounds();
        let extent = bounds.upper - bounds.lower;
        let widest = extent.max_position();
        // Slightly less than the number of bins, so that the last centre is in the last bin despite rounding.
        let scale = |extent: f32| {
            if extent > LEAST_EXTENT {
                bins as f32 * 0.9999 / extent
            } else {
                0.0
            }
        };
        let (l, k) = (bounds.lower, [scale(extent.x), scale(extent.y), scale(extent.z)]);
        Self {
            base: F32x8::new([0.0, 0.0, 0.0, 0.0, l.x, l.y, l.z, 0.0]),
            scale: F32x8::new([0.0, 0.0, 0.0, 0.0, k[0], k[1], k[2], 0.0]),
            bins,
            axes: if all_axes { 0..3 } else { widest..widest + 1 },
        }
    }

    #[inline(always)]
    fn bins_of<S: Simd>(&self, simd: S, b: Box8) -> [usize; 3] {
        let i = ((b.center_lanes(simd) - simd.load(&self.base)) * simd.load(&self.scale)).trunc();
        [
            i[4] as usize & (BINS - 1),
            i[5] as usize & (BINS - 1),
            i[6] as usize & (BINS - 1),
        ]
    }
}

/// The contents of the bins: boxes and counts.
struct Bins {
    bounds: [[Box8; BINS]; 3],
    count: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self {
        bounds: [[Box8::EMPTY; BINS]; 3],
        count: [[0; BINS]; 3],
    };

    #[inline(always)]
    fn fill<S: Simd>(&mut self, simd: S, boxes: &[Box8], binning: &Binning) {
        if binning.axes.len() == 1 {
            let axis = binning.axes.start;
            let (bounds, counts) = (&mut self.bounds[axis], &mut self.count[axis]);
            for &b in boxes {
                let bin = binning.bins_of(simd, b)[axis];
                bounds[bin] = bounds[bin].union(simd, b);
                counts[bin] += 1;
            }
            return;
        }
        for &b in boxes {
            let bins = binning.bins_of(simd, b);
            for (axis, &bin) in bins.iter().enumerate().take(3) {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(simd, b);
                self.count[axis][bin] += 1;
            }
        }
    }

    #[inline(always)]
    fn merge<S: Simd>(mut self, simd: S, other: &Self) -> Self {
        for axis in 0..3 {
            for bin in 0..BINS {
                self.bounds[axis][bin] = self.bounds[axis][bin].union(simd, other.bounds[axis][bin]);
                self.count[axis][bin] += other.count[axis][bin];
            }
        }
        self
    }

    /// The axis of the best division, and the first bin of its second part.
    #[inline(always)]
    fn best<S: Simd>(&self, simd: S, binning: &Binning) -> Option<(usize, usize)> {
        let bins = binning.bins;
        let mut best = (f32::INFINITY, None);
        for axis in binning.axes.clone() {
            let (bounds, counts) = (&self.bounds[axis], &self.count[axis]);
            let mut above = [0.0; BINS];
            let (mut all, mut count) = (Box8::EMPTY, 0);
            for bin in (1..bins).rev() {
                all = all.union(simd, bounds[bin]);
                count += counts[bin];
                above[bin] = all.half_area(simd) * blocks(count);
            }
            let (mut all, mut count) = (Box8::EMPTY, 0);
            for bin in 1..bins {
                all = all.union(simd, bounds[bin - 1]);
                count += counts[bin - 1];
                let cost = all.half_area(simd) * blocks(count) + above[bin];
                if cost < best.0 {
                    best = (cost, Some((axis, bin)));
                }
            }
        }
        best.1
    }
}

/// The fewest leaf blocks for this many primitives. This is their cost, since a block costs nearly the same however full
/// it is. (`plan` adds a little for each primitive.)
// Tuned: see docs/lab-notes.md#block-sah
#[inline(always)]
fn blocks(primitives: u32) -> f32 {
    primitives.div_ceil(WIDTH as u32) as f32
}

/// Divides `boxes` in place and returns how many are in the first part: at least one, and not all.
///
/// `centers` is around their centres. If `halve`, both parts are equal, which bounds the depth where the heuristic would
/// split off one box at a time (boxes each far larger than the one before).
#[inline(always)]
pub(super) fn divide<S: Simd>(
    simd: S,
    boxes: &mut [Box8],
    centers: Box8,
    effort: Effort,
    halve: bool,
) -> usize {
    if halve {
        return halves(boxes, centers);
    }
    let bins = (4 + boxes.len() / 8).min(effort.bins);
    let binning = Binning::new(centers, bins, effort.all_axes);
    let Some((axis, bin)) = best_split(simd, boxes, &binning) else {
        return halves(boxes, centers);
    };
    let side = Side {
        simd,
        binning,
        axis,
        bin,
    };
    let first = if boxes.len() > PARALLEL {
        partition_parallel(boxes, &side)
    } else {
        simd.call(
            #[inline(always)]
            || partition(boxes, &side),
        )
    };
    debug_assert!(0 < first && first < boxes.len());
    first
}

#[inline(always)]
fn best_split<S: Simd>(simd: S, boxes: &[Box8], binning: &Binning) -> Option<(usize, usize)> {
    if boxes.len() > PARALLEL {
        let filled = |chunk: &[Box8]| filled(simd, chunk, binning);
        let merged = |a: Bins, b: Bins| {
            simd.call(
                #[inline(always)]
                || a.merge(simd, &b),
            )
        };
        let bins = boxes.par_chunks(CHUNK).map(filled).reduce(|| Bins::EMPTY, merged);
        return bins.best(simd, binning);
    }
    simd.call(
        #[inline(always)]
        || {
            let mut bins = Bins::EMPTY;
            bins.fill(simd, boxes, binning);
            bins.best(simd, binning)
        },
    )
}

fn filled<S: Simd>(simd: S, boxes: &[Box8], binning: &Binning) -> Bins {
    let mut bins = Bins::EMPTY;
    simd.call(
        #[inline(always)]
        || bins.fill(simd, boxes, binning),
    );
    bins
}

/// The sides of a division: boxes in bins before `bin` come first.
struct Side<S> {
    simd: S,
    binning: Binning,
    axis: usize,
    bin: usize,
}

impl<S: Simd> Side<S> {
    #[inline(always)]
    fn is_first(&self, b: Box8) -> bool {
        self.binning.bins_of(self.simd, b)[self.axis] < self.bin
    }
}

/// Partitions without a branch on the side, which is unpredictable.
#[inline(always)]
fn partition<S: Simd>(boxes: &mut [Box8], side: &Side<S>) -> usize {
    let mut first = 0;
    for i in 0..boxes.len() {
        let b = boxes[i];
        boxes.swap(i, first);
        first += usize::from(side.is_first(b));
    }
    first
}

/// Partitions both halves, then swaps what is on the wrong side. The resulting order depends only on the boxes, not on the
/// number of threads.
fn partition_parallel<S: Simd>(boxes: &mut [Box8], side: &Side<S>) -> usize {
    if boxes.len() <= CHUNK {
        return side.simd.call(
            #[inline(always)]
            || partition(boxes, side),
        );
    }
    let middle = boxes.len() / 2;
    let (low, high) = boxes.split_at_mut(middle);
    let (low_first, high_first) = rayon::join(
        || partition_parallel(low, side),
        || partition_parallel(high, side),
    );
    let count = high_first.min(middle - low_first);
    let (wrong_low, wrong_high) = (
        &mut low[low_first..low_first + count],
        &mut high[high_first - count..high_first],
    );
    wrong_low
        .par_chunks_mut(CHUNK)
        .zip(wrong_high.par_chunks_mut(CHUNK))
        .for_each(|(a, b)| a.swap_with_slice(b));
    low_first + high_first
}

/// Halves the boxes by their centres on the axis with the greatest extent.
#[cold]
fn halves(boxes: &mut [Box8], centers: Box8) -> usize {
    let bounds = centers.bounds();
    let extent = bounds.upper - bounds.lower;
    let axis = extent.max_position();
    let middle = boxes.len() / 2;
    if extent[axis] > 0.0 {
        let key = |b: &Box8| b.center(Portable).bounds().upper[axis];
        boxes.select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
    }
    middle
}
