//! How long a way of tracing that was of no use is left alone.

/// So many bundles of scattered rays go one by one before another is tried, and twice as many each time that proves to
/// be of no use again, up to so many.
const SCATTERED_BUNDLES: std::ops::RangeInclusive<u32> = 3..=48;

/// How many bundles still go one by one, because those before were scattered.
#[derive(Debug, Default)]
pub(super) struct Backoff {
    left: u32,
    /// How many did so the last time; 0 if the last bundle was of use.
    before: u32,
}

impl Backoff {
    pub fn is_on(&self) -> bool {
        self.left > 0
    }

    /// Another bundle went one by one.
    pub fn one_less(&mut self) {
        self.left = self.left.saturating_sub(1);
    }

    /// A bundle was tried.
    pub fn tried(&mut self, was_scattered: bool) {
        if was_scattered {
            let (least, most) = (*SCATTERED_BUNDLES.start(), *SCATTERED_BUNDLES.end());
            self.before = (2 * self.before).clamp(least, most);
            self.left = self.before;
        } else {
            self.before = 0;
        }
    }
}
