//! Tests of `playback`.

use super::*;
use crate::{
    accel::Bvh,
    scene::SceneBuilder,
    viewer::{
        mailbox::{Picture, Shared},
        request::Request,
        timeline::{Frames, Model},
        worker::{self, Note},
    },
};
use std::{sync::mpsc, thread};

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
fn a_frame_that_fails_is_left_for_the_one_that_is_shown() {
    let start = Instant::now();
    let mut playback = Playback::new(9, 25);
    playback.step(2);
    playback.toggle(start);
    assert!(playback.go_on(playback.next().unwrap()) && playback.plays());
    // Frame 4 failed: 3 is on the screen.
    playback.stop_at(3, 4);
    assert!(!playback.plays() && playback.next().is_none());
    playback.step(-1);
    assert_eq!(playback.frame(), 2);
    playback.stop_at(0, 2);
    assert_eq!(playback.frame(), 1);
    playback.stop_at(10, 2);
    assert_eq!(playback.frame(), 9);
}

#[test]
fn steps_go_past_frames_that_fail() {
    let start = Instant::now();
    let mut playback = Playback::new(9, 25);
    let mut step = |steps: i64, failed: Option<u32>, shown: u32| {
        playback.step(steps);
        let frame = playback.frame();
        if let Some(failed) = failed {
            assert_eq!(frame, failed);
            playback.stop_at(shown, failed);
        }
        frame
    };
    // Frames 2 and 3 fail.
    assert_eq!(step(1, Some(2), 1), 2);
    assert_eq!(step(1, Some(3), 1), 3);
    assert_eq!([step(1, None, 0), step(-1, Some(3), 4)], [4, 3]);
    // The other way, steps count from the frame that is shown.
    assert_eq!(step(1, None, 0), 5);
    assert_eq!(step(-1, None, 0), 4);
    assert_eq!(
        [step(-1, Some(3), 4), step(-1, Some(2), 4), step(-1, None, 0)],
        [3, 2, 1]
    );
    // Playback goes past them, too.
    assert_eq!(step(1, Some(2), 1), 2);
    playback.toggle(start);
    assert!(playback.go_on(playback.next().unwrap()));
    assert_eq!(playback.frame(), 3);
    // A file that is loaded again has other frames.
    playback.stop_at(1, 3);
    playback.set_count(5);
    playback.step(1);
    assert_eq!(playback.frame(), 2);
}

/// The window goes back to the frame that is shown, which the worker then finishes.
#[test]
fn the_worker_finishes_the_frame_before_one_that_fails() {
    let model = Model::new(
        SceneBuilder::new().finish(),
        Bvh::build(&SceneBuilder::new().finish()),
    );
    let frames = Frames {
        count: 3,
        load: Box::new(|frame| match frame {
            2 => Ok(SceneBuilder::new().finish()),
            _ => Err(format!("no frame {frame}")),
        }),
    };
    let timeline = Arc::new(Timeline::with_frames(model, Some(frames)));
    let (shared, (sender, notes)) = (Shared::default(), mpsc::channel());
    let at = |frame| Request {
        frame,
        ..Request::of_view(&timeline, 1)
    };
    let last = |shared: &Shared| {
        let mut picture = Picture::default();
        while !picture.last {
            match notes.recv_timeout(Duration::from_mins(1)) {
                Ok(Note::Failed(frame, why)) => return Err((frame, why)),
                Ok(_) => shared.take(&mut picture),
                Err(_) => return Err((0, "no picture".to_owned())),
            };
        }
        Ok(picture.frame)
    };
    let found = thread::scope(|scope| {
        scope.spawn(|| {
            worker::run(&shared, Duration::from_millis(50), &|note| {
                sender.send(note).unwrap_or_default();
            });
        });
        let found = [2, 3, 0].map(|frame| {
            // At last the one that is shown.
            let frame = if frame == 0 { timeline.now().frame() } else { frame };
            shared.post(at(frame));
            last(&shared)
        });
        shared.end();
        found
    });
    let failed = Err((3, "no frame 3".to_owned()));
    assert_eq!(found, [Ok([2, 3]), failed, Ok([2, 3])]);
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
