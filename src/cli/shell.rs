//! `octray completions` and `octray man`: what shells and `man` want to know, from the arguments' own definition.

use super::{CliError, args::Cli};
use clap::{Args, Command, CommandFactory};
use clap_complete::Shell;
use std::io;

#[derive(Args, Debug)]
pub struct CompletionsArgs {
    /// The shell that is to complete octray's arguments
    pub shell: Shell,
}

#[derive(Args, Debug)]
pub struct ManArgs {
    /// The page of one command [default: that of octray as a whole]
    pub command: Option<String>,
}

/// A shell's script.
pub fn completions(args: &CompletionsArgs) -> String {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "octray", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// A page in roff, for `man`.
///
/// # Errors
/// [`CliError::Usage`] for a command that there is not.
pub fn man(args: &ManArgs) -> Result<String, CliError> {
    let mut all = Cli::command();
    // Gives each command the options and the usage that it inherits.
    all.build();
    let page = match &args.command {
        None => all,
        Some(name) => {
            let found = all.get_subcommands().find(|command| command.get_name() == name);
            let page = found.ok_or_else(|| no_command(&all, name))?;
            page.clone().display_name(format!("octray-{name}"))
        }
    };
    let mut text = Vec::new();
    render(page, &mut text).map_err(|error| CliError::Failed(format!("cannot make the page: {error}")))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}

fn render(page: Command, to: &mut Vec<u8>) -> io::Result<()> {
    // A version with the build's instruction set would make pages differ from machine to machine.
    let version = env!("CARGO_PKG_VERSION");
    let page = page.version(version).long_version(None);
    clap_mangen::Man::new(page)
        .source(format!("octray {version}"))
        .render(to)
}

fn no_command(all: &Command, name: &str) -> CliError {
    let names: Vec<&str> = all.get_subcommands().map(Command::get_name).collect();
    CliError::Usage(format!(
        "there is no command `{}`, expected one of {}",
        crate::error::escape(name),
        names.join(", ")
    ))
}
