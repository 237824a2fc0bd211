//! Tests of `merge`.

use super::*;

fn crop([x0, y0, x1, y1]: [u32; 4]) -> Crop {
    Crop { x0, y0, x1, y1 }
}

#[test]
fn the_first_gap_is_a_rectangle() {
    let mut covered = vec![false; 5 * 4];
    for (next, gap) in [
        ([0, 0, 5, 1], [0, 0, 5, 4]),
        ([0, 1, 2, 3], [0, 1, 5, 4]),
        ([4, 1, 5, 4], [2, 1, 5, 4]),
        ([2, 1, 4, 3], [2, 1, 4, 4]),
        ([0, 3, 3, 4], [0, 3, 4, 4]),
        ([3, 3, 4, 4], [3, 3, 4, 4]),
    ] {
        assert_eq!(first_gap(&covered, 5), Some(crop(gap)));
        cover(&mut covered, 5, crop(next));
    }
    assert_eq!(first_gap(&covered, 5), None);
}
