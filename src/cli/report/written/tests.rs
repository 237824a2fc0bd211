//! Tests of `written`.

use super::*;

#[test]
fn one_line_for_one_picture_or_many() {
    let mut written = Written::default();
    written.add("a-1.png", Duration::from_micros(6400));
    assert_eq!(written.line((512, 256)), "wrote a-1.png (512x256, 6 ms)\n");
    written.add("a-2.png", Duration::from_millis(300));
    written.add("a-3.png", Duration::from_secs(2));
    assert_eq!(
        written.line((9, 8)),
        "wrote 3 pictures, a-1.png to a-3.png (9x8, 2.3 s)\n"
    );
    for (seconds, expected) in [
        (0.0, "1 ms"),
        (0.9999, "999 ms"),
        (125.0, "2:05 min"),
        (7500.0, "2:05 h"),
    ] {
        assert_eq!(duration(Duration::from_secs_f64(seconds)), expected);
    }
}
