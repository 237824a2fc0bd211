//! Bands of whole rows, and how threads come by them.

use rayon::prelude::*;
use std::{
    iter::{Enumerate, from_fn},
    slice::ChunksMut,
    sync::{Mutex, PoisonError},
};

/// The bands of a picture that no thread has taken yet, from the top.
///
/// Each thread takes the next one when it is done with the one before, so that none is without work for longer than the
/// last band takes. (Halves that threads steal from each other, and halves of what is left of those, left one of two
/// threads without work for 0.4 to 1 ms of a frame of 15 ms, in place of 0.2 ms: the course's `reflections.scn`, in
/// which few bands are most of the work.) The lock is held for as long as it takes to cut off a slice, once a band.
/// (Where the system's locks are not words in memory, as on macOS, each takes memory, once a frame.)
#[derive(Debug)]
pub(crate) struct Bands<'a, P> {
    rows: u32,
    left: Mutex<Enumerate<ChunksMut<'a, P>>>,
}

impl<'a, P: Send> Bands<'a, P> {
    /// `pixels` are rows of `width`, each band so many `rows` of them; the last one may be lower.
    pub fn new(pixels: &'a mut [P], width: u32, rows: u32) -> Self {
        Self {
            rows,
            left: Mutex::new(pixels.chunks_mut(width as usize * rows as usize).enumerate()),
        }
    }

    /// The next band and the row that it begins with.
    fn next(&self) -> Option<(u32, &'a mut [P])> {
        let (i, band) = self.left.lock().unwrap_or_else(PoisonError::into_inner).next()?;
        Some((i as u32 * self.rows, band))
    }

    /// All bands that are left, each with the row that it begins with, on the threads of the current rayon pool.
    pub fn in_turn(&self) -> impl ParallelIterator<Item = (u32, &'a mut [P])> {
        (0..rayon::current_num_threads())
            .into_par_iter()
            .with_max_len(1)
            .flat_map_iter(|_| from_fn(|| self.next()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(work)
    }

    #[test]
    fn every_row_is_in_one_band() {
        for (width, height, rows) in [(3, 40, 16), (1, 16, 16), (5, 1, 16), (7, 33, 1)] {
            let mut pixels = vec![u32::MAX; (width * height) as usize];
            let bands = Bands::new(&mut pixels, width, rows);
            let fill = |(y, band): (u32, &mut [u32])| {
                for (row, y) in band.chunks_mut(width as usize).zip(y..) {
                    for pixel in row {
                        assert_eq!(*pixel, u32::MAX);
                        *pixel = y;
                    }
                }
            };
            on_threads(4, || bands.in_turn().for_each(fill));
            let expected: Vec<u32> = (0..height).flat_map(|y| (0..width).map(move |_| y)).collect();
            assert_eq!(pixels, expected);
        }
    }

    #[test]
    fn one_thread_takes_bands_from_the_top() {
        let mut pixels = [0_u8; 50];
        let bands = Bands::new(&mut pixels, 1, 16);
        let taken: Vec<_> = on_threads(1, || bands.in_turn().map(|(y, band)| (y, band.len())).collect());
        assert_eq!(taken, [(0, 16), (16, 16), (32, 16), (48, 2)]);
    }
}
