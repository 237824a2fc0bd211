//! The files of a load, to be watched for changes.

use std::{
    collections::HashMap,
    fs::{self, Metadata},
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

/// All files that belong to a scene.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    /// Their paths; also of those that could not be read.
    pub files: Vec<PathBuf>,
    /// How they were when they were read.
    pub states: States,
}

/// How files were before they were opened; `None` if they were missing. All clones are one list.
#[derive(Clone, Debug, Default)]
pub struct States(Arc<Mutex<HashMap<PathBuf, Option<Metadata>>>>);

impl States {
    /// Notes how a file is, unless that was noted before.
    pub fn note(&self, path: &Path) {
        let mut states = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if !states.contains_key(path) {
            states.insert(path.to_owned(), fs::metadata(path).ok());
        }
    }

    /// Whether a file is other than it was noted.
    #[must_use]
    pub fn have_changed(&self) -> bool {
        let states = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        states.iter().any(|(path, before)| {
            let now = fs::metadata(path).ok();
            let of = |file: &Metadata| (file.len(), file.modified().ok());
            !is_same(before.as_ref(), now.as_ref()) || before.as_ref().map(of) != now.as_ref().map(of)
        })
    }
}

/// Whether a path leads to the same file or folder as before, or to none as before.
pub(super) fn is_same(before: Option<&Metadata>, now: Option<&Metadata>) -> bool {
    // Numbers of removed files are given again.
    let born = |file: &Metadata| file.created().ok();
    #[cfg(unix)]
    let number = |file: &Metadata| {
        use std::os::unix::fs::MetadataExt;
        (file.dev(), file.ino())
    };
    #[cfg(not(unix))]
    let number = |_: &Metadata| ();
    before.map(|file| (number(file), born(file))) == now.map(|file| (number(file), born(file)))
}

#[cfg(test)]
mod tests;
