//! Tests of `bvh`.

use super::*;

#[test]
fn numbers_are_as_long_as_they_need_to_be() {
    assert_eq!(
        by_size([12, 0, 3000, 0, 0, 0, 0, 1], "primitives"),
        "12 x 1, 3 000 x 3, 1 x 8 primitives"
    );
    assert_eq!(by_size([0; 8], "children"), "none");
}
