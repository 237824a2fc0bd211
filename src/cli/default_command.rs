//! `octray SCENE` for `octray render SCENE`.

use super::args::Cli;
use clap::CommandFactory;
use std::{
    ffi::{OsStr, OsString},
    path::Path,
};

/// Puts `render` before arguments that do not begin with a command, so that `octray SCENE` works.
///
/// Only the first argument counts. A default command is done here and not by clap, whose usage errors for
/// optional subcommands mix both levels.
pub fn with_default_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let render = match arguments.get(1) {
        Some(first) => !is_top_level(first),
        None => false,
    };
    if render {
        arguments.insert(1, "render".into());
    }
    arguments
}

/// Whether clap should read the argument as a command: because it is one, or because it looks like a
/// misspelt one and no such scene exists, so that clap answers with the one that was meant.
fn is_top_level(argument: &OsStr) -> bool {
    let Some(argument) = argument.to_str() else {
        return false;
    };
    if matches!(argument, "help" | "-h" | "--help" | "-V" | "--version") {
        return true;
    }
    let may_be_misspelt = argument.bytes().all(|b| b.is_ascii_alphabetic()) && !Path::new(argument).exists();
    Cli::command().get_subcommands().any(|command| {
        let name = command.get_name();
        // Two letters: one wrong, or two swapped. Of a short name that would leave too little.
        let most = name.len().div_ceil(3).min(2);
        argument == name || (may_be_misspelt && strsim::levenshtein(argument, name) <= most)
    })
}
