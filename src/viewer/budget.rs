//! How large a picture can be traced while the camera moves, learnt from the frames before.
//!
//! The rule, for a budget of 16 ms: all pixels, if they take 16 ms; else all pixels, if they take 32 ms; else as many as
//! take 16 ms, down to a quarter of the window's sides; else that quarter, in up to 48 ms; else still fewer pixels.

use std::time::Duration;

/// The time of a moving frame, unless another is asked for: 60 frames a second.
pub const DEFAULT_BUDGET: Duration = Duration::from_millis(16);

/// Sides of the picture that is traced, as shares of the window's sides, finest first.
const SCALES: [f64; 9] = [1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.0625, 0.03125];
/// Where nothing is known yet: a sixteenth of the pixels finds out. What is coarser shows little: rather than that,
/// frames take longer, up to [`MOST_TIME`].
const FIRST_LEVEL: usize = 4;
/// Frames without a failure after which a level is trusted again as if it had never failed: what slowed it down is over.
const TRUST: u32 = 30;
/// Frames of each level that count.
const RECENT: usize = 5;
/// Frames between two that were given up, so that each of them was a stutter.
const STUTTER: u64 = 10;
/// What a frame may take at most, in times of the budget, before it becomes coarser than [`FIRST_LEVEL`]: 20 frames a
/// second, unless another budget is asked for.
const MOST_TIME: u32 = 3;
/// What a frame of all pixels may take, in times of the budget, before it becomes coarser at all: 31 frames a second of
/// the sharp picture are worth more than 60 of a coarser one.
const FULL_TIME: u32 = 2;
/// A finer picture that takes at most so many times as long is preferred: where other programs have the processor, frames
/// wait for it however few their pixels are.
const SAME_TIME: f64 = 1.25;
/// A frame that takes so many times the budget, or twice what it may, is given up for a coarser one.
const GIVE_UP: u32 = 4;
/// A finer picture is tried only if it should leave so much of the budget, so that the sharpness does not flicker.
const MARGIN: f64 = 0.9;
/// Pixels of a finer picture that has not been traced lately are taken to cost so much of what they cost now: a frame
/// also takes time that does not depend on its pixels.
const OPTIMISM: f64 = 0.75;
/// Frames after which a finer picture that was too slow may be tried again: first, and at most. The time doubles with
/// every failure.
const PATIENCE: [u64; 2] = [30, 960];

/// What to trace for one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Whether that is every pixel of the window.
    pub full: bool,
    /// Whether there is nothing coarser.
    pub coarsest: bool,
}

/// What pixels of one level have cost.
#[derive(Clone, Copy, Debug, Default)]
struct Measured {
    /// Seconds a pixel of the last frames, the newest first.
    recent: [f64; RECENT],
    count: usize,
    /// When the last of them was.
    frame: u64,
    /// How often the level was given up for being too slow.
    failures: u32,
    /// Frames since then.
    kept: u32,
    /// When one of its frames was given up last.
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

    /// The median; of an even number of frames the faster of the two in the middle. A stutter or two say nothing.
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

    /// How long to remember that the level was too slow, frames.
    fn patience(&self) -> u64 {
        let [first, most] = PATIENCE;
        (first << self.failures.saturating_sub(1).min(10)).min(most)
    }
}

/// A time for each frame, and what pixels have cost so far.
#[derive(Clone, Debug)]
pub struct Budget {
    target: f64,
    levels: [Measured; SCALES.len()],
    level: usize,
    /// What a frame may take now, in times of the target.
    time: u32,
    frame: u64,
}

impl Budget {
    /// With so much time for each frame.
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

