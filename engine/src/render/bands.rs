//! Bands of whole rows, the work items of the render threads.

use rayon::prelude::*;
use std::{
    iter::{Enumerate, from_fn},
    slice::ChunksMut,
    sync::{Mutex, PoisonError},
};

/// The bands of a picture that no thread has taken yet, from the top.
///
/// A thread takes the next band when it finishes one, so none idles for longer than the last band takes.
// Tuned: see docs/lab-notes.md#bands
#[derive(Debug)]
#[doc(hidden)]
pub struct Bands<'a, P> {
    rows: u32,
    left: Mutex<Enumerate<ChunksMut<'a, P>>>,
}

impl<'a, P: Send> Bands<'a, P> {
    /// Divides `pixels`, rows of `width`, into bands of `rows` rows; the last band may have fewer.
    pub fn new(pixels: &'a mut [P], width: u32, rows: u32) -> Self {
        Self {
            rows,
            left: Mutex::new(pixels.chunks_mut(width as usize * rows as usize).enumerate()),
        }
    }

    /// Takes the next band, with the index of its first row.
    fn next(&self) -> Option<(u32, &'a mut [P])> {
        let (i, band) = self.left.lock().unwrap_or_else(PoisonError::into_inner).next()?;
        Some((i as u32 * self.rows, band))
    }

    /// Yields each band with the index of its first row, on the threads of the current rayon pool.
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
