//! What the window wants and what the worker has made, one of each: the latest.

use super::look::Wanted;
use std::{
    sync::{
        Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
    time::Duration,
};

/// A finished picture in pixels of the window.
#[derive(Debug, Default)]
pub struct Picture {
    /// 0RGB, row by row.
    pub pixels: Vec<u32>,
    /// The wish that it answers.
    pub epoch: u64,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Pixels that were traced, across and down.
    pub traced: [u32; 2],
    /// Samples of each.
    pub samples: u32,
    /// Whether every pixel of the window was traced.
    pub full: bool,
    /// Whether it is all that there will be: nothing moves, and all samples are in.
    pub last: bool,
    /// Whether the BVH stood in for brute force.
    pub stand_in: bool,
    /// Rays of all kinds.
    pub rays: u64,
    /// Tracing and shading alone.
    pub elapsed: Duration,
    /// Whether this was traced in packets, ray by ray, or by neither in particular.
    pub packets: Option<bool>,
}

/// The epoch in which everything ends.
const END: u64 = u64::MAX;

/// What the window and the worker share.
#[derive(Debug, Default)]
pub struct Shared {
    inbox: Mutex<Inbox>,
    arrived: Condvar,
    /// Counts wishes for other pictures.
    epoch: AtomicU64,
    /// The epoch of the last wish for more than another pose or size.
    turn: AtomicU64,
    done: Mutex<Done>,
}

#[derive(Debug, Default)]
struct Inbox {
    next: Option<Wish>,
    latest: Option<Wanted>,
}

/// What is wanted, and the epoch that it begins.
#[derive(Clone, Debug)]
pub struct Wish {
    /// What is wanted.
    pub wanted: Wanted,
    /// Counts up with every wish for another picture.
    pub epoch: u64,
}

#[derive(Debug, Default)]
struct Done {
    picture: Option<Picture>,
    /// Memory of older pictures.
    spare: Vec<u32>,
}

/// What is left by a panicked thread is as good as any other state here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Asks for a picture, instead of all that was asked for before.
    pub fn post(&self, wanted: Wanted) {
        let mut inbox = lock(&self.inbox);
        if self.has_ended() {
            return;
        }
        let mut epoch = self.epoch.load(Ordering::Relaxed);
        let latest = inbox.latest.as_ref();
        if !latest.is_some_and(|latest| latest.same_picture(&wanted)) {
            epoch += 1;
            self.epoch.store(epoch, Ordering::Relaxed);
            if !latest.is_some_and(|latest| latest.same_rays(&wanted)) {
                self.turn.store(epoch, Ordering::Relaxed);
            }
        }
        inbox.latest = Some(wanted.clone());
        inbox.next = Some(Wish { wanted, epoch });
        self.arrived.notify_one();
    }

    /// Ends the worker, soon.
    pub fn end(&self) {
        let _inbox = lock(&self.inbox);
        self.epoch.store(END, Ordering::Relaxed);
        self.arrived.notify_one();
    }

    /// The newest picture, if there is one that has not been taken yet; `old` is given back for its memory. A picture of
    /// another scene, or by other rays, than wished for by now is none; an older pose's is, so that a camera that moves on
    /// and on is seen to move.
    pub fn take(&self, old: &mut Picture) -> bool {
        let mut done = lock(&self.done);
        let Some(mut picture) = done.picture.take() else {
            return false;
        };
        if self.has_turned(picture.epoch) {
            done.spare = picture.pixels;
            return false;
        }
        picture.last &= !self.is_over(picture.epoch);
        done.spare = std::mem::replace(old, picture).pixels;
        true
    }

    /// Hands a picture to the window, instead of one that it has not taken yet.
    pub fn publish(&self, picture: Picture) {
        lock(&self.done).picture = Some(picture);
    }

    /// Memory of an older picture.
    pub fn spare(&self) -> Vec<u32> {
        std::mem::take(&mut lock(&self.done).spare)
    }

    /// Whether [`Self::end`] was called.
    pub fn has_ended(&self) -> bool {
        self.epoch.load(Ordering::Relaxed) == END
    }

    /// Whether another picture is wanted by now.
    pub fn is_over(&self, epoch: u64) -> bool {
        self.epoch.load(Ordering::Relaxed) != epoch
    }

    /// Whether a picture of another scene, or by other rays, is.
    pub fn has_turned(&self, epoch: u64) -> bool {
        self.turn.load(Ordering::Relaxed) > epoch || self.has_ended()
    }

    /// The next wish. Waits for it for as long as `patience`, or for ever.
    pub fn next(&self, patience: Option<Duration>) -> Option<Wish> {
        let inbox = lock(&self.inbox);
        let is_quiet = |inbox: &mut Inbox| inbox.next.is_none() && !self.has_ended();
        let mut inbox = match patience {
            None => self
                .arrived
                .wait_while(inbox, is_quiet)
                .unwrap_or_else(PoisonError::into_inner),
            Some(patience) => {
                self.arrived
                    .wait_timeout_while(inbox, patience, is_quiet)
                    .unwrap_or_else(PoisonError::into_inner)
                    .0
            }
        };
        inbox.next.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        accel::Bvh,
        render::Settings,
        scene::SceneBuilder,
        viewer::{
            look::{Boxes, Look, Model, Style},
            orbit::Pose,
        },
    };
    use std::{sync::Arc, thread};

    fn model() -> Arc<Model> {
        let scene = SceneBuilder::new().finish();
        let bvh = Bvh::build(&scene);
        Arc::new(Model { scene, bvh })
    }

    fn wish(model: &Arc<Model>, view: u32) -> Wanted {
        let pose = Pose::classic_view(view).unwrap();
        Wanted {
            model: Arc::clone(model),
            pose,
            camera: pose.camera().unwrap(),
            style: Style {
                look: Look::Full,
                brute: false,
                antialias: true,
                boxes: Boxes::Hidden,
                settings: Settings::default(),
            },
            size: [64, 48],
        }
    }

    /// What the worker makes of the next wish.
    fn answer(shared: &Shared) -> Picture {
        let Wish { wanted, epoch } = shared.next(Some(Duration::ZERO)).unwrap();
        Picture {
            epoch,
            size: wanted.size,
            last: true,
            ..Picture::default()
        }
    }

    #[test]
    fn the_latest_wish_is_the_only_one() {
        let (shared, model) = (Shared::default(), model());
        for view in [1, 2, 3] {
            shared.post(wish(&model, view));
        }
        let next = shared.next(None).unwrap();
        assert_eq!(next.wanted.pose, wish(&model, 3).pose);
        assert!(!shared.is_over(next.epoch) && !shared.has_turned(next.epoch));
        assert!(shared.next(Some(Duration::ZERO)).is_none());
        // The same picture again is no other epoch: what is under way for it goes on.
        shared.post(wish(&model, 3));
        assert!(!shared.is_over(next.epoch));
        assert_eq!(shared.next(None).unwrap().epoch, next.epoch);
    }

    #[test]
    fn an_older_result_never_replaces_a_newer_wish() {
        let (shared, first) = (Shared::default(), model());
        let changes: [fn(&mut Wanted); 4] = [
            |wanted| wanted.model = model(),
            |wanted| wanted.style.look = Look::Normals,
            |wanted| wanted.style.brute = true,
            |wanted| wanted.style.settings.max_depth = 1,
        ];
        let mut shown = Picture::default();
        for change in changes {
            shared.post(wish(&first, 1));
            // Finished just before the wish changes, or just after.
            for publish_first in [true, false] {
                shared.post(wish(&first, 1));
                let old = answer(&shared);
                let old_epoch = old.epoch;
                let mut other = wish(&first, 1);
                change(&mut other);
                let mut old = Some(old);
                if publish_first {
                    shared.publish(old.take().unwrap());
                }
                shared.post(other);
                if let Some(old) = old {
                    shared.publish(old);
                }
                assert!(shared.is_over(old_epoch) && shared.has_turned(old_epoch));
                assert!(!shared.take(&mut shown));
                let new = answer(&shared);
                assert!(new.epoch > old_epoch);
                shared.publish(new);
                assert!(shared.take(&mut shown) && shown.last && shown.epoch > old_epoch);
                // And nothing is taken twice.
                assert!(!shared.take(&mut shown));
            }
        }
    }

    #[test]
    fn an_older_pose_is_shown_but_is_not_the_last() {
        let (shared, model) = (Shared::default(), model());
        let mut shown = Picture::default();
        shared.post(wish(&model, 1));
        let old = answer(&shared);
        let epoch = old.epoch;
        shared.post(wish(&model, 2));
        assert!(shared.is_over(epoch) && !shared.has_turned(epoch));
        shared.publish(old);
        assert!(shared.take(&mut shown) && !shown.last);
        shared.publish(answer(&shared));
        assert!(shared.take(&mut shown) && shown.last);
    }

    #[test]
    fn the_end_wakes_who_waits() {
        let (shared, model) = (Shared::default(), model());
        thread::scope(|scope| {
            let waiting = scope.spawn(|| shared.next(None).is_none());
            shared.end();
            assert!(waiting.join().unwrap());
        });
        assert!(shared.has_ended() && shared.is_over(0) && shared.has_turned(u64::MAX - 1));
        // What is wished for afterwards does not take it back.
        shared.post(wish(&model, 1));
        assert!(shared.has_ended());
    }
}
