//! What is traced while nothing moves: the whole picture, then the same picture with ever more samples.
//!
//! The samples of a pixel lie on regular grids of 1, 4, 16 and 64, one grid after another and each of them whole, so
//! that the picture at any of them has the bytes that `octray render --samples` makes. The grids share no sample: the
//! centres of a grid of N x N are on none of another of twice its side. 85 rays a pixel are the price for 64 samples.

/// Samples along a side of a pixel, grid after grid.
pub const GRIDS: [u32; 4] = [1, 2, 4, 8];

/// Which grid comes next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progressive {
    next: usize,
}

impl Progressive {
    /// Everything is to be traced again.
    pub fn restart(&mut self) {
        self.next = 0;
    }

    /// The next picture's samples along a side of a pixel; `None` if there is nothing left to do.
    #[must_use]
    pub fn next(&self, antialias: bool) -> Option<u32> {
        let last = if antialias { GRIDS.len() } else { 1 };
        GRIDS[..last].get(self.next).copied()
    }

    /// The picture of that grid is done.
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
        // Anti-aliasing goes on from where it stands.
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
