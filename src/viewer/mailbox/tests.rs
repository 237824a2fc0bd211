use super::*;
use crate::{
    accel::Bvh,
    scene::SceneBuilder,
    viewer::{
        request::Look,
        timeline::{Model, Timeline},
    },
};
use std::{sync::Arc, thread};

fn timeline() -> Arc<Timeline> {
    let scene = SceneBuilder::new().finish();
    let bvh = Bvh::build(&scene);
    Arc::new(Timeline::new(Model::new(scene, bvh)))
}

/// The worker's picture for the next request.
fn answer(shared: &Shared) -> Picture {
    let Job { request, generation } = shared.next(Some(Duration::ZERO)).unwrap();
    Picture {
        generation,
        size: request.size,
        last: true,
        ..Picture::default()
    }
}

#[test]
fn only_the_latest_request_counts() {
    let (shared, timeline) = (Shared::default(), timeline());
    for view in [1, 2, 3] {
        shared.post(Request::of_view(&timeline, view));
    }
    let next = shared.next(None).unwrap();
    assert_eq!(next.request.pose, Request::of_view(&timeline, 3).pose);
    assert!(!shared.changed_since(next.generation) && !shared.rays_changed_since(next.generation));
    assert!(shared.next(Some(Duration::ZERO)).is_none());
    // The same picture again starts no generation: tracing goes on.
    shared.post(Request::of_view(&timeline, 3));
    assert!(!shared.changed_since(next.generation));
    assert_eq!(shared.next(None).unwrap().generation, next.generation);
}

#[test]
fn results_of_older_requests_are_dropped() {
    let (shared, first) = (Shared::default(), timeline());
    let changes: [fn(&mut Request); 4] = [
        |request| request.timeline = timeline(),
        |request| request.style.look = Look::Normals,
        |request| request.style.brute = true,
        |request| request.style.settings.max_depth = 1,
    ];
    let mut shown = Picture::default();
    for change in changes {
        shared.post(Request::of_view(&first, 1));
        // Finished just before the request changes, or just after.
        for publish_first in [true, false] {
            shared.post(Request::of_view(&first, 1));
            let old = answer(&shared);
            let old_generation = old.generation;
            let mut other = Request::of_view(&first, 1);
            change(&mut other);
            let mut old = Some(old);
            if publish_first {
                shared.publish(old.take().unwrap());
            }
            shared.post(other);
            if let Some(old) = old {
                shared.publish(old);
            }
            assert!(shared.changed_since(old_generation) && shared.rays_changed_since(old_generation));
            assert!(!shared.take(&mut shown));
            let new = answer(&shared);
            assert!(new.generation > old_generation);
            shared.publish(new);
            assert!(shared.take(&mut shown) && shown.last && shown.generation > old_generation);
            // Nothing is taken twice.
            assert!(!shared.take(&mut shown));
        }
    }
}

#[test]
fn an_older_pose_is_shown_but_is_not_final() {
    let (shared, timeline) = (Shared::default(), timeline());
    let mut shown = Picture::default();
    shared.post(Request::of_view(&timeline, 1));
    let old = answer(&shared);
    let generation = old.generation;
    shared.post(Request::of_view(&timeline, 2));
    assert!(shared.changed_since(generation) && !shared.rays_changed_since(generation));
    shared.publish(old);
    assert!(shared.take(&mut shown) && !shown.last);
    shared.publish(answer(&shared));
    assert!(shared.take(&mut shown) && shown.last);
}

#[test]
fn the_end_wakes_the_worker() {
    let (shared, timeline) = (Shared::default(), timeline());
    thread::scope(|scope| {
        let waiting = scope.spawn(|| shared.next(None).is_none());
        shared.end();
        assert!(waiting.join().unwrap());
    });
    assert!(shared.has_ended() && shared.changed_since(0) && shared.rays_changed_since(u64::MAX - 1));
    // Later requests do not undo it.
    shared.post(Request::of_view(&timeline, 1));
    assert!(shared.has_ended());
}
