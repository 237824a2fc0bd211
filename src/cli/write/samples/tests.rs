//! Tests of `samples`.

use super::*;

fn crop([x0, y0, x1, y1]: [u32; 4]) -> Crop {
    Crop { x0, y0, x1, y1 }
}

#[test]
fn overlaps_are_compared() {
    let mut whole = vec![0; 4 * 2];
    let mut covered = vec![false; 4 * 2];
    let left = crop([0, 0, 3, 2]);
    assert_eq!(
        paste((&mut whole, 4), &[1, 2, 3, 5, 6, 7], 1, left, &covered),
        None
    );
    cover(&mut covered, 4, left);
    let right = crop([2, 0, 4, 2]);
    let mut other = whole.clone();
    assert_eq!(
        paste((&mut other, 4), &[3, 4, 9, 8], 1, right, &covered),
        Some([2, 1])
    );
    assert_eq!(paste((&mut whole, 4), &[3, 4, 7, 8], 1, right, &covered), None);
    assert_eq!(whole, [1, 2, 3, 4, 5, 6, 7, 8]);
}
