//! Tests of `nearest`.

use super::*;

#[test]
fn a_letter_in_three_may_be_wrong() {
    let known = ["eye", "target", "up", "fov"];
    assert_eq!(nearest(b"eyes", known), Some("eye"));
    assert_eq!(nearest(b"TAREGT", known), Some("target"));
    assert_eq!(nearest(b"to", known), None);
    assert_eq!(nearest(b"\xff", known), None);
}

#[test]
fn lists() {
    assert_eq!(list(&[]), "");
    assert_eq!(list(&["a"]), "`a`");
    assert_eq!(list(&["a", "b", "c"]), "`a`, `b` or `c`");
    assert_eq!(list_or_end(&["a", "b"]), "`a`, `b` or the end of the line");
}
