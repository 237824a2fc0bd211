//! The resolution of frames while the camera moves, from the measured times of earlier frames.
//!
//! With a budget of 16 ms, the first of these that is possible:
//! 1. all pixels in 16 ms,
//! 2. all pixels in 32 ms,
//! 3. a coarser picture in 16 ms, down to a quarter of the window's sides,
//! 4. that quarter in up to 48 ms,
//! 5. a still coarser picture.

use std::time::Duration;

/// The default time of a moving frame: 60 frames per second.
pub const DEFAULT_BUDGET: Duration = Duration::from_millis(16);

/// Levels of resolution: shares of the window's sides, finest first.
const SCALES: [f64; 9] = [1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.0625, 0.03125];
/// The first level: a sixteenth of the pixels. Coarser pictures show little, so frames take up to [`MOST_TIME`] before
/// they become coarser than this.
const FIRST_LEVEL: usize = 4;
/// After this many frames without a failure, earlier failures of a level are forgotten.
const TRUST: u32 = 30;
/// The number of frames of each level that the median is taken of.
const RECENT: usize = 5;
/// Frames between two cancelled ones for each to count as a stutter.
const STUTTER: u64 = 10;
/// How many budgets a frame may take before it becomes coarser than [`FIRST_LEVEL`]: 20 frames per second by default.
const MOST_TIME: u32 = 3;
/// How many budgets a frame of all pixels may take: 31 sharp frames per second are better than 60 coarse ones.
const FULL_TIME: u32 = 2;
/// A finer picture is preferred if it takes at most this factor longer. On a busy machine, frames wait for the
/// processor however few pixels they have.
const SAME_TIME: f64 = 1.25;
/// A frame is cancelled for a coarser one after this many budgets, or after twice its allowed time.
const GIVE_UP: u32 = 4;
/// A finer picture is tried only if it is expected to take this share of the budget, to avoid flicker.
const MARGIN: f64 = 0.9;
/// The expected cost of a pixel at a finer level that was not measured lately, as a share of the present cost: part of
/// a frame's time does not depend on its pixels.
const OPTIMISM: f64 = 0.75;
/// Frames before a level that was too slow is tried again: after the first failure, doubled with every further one, up to
/// the second number.
const PATIENCE: [u64; 2] = [30, 960];

/// The resolution of one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Whether that is every pixel of the window.
    pub full: bool,
    /// Whether this is the coarsest level.
    pub coarsest: bool,
}

/// The measured cost of pixels at one level.
#[derive(Clone, Copy, Debug, Default)]
struct Measured {
    /// Seconds a pixel in the last frames, newest first.
    recent: [f64; RECENT],
    count: usize,
    /// The number of the last of them.
    frame: u64,
    /// How often the level was too slow.
    failures: u32,
    /// Frames since then.
    kept: u32,
    /// The last of its frames that was cancelled.
    given_up: Option<u64>,
}

impl Measured {
    fn add(&mut self, cost: f64, frame: u64) {
        self.recent.rotate_right(1);
        self.recent[0] = cost;
        self.count += 1;
        self.frame = frame;
        self.kept += 1;
        if self.kept >= TRUST {
            self.failures = 0;
        }
    }

    /// The median, which ignores a stutter or two. Of an even number of frames the lower one.
    fn cost(&self) -> Option<f64> {
        let mut recent = self.recent;
        let known = &mut recent[..self.count.min(RECENT)];
        known.sort_by(f64::total_cmp);
        known.get(known.len().saturating_sub(1) / 2).copied()
    }

    fn fail(&mut self) {
        self.failures += 1;
        self.kept = 0;
    }

    /// Frames before the level is tried again.
    fn patience(&self) -> u64 {
        let [first, most] = PATIENCE;
        (first << self.failures.saturating_sub(1).min(10)).min(most)
    }
}

/// The time for each frame, and the measured cost of pixels.
#[derive(Clone, Debug)]
pub struct Budget {
    target: f64,
    levels: [Measured; SCALES.len()],
    level: usize,
    /// How many budgets a frame may take now.
    time: u32,
    frame: u64,
}

