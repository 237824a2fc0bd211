//! Tests of `offset`.

use super::*;

#[test]
fn coordinates_are_rounded_once() {
    let offset = Offset::new(DVec3::new(500_000.0, 4e6, 0.0));
    assert_eq!(offset.parse(0, b"500000.0009765625"), Ok(0.000_976_562_5));
    assert_eq!(offset.parse(1, b"3999999.9"), Ok((3_999_999.9_f64 - 4e6) as f32));
    assert_eq!(offset.parse(2, b"0.1"), Ok(0.1));
    assert!(offset.parse(0, b"x").is_err());
    // Unusable with an offset as without one.
    for word in [&b"nan"[..], b"1.0004e9", b"-inf", b"1e39"] {
        let [with, without] = [offset, Offset::NONE].map(|offset| offset.parse(0, word).unwrap());
        assert_eq!(with.to_bits(), without.to_bits());
    }
    assert!(Offset::new(DVec3::ZERO).is_none());
    // Rounding by way of f64 would give 1.
    let above_halfway = b"1.00000005960464477539062500001";
    assert_eq!(Offset::NONE.parse(0, above_halfway), Ok(1.0 + f32::EPSILON));
}
