//! `octray bench`.

use super::{BenchArgs, CliError};

/// Times single rays against packets.
///
/// # Errors
/// [`CliError`].
pub fn run(args: &BenchArgs) -> Result<(), CliError> {
    let _ = args;
    Err(CliError::Failed("octray bench is not built yet".into()))
}
