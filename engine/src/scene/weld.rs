//! Vertex welding: files often store several vertices at one position.

use super::is_usable;
use rayon::prelude::*;

/// Returns for each vertex the first one with the same position. 0 and -0 are equal.
pub fn weld(x: &[f32], y: &[f32], z: &[f32]) -> Vec<u32> {
    debug_assert!(x.iter().all(|&value| is_usable(value)));
    let bits = |value: f32| u128::from((value + 0.0).to_bits());
    let positions = (x, y, z).into_par_iter().enumerate();
    let mut keys: Vec<u128> = positions
        .map(|(i, (&x, &y, &z))| bits(x) << 96 | bits(y) << 64 | bits(z) << 32 | i as u128)
        .collect();
    keys.par_sort_unstable();
    let mut first = vec![0; keys.len()];
    let (mut position, mut first_i) = (None, 0);
    for key in keys {
        let i = key as u32;
        if position != Some(key >> 32) {
            (position, first_i) = (Some(key >> 32), i);
        }
        first[i as usize] = first_i;
    }
    first
}

#[cfg(test)]
mod tests;
