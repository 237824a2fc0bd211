//! Checks that no two pictures of a call have the same file.

use super::{
    input::is_standard_input,
    names::{Origin, folder},
};
use crate::{
    cli::{CliError, write::Output},
    error::clip_path,
    format,
};
use std::{
    collections::{HashMap, hash_map::Entry},
    path::{Path, PathBuf},
};

/// Which scene's picture each place will hold.
#[derive(Default)]
pub(super) struct Places(HashMap<PathBuf, PathBuf>);

impl Places {
    pub(super) fn claim(&mut self, output: &Output, scene: &Path, turning: bool) -> Result<(), CliError> {
        let first = match self.0.entry(output.place().to_owned()) {
            Entry::Vacant(place) => {
                place.insert(scene.to_owned());
                return Ok(());
            }
            Entry::Occupied(place) => place.get().clone(),
        };
        // If one is missing, that is the fault, as in `octray my models/my`.
        for path in [&*first, scene] {
            if first != scene && !is_standard_input(path) {
                format::check_file(path)?;
            }
        }
        let name = output.name();
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
        } else if turning {
            format!(
                "several frames would be written to {name}; add a run of # for the frame number, such as a-####.png"
            )
        } else {
            format!(
                "two pictures of {} would be written to {name}; give each a name of its own",
                clip_path(scene)
            )
        }))
    }
}
