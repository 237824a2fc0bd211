//! The pictures that are traced at rest: 1, 4, 16 and 64 samples a pixel.
//!
//! Each is traced from scratch on a regular grid of samples, so it has the bytes of `octray render --samples`. The grids share
//! no samples: 64 samples cost 85 rays a pixel.

/// Samples along a side of a pixel, picture after picture.
pub const GRIDS: [u32; 4] = [1, 2, 4, 8];

/// Which picture comes next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progressive {
    next: usize,
}

impl Progressive {
    /// Starts again.
    pub fn restart(&mut self) {
        self.next = 0;
    }

    /// Returns the samples along a side of a pixel of the next picture; `None` after the last one.
    #[must_use]
    pub fn next(&self, antialias: bool) -> Option<u32> {
        let last = if antialias { GRIDS.len() } else { 1 };
        GRIDS[..last].get(self.next).copied()
    }

    /// Takes in that the picture with these samples is done.
    pub fn done(&mut self, samples_per_axis: u32) {
        if let Some(i) = GRIDS.iter().position(|&n| n == samples_per_axis) {
            self.next = self.next.max(i + 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(state: &mut Progressive, antialias: bool) -> Vec<u32> {
        std::iter::from_fn(|| {
            let n = state.next(antialias)?;
            state.done(n);
            Some(n * n)
        })
        .collect()
    }

    #[test]
    fn up_to_64_samples_and_then_nothing() {
        let mut state = Progressive::default();
        assert_eq!(all(&mut state, true), [1, 4, 16, 64]);
        assert_eq!(state.next(true), None);
        state.restart();
        assert_eq!(all(&mut state, false), [1]);
        // Anti-aliasing continues after the first picture.
        assert_eq!(all(&mut state, true), [4, 16, 64]);
        assert_eq!(all(&mut state, false), [0; 0]);
    }

    #[test]
    fn a_moving_frame_of_full_quality_counts() {
        let mut state = Progressive::default();
        state.done(1);
        assert_eq!(all(&mut state, true), [4, 16, 64]);
    }
}