impl Budget {
    /// Starts with this time for each frame.
    #[must_use]
    pub fn new(target: Duration) -> Self {
        Self {
            target: target.as_secs_f64(),
            levels: Default::default(),
            level: FIRST_LEVEL,
            time: 1,
            frame: 0,
        }
    }

    /// Returns the finest picture that is expected to be done in time.
    pub fn plan(&mut self, [width, height]: [u32; 2]) -> Plan {
        let side = |pixels: u32, scale: f64| ((f64::from(pixels) * scale).round() as u32).max(1);
        let pixels = |level: usize| f64::from(width) * f64::from(height) * SCALES[level].powi(2);
        if let Some(cost) = self.levels[self.level].cost() {
            let finest = |time: u32| {
                let limit = self.target * f64::from(time);
                // Changes for the better need a margin.
                let spare = |level: usize| {
                    let is_better = level < self.level || time < self.time;
                    limit * if is_better { MARGIN } else { 1.0 }
                };
                let fits = |&level: &usize| {
                    let known = self.levels[level].cost().filter(|_| !self.has_expired(level));
                    let guess = if level < self.level { cost * OPTIMISM } else { cost };
                    known.unwrap_or(guess) * pixels(level) <= spare(level)
                };
                let is_slow = cost * pixels(self.level) > limit;
                let first = if is_slow { self.level + 1 } else { 0 };
                (first..SCALES.len()).find(fits).unwrap_or(SCALES.len() - 1)
            };
            let sharp = (1..=FULL_TIME).map(|time| (time, 0));
            let coarser = (1..=MOST_TIME).map(|time| (time, FIRST_LEVEL));
            let (time, level) = sharp
                .chain(coarser)
                .map(|(time, coarsest)| (time, finest(time), coarsest))
                .find(|&(_, level, coarsest)| level <= coarsest)
                .map_or_else(
                    || (MOST_TIME, finest(MOST_TIME)),
                    |(time, level, _)| (time, level),
                );
            let seconds = |level: usize| self.levels[level].cost().map(|cost| cost * pixels(level));
            let is_as_fast = |&finer: &usize| match (seconds(finer), seconds(level)) {
                (Some(finer), Some(chosen)) => finer <= chosen * SAME_TIME,
                _ => false,
            };
            let level = (0..level).find(is_as_fast).unwrap_or(level);
            if level > self.level {
                self.levels[self.level].fail();
            }
            if level != self.level && self.has_expired(level) {
                self.levels[level].count = 0;
            }
            (self.level, self.time) = (level, time);
        }
        let scale = SCALES[self.level];
        Plan {
            size: [side(width, scale), side(height, scale)],
            full: self.level == 0,
            coarsest: self.level + 1 == SCALES.len(),
        }
    }

    /// Whether the measurements of a level are too old to count.
    fn has_expired(&self, level: usize) -> bool {
        let measured = &self.levels[level];
        self.frame - measured.frame > measured.patience()
    }

    /// Records the time of the last planned picture.
    pub fn learn(&mut self, pixels: u64, elapsed: Duration) {
        if pixels == 0 {
            return;
        }
        self.frame += 1;
        let cost = elapsed.as_secs_f64() / pixels as f64;
        self.levels[self.level].add(cost, self.frame);
    }

    /// Records that the last planned picture was cancelled after this many pixels. After frames in time it counts as a stutter,
    /// unless it is the second one within a short time.
    pub fn learn_failure(&mut self, pixels: u64, elapsed: Duration) {
        let measured = &mut self.levels[self.level];
        let last = measured.given_up.replace(self.frame);
        let is_second = last.is_some_and(|last| self.frame - last < STUTTER);
        if is_second || measured.count < RECENT {
            measured.count = 0;
        }
        self.learn(pixels.max(1), elapsed);
    }

    /// Forgets all measurements: other rays are traced from now on.
    pub fn forget(&mut self) {
        self.levels = Default::default();
        (self.level, self.time) = (FIRST_LEVEL, 1);
    }

    /// Whether a frame that has taken this long should be cancelled.
    #[must_use]
    pub fn is_overdrawn(&self, elapsed: Duration) -> bool {
        elapsed.as_secs_f64() > self.target * f64::from(GIVE_UP.max(2 * self.time))
    }
}

#[cfg(test)]
mod tests;
