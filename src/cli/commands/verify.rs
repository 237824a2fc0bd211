//! `octray verify`: checks that every tracing method finds what brute force finds.

use crate::{
    cli::{
        CliError,
        plan::{JsonTarget, VerifyPlan},
        process::Interrupt,
        report::{
            self, SCHEMA, VerifyBar,
            verify::{Json, difference, text},
        },
        write::{json_line, write_json},
    },
    verify::{self, Done, Implementations},
};
use std::{
    ops::ControlFlow,
    time::{Duration, Instant},
};

/// A large scene takes less than this on a busy machine. The counts are printed once it is done.
const PATIENCE: Duration = Duration::from_secs(5);

/// Verifies and prints the counts.
///
/// # Errors
/// [`CliError::Differs`] with the command that repeats it, [`CliError::Interrupted`] after the counts so far.
pub fn run(plan: &VerifyPlan) -> Result<(), CliError> {
    run_with(
        plan,
        &verify::implementations,
        &Interrupt::install_with(PATIENCE)?,
    )
}

fn run_with(
    plan: &VerifyPlan,
    implementations: &Implementations,
    interrupt: &Interrupt,
) -> Result<(), CliError> {
    let VerifyPlan {
        settings,
        time_limit: limit,
        json,
    } = plan;
    let start = Instant::now();
    let is_quiet = *json == Some(JsonTarget::Stdout);
    let bar = VerifyBar::new(!is_quiet && report::notes_to_terminal(), settings.rays);
    let report = |done: Done| {
        bar.show(done, start.elapsed(), *limit);
        if interrupt.requested() || limit.is_some_and(|limit| start.elapsed() >= limit) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let outcome = verify::run(settings, implementations, &report);
    bar.clear();
    let outcome = outcome.map_err(|error| CliError::Failed(error.to_string()))?;
    let took = start.elapsed();

    let stopped = interrupt.requested();
    if !is_quiet {
        report::print(&text(settings, &outcome, took, stopped))?;
    }
    if let Some(target) = json {
        let json = Json::new(SCHEMA, settings, &outcome, took);
        write_json(target, &json_line(&json))?;
    }
    match &outcome.fault {
        Some(fault) => Err(CliError::Differs(difference(fault))),
        None if stopped => Err(CliError::Interrupted),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
