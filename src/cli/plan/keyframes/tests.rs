//! Tests of `keyframes`.

use super::*;

#[test]
fn some_frames_are_spread_over_all() {
    let frames = |count| {
        let playback = Playback {
            animation: None,
            count,
            fps: 25,
        };
        playback.some_frames().collect::<Vec<_>>()
    };
    assert_eq!(frames(1), [1]);
    assert_eq!(frames(3), [1, 2, 3]);
    let many = frames(u32::MAX);
    assert_eq!((many.len(), many.first()), (32, Some(&1)));
    assert_eq!(many[16], 1 << 31);
}
