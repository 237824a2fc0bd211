//! The instruction set that `OCTRAY_ISA` selects.

use crate::{Level, cli::CliError};

/// Sets the process's level to that of the environment variable, if it is set.
///
/// # Errors
/// [`CliError::Usage`] if there is no such level, or this CPU lacks it.
pub fn hold_level() -> Result<(), CliError> {
    let Some(name) = std::env::var_os("OCTRAY_ISA").filter(|name| !name.is_empty()) else {
        return Ok(());
    };
    let name = name.to_string_lossy();
    match name.parse::<Level>() {
        Ok(level) => level.hold(),
        Err(error) => return Err(CliError::Usage(format!("OCTRAY_ISA={name}: {error}"))),
    }
    Ok(())
}
