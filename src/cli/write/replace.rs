//! Which files a call may replace: none that it reads and, under a name that the user did not type, only octray's own.

use super::mark::is_own;
use crate::{
    cli::{
        CliError,
        plan::{JsonTarget, is_standard_stream},
    },
    error::clip_path,
    scene::Scene,
};
use std::{
    collections::HashMap,
    fs::{self, Metadata},
    path::{Path, PathBuf},
};

/// A file, whatever it is called.
#[cfg(unix)]
pub type Identity = (u64, u64);
#[cfg(not(unix))]
pub type Identity = PathBuf;

/// The regular file at `path`, whose metadata are `found`. Links are followed.
pub fn identity(path: &Path, found: &Metadata) -> Option<Identity> {
    if !found.is_file() {
        return None;
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let _ = path;
        Some((found.dev(), found.ino()))
    }
    #[cfg(not(unix))]
    fs::canonicalize(path).ok()
}

/// The files that a call reads, which it does not replace.
#[derive(Clone, Debug, Default)]
pub struct Inputs(HashMap<Identity, (PathBuf, String)>);

impl Inputs {
    /// Adds a file, called `role` in messages.
    pub fn add(&mut self, path: &Path, role: &str) {
        // Standard input may be a file, too.
        let path = if is_standard_stream(path) && cfg!(unix) {
            Path::new("/dev/stdin")
        } else {
            path
        };
        let file = fs::metadata(path).ok().and_then(|found| identity(path, &found));
        if let Some(file) = file {
            self.0
                .entry(file)
                .or_insert_with(|| (path.to_owned(), role.to_owned()));
        }
    }

    /// Adds the files that a scene was loaded from, and its textures.
    pub fn add_scene<'a>(
        &mut self,
        path: &Path,
        files: impl IntoIterator<Item = &'a PathBuf>,
        scene: Option<&'a Scene>,
    ) {
        let role = format!("a file of {}", clip_path(path));
        let textures = scene.into_iter().flat_map(|scene| &scene.sources().textures);
        for file in files.into_iter().chain(textures) {
            self.add(file, &role);
        }
    }

    /// Why nothing can be written to `name`, which now is the file `found`.
    pub fn objection(&self, name: &str, found: &Identity) -> Option<String> {
        let (path, role) = self.0.get(found)?;
        let path = clip_path(path);
        let path = if path == name {
            String::new()
        } else {
            format!(", {path}")
        };
        Some(format!(
            "{name} would replace {role}{path}; write to another file"
        ))
    }

    /// Refuses a file of JSON that would replace one of these.
    ///
    /// # Errors
    /// [`CliError::Usage`].
    pub fn check_json(&self, target: Option<&JsonTarget>) -> Result<(), CliError> {
        let Some(JsonTarget::File(path)) = target else {
            return Ok(());
        };
        let found = fs::metadata(path).ok();
        let found = found.and_then(|found| identity(path, &found));
        match found.and_then(|found| self.objection(&clip_path(path), &found)) {
            Some(objection) => Err(CliError::Usage(objection)),
            None => Ok(()),
        }
    }
}

/// Whether a file exists that octray did not write, judging by its first and last bytes.
pub fn is_foreign(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| found.is_file()) && !is_own(path)
}
