//! `octray completions` and `octray man`, from the definition of the arguments.

mod scenes;

use crate::{
    cli::{CliError, args},
    error::clip,
};
use clap::{Arg, Command, builder::PossibleValuesParser};
use clap_complete::Shell;
use std::{io, str::FromStr};

/// The definition of the command line, from which `docs/cli.md` is generated.
#[must_use]
pub fn definition() -> Command {
    args::definition()
}

/// The completion script of a shell.
///
/// # Errors
/// [`CliError::Usage`] for an unknown shell.
pub fn completions(shell: &str) -> Result<String, CliError> {
    let shell = Shell::from_str(shell).map_err(CliError::Usage)?;
    let mut all = args::definition();
    all.build();
    // clap takes only names that live as long as the program.
    let names: Vec<&'static str> = names(&all).map(|name| &*name.to_owned().leak()).collect();
    let pages = PossibleValuesParser::new(names.clone());
    let mut all = args::definition()
        .mut_subcommand("man", |man| offering(man, "command", pages))
        .mut_subcommands(|command| {
            WORDS.iter().fold(command, |command, (option, words)| {
                offering(command, option, PossibleValuesParser::new(*words))
            })
        });
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut all, "octray", &mut script);
    let script = String::from_utf8_lossy(&script);
    Ok(scenes::with_scenes(shell, &script, &names, &fish_words(&all)))
}

/// Options that take words besides numbers or colours.
const WORDS: [(&str, &[&str]); 2] = [
    ("background", &["scene", "transparent", "white", "black"]),
    ("samples", &["auto", "auto:64", "1", "16", "64"]),
];

/// Offers values for an argument, if the command has it.
fn offering(command: Command, name: &'static str, values: PossibleValuesParser) -> Command {
    if command.get_arguments().any(|arg| arg.get_id() == name) {
        return command.mut_arg(name, |arg| arg.value_parser(values));
    }
    command
}

/// The words of arguments without options, which clap_complete leaves out for fish.
fn fish_words(all: &Command) -> String {
    let mut lines = String::new();
    for command in all.get_subcommands() {
        let words = command.get_positionals().flat_map(Arg::get_possible_values);
        let words = words.map(|word| {
            let help = word.get_help().map(ToString::to_string).unwrap_or_default();
            format!("{}\\t'{}'", word.get_name(), help.replace('\'', "\\'"))
        });
        let words: Vec<String> = words.collect();
        if !words.is_empty() {
            let (name, words) = (command.get_name(), words.join("\n"));
            lines += &format!(
                "complete -c octray -n \"__fish_octray_using_subcommand {name}\" -f -a \"{words}\"\n"
            );
        }
    }
    lines
}

/// A manual page in roff: of octray as a whole, or of one command.
///
/// # Errors
/// [`CliError::Usage`] for an unknown command.
pub fn man(command: Option<&str>) -> Result<String, CliError> {
    let mut all = args::definition();
    // Gives each command the options and the usage that it inherits.
    all.build();
    let page = match command {
        None => all,
        Some(name) => {
            let found = all.get_subcommands().find(|command| command.get_name() == name);
            let page = found.ok_or_else(|| no_command(&all, name))?;
            let page = page.clone().display_name(format!("octray-{name}"));
            // The words after `octray help` are no commands with pages of their own.
            page.subcommand_value_name("COMMAND")
                .mut_subcommands(|word| word.hide(true))
        }
    };
    let mut text = Vec::new();
    render(page, &mut text)
        .map_err(|error| CliError::Failed(format!("cannot make the manual page: {error}")))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

fn render(page: Command, to: &mut Vec<u8>) -> io::Result<()> {
    // Without the build's instruction set, so that pages do not depend on the machine.
    let version = env!("CARGO_PKG_VERSION");
    let page = page.version(version).long_version(None);
    clap_mangen::Man::new(page)
        .source(format!("octray {version}"))
        .render(to)
}

/// The names of the commands.
fn names(all: &Command) -> impl Iterator<Item = &str> {
    all.get_subcommands().map(Command::get_name)
}

fn no_command(all: &Command, name: &str) -> CliError {
    let names: Vec<&str> = names(all).collect();
    CliError::Usage(format!(
        "no command `{}`, expected one of {}",
        clip(name),
        names.join(", ")
    ))
}
