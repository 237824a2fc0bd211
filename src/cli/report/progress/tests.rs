//! Tests of `progress`.

use super::*;

#[test]
fn time_left_is_in_proportion() {
    let left = |seconds, done| time_left(Duration::from_secs(seconds), done, 100);
    assert_eq!(left(1, 0), "?");
    assert_eq!(time_left(Duration::from_secs(1), 9, 1000), "?");
    assert_eq!(left(1, 10), "9 s");
    assert_eq!(left(10, 10), "1:30 min");
    assert_eq!(left(1000, 10), "2:30 h");
    assert_eq!(left(5, 100), "0 s");
}

#[test]
fn a_bar_ends_with_its_work() {
    let bar = StageBar::new(true, "working", 0);
    assert_eq!(bar.during(|| 3), 3);
    let worked = std::panic::catch_unwind(|| bar.during(|| panic!("on purpose")));
    assert!(worked.is_err());
}
