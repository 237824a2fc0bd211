//! The command line; its modules follow a call:
//!
//! ```text
//! args     command line and config file (clap)
//!   plan     every input, picture, reference and limit, checked
//!     load     scenes, cameras, lights
//!     picture    a picture in memory, for the Python package
//!     commands   render, view, info, bench, verify, generate, ...
//!       write      pictures, AOVs, comparisons, JSON
//!       report     messages, progress, figures
//! ```

mod args;
mod commands;
mod error;
mod load;
#[doc(hidden)]
pub mod picture;
mod plan;
mod process;
mod report;
mod write;

#[doc(hidden)]
pub use commands::definition;
pub use error::CliError;
pub use process::{MemoryRefusal, out_of_memory};

use std::{ffi::OsString, process::ExitCode, time::Instant};

/// Runs the program with the process's arguments. `limit_memory` sets the allocator's limit in bytes, which catches what
/// estimates miss.
#[must_use]
pub fn main(limit_memory: impl Fn(u64)) -> ExitCode {
    ExitCode::from(run(std::env::args_os().collect(), limit_memory))
}

/// Runs the program with arguments, the program's name first, as [`main`] does; returns the exit code. On Unix, a signal
/// ends the process instead.
#[must_use]
pub fn run(arguments: Vec<OsString>, limit_memory: impl Fn(u64)) -> u8 {
    let start = Instant::now();
    let done = process::hold_level()
        .and_then(|()| args::plan(arguments))
        .and_then(|plan| match plan {
            Some(plan) => {
                limit_memory(load::memory::cap(plan.memory()));
                commands::run(plan, start)
            }
            None => Ok(()),
        });
    match done {
        Ok(()) => 0,
        Err(error) => {
            if let Some(text) = error.text() {
                report::error(&text);
            }
            if matches!(error, CliError::Interrupted) {
                // What has not been flushed would be lost; that it cannot be written is no news to an interrupted program.
                let _ = report::flush();
                process::end_by_signal();
            }
            error.exit_code()
        }
    }
}

/// Parses an option's value into its numbers: for tests and fuzzing.
///
/// # Errors
/// The message about the value.
#[doc(hidden)]
pub fn parse_value(option: &str, text: &str) -> Result<Vec<f64>, String> {
    args::numbers(option, text)
}

/// The name that a pattern gives for a scene: for tests and fuzzing.
#[doc(hidden)]
#[must_use]
pub fn named(pattern: &str, scene: &str, number: Option<u32>) -> String {
    let name = plan::expand(pattern.as_ref(), scene.as_ref(), number, None);
    name.to_string_lossy().into_owned()
}
