//! JSON answers, one line each.

use crate::{
    cli::{CliError, plan::JsonTarget, report},
    whole_file,
};
use serde::Serialize;
use std::{
    fs::{self, OpenOptions},
    io::Write,
};

/// An answer as one line of JSON.
pub fn json_line(json: &impl Serialize) -> String {
    // Plain structs of numbers and strings always serialize.
    serde_json::to_string(json).unwrap_or_default() + "\n"
}

/// Writes lines of [`json_line`]. A file is written whole or not at all.
///
/// # Errors
/// [`CliError::Failed`] or [`CliError::ClosedPipe`].
pub fn write_json(target: &JsonTarget, lines: &str) -> Result<(), CliError> {
    let path = match target {
        JsonTarget::Stdout => return report::print(lines),
        JsonTarget::File(path) => path,
    };
    // A device or a pipe is written through: replacing it would make it a file.
    let written = if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        let file = OpenOptions::new().write(true).open(path);
        file.and_then(|mut file| file.write_all(lines.as_bytes()))
    } else {
        whole_file::write(path, |out| out.write_all(lines.as_bytes()))
    };
    written.map_err(|error| CliError::writing(&path.display().to_string(), &error))
}
