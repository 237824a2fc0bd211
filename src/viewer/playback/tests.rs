//! Tests of `playback`.

use super::*;

#[test]
fn frames_pass_in_real_time_and_repeat() {
    let start = Instant::now();
    let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
    let mut playback = Playback::new(48, 25);
    assert!(!playback.go_on(at(1.0)) && playback.next().is_none());
    playback.step(4);
    playback.toggle(start);
    let mut seen = Vec::new();
    for _ in 0..3 {
        let next = playback.next().unwrap();
        let before = next.checked_sub(Duration::from_millis(1)).unwrap();
        assert!(!playback.go_on(before));
        assert!(playback.go_on(next) && !playback.go_on(next));
        seen.push(playback.frame());
    }
    assert_eq!(seen, [6, 7, 8]);
    // A late one is not made up for: 25 frames per second, whatever was shown.
    assert!(playback.go_on(at(1.001)));
    assert_eq!(playback.frame(), 30);
    assert!(playback.go_on(at(4.001)));
    assert_eq!(playback.frame(), (4 + 100) % 48 + 1);
    playback.toggle(at(4.002));
    assert!(!playback.go_on(at(9.0)));
    playback.step(-9);
    assert_eq!(playback.frame(), 48);
    playback.step(1);
    assert_eq!(playback.frame(), 1);
}

#[test]
fn what_does_not_move_does_not_play() {
    let mut playback = Playback::new(1, 25);
    playback.toggle(Instant::now());
    playback.step(1);
    assert_eq!((playback.frame(), playback.next()), (1, None));
    // A scene that loses its keyframes stops.
    playback = Playback::new(9, 25);
    playback.step(6);
    playback.toggle(Instant::now());
    playback.set_count(5);
    assert_eq!(playback.frame(), 5);
    assert!(playback.next().is_some());
    playback.set_count(1);
    assert_eq!((playback.frame(), playback.next()), (1, None));
}
