//! Checks that no two pictures of a call have the same file.

use super::{
    Poses, Turn,
    input::is_standard_stream,
    names::{Origin, folder, numbered, pattern_per_pose},
};
use crate::{
    cli::{CliError, write::Output},
    error::{clip, clip_path},
    format,
};
use std::{
    collections::{HashMap, hash_map::Entry},
    path::{Path, PathBuf},
};

/// Which picture each place will hold.
pub(super) struct Places<'a> {
    poses: Option<&'a Poses>,
    /// The picture's scene, and its frame if it is one of several.
    taken: HashMap<PathBuf, (PathBuf, Option<u32>)>,
}

impl<'a> Places<'a> {
    /// No pictures yet; `poses` are those of the frames.
    pub(super) fn new(poses: Option<&'a Poses>) -> Self {
        let taken = HashMap::new();
        Self { poses, taken }
    }

    /// Takes the place of a picture, whose name is made from `pattern`; `turn` is its frame if it has a file of its own.
    pub(super) fn claim(
        &mut self,
        output: &Output,
        scene: &Path,
        turn: Option<Turn>,
        pattern: Option<&Path>,
    ) -> Result<(), CliError> {
        let frame = turn.map(|turn| turn.number);
        let (first, first_frame) = match self.taken.entry(output.place().to_owned()) {
            Entry::Vacant(place) => {
                place.insert((scene.to_owned(), frame));
                return Ok(());
            }
            Entry::Occupied(place) => place.get().clone(),
        };
        // If one is missing, that is the fault, as in `octray my models/my`.
        for path in [&*first, scene] {
            if first != scene && !is_standard_stream(path) {
                format::check_file(path)?;
            }
        }
        let name = output.name();
        let frames = first_frame.zip(frame).filter(|(first, second)| first != second);
        Err(CliError::Usage(if first != scene {
            let hint = match output.origin() {
                Origin::Typed => "use {stem} in the name, which stands for the scene's name",
                Origin::Derived if folder(&first) != folder(scene) => {
                    "name them with -o '{folder}-{stem}.png'"
                }
                Origin::Derived => "render them in two calls, each with its own --output",
            };
            let (first, scene) = (clip_path(&first), clip_path(scene));
            format!("{first} and {scene} would both be written to {name}; {hint}")
        } else if let Some((first, second)) = frames {
            let poses = self.poses.zip(pattern.and_then(pattern_per_pose));
            if let Some((poses, pattern)) = poses {
                let [first, second] = [first, second].map(|number| described(poses, number));
                let pattern = clip(&pattern);
                format!("poses {first} and {second} would both be written to {name}; use {pattern}")
            } else {
                let numbered = numbered(pattern.unwrap_or(Path::new("a.png")));
                format!(
                    "several frames would be written to {name}; add a run of # for the frame number, such as {}",
                    clip_path(&numbered)
                )
            }
        } else {
            format!(
                "two pictures of {} would be written to {name}; give each a name of its own",
                clip_path(scene)
            )
        }))
    }
}

/// A pose's number, and the path of its picture if it has one.
fn described(poses: &Poses, number: u32) -> String {
    match poses.poses.get(number as usize - 1) {
        Some(pose) if !pose.picture.is_empty() => format!("{number} ({})", clip(&pose.picture)),
        _ => number.to_string(),
    }
}
