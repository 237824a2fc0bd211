//! Which vertices stand at the same place: files often store one several times.

use super::is_usable;
use rayon::prelude::*;

/// For each vertex the first one with the same position. 0 and -0 are the same place.
pub(crate) fn first_at_place(x: &[f32], y: &[f32], z: &[f32]) -> Vec<u32> {
    debug_assert!(x.iter().all(|&value| is_usable(value)));
    let bits = |value: f32| u128::from((value + 0.0).to_bits());
    let columns = (x, y, z).into_par_iter().enumerate();
    let mut keys: Vec<u128> = columns
        .map(|(i, (&x, &y, &z))| bits(x) << 96 | bits(y) << 64 | bits(z) << 32 | i as u128)
        .collect();
    keys.par_sort_unstable();
    let mut first = vec![0; keys.len()];
    let (mut place, mut at_place) = (None, 0);
    for key in keys {
        let i = key as u32;
        if place != Some(key >> 32) {
            (place, at_place) = (Some(key >> 32), i);
        }
        first[i as usize] = at_place;
    }
    first
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_first_of_a_place_stands_for_all() {
        let found = super::first_at_place(&[1.0, 0.0, 1.0, -0.0, 1.0], &[2.0, 0.0, 2.0, 0.0, 3.0], &[0.0; 5]);
        assert_eq!(found, [0, 1, 0, 1, 4]);
    }
}
