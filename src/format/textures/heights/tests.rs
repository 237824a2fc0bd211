//! Tests of `heights`.

use super::*;

#[test]
fn normals_lean_away_from_what_is_higher() {
    let grey = |levels: &[u8]| levels.iter().map(|&level| [level; 4]).collect::<Vec<_>>();
    // Three rows: the middle column of the middle one has slopes of 1 to the right and of 0.5 down.
    let heights = grey(&[0, 0, 0, 0, 100, 255, 0, 128, 0]);
    assert!(is_grey(&heights) && !is_grey(&[[128, 128, 255, 255]]));
    let [red, green, blue, _] = normals([3, 3], &heights)[4];
    // Of (-1, 0.5, 1), 1.5 long.
    assert_eq!([red, green, blue], [43, 170, 212]);
    assert_eq!(normals([2, 1], &grey(&[7, 7])), [[128, 128, 255, 255]; 2]);
}
