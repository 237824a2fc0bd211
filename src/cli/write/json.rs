//! JSON output, one line per result.

use crate::{
    cli::{CliError, plan::JsonTarget, report},
    error::clip_path,
    whole_file,
};
use serde::Serialize;
use std::io::Write;

/// A result as one line of JSON without characters that control a terminal.
pub fn json_line(json: &impl Serialize) -> String {
    // Plain structs of numbers and strings always serialize.
    report::tame_json(&(serde_json::to_string(json).unwrap_or_default() + "\n"))
}

/// Writes lines of [`json_line`]. A file is written whole or not at all.
///
/// # Errors
/// [`CliError::Failed`] or [`CliError::ClosedPipe`].
pub fn write_json(target: &JsonTarget, lines: &str) -> Result<(), CliError> {
    let path = match target {
        JsonTarget::Stdout => return report::print_bytes(lines.as_bytes()),
        JsonTarget::File(path) => path,
    };
    let written = whole_file::write(path, |out| out.write_all(lines.as_bytes()));
    written.map_err(|error| CliError::writing(&clip_path(path), &error))
}
