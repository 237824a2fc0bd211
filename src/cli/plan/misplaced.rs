//! Scenes that are missing because they are something else: a part of a name with spaces, or the picture to write.

use super::{is_standard_stream, kind_of};
use crate::{
    cli::{CliError, write::Format},
    error::clip_path,
};
use std::{
    ffi::OsString,
    path::{Path, PathBuf},
};

/// How many words of a name are joined.
const MOST_WORDS: usize = 8;

/// Refuses scenes of a call that are no scenes, with what was meant. `is_named` says that the call names its picture.
///
/// # Errors
/// [`CliError::Failed`].
pub(super) fn check(scenes: &[PathBuf], is_named: bool) -> Result<(), CliError> {
    let is_missing = |scene: &&PathBuf| !is_standard_stream(scene) && !scene.exists();
    if scenes.len() < 2 {
        return Ok(());
    }
    if let Some(missing) = scenes.iter().find(is_missing)
        && let Some(whole) = joined(scenes)
    {
        let (missing, whole) = (clip_path(missing), clip_path(&whole));
        return Err(CliError::Failed(format!(
            "{missing}: file not found; put quotes around a name with spaces: \"{whole}\""
        )));
    }
    let is_picture = |scene: &&PathBuf| scene.extension().and_then(Format::from_extension).is_some();
    // A picture that the call names already is not this one.
    let Some(picture) = scenes.iter().find(is_picture).filter(|_| !is_named) else {
        return Ok(());
    };
    let why = if picture.exists() {
        match kind_of(picture) {
            Err(error) => error.text().unwrap_or_default(),
            Ok(_) => return Ok(()),
        }
    } else {
        format!("{}: file not found", clip_path(picture))
    };
    Err(CliError::Failed(format!(
        "{why}; to write it, use -o {}",
        clip_path(picture)
    )))
}

/// The first file whose name, cut at its spaces, is a run of these words.
fn joined(words: &[PathBuf]) -> Option<PathBuf> {
    let runs = (0..words.len())
        .flat_map(|start| (start + 2..=words.len().min(start + MOST_WORDS)).map(move |end| start..end));
    let names = runs.take(1 << 12).filter_map(|run| {
        let words: Vec<OsString> = words.get(run)?.iter().map(|word| word.clone().into()).collect();
        Some(PathBuf::from(words.join(" ".as_ref())))
    });
    names.into_iter().find(|name| Path::is_file(name))
}