    /// The finest picture for a window of that size that should be done in time.
    pub fn plan(&mut self, [width, height]: [u32; 2]) -> Plan {
        let side = |pixels: u32, scale: f64| ((f64::from(pixels) * scale).round() as u32).max(1);
        let pixels = |level: usize| f64::from(width) * f64::from(height) * SCALES[level].powi(2);
        if let Some(cost) = self.levels[self.level].cost() {
            let finest = |time: u32| {
                let limit = self.target * f64::from(time);
                // Neither finer pictures nor shorter times are tried on the edge of what fits.
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

    /// Whether what is known of a level is too old to count.
    fn has_expired(&self, level: usize) -> bool {
        let measured = &self.levels[level];
        self.frame - measured.frame > measured.patience()
    }

    /// So many pixels of the picture planned last have taken so long.
    pub fn learn(&mut self, pixels: u64, elapsed: Duration) {
        if pixels == 0 {
            return;
        }
        self.frame += 1;
        let cost = elapsed.as_secs_f64() / pixels as f64;
        self.levels[self.level].add(cost, self.frame);
    }

    /// The picture planned last was given up after so many of its pixels. Where others were in time just before, that is a
    /// stutter; a second one soon is none.
    pub fn learn_failure(&mut self, pixels: u64, elapsed: Duration) {
        let measured = &mut self.levels[self.level];
        let last = measured.given_up.replace(self.frame);
        let is_second = last.is_some_and(|last| self.frame - last < STUTTER);
        if is_second || measured.count < RECENT {
            measured.count = 0;
        }
        self.learn(pixels.max(1), elapsed);
    }

    /// Other rays are traced from now on: what was learnt is of no use.
    pub fn forget(&mut self) {
        self.levels = Default::default();
        (self.level, self.time) = (FIRST_LEVEL, 1);
    }

    /// Whether a frame that has taken so long is far out of its time.
    #[must_use]
    pub fn is_overdrawn(&self, elapsed: Duration) -> bool {
        elapsed.as_secs_f64() > self.target * f64::from(GIVE_UP.max(2 * self.time))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDOW: [u32; 2] = [1280, 720];

    /// Frames where every pixel costs so many nanoseconds.
    fn run(budget: &mut Budget, nanoseconds: f64, frames: u32) -> Plan {
        for _ in 0..frames {
            let Plan { size: [w, h], .. } = budget.plan(WINDOW);
            let pixels = u64::from(w) * u64::from(h);
            budget.learn(
                pixels,
                Duration::from_secs_f64(pixels as f64 * nanoseconds * 1e-9),
            );
        }
        budget.plan(WINDOW)
    }

    #[test]
    fn fast_scenes_are_sharp_at_the_second_frame() {
        let mut budget = Budget::new(DEFAULT_BUDGET);
        assert_eq!(budget.plan(WINDOW).size, [320, 180]);
        let plan = run(&mut budget, 10.0, 1);
        assert_eq!((plan.size, plan.full), (WINDOW, true));
    }

    #[test]
    fn slow_scenes_keep_the_time() {
        for (nanoseconds, width, seconds) in [
            (40.0, 640, 0.016),
            (50.0, 640, 0.016),
            (200.0, 320, 0.016),
            // A quarter of the sides, as long as that leaves 20 frames a second.
            (400.0, 320, 0.032),
            (800.0, 320, 0.048),
            (1200.0, 240, 0.06),
        ] {
            let mut budget = Budget::new(DEFAULT_BUDGET);
            let plan = run(&mut budget, nanoseconds, 20);
            assert_eq!((plan.size[0], plan.full), (width, false), "{nanoseconds}");
            let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
            assert!(pixels * nanoseconds * 1e-9 <= seconds, "{nanoseconds}: {plan:?}");
        }
        let mut budget = Budget::new(DEFAULT_BUDGET);
        let plan = run(&mut budget, 1e7, 3);
        assert_eq!((plan.size, plan.coarsest), ([40, 23], true));
    }

    #[test]
    fn the_sharp_picture_stays_for_twice_the_time() {
        // 33 frames a second of all pixels, then 27.
        let cost = |milliseconds: f64| milliseconds * 1e6 / (1280.0 * 720.0);
        let mut budget = Budget::new(DEFAULT_BUDGET);
        for milliseconds in [15.0, 20.0, 28.0, 30.0, 10.0] {
            for _ in 0..60 {
                assert!(run(&mut budget, cost(milliseconds), 1).full, "{milliseconds}");
            }
        }
        // Whoever comes from a coarser picture finds it, too.
        assert!(!run(&mut budget, cost(80.0), 60).full);
        assert!(run(&mut budget, cost(27.0), 60).full);
        let tried = (0..2000).filter(|_| run(&mut budget, cost(37.0), 1).full);
        assert!(tried.count() < 20);
        assert_eq!(run(&mut budget, cost(37.0), 4).size[0], 640);
    }

    #[test]
    fn it_restores_what_it_lowered() {
        let mut budget = Budget::new(DEFAULT_BUDGET);
        assert!(run(&mut budget, 10.0, 3).full);
        assert!(!run(&mut budget, 100.0, 3).full);
        assert!(run(&mut budget, 10.0, 40).full);
    }

    #[test]
    fn it_does_not_flicker() {
        // A full frame would take all of its time, or twice that; or one of a quarter of the sides would.
        for milliseconds in [15.0, 30.0, 16.0 * 15.0, 16.0 * 18.0] {
            let cost = milliseconds * 1e6 / (1280.0 * 720.0);
            let mut budget = Budget::new(DEFAULT_BUDGET);
            let settled = run(&mut budget, cost, 60);
            for i in 0..40 {
                let noise = if i % 2 == 0 { 0.97 } else { 1.03 };
                assert_eq!(run(&mut budget, cost * noise, 1), settled, "{milliseconds}");
            }
        }
    }

    #[test]
    fn a_stutter_changes_nothing_and_slowness_does() {
        let mut budget = Budget::new(DEFAULT_BUDGET);
        run(&mut budget, 10.0, 10);
        assert!(run(&mut budget, 90.0, 1).full);
        assert!(run(&mut budget, 10.0, 4).full);
        assert!(run(&mut budget, 90.0, 2).full);
        assert!(run(&mut budget, 10.0, 4).full);
        assert!(!run(&mut budget, 90.0, 3).full);
    }

    #[test]
    fn one_frame_that_is_given_up_is_a_stutter_and_two_are_not() {
        let fail = |budget: &mut Budget| {
            budget.plan(WINDOW);
            budget.learn_failure(1000, Duration::from_millis(70));
            budget.plan(WINDOW)
        };
        let mut budget = Budget::new(DEFAULT_BUDGET);
        for _ in 0..5 {
            assert!(run(&mut budget, 10.0, 20).full);
            assert!(fail(&mut budget).full);
        }
        assert!(!fail(&mut budget).full);
        // Nothing is known yet: no stutter.
        let mut budget = Budget::new(DEFAULT_BUDGET);
        assert!(run(&mut budget, 10.0, 2).full);
        assert!(!fail(&mut budget).full);
    }

    #[test]
    fn what_is_fast_again_is_trusted_again() {
        let mut budget = Budget::new(DEFAULT_BUDGET);
        for _ in 0..10 {
            assert!(!run(&mut budget, 90.0, 10).full);
            // Failed often, it would have to wait for hundreds of frames.
            assert!(run(&mut budget, 10.0, 80).full);
        }
    }

    #[test]
    fn what_is_too_slow_is_tried_less_and_less_often() {
        // Each frame takes half a millisecond for nothing and 10 ns a pixel: half of the sides fit, all pixels would take too long.
        let mut budget = Budget::new(Duration::from_micros(4750));
        let mut tried = Vec::new();
        for frame in 0..3000 {
            let Plan {
                size: [w, h], full, ..
            } = budget.plan(WINDOW);
            let pixels = u64::from(w) * u64::from(h);
            if full {
                tried.push(frame);
            }
            budget.learn(pixels, Duration::from_secs_f64(5e-4 + pixels as f64 * 1e-8));
        }
        assert!(!tried.is_empty() && tried.len() < 20, "{tried:?}");
        assert_eq!(budget.plan(WINDOW).size, [640, 360]);
    }

    #[test]
    fn pixels_are_not_given_up_for_nothing() {
        // Each frame takes 60 ms, however few its pixels are.
        let mut budget = Budget::new(DEFAULT_BUDGET);
        let mut coarser = 0;
        for _ in 0..200 {
            let Plan { size: [w, h], .. } = budget.plan(WINDOW);
            coarser += u32::from(w < 320);
            budget.learn(u64::from(w) * u64::from(h), Duration::from_millis(60));
        }
        assert!(coarser < 10, "{coarser}");
        // When that is over, all pixels are back.
        assert!(run(&mut budget, 10.0, 40).full);
    }

    #[test]
    fn small_windows_have_pixels() {
        let mut budget = Budget::new(DEFAULT_BUDGET);
        assert_eq!(budget.plan([1, 3]).size, [1, 1]);
        budget.learn(0, DEFAULT_BUDGET);
        assert!(budget.is_overdrawn(Duration::from_millis(65)) && !budget.is_overdrawn(DEFAULT_BUDGET));
    }
}
