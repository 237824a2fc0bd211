//! The next scene is loaded while the one before is rendered.

use crate::cli::{
    load::{self, Input},
    plan::{InputKind, InputPlan, Job},
};
use std::{
    path::PathBuf,
    thread::{Scope, ScopedJoinHandle},
    time::{Duration, Instant},
};

/// Larger mesh files are loaded when their turn comes, with a bar that shows how far they are, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// A scene that was loaded, the files that were opened, and how long it took.
pub type Ready = (Input, Vec<PathBuf>, Duration);

/// Loads one scene ahead.
pub struct Ahead<'scope, 'env> {
    scope: &'scope Scope<'scope, 'env>,
    loading: Option<ScopedJoinHandle<'scope, Option<Ready>>>,
}

impl<'scope, 'env> Ahead<'scope, 'env> {
    pub fn new(scope: &'scope Scope<'scope, 'env>) -> Self {
        Self { scope, loading: None }
    }

    /// Begins to load the scene of a job within `memory` bytes.
    pub fn start(&mut self, job: Option<&'env Job>, memory: u64) {
        if let Some(job) = job.filter(|job| is_small(&job.input)) {
            self.loading = Some(self.scope.spawn(move || load(&job.input, memory)));
        }
    }

    /// The scene that was begun. `None` if none was, or if it failed: then it is loaded again, with all the memory there
    /// is and an error in its turn.
    pub fn take(&mut self) -> Option<Ready> {
        // A panic has been told by its thread.
        self.loading.take()?.join().ok()?
    }
}

fn load(plan: &InputPlan, memory: u64) -> Option<Ready> {
    let (mut files, start) = (Vec::new(), Instant::now());
    let input = load::load_and_list(plan, memory, &mut files).ok()?;
    Some((input, files, start.elapsed()))
}

/// Whether a scene is not standard input, which is read once, or a large mesh.
fn is_small(plan: &InputPlan) -> bool {
    match plan.kind {
        InputKind::Scene => true,
        InputKind::Mesh => plan.path.metadata().is_ok_and(|file| file.len() <= MOST_BYTES),
        InputKind::Any => false,
    }
}
