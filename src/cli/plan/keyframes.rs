//! The frames of animated scenes and meshes. Their number is found before anything is rendered, because pictures are named then.

use super::{FrameRange, InputKind, Turntable, is_standard_stream, kind_of, render::MOST_PICTURES};
use crate::{
    cli::CliError,
    error::{LoadError, LoadErrorKind, clip_path},
    format::{
        self,
        mesh::{self, MeshAnimation, Moment},
    },
};
use std::path::{Path, PathBuf};

/// The error about the animation of a mesh from standard input.
pub const NOT_PLAYED_FROM_STANDARD_INPUT: &str =
    "animations of meshes are played from files, not from standard input";
/// The most poses that a camera is placed for.
const MOST_POSES: u32 = 32;

/// The frames of one scene.
#[derive(Clone, Debug)]
pub struct Keyframes {
    pub frames: Turntable,
    /// How an animation of a mesh is played.
    pub playback: Option<Playback>,
}

/// An animation of a file from its beginning to its end.
#[derive(Clone, Debug)]
pub struct Playback {
    /// Its name or number.
    animation: Option<String>,
    /// All frames.
    count: u32,
    fps: u32,
}

/// How animations of meshes would be played.
#[derive(Clone, Copy, Debug)]
pub struct Playing<'a> {
    /// The name or number of the animation; the first one if `None`.
    pub animation: Option<&'a str>,
    /// Whether that comes from the config file, for meshes that have animations.
    pub is_default: bool,
    /// Frames per second.
    pub fps: u32,
    /// What loading a mesh may take, bytes.
    pub memory: u64,
}

impl Playback {
    /// What a frame, from 1 on, shows.
    pub fn moment(&self, frame: u32) -> Moment {
        Moment {
            animation: self.animation.clone(),
            seconds: f64::from(frame - 1) / f64::from(self.fps),
        }
    }

    /// All frames.
    #[cfg(feature = "viewer")]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Frames that are spread over all of them, at most 32.
    pub fn some_frames(&self) -> impl Iterator<Item = u32> {
        let (count, poses) = (u64::from(self.count), u64::from(self.count.min(MOST_POSES)));
        (0..poses).map(move |i| (i * count / poses) as u32 + 1)
    }
}

/// The frames of each scene, one for static scenes; empty if no scene moves. Meshes move if there is `playing`. To `keep_going`
/// a scene that cannot be read counts as static.
///
/// Standard input is read later, so its frames are those of `frames`.
///
/// # Errors
/// [`CliError::Load`] for a scene that cannot be read.
pub fn keyframes(
    scenes: &[PathBuf],
    frames: Option<FrameRange>,
    playing: Option<Playing<'_>>,
    keep_going: bool,
) -> Result<Vec<Keyframes>, CliError> {
    let mut found = Vec::new();
    for scene in scenes {
        match frames_of(scene, frames.map(|frames| frames.last), playing) {
            Err(CliError::Load(_)) if keep_going => found.push((None, None)),
            of_scene => found.push(of_scene?),
        }
    }
    if found.iter().all(|(count, _)| count.is_none()) {
        return Ok(Vec::new());
    }
    let of_one = |(count, playback): (Option<u32>, Option<Playback>)| Keyframes {
        frames: Turntable {
            count: count.unwrap_or(1),
            frames,
        },
        playback,
    };
    Ok(found.into_iter().map(of_one).collect())
}

/// How many frames a scene has, if it moves, and how they are played. `last` is the last one that is asked for.
fn frames_of(
    scene: &Path,
    last: Option<u32>,
    playing: Option<Playing<'_>>,
) -> Result<(Option<u32>, Option<Playback>), CliError> {
    if is_standard_stream(scene) {
        return Ok((last, None));
    }
    match (kind_of(scene), playing) {
        (Ok(InputKind::Scene), _) => Ok((format::frames(scene)?, None)),
        (Ok(InputKind::Mesh), Some(playing)) => {
            let playback = playback_of(scene, playing, last)?;
            Ok((playback.as_ref().map(|playback| playback.count), playback))
        }
        _ => Ok((None, None)),
    }
}

/// How a mesh is played; `None` without animations. If its file does not say how long the animation is, the `last` frame is.
///
/// # Errors
/// [`CliError`] if it cannot be read, or has too many frames.
pub fn playback_of(
    path: &Path,
    playing: Playing<'_>,
    last: Option<u32>,
) -> Result<Option<Playback>, CliError> {
    let Playing {
        animation,
        is_default,
        fps,
        memory,
    } = playing;
    let animations = mesh::animations(path, memory)?;
    if animations.is_empty() && (animation.is_none() || is_default) {
        return Ok(None);
    }
    let refused = |why: String| LoadError::whole_file(path, why).with_kind(LoadErrorKind::Absent);
    let chosen = MeshAnimation::find(&animations, animation).map_err(refused)?;
    let refused = |why: String| CliError::Usage(format!("{}: {why}", clip_path(path)));
    let frames = |seconds: f64| (seconds * f64::from(fps)).round().max(1.0);
    let length = animations.get(chosen).and_then(|animation| animation.seconds);
    let count = match length.map(frames) {
        Some(count) if count > MOST_PICTURES as f64 => {
            return Err(refused(format!(
                "its animation has {count} frames, {fps} for each second, expected at most {MOST_PICTURES}: lower --fps"
            )));
        }
        Some(count) => count as u32,
        None => last.ok_or_else(|| {
            let why = "the file does not say how long its animation is: ask for frames with --frames";
            refused(why.into())
        })?,
    };
    Ok(Some(Playback {
        animation: animation.map(str::to_owned),
        count,
        fps,
    }))
}

#[cfg(test)]
mod tests;
