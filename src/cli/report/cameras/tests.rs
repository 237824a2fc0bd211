use super::*;

#[test]
fn numbers_are_as_long_as_they_need_to_be() {
    let widened = [0.1_f32, -2.7, 1e6].map(f64::from);
    assert_eq!(list(rounded(widened)), "0.1 -2.7 1000000");
}
