//! The arguments: clap's definition of all commands and the config file, from which a checked [`Plan`] is made.
//!
//! Only this folder and the command that prints completions and manual pages use clap.

mod bench;
mod camera;
mod choices;
mod config;
mod default_command;
mod examples;
mod generate;
mod info;
mod job;
mod limits;
mod merge;
mod picture;
mod render;
mod series;
mod shell;
#[cfg(feature = "viewer")]
mod spelled;
mod trace;
mod usage;
mod values;
mod verify;
#[cfg(feature = "viewer")]
mod view;

pub use picture::look;
#[cfg(feature = "viewer")]
pub use spelled::spelled;
pub use values::numbers;

use super::{
    CliError,
    plan::{Plan, explained_plan},
    report::{self, version},
};
use crate::error::clip;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand, error::ErrorKind};
use std::ffi::{OsStr, OsString};

/// A fast CPU ray tracer for scenes of triangle meshes and spheres.
#[derive(Debug, Parser)]
#[command(
    name = "octray",
    version = version::short(),
    long_version = version::long(),
    propagate_version = true,
    override_usage = examples::USAGE,
    after_long_help = examples::ALL,
    max_term_width = 110
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene into a picture
    #[command(override_usage = examples::RENDER_USAGE, after_long_help = examples::RENDER)]
    Render(Box<render::RenderArgs>),
    /// Explore a scene in a live, ray-traced window
    #[cfg(feature = "viewer")]
    #[command(after_long_help = examples::VIEW_KEYS)]
    View(Box<view::ViewArgs>),
    /// Write the tasks with which a render farm renders frames or tiles
    ///
    /// Tasks read and write files: neither - nor animations are supported.
    #[command(after_long_help = examples::JOB)]
    Job(Box<job::JobArgs>),
    /// Merge the tiles of a picture, rendered with `octray render --crop`
    #[command(after_help = examples::MERGE)]
    Merge(merge::MergeArgs),
    /// Describe a scene and its BVH
    Info(info::InfoArgs),
    /// Compare the speed of tracing methods on the same rays, on one thread
    Bench(Box<bench::BenchArgs>),
    /// Check every tracing method against brute force, on random scenes and rays
    Verify(verify::VerifyArgs),
    /// Generate a scene of any size from a seed
    Generate(generate::GenerateArgs),
    /// Print a script that completes octray's arguments in a shell
    #[command(after_help = examples::COMPLETIONS)]
    Completions(shell::CompletionsArgs),
    /// Print the manual page of octray or of a command
    #[command(after_help = examples::MAN)]
    Man(shell::ManArgs),
}

/// The definition of all commands and options.
pub fn definition() -> clap::Command {
    let hidden = |job: clap::Command, id: &&'static str| job.mut_arg(*id, |option| option.hide(true));
    let explained = |job: clap::Command, (id, help): (&'static str, &'static str)| {
        job.mut_arg(id, |argument| argument.help(help))
    };
    Cli::command().mut_subcommands(|command| match command.get_name() {
        "job" => job::HELP
            .into_iter()
            .fold(job::IGNORED_DEFAULTS.iter().fold(command, hidden), explained),
        _ => command,
    })
}

/// The plan of a command line; `None` if clap has shown help or the version instead.
///
/// # Errors
/// [`CliError`].
pub fn plan(arguments: Vec<OsString>) -> Result<Option<Plan>, CliError> {
    #[cfg(not(feature = "viewer"))]
    if let Some(why) = usage::no_window(&arguments) {
        return Err(CliError::Usage(why));
    }
    let arguments = default_command::with_default_command(arguments);
    let arguments = default_command::with_joined_values(arguments);
    let arguments = default_command::with_plain_help(arguments);
    if let Some(why) = usage::one_dash(&arguments).or_else(|| usage::two_pages(&arguments)) {
        return Err(CliError::Usage(why));
    }
    let mut missing = None;
    let parsed = parse(&arguments).or_else(|answer| {
        if answer.kind() != ErrorKind::MissingRequiredArgument {
            return Err(answer);
        }
        // The config file may have the option that another one needs.
        missing = Some(answer);
        parsed_by(definition().ignore_errors(true), &arguments)
    });
    let (cli, matches) = match parsed {
        Ok(parsed) => parsed,
        Err(answer) => return show(missing.unwrap_or(answer), &arguments),
    };
    // Without the defaults of the config file that are not for this command, nor an option of it.
    let with_defaults = |option: Option<&str>| {
        let (Some(args), Some((_, given))) = (cli.command.render(), matches.subcommand()) else {
            return Ok(None);
        };
        let mut ignored = cli.command.ignored_defaults().to_vec();
        ignored.extend(option);
        config::with_defaults(&arguments, given, &args.config, &ignored)
    };
    let plan = match with_defaults(None)? {
        None => match missing {
            Some(answer) => return show(answer, &arguments),
            None => cli.command.plan(&matches),
        },
        Some(all) => match parse(&all.arguments) {
            Err(answer) => return show(answer, &all.arguments),
            Ok(parsed) => {
                let defaults = all.options.clone();
                plan_of(parsed, all).map_err(|error| {
                    explained_plan(error, &defaults, |option| {
                        let fewer = with_defaults(Some(option)).ok()??;
                        let parsed = parse(&fewer.arguments).ok()?;
                        Some(plan_of(parsed, fewer).map(drop))
                    })
                })
            }
        },
    };
    // Of `-s 800 600` one number is a size and the other one a file.
    plan.map(Some)
        .map_err(|error| usage::misread(&arguments).map_or(error, CliError::Usage))
}

