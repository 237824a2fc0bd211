//! Where messages go. All of them begin as clap's do.

use crate::{cli::CliError, error::escape};
use std::io::{self, Write};

/// Writes a command's answer to standard output.
///
/// # Errors
/// [`CliError::ClosedPipe`] if the reader has gone, else [`CliError::Failed`].
pub fn print(text: &str) -> Result<(), CliError> {
    let mut stdout = io::stdout().lock();
    stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
        .map_err(|error| CliError::writing("standard output", &error))
}

/// Writes to standard error. A closed standard error is not a failure.
pub fn note(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}

/// Warns on standard error.
pub fn warning(text: &str) {
    note(&format!("warning: {}\n", escape(text)));
}

/// Says on standard error why a command failed.
pub fn error(text: &str) {
    note(&format!("error: {text}\n"));
}
