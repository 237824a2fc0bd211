//! Tests of `animation`.

use super::*;

#[test]
fn gifs_have_the_right_length() {
    for fps in 1..=100 {
        let sum: u32 = (0..3 * fps).map(|frame| hundredths(frame, fps)).sum();
        assert_eq!(sum, 300, "{fps}");
    }
    assert_eq!([0, 1, 2].map(|frame| hundredths(frame, 24)), [4, 4, 5]);
}

#[test]
fn planes_of_y4m() {
    let mut bytes = Vec::new();
    add_y4m(&[0, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0, 255], &mut bytes);
    let expected = [16, 235, 81, 41, 128, 128, 90, 240, 128, 128, 240, 110];
    assert_eq!(bytes, [&b"FRAME\n"[..], &expected].concat());
}
