//! Labels of the pictures on a contact sheet.

use crate::cli::plan::{Frame, RenderPlan};
use std::{
    collections::HashSet,
    ffi::{OsStr, OsString},
    path::Path,
};

/// File names that several files of the call have.
pub(super) struct Labels(HashSet<OsString>);

impl Labels {
    pub(super) fn new(plan: &RenderPlan) -> Self {
        let (mut known, mut alike) = (HashSet::new(), HashSet::new());
        let paths: HashSet<&Path> = plan.jobs.iter().map(|job| &*job.input.path).collect();
        for name in paths.into_iter().map(file_name) {
            if !known.insert(name) {
                alike.insert(name.into());
            }
        }
        Self(alike)
    }

    /// A scene's file name, with its folder if the name is ambiguous, and the number of a frame.
    pub(super) fn of(&self, scene: &Path, frame: &Frame) -> String {
        let mut name = file_name(scene).to_string_lossy().into_owned();
        let folder = scene.parent().and_then(Path::file_name);
        if let Some(folder) = folder.filter(|_| self.0.contains(file_name(scene))) {
            name = format!("{}/{name}", folder.to_string_lossy());
        }
        match frame.turn {
            Some(turn) => format!("{name} {}", turn.number),
            None => name,
        }
    }
}

fn file_name(path: &Path) -> &OsStr {
    path.file_name().unwrap_or(path.as_os_str())
}
