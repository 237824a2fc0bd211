//! Tests of `worker`.

use super::*;
use crate::{accel::Bvh, scene::SceneBuilder, viewer::timeline::Timeline};
use std::{
    sync::{atomic::AtomicBool, mpsc},
    thread,
};

/// After the picture of 4 samples, and after the last one, of 16, another request comes and goes before the worker looks for
/// one. The window has taken the picture by then or not.
#[test]
fn a_request_that_comes_back_ends_with_its_last_picture() {
    let scene = SceneBuilder::new().finish();
    let bvh = Bvh::build(&scene);
    let timeline = Arc::new(Timeline::new(Model::new(scene, bvh)));
    let mut first = Request::of_view(&timeline, 1);
    first.style.settings.samples = 16;
    // The first changes the rays.
    let changes: [fn(&mut Request); 2] = [
        |request| request.style.look = Look::Normals,
        |request| request.style.boxes = Boxes::Leaves,
    ];
    for (i, change) in changes.into_iter().enumerate() {
        let mut other = first.clone();
        change(&mut other);
        for (after, is_taken) in [(4, false), (16, false), (16, true)] {
            let found = comes_back(&first, &other, after, is_taken);
            assert_eq!(
                found,
                Ok(16),
                "change {i} after {after} samples, taken: {is_taken}"
            );
        }
    }
}

/// Returns the samples of the last picture when that of `after` samples is followed by two requests.
fn comes_back(first: &Request, other: &Request, after: u32, is_taken: bool) -> Result<u32, String> {
    let (shared, comes, (sender, notes)) = (Shared::default(), AtomicBool::new(true), mpsc::channel());
    let tell = |note| {
        let Note::Picture = note else { return };
        if comes.load(Ordering::Relaxed) {
            let mut picture = Picture::default();
            assert!(shared.take(&mut picture));
            if picture.samples < after {
                return;
            }
            if !is_taken {
                shared.publish(picture);
            }
            comes.store(false, Ordering::Relaxed);
            shared.post(other.clone());
            shared.post(first.clone());
        }
        sender.send(()).unwrap_or_default();
    };
    let mut shown = Picture::default();
    thread::scope(|scope| {
        shared.post(first.clone());
        scope.spawn(|| run(&shared, Duration::from_secs(1), &tell));
        while !shown.last && notes.recv_timeout(Duration::from_secs(20)).is_ok() {
            shared.take(&mut shown);
        }
        shared.end();
    });
    if shown.last {
        Ok(shown.samples)
    } else {
        Err("none is last".into())
    }
}
