//! Progress of a build.

use super::tree::subtree_size;
use crate::scene::Scene;
use std::sync::atomic::{AtomicU64, Ordering};

/// The progress of a build.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildProgress {
    /// Steps done, of about equal time.
    pub done: u64,
    /// Total number of steps, an estimate.
    pub total: u64,
}

/// Called by the threads that build, every few thousand primitives.
pub type OnBuild<'a> = &'a (dyn Fn(BuildProgress) + Sync);

/// Finding the boxes of primitives, building a subtree and writing it each take about as long as this many divisions.
const DIVISIONS: usize = 6;

/// Counts the steps of a build: a primitive in a division.
pub(super) struct Steps<'a> {
    on_build: OnBuild<'a>,
    done: AtomicU64,
    total: u64,
}

impl<'a> Steps<'a> {
    pub(super) fn of(scene: &Scene, on_build: OnBuild<'a>) -> Self {
        let (primitives, instances) = (scene.primitive_count(), scene.instances().len());
        let divisions = |count: usize| (count / subtree_size(count)).max(1).ilog2() as usize;
        let total = primitives * (divisions(primitives) + 3 * DIVISIONS)
            + instances * (divisions(instances) + DIVISIONS);
        Self {
            on_build,
            done: AtomicU64::new(0),
            total: total as u64,
        }
    }

    /// A set of `count` primitives is divided.
    pub(super) fn divided(&self, count: usize) {
        let count = count as u64;
        let done = self.done.fetch_add(count, Ordering::Relaxed) + count;
        let total = self.total;
        let done = done.min(total);
        (self.on_build)(BuildProgress { done, total });
    }

    /// Boxes of `count` primitives are found, or a subtree of them is built or written.
    pub(super) fn finished(&self, count: usize) {
        self.divided(DIVISIONS * count);
    }
}
