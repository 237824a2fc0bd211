//! The command line: arguments, commands, exit codes. Everything that is printed is printed here.

mod args;
mod bench;
mod camera;
mod encode;
mod error;
mod faults;
mod generate;
mod info;
mod input;
mod interrupt;
mod output;
mod picture;
mod progress;
mod render;
mod report;
mod stage;
mod value;
mod version;
#[cfg(feature = "viewer")]
mod view;
mod whole_file;

pub use args::BenchArgs;
pub use error::CliError;

use args::{Cli, Command};
use clap::Parser;
use std::{
    ffi::OsString,
    io::{self, Write},
    process::ExitCode,
    time::Instant,
};

/// Runs the program with the process's arguments.
#[must_use]
pub fn main() -> ExitCode {
    let start = Instant::now();
    let arguments = args::with_default_command(std::env::args_os().collect());
    match run(arguments, start) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            if let Some(text) = error.text() {
                // Nothing is left to do where standard error itself is gone.
                let _ = writeln!(io::stderr(), "octray: error: {text}");
            }
            ExitCode::from(error.exit_code())
        }
    }
}

fn run(arguments: Vec<OsString>, start: Instant) -> Result<(), CliError> {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(mut answer) => {
            camera::explain_conflict(&mut answer);
            // Help and version go to standard output; a closed pipe there is not worth a word.
            let _ = answer.print();
            return if answer.use_stderr() {
                Err(CliError::UsageShown)
            } else {
                Ok(())
            };
        }
    };
    match cli.command {
        Command::Render(args) => render::run(&args, start),
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Generate(args) => print(&generate::run(&args).map_err(CliError::Failed)?),
    }
}

/// Writes a command's answer to standard output.
///
/// # Errors
/// [`CliError::ClosedPipe`] where nobody reads any more, else [`CliError::Failed`].
fn print(text: &str) -> Result<(), CliError> {
    let mut stdout = io::stdout().lock();
    stdout
        .write_all(text.as_bytes())
        .and_then(|()| stdout.flush())
        .map_err(|error| CliError::writing("standard output", &error))
}
