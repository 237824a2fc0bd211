//! Tests of `blocks`.

use super::*;

#[test]
fn vertices_are_shared_in_large_meshes() {
    assert_eq!(Layout::suiting(LARGE, LARGE / 2), Layout::Indexed);
    assert_eq!(Layout::suiting(LARGE, LARGE), Layout::Indexed);
    assert_eq!(Layout::suiting(LARGE - 1, LARGE / 2), Layout::Whole);
    assert_eq!(Layout::suiting(LARGE, 3 * LARGE), Layout::Whole);
}
