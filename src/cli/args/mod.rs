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
    plan::Plan,
    report::{self, version},
};
use crate::error::clip;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
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
    Cli::command()
}

/// The plan of a command line; `None` if clap has shown help or the version instead.
///
/// # Errors
/// [`CliError`].
pub fn plan(arguments: Vec<OsString>) -> Result<Option<Plan>, CliError> {
    let arguments = default_command::with_default_command(arguments);
    let arguments = default_command::with_negative_values(arguments);
    if let Some(why) = usage::one_dash(&arguments) {
        return Err(CliError::Usage(why));
    }
    let (mut cli, mut matches) = match parse(&arguments) {
        Ok(parsed) => parsed,
        Err(answer) => return show(answer, &arguments),
    };
    let read = |args: &render::RenderArgs| match matches.subcommand() {
        Some((_, given)) => config::with_defaults(&arguments, given, &args.config),
        None => Ok(None),
    };
    if let Some(with_defaults) = cli.command.render().map_or(Ok(None), read)? {
        match parse(&with_defaults.arguments) {
            Ok(parsed) => (cli, matches) = parsed,
            Err(answer) => return show(answer, &with_defaults.arguments),
        }
        if let Some(args) = cli.command.render_mut() {
            args.defaults = with_defaults.options;
        }
    }
    let plan = cli.command.plan(&matches).map(Some);
    // Of `-s 800 600` one number is a size and the other one a file.
    plan.map_err(|error| usage::misread(&arguments).map_or(error, CliError::Usage))
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
    let matches = Cli::command().try_get_matches_from(arguments)?;
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
mod tests {
    use super::{default_command::with_default_command, render::RenderArgs, values::Size, *};
    use crate::{accel::BuildQuality, bench::Method, cli::plan::Build};
    use glam::DVec3;
    use std::path::PathBuf;

    fn parse(arguments: &[&str]) -> Result<Command, clap::Error> {
        let arguments = std::iter::once("octray").chain(arguments.iter().copied());
        Cli::try_parse_from(with_default_command(arguments.map(OsString::from).collect()))
            .map(|cli| cli.command)
    }

    fn parse_render(arguments: &[&str]) -> RenderArgs {
        match parse(arguments) {
            Ok(Command::Render(args)) => *args,
            other => panic!("{arguments:?}: {other:?}"),
        }
    }

    #[test]
    fn clap_accepts_the_definition() {
        Cli::command().debug_assert();
    }

    #[test]
    fn render_is_the_default_command() {
        for arguments in [
            &["a.scn", "--view", "2"][..],
            &["render", "a.scn", "--view=2"],
            &["--view", "2", "a.scn"],
            &["--view", "2", "--", "a.scn"],
        ] {
            let args = parse_render(arguments);
            assert_eq!((args.scenes, args.camera.view), (vec!["a.scn".into()], Some(2)));
        }
        assert_eq!(parse_render(&["./info"]).scenes, [PathBuf::from("./info")]);
        assert_eq!(parse_render(&["render", "info"]).scenes, [PathBuf::from("info")]);
        assert!(matches!(parse(&["info", "render"]), Ok(Command::Info(_))));
    }

    #[test]
    fn coordinates_may_be_negative() {
        let args = parse_render(&[
            "a.scn",
            "--eye",
            "-1,2,3",
            "--target=-0.5,0,-1e3",
            "--up",
            "-0,0,1",
        ]);
        assert_eq!(args.camera.eye, Some(DVec3::new(-1.0, 2.0, 3.0)));
        assert_eq!(args.camera.target, Some(DVec3::new(-0.5, 0.0, -1000.0)));
    }

    #[test]
    fn one_option_says_where_the_camera_stands() {
        for arguments in [
            &["a.scn", "--view", "2", "--eye", "1,2,3"][..],
            &["a.scn", "--camera", "a", "--eye", "1,2,3"],
            &["a.scn", "--camera", "a", "--view=2"],
        ] {
            let error = parse(arguments).expect_err("a contradiction");
            assert_eq!(error.kind(), clap::error::ErrorKind::ArgumentConflict);
        }
        let args = parse_render(&["a.scn", "--camera", "a", "--fov", "30"]);
        assert_eq!(
            (args.camera.camera.as_deref(), args.camera.fov),
            (Some("a"), Some(30.0))
        );
    }

    #[test]
    fn the_build_pays_for_itself() {
        assert_eq!(parse_render(&["a.scn"]).trace.build, Build::Auto);
        assert_eq!(
            parse_render(&["a.scn", "--build", "fast"]).trace.build,
            Build::Quality(BuildQuality::Fast)
        );
        assert_eq!(Build::Auto.quality(1e6, 10_000_000), BuildQuality::Fast);
        assert_eq!(Build::Auto.quality(1e6, 10_000), BuildQuality::Best);
        assert_eq!(
            Build::Quality(BuildQuality::Best).quality(1.0, 10_000_000),
            BuildQuality::Best
        );
        assert_eq!(
            Build::Quality(BuildQuality::Ploc).quality(1.0, 10_000_000),
            BuildQuality::Ploc
        );
    }

    #[cfg(feature = "viewer")]
    #[test]
    fn what_the_window_prints_makes_its_picture() {
        use crate::cli::plan::Style;
        for options in [
            &[][..],
            &["--samples=auto"],
            &["--samples=auto:7", "--filter=box", "--linear"],
            &["--samples=1"],
            &["--samples=10", "--srgb", "--no-shadows"],
            &["--samples=16", "--pattern=stratified", "--max-depth=7"],
            &["--pattern=sobol", "--filter=tent"],
            &["--pattern=grid", "--filter=blackman-harris"],
        ] {
            for style in [None, Some(Style::Plain), Some(Style::Studio), Some(Style::Clay)] {
                let mut arguments = vec!["view", "--size=20x10", "a"];
                arguments.extend(match style {
                    Some(Style::Plain) => Some("--style=plain"),
                    Some(Style::Clay) => Some("--style=clay"),
                    _ => None,
                });
                arguments.extend(options);
                let Ok(Command::View(view)) = parse(&arguments) else {
                    panic!("{arguments:?}");
                };
                let shown = view.looks().unwrap();
                let shown = shown.of(style.is_some());
                let printed = spelled(&shown.settings, shown.picture.transfer, style);
                let arguments: Vec<&str> = ["render", "--size=20x10", "a"]
                    .into_iter()
                    .chain(printed.split_whitespace())
                    .collect();
                let looks = parse_render(&arguments);
                let looks = looks.looks(looks.size(None)).unwrap();
                assert_eq!(looks.of(style.is_some()), shown, "{printed}");
            }
        }
    }

    #[test]
    fn bench_takes_a_scene_or_the_suite() {
        let Ok(Command::Bench(args)) = parse(&["bench", "--all", "--quick"]) else {
            panic!("not bench");
        };
        assert!(args.all && args.quick && args.scene.is_none());
        for arguments in [
            &["bench"][..],
            &["bench", "a.scn", "--all"],
            &["bench", "a.scn", "--quick"],
            &["bench", "--all", "--view", "2"],
        ] {
            assert!(parse(arguments).is_err(), "{arguments:?}");
        }
    }

    #[test]
    fn bench_methods_may_be_listed() {
        let Ok(Command::Bench(args)) = parse(&[
            "bench",
            "a.scn",
            "--method",
            "scalar,packet",
            "--method",
            "render",
        ]) else {
            panic!("not bench");
        };
        assert_eq!(args.methods, [Method::Scalar, Method::Packet, Method::Render]);
        assert_eq!(
            args.size,
            Size {
                width: 1024,
                height: 1024
            }
        );
    }
}
