//! Tests of `progress`.

use super::*;

#[test]
fn time_left_is_in_proportion() {
    let left = |seconds, done| time_left(Duration::from_secs(seconds), done, 100);
    assert_eq!(left(1, 0), "?");
    assert_eq!(left(1, 10), "9 s");
    assert_eq!(left(10, 10), "1:30 min");
    assert_eq!(left(1000, 10), "2:30 h");
    assert_eq!(left(5, 100), "0 s");
}
