//! The latest request of the window and the latest picture of the worker.

use super::request::Request;
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
    /// The generation of the request that it answers.
    pub generation: u64,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// The frame of the scene, and how many there are.
    pub frame: [u32; 2],
    /// Pixels that were traced, across and down.
    pub traced: [u32; 2],
    /// Samples a pixel.
    pub samples: u32,
    /// Whether pixels that look like their neighbours have fewer.
    pub adaptive: bool,
    /// Whether every pixel of the window was traced.
    pub full: bool,
    /// Whether it is final: nothing moves, and all samples are in.
    pub last: bool,
    /// Whether the BVH was used instead of brute force.
    pub stand_in: bool,
    /// Rays of all kinds.
    pub rays: u64,
    /// The time of tracing and shading only.
    pub elapsed: Duration,
    /// Whether it was traced in packets or as single rays; `None` for brute force and cost.
    pub packets: Option<bool>,
}

/// The generation after [`Shared::end`].
const END: u64 = u64::MAX;

/// The shared state of the window and the worker.
#[derive(Debug, Default)]
pub struct Shared {
    inbox: Mutex<Inbox>,
    arrived: Condvar,
    /// Counts requests for different pictures.
    generation: AtomicU64,
    /// The last generation that changed more than pose and size.
    rays_changed: AtomicU64,
    done: Mutex<Done>,
}

#[derive(Debug, Default)]
struct Inbox {
    next: Option<Job>,
    latest: Option<Request>,
}

/// A request and its generation.
#[derive(Clone, Debug)]
pub struct Job {
    /// What to show.
    pub request: Request,
    /// Counts up with every request for a different picture.
    pub generation: u64,
}

#[derive(Debug, Default)]
struct Done {
    picture: Option<Picture>,
    /// Memory of older pictures, for reuse.
    spare: Vec<u32>,
}

/// Locks, also after a panic: every state is valid here.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shared {
    /// Requests a picture. Replaces earlier requests.
    pub fn post(&self, request: Request) {
        let mut inbox = lock(&self.inbox);
        if self.has_ended() {
            return;
        }
        let mut generation = self.generation.load(Ordering::Relaxed);
        let latest = inbox.latest.as_ref();
        if !latest.is_some_and(|latest| latest.same_picture(&request)) {
            generation += 1;
            self.generation.store(generation, Ordering::Relaxed);
            if !latest.is_some_and(|latest| latest.same_rays(&request)) {
                self.rays_changed.store(generation, Ordering::Relaxed);
            }
        }
        inbox.latest = Some(request.clone());
        inbox.next = Some(Job { request, generation });
        self.arrived.notify_one();
    }

    /// Tells the worker to end.
    pub fn end(&self) {
        let _inbox = lock(&self.inbox);
        self.generation.store(END, Ordering::Relaxed);
        self.arrived.notify_one();
    }

    /// Replaces `old` by the newest picture; false if there is no new one. Pictures of another scene or
    /// by other rays than requested are dropped. Those of an older pose are shown, so that a moving camera is seen to
    /// move.
    pub fn take(&self, old: &mut Picture) -> bool {
        let mut done = lock(&self.done);
        let Some(mut picture) = done.picture.take() else {
            return false;
        };
        if self.rays_changed_since(picture.generation) {
            done.spare = picture.pixels;
            return false;
        }
        picture.last &= !self.changed_since(picture.generation);
        done.spare = std::mem::replace(old, picture).pixels;
        true
    }

    /// Passes a picture to the window. Replaces one that was not taken yet.
    pub fn publish(&self, picture: Picture) {
        lock(&self.done).picture = Some(picture);
    }

    /// Returns the memory of an older picture.
    pub fn spare(&self) -> Vec<u32> {
        std::mem::take(&mut lock(&self.done).spare)
    }

    /// Whether [`Self::end`] was called.
    pub fn has_ended(&self) -> bool {
        self.generation.load(Ordering::Relaxed) == END
    }

    /// Whether another picture is requested by now.
    pub fn changed_since(&self, generation: u64) -> bool {
        self.generation.load(Ordering::Relaxed) != generation
    }

    /// Whether a picture of another scene or by other rays is requested by now.
    pub fn rays_changed_since(&self, generation: u64) -> bool {
        self.rays_changed.load(Ordering::Relaxed) > generation || self.has_ended()
    }

    /// Waits for the next request, at most for `timeout` if there is one.
    pub fn next(&self, timeout: Option<Duration>) -> Option<Job> {
        let inbox = lock(&self.inbox);
        let is_quiet = |inbox: &mut Inbox| inbox.next.is_none() && !self.has_ended();
        let mut inbox = match timeout {
            None => self
                .arrived
                .wait_while(inbox, is_quiet)
                .unwrap_or_else(PoisonError::into_inner),
            Some(timeout) => {
                self.arrived
                    .wait_timeout_while(inbox, timeout, is_quiet)
                    .unwrap_or_else(PoisonError::into_inner)
                    .0
            }
        };
        inbox.next.take()
    }
}

#[cfg(test)]
mod tests;