/// The plan of a command line with defaults.
fn plan_of((mut cli, matches): (Cli, ArgMatches), defaults: config::WithDefaults) -> Result<Plan, CliError> {
    if let Some(args) = cli.command.render_mut() {
        args.defaults = defaults.options;
    }
    cli.command.plan(&matches)
}

impl Command {
    /// The arguments of `octray render`, if the command takes them.
    fn render(&self) -> Option<&render::RenderArgs> {
        match self {
            Self::Render(args) => Some(args),
            Self::Job(args) => Some(&args.render),
            _ => None,
        }
    }

    fn render_mut(&mut self) -> Option<&mut render::RenderArgs> {
        match self {
            Self::Render(args) => Some(args),
            Self::Job(args) => Some(&mut args.render),
            _ => None,
        }
    }

    /// The ids of options whose defaults in a config file are not for this command.
    fn ignored_defaults(&self) -> &'static [&'static str] {
        match self {
            Self::Job(_) => &job::IGNORED_DEFAULTS,
            _ => &[],
        }
    }

    fn plan(self, matches: &ArgMatches) -> Result<Plan, CliError> {
        let given = matches.subcommand().map_or(matches, |(_, given)| given);
        Ok(match self {
            Self::Render(args) => Plan::Render(Box::new(args.plan()?)),
            Self::Job(args) => Plan::Job(Box::new(args.plan(given)?)),
            #[cfg(feature = "viewer")]
            Self::View(args) => Plan::View(Box::new(args.plan()?)),
            Self::Merge(args) => Plan::Merge(args.plan()?),
            Self::Info(args) => Plan::Info(args.plan()?),
            Self::Bench(args) => Plan::Bench(args.plan()?),
            Self::Verify(args) => Plan::Verify(args.plan()?),
            Self::Generate(args) => Plan::Generate(args.plan()?),
            Self::Completions(args) => Plan::Completions(args.shell.to_string()),
            Self::Man(args) => Plan::Man(args.command),
        })
    }
}

fn parse(arguments: &[OsString]) -> Result<(Cli, ArgMatches), clap::Error> {
    parsed_by(definition(), arguments)
}

fn parsed_by(definition: clap::Command, arguments: &[OsString]) -> Result<(Cli, ArgMatches), clap::Error> {
    let matches = definition.try_get_matches_from(arguments)?;
    let cli = Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut Cli::command()))?;
    Ok((cli, matches))
}

/// Shows help, the version or a usage error.
fn show(mut answer: clap::Error, arguments: &[OsString]) -> Result<Option<Plan>, CliError> {
    if answer.use_stderr()
        && let Some(why) = usage::misread(arguments)
    {
        return Err(CliError::Usage(why));
    }
    let tame: Vec<OsString> = arguments.iter().map(|argument| tame(argument)).collect();
    if tame != arguments {
        match parse(&tame) {
            Err(same) if same.kind() == answer.kind() => answer = same,
            // Nothing that clap could say would be safe to print.
            _ => return Err(CliError::Usage(answer.kind().to_string())),
        }
    }
    usage::explain(&mut answer, arguments);
    let printed = answer.print();
    if answer.use_stderr() {
        return Err(CliError::UsageShown);
    }
    let printed = printed.map_err(|error| CliError::writing("standard output", &error));
    match printed.and_then(|()| report::flush()) {
        // A reader that has seen enough is no failure of help.
        Ok(()) | Err(CliError::ClosedPipe) => Ok(None),
        Err(error) => Err(error),
    }
}

/// An argument as clap's messages may repeat it: escaped, and cut if it is long. clap colours its messages, so they cannot
/// be escaped afterwards.
fn tame(argument: &OsStr) -> OsString {
    clip(&argument.to_string_lossy()).into()
}

#[cfg(test)]
mod tests;
