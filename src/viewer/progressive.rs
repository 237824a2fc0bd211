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
mod tests {
    use super::*;

    fn all(state: &mut Progressive, last: u32) -> Vec<u32> {
        std::iter::from_fn(|| {
            let samples = state.next(last)?;
            state.done(samples);
            Some(samples)
        })
        .collect()
    }

    #[test]
    fn up_to_the_last_number_and_then_nothing() {
        let mut state = Progressive::default();
        assert_eq!(all(&mut state, 64), [1, 4, 16, 64]);
        assert_eq!(state.next(64), None);
        for (last, expected) in [
            (1, &[1][..]),
            (10, &[1, 4, 10]),
            (4, &[1, 4]),
            (65, &[1, 4, 16, 64, 65]),
        ] {
            state.restart();
            assert_eq!(all(&mut state, last), expected);
        }
        state.done(u32::MAX - 1);
        assert_eq!(state.next(u32::MAX), Some(u32::MAX));
    }

    #[test]
    fn a_moving_frame_of_full_quality_counts() {
        let mut state = Progressive::default();
        state.done(1);
        assert_eq!(all(&mut state, 64), [4, 16, 64]);
    }
}
