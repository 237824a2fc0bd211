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
mod tests;
