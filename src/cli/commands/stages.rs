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

/// Does what [`load::load_and_list`] does; a bar shows how much is read, if `visible`.
///
/// # Errors
/// [`CliError`].
pub fn load(
    plan: &InputPlan,
    memory: u64,
    files: &mut Vec<PathBuf>,
    visible: bool,
) -> Result<Input, CliError> {
    let path = plan.name();
    // What the meshes of a scene have is not known yet.
    let bytes = match plan.kind {
        InputKind::Mesh => plan.path.metadata().map_or(0, |file| file.len()),
        _ => 0,
    };
    let bar = Arc::new(StageBar::new(
        visible,
        format!("loading {}", clip_path(path)),
        bytes,
    ));
    let read = Arc::clone(&bar);
    let limits = Limits {
        memory,
        on_read: Some(Arc::new(move |bytes| read.add(bytes as u64))),
    };
    let input = load::load_and_list(plan, limits, files);
    bar.clear();
    input
}

/// Does what [`Bvh::build_with`] does; a bar shows how far it is, if `visible`.
pub fn build(scene: &Scene, quality: BuildQuality, visible: bool) -> Bvh {
    let bar = StageBar::new(visible, "building", 0);
    let bvh = Bvh::build_watched(scene, quality, &|progress| {
        bar.show(progress.done, progress.total);
    });
    bar.clear();
    bvh
}
