//! Loading and building, with their progress on a terminal.

use crate::{
    accel::{BuildQuality, Bvh},
    cli::{
        CliError,
        load::{self, Input},
        plan::{InputKind, InputPlan},
        report::StageBar,
    },
    error::clip_path,
    format::Limits,
    scene::Scene,
};
use std::{path::PathBuf, sync::Arc};

/// [`load::load_and_list`] with a progress bar, if `visible`.
///
/// # Errors
/// [`CliError`].
pub fn load(
    plan: &InputPlan,
    memory: u64,
    files: &mut Vec<PathBuf>,
    visible: bool,
) -> Result<Input, CliError> {
    let bar = Arc::new(StageBar::new(visible, reading(plan), bytes_of(plan)));
    let [read, parsed] = [&bar, &bar].map(Arc::clone);
    let limits = Limits {
        memory,
        on_read: Some(Arc::new(move |bytes| read.add(bytes as u64))),
        on_parsed: Some(Arc::new(move |done, total| {
            parsed.show(done as u64, total as u64);
        })),
        on_open: None,
    };
    bar.during(|| load::load_and_list(plan, limits, files))
}

/// Shows that a scene is loaded, if `visible`, while this waits for it.
pub fn waiting<T>(plan: &InputPlan, visible: bool, wait: impl FnOnce() -> T) -> T {
    StageBar::new(visible, reading(plan), 0).during(wait)
}

/// The text of the progress bar while this is loaded.
pub fn reading(plan: &InputPlan) -> String {
    format!("loading {}", clip_path(plan.name()))
}

/// The number of bytes to read; 0 if unknown, as for the meshes of a scene.
pub fn bytes_of(plan: &InputPlan) -> u64 {
    match plan.kind {
        InputKind::Mesh => plan.path.metadata().map_or(0, |file| file.len()),
        _ => 0,
    }
}

/// [`Bvh::build_with`] with a progress bar, if `visible`.
pub fn build(scene: &Scene, quality: BuildQuality, visible: bool) -> Bvh {
    let bar = StageBar::new(visible, "building", 0);
    bar.during(|| {
        Bvh::build_watched(scene, quality, &|progress| {
            bar.show(progress.done, progress.total);
        })
    })
}
