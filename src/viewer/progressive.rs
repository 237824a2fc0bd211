//! The pictures that are traced at rest: of 1, 4, 16, ... samples per pixel, up to a last number.
//!
//! Each is traced from scratch, so that the last one has the bytes of `octray render --samples`. They share no samples:
//! 64 cost 85 rays per pixel.

/// How much finer each picture is than the one before.
const STEP: u32 = 4;

/// Which picture comes next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progressive {
    /// Samples per pixel of the finest picture so far.
    done: u32,
}

impl Progressive {
    /// Starts again.
    pub fn restart(&mut self) {
        self.done = 0;
    }

    /// Returns the samples per pixel of the next picture; `None` after one of `last` samples.
    #[must_use]
    pub fn next(&self, last: u32) -> Option<u32> {
        let next = self.done.saturating_mul(STEP).clamp(1, last.max(1));
        (self.done < last).then_some(next)
    }

    /// Records that the picture with these samples is done.
    pub fn done(&mut self, samples: u32) {
        self.done = self.done.max(samples);
    }
}

#[cfg(test)]
mod tests;
