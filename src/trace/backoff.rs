//! Backs off from bundles after incoherent ones.

/// After an incoherent bundle this many go ray by ray before another is tried; the count doubles up to the maximum
/// each time that one is incoherent again.
const SKIPPED_BUNDLES: std::ops::RangeInclusive<u32> = 3..=48;

/// Counts the bundles that still go ray by ray.
#[derive(Debug, Default)]
pub(super) struct Backoff {
    left: u32,
    /// The count of the last time; 0 if the last bundle was coherent.
    before: u32,
}

impl Backoff {
    pub fn is_on(&self) -> bool {
        self.left > 0
    }

    /// Notes that a bundle went ray by ray.
    pub fn one_less(&mut self) {
        self.left = self.left.saturating_sub(1);
    }

    /// Notes that a bundle was tried.
    pub fn tried(&mut self, was_incoherent: bool) {
        if was_incoherent {
            let (least, most) = (*SKIPPED_BUNDLES.start(), *SKIPPED_BUNDLES.end());
            self.before = (2 * self.before).clamp(least, most);
            self.left = self.before;
        } else {
            self.before = 0;
        }
    }
}
