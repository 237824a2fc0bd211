//! Tests of `text`.

use super::*;
use crate::error::in_bytes;

#[test]
fn numbers_are_readable() {
    assert_eq!(grouped(0), "0");
    assert_eq!(grouped(999), "999");
    assert_eq!(grouped(1000), "1 000");
    assert_eq!(grouped(12_345_678), "12 345 678");
    assert_eq!(in_bytes(1023), "1023 B");
    assert_eq!(in_bytes(1536), "1.5 KiB");
    assert_eq!(in_bytes(3 << 30), "3.0 GiB");
}
