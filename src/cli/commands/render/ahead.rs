//! Loads the next scene while one is rendered.

use crate::cli::{
    load::{self, Input},
    plan::{InputKind, InputPlan, Job},
};
use std::{
    fs::Metadata,
    path::PathBuf,
    thread::{self, Scope, ScopedJoinHandle},
    time::{Duration, Instant},
};

/// Larger mesh files, in bytes, are not loaded ahead, but with a progress bar.
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
            // If the system refuses the thread, the scene is loaded when its turn comes.
            let thread = thread::Builder::new();
            let loading = thread.spawn_scoped(self.scope, move || load(&job.input, memory));
            self.loading = loading.ok();
        }
    }

    /// The scene that was loaded ahead. `None` if none was, or if it failed or is incomplete: it is then loaded again, within
    /// the whole limit, and reports its errors and warnings in order.
    pub fn take(&mut self) -> Option<Ready> {
        // The thread has reported its panic.
        self.loading.take()?.join().ok()?
    }
}

fn load(plan: &InputPlan, memory: u64) -> Option<Ready> {
    let (mut files, start) = (Vec::new(), Instant::now());
    let input = load::load_and_list(plan, memory, &mut files).ok()?;
    // Images that do not fit are left out with a warning; later there may be enough memory.
    let is_whole = !input.notes.iter().any(|note| note.contains("memory"));
    is_whole.then(|| (input, files, start.elapsed()))
}

/// Whether a scene is a file (pipes are read only once) and not a large mesh.
fn is_small(plan: &InputPlan) -> bool {
    let is_small =
        |file: Metadata| file.is_file() && (plan.kind == InputKind::Scene || file.len() <= MOST_BYTES);
    plan.kind != InputKind::Any && plan.path.metadata().is_ok_and(is_small)
}
