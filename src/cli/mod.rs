//! The command line: arguments, commands, exit codes. Everything that is printed is printed here.

mod aov;
mod aov_files;
mod args;
mod batch;
mod batch_args;
mod bench;
mod bench_args;
mod camera;
mod camera_args;
mod compare;
mod config;
mod default_command;
mod encode;
mod error;
mod exr_layers;
mod faults;
mod generate;
mod info;
mod input;
mod interrupt;
mod memory;
mod names;
mod output;
mod picture;
mod picture_args;
mod progress;
mod render;
mod report;
mod shell;
mod source;
mod stage;
mod threads;
mod trace_args;
mod turntable;
mod usage;
mod value;
mod verify;
mod verify_report;
mod version;
#[cfg(feature = "viewer")]
mod view;
mod whole_file;

pub use bench_args::BenchArgs;
pub use error::CliError;

use args::{Cli, Command};
use clap::{ArgMatches, CommandFactory, FromArgMatches};
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
    let arguments = default_command::with_default_command(std::env::args_os().collect());
    match run(&arguments, start) {
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

fn run(arguments: &[OsString], start: Instant) -> Result<(), CliError> {
    let (cli, matches) = match parse(arguments) {
        Ok(parsed) => parsed,
        Err(answer) => return show(answer),
    };
    if !matches!(cli.command, Command::Completions(_) | Command::Man(_)) {
        start_threads()?;
    }
    match cli.command {
        Command::Render(args) => {
            let given = matches.subcommand_matches("render").unwrap_or(&matches);
            let with_defaults = config::with_defaults(arguments, given, &args.config)?;
            match with_defaults.map(|arguments| parse(&arguments)) {
                Some(Ok((
                    Cli {
                        command: Command::Render(args),
                    },
                    _,
                ))) => render::run(&args, start),
                Some(Err(answer)) => show(answer),
                _ => render::run(&args, start),
            }
        }
        #[cfg(feature = "viewer")]
        Command::View(args) => view::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Verify(args) => verify::run(&args),
        Command::Generate(args) => print(&generate::run(&args)?),
        Command::Completions(args) => print(&shell::completions(&args)),
        Command::Man(args) => print(&shell::man(&args)?),
    }
}

/// Starts the [threads] that everything runs on.
fn start_threads() -> Result<(), CliError> {
    threads::start().map_err(|error| {
        let why = std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string);
        CliError::Failed(format!("cannot start threads: {why}"))
    })
}

fn parse(arguments: &[OsString]) -> Result<(Cli, ArgMatches), clap::Error> {
    let matches = Cli::command().try_get_matches_from(arguments)?;
    let cli = Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut Cli::command()))?;
    Ok((cli, matches))
}

/// Shows what clap says instead of a command line: help, version, or what is wrong.
fn show(mut answer: clap::Error) -> Result<(), CliError> {
    usage::explain(&mut answer);
    // Help and version go to standard output; a closed pipe there is not worth a word.
    let _ = answer.print();
    if answer.use_stderr() {
        Err(CliError::UsageShown)
    } else {
        Ok(())
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

/// The numbers of an option's value, by the option's name: for tests and fuzzing, which know no types of clap.
///
/// # Errors
/// What is said about the value.
#[doc(hidden)]
pub fn parse_value(option: &str, text: &str) -> Result<Vec<f64>, String> {
    value::numbers(option, text)
}

/// The name that a pattern gives for a scene: for tests and fuzzing.
#[doc(hidden)]
#[must_use]
pub fn named(pattern: &str, scene: &str, number: Option<u32>) -> String {
    let name = names::expand(pattern.as_ref(), names::stem(scene.as_ref()), number);
    name.to_string_lossy().into_owned()
}
