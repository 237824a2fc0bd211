//! Tests of `sharing`.

use super::*;

#[test]
fn those_that_save_most_are_shared() {
    let of = |meshes: &[[usize; 2]], sharing| shared(meshes.iter().copied(), sharing);
    // Four wheels, a forest, boxes, and what stands once.
    let all = [[20_000, 4], [20_000, 2000], [12, 1_000_000], [5_000_000, 1]];
    assert_eq!(of(&all, Sharing::Never), [false; 4]);
    assert_eq!(of(&all, Sharing::WherePays), [false, true, false, false]);
    assert_eq!(of(&all, Sharing::Always), [true, true, true, false]);
    // Many that save little are shared until little is left.
    let many = vec![[10_000, 11]; 30];
    let count = of(&many, Sharing::WherePays).iter().filter(|&&is| is).count();
    assert_eq!(count, 20);
    assert_eq!(of(&[[usize::MAX, 7]; 2], Sharing::WherePays), [true; 2]);
}
