//! Tests of `progressive`.

use super::*;

fn all(state: &mut Progressive, last: u32) -> Vec<u32> {
    std::iter::from_fn(|| {
        let samples = state.next(last)?;
        state.done(samples);
        Some(samples)
    })
    .collect()
}

#[test]
fn up_to_the_last_number_and_then_nothing() {
    let mut state = Progressive::default();
    assert_eq!(all(&mut state, 64), [1, 4, 16, 64]);
    assert_eq!(state.next(64), None);
    for (last, expected) in [
        (1, &[1][..]),
        (10, &[1, 4, 10]),
        (4, &[1, 4]),
        (65, &[1, 4, 16, 64, 65]),
    ] {
        state.restart();
        assert_eq!(all(&mut state, last), expected);
    }
    state.done(u32::MAX - 1);
    assert_eq!(state.next(u32::MAX), Some(u32::MAX));
}

#[test]
fn a_moving_frame_of_full_quality_counts() {
    let mut state = Progressive::default();
    state.done(1);
    assert_eq!(all(&mut state, 64), [4, 16, 64]);
}
