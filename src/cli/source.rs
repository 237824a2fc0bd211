//! Where a scene comes from: a file, or standard input.

use super::CliError;
use crate::{error::LoadError, format, scene::Scene};
use std::{
    io::{self, IsTerminal},
    path::Path,
};

/// What stands for standard input in errors. It is in no folder, so that paths count from the current one.
const STDIN: &str = "standard input";

/// Whether this stands for standard input.
pub fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Loads a scene from a file, or for `-` from standard input. `memory` is what it may take, bytes.
///
/// # Errors
/// [`CliError`].
pub fn load(path: &Path, memory: u64) -> Result<Scene, CliError> {
    if !is_standard_input(path) {
        return Ok(format::load_within(path, &mut Vec::new(), memory)?);
    }
    let stdin = io::stdin();
    if stdin.is_terminal() {
        return Err(CliError::Usage(
            "the scene is to come from standard input, which is a terminal; send a file or a program's output with < \
             or |"
                .into(),
        ));
    }
    let loaded: Result<Scene, LoadError> = format::load_from_reader(stdin.lock(), Path::new(STDIN), memory);
    Ok(loaded?)
}
