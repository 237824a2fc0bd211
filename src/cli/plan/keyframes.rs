//! The frames of animated scenes. Their number is found before anything is loaded, because pictures are named then.

use super::{FrameRange, InputKind, Turntable, is_standard_input, kind_of};
use crate::{cli::CliError, format};
use std::path::PathBuf;

/// The frames of each scene, one for static scenes; empty if no scene moves.
///
/// Standard input is read later, so its frames are those of `frames`.
///
/// # Errors
/// [`CliError::Load`] for a scene that cannot be read.
pub fn keyframes(scenes: &[PathBuf], frames: Option<FrameRange>) -> Result<Vec<Turntable>, CliError> {
    let mut counts = Vec::new();
    for scene in scenes {
        counts.push(if is_standard_input(scene) {
            frames.map(|frames| frames.last)
        } else if kind_of(scene).is_ok_and(|kind| kind == InputKind::Scene) {
            format::frames(scene)?
        } else {
            None
        });
    }
    if counts.iter().all(Option::is_none) {
        return Ok(Vec::new());
    }
    let of_one = |count: Option<u32>| Turntable {
        count: count.unwrap_or(1),
        frames,
    };
    Ok(counts.into_iter().map(of_one).collect())
}
