//! The commands, one file each.

mod bench;
mod generate;
mod info;
mod job;
mod merge;
mod render;
mod shell;
mod stages;
mod verify;
#[cfg(feature = "viewer")]
mod view;

pub use shell::definition;

use super::{CliError, plan::Plan, process, report};
use crate::error::in_bytes;
use std::time::Instant;

/// Runs a command. `start` is when the program began.
///
/// # Errors
/// [`CliError`].
pub fn run(plan: Plan, start: Instant) -> Result<(), CliError> {
    if !matches!(plan, Plan::Completions(_) | Plan::Man(_)) {
        process::start_threads()?;
    }
    match plan {
        Plan::Render(plan) => render::run(&plan, start),
        #[cfg(feature = "viewer")]
        Plan::View(plan) => view::run(*plan),
        Plan::Job(plan) => job::run(&plan),
        Plan::Merge(plan) => merge::run(&plan, start),
        Plan::Info(plan) => info::run(&plan),
        Plan::Bench(plan) => bench::run(&plan),
        Plan::Verify(plan) => verify::run(&plan),
        Plan::Generate(plan) => generate::run(&plan),
        Plan::Completions(shell) => report::print_bytes(shell::completions(&shell)?.as_bytes()),
        Plan::Man(command) => report::print_bytes(shell::man(command.as_deref())?.as_bytes()),
    }
}

/// Refuses work that needs more memory than the limit, both in bytes.
fn check_room(what: &str, needed: u64, limit: u64) -> Result<(), CliError> {
    if needed <= limit {
        return Ok(());
    }
    Err(CliError::Memory(format!(
        "{what} would take about {} of memory, more than the limit of {}",
        in_bytes(needed),
        in_bytes(limit)
    )))
}
