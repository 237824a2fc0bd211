//! Tests of `info`.

use super::*;

#[test]
fn long_lists_say_how_many_more() {
    let mut lines = Vec::new();
    some(&mut lines, "note", &[1; MOST_LINES], ToString::to_string);
    assert_eq!(lines.len(), MOST_LINES);
    lines.clear();
    some(&mut lines, "note", &vec![1; 2000], ToString::to_string);
    assert_eq!(lines.len(), MOST_LINES + 1);
    assert_eq!(
        lines[MOST_LINES],
        ("note".to_owned(), "and 1 994 more".to_owned())
    );
}
