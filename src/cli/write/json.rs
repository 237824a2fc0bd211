//! JSON answers.

use super::guarded;
use crate::cli::{CliError, plan::JsonTarget, process::Interrupt, report};
use serde::Serialize;
use std::io::Write;

/// Writes an answer as JSON.
///
/// # Errors
/// [`CliError::Failed`] or [`CliError::ClosedPipe`].
pub fn write_json(target: &JsonTarget, json: &impl Serialize) -> Result<(), CliError> {
    // Plain structs of numbers and strings always serialize.
    let mut text = serde_json::to_string_pretty(json).unwrap_or_default();
    text.push('\n');
    match target {
        JsonTarget::Stdout => report::print(&text),
        JsonTarget::File(path) => {
            guarded::write(path, &Interrupt::default(), |out| out.write_all(text.as_bytes()))
                .map_err(|error| CliError::writing(&path.display().to_string(), &error))
        }
    }
}

/// An answer as one line of JSON.
pub fn json_line(json: &impl Serialize) -> String {
    // Plain structs of numbers and strings always serialize.
    serde_json::to_string(json).unwrap_or_default() + "\n"
}
