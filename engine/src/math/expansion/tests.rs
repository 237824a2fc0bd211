//! Tests of `expansion`.

use super::*;

#[test]
fn sums_do_not_round() {
    let sign = |numbers: &[f64]| {
        let mut sum = Expansion::default();
        for &number in numbers {
            sum.add(number);
        }
        sum.sign()
    };
    assert_eq!(sign(&[1e300, 1e-300, -1e300, -1e-300]), 0.0);
    assert!(sign(&[1.0, 1e-300, -1.0]) > 0.0);
    assert!(sign(&[1e-300, -1.0, 1e200, -1e200]) < 0.0);
    assert_eq!(sign(&[]), 0.0);
}
