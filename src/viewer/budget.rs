//! How large a picture can be traced while the camera moves, learnt from the frames before.

use std::time::Duration;

/// The time of a moving frame, unless another is asked for: 60 frames a second.
pub const DEFAULT_BUDGET: Duration = Duration::from_millis(16);

/// Sides of the picture that is traced, as shares of the window's sides, finest first.
const SCALES: [f64; 7] = [1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125];
/// Where nothing is known yet: a sixteenth of the pixels finds out.
const FIRST_LEVEL: usize = 4;
/// A finer picture is tried only if it should leave so much of the budget, so that the sharpness does not flicker.
const MARGIN: f64 = 0.85;
/// How much a new measurement counts. What was slow counts at once: one stutter is enough.
const SLOWER: f64 = 0.6;
const FASTER: f64 = 0.2;

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

/// A time for each frame, and what pixels have cost so far.
#[derive(Clone, Debug)]
pub struct Budget {
    target: f64,
    seconds_per_pixel: Option<f64>,
    level: usize,
}

impl Budget {
    /// With so much time for each frame.
    #[must_use]
    pub fn new(target: Duration) -> Self {
        Self {
            target: target.as_secs_f64(),
            seconds_per_pixel: None,
            level: FIRST_LEVEL,
        }
    }

    /// The finest picture for a window of that size that should be done in time.
    pub fn plan(&mut self, [width, height]: [u32; 2]) -> Plan {
        let side = |pixels: u32, scale: f64| ((f64::from(pixels) * scale).round() as u32).max(1);
        if let Some(cost) = self.seconds_per_pixel {
            let pixels = f64::from(width) * f64::from(height);
            let fits = |&level: &usize| {
                let seconds = cost * pixels * SCALES[level].powi(2);
                seconds <= self.target * if level < self.level { MARGIN } else { 1.0 }
            };
            self.level = (0..SCALES.len()).find(fits).unwrap_or(SCALES.len() - 1);
        }
        let scale = SCALES[self.level];
        Plan {
            size: [side(width, scale), side(height, scale)],
            full: self.level == 0,
            coarsest: self.level + 1 == SCALES.len(),
        }
    }

    /// So many pixels have taken so long.
    pub fn learn(&mut self, pixels: u64, elapsed: Duration) {
        if pixels == 0 {
            return;
        }
        let cost = elapsed.as_secs_f64() / pixels as f64;
        self.seconds_per_pixel = Some(match self.seconds_per_pixel {
            None => cost,
            Some(old) => old + (cost - old) * if cost > old { SLOWER } else { FASTER },
        });
    }

    /// Other rays are traced from now on: what was learnt is of no use.
    pub fn forget(&mut self) {
        self.seconds_per_pixel = None;
        self.level = FIRST_LEVEL;
    }

    /// Whether a frame that has taken so long is far out of its time.
    #[must_use]
    pub fn is_overdrawn(&self, elapsed: Duration) -> bool {
        elapsed.as_secs_f64() > 4.0 * self.target
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
        for nanoseconds in [20.0, 50.0, 200.0, 800.0] {
            let mut budget = Budget::new(DEFAULT_BUDGET);
            let plan = run(&mut budget, nanoseconds, 20);
            let pixels = f64::from(plan.size[0]) * f64::from(plan.size[1]);
            assert!(pixels * nanoseconds * 1e-9 <= 0.016, "{nanoseconds}: {plan:?}");
            assert!(!plan.full);
        }
        let mut budget = Budget::new(DEFAULT_BUDGET);
        let plan = run(&mut budget, 1e7, 3);
        assert_eq!((plan.size, plan.coarsest), ([160, 90], true));
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
        // A full frame would take 15 ms: in time, but too close to it.
        let cost = 15e6 / (1280.0 * 720.0);
        let mut budget = Budget::new(DEFAULT_BUDGET);
        run(&mut budget, 2.0 * cost, 10);
        let settled = run(&mut budget, cost, 60);
        for i in 0..40 {
            let noise = if i % 2 == 0 { 0.97 } else { 1.03 };
            assert_eq!(run(&mut budget, cost * noise, 1), settled);
        }
    }

    #[test]
    fn small_windows_have_pixels() {
        let mut budget = Budget::new(DEFAULT_BUDGET);
        assert_eq!(budget.plan([1, 3]).size, [1, 1]);
        budget.learn(0, DEFAULT_BUDGET);
        assert!(budget.is_overdrawn(Duration::from_millis(65)) && !budget.is_overdrawn(DEFAULT_BUDGET));
    }
}
