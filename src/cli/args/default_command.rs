//! `octray SCENE` for `octray render SCENE`.

use super::definition;
use std::{
    ffi::{OsStr, OsString},
    path::Path,
};

/// Inserts `render` before a first argument that is not a command.
///
/// Not done by clap, whose usage errors for optional subcommands mix both levels.
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

/// Whether the argument is a command, or looks like a misspelt one and no such file exists: clap then suggests the
/// command.
fn is_top_level(argument: &OsStr) -> bool {
    let Some(argument) = argument.to_str() else {
        return false;
    };
    if matches!(argument, "help" | "-h" | "--help" | "-V" | "--version") {
        return true;
    }
    let may_be_misspelt = argument.bytes().all(|b| b.is_ascii_alphabetic()) && !Path::new(argument).exists();
    definition().get_subcommands().any(|command| {
        let name = command.get_name();
        // At most two letters (one wrong, or two swapped), and fewer in short names.
        let most = name.len().div_ceil(3).min(2);
        argument == name || (may_be_misspelt && strsim::levenshtein(argument, name) <= most)
    })
}
