//! Tests of `loading`.

use super::*;

#[test]
fn progress_is_percent_or_megabytes() {
    assert_eq!(measure(0, 7), (0, "%"));
    assert_eq!(measure(u64::MAX / 2, u64::MAX), (49, "%"));
    assert_eq!(measure(9, 7), (100, "%"));
    assert_eq!(measure(12_999_999, 0), (12, "MB"));
}

#[test]
fn time_left_is_that_of_the_rest() {
    let left = |seconds, done, total| time_left(Duration::from_secs(seconds), done, total);
    assert_eq!(left(1, 5, 10), None);
    assert_eq!(left(3, 0, 10), None);
    assert_eq!(left(3, 5_000_000, 0), None);
    assert_eq!(left(30, 10, 10), None);
    assert_eq!(left(30, 3, 4).as_deref(), Some(", 10 s left"));
    assert_eq!(left(30, 1, 7).as_deref(), Some(", 3 min left"));
}
