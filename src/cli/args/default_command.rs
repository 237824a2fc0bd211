//! Arguments before clap sees them: `octray SCENE` for `octray render SCENE`, values that begin with a minus, and
//! `octray help --help`.

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

/// Joins an option and a value such as `-1,2,3`, which clap would take for an option: no option begins with a digit. Joins
/// `--edges` and a number, which clap would take for a file, because the option needs no value.
pub fn with_joined_values(arguments: Vec<OsString>) -> Vec<OsString> {
    let mut joined: Vec<OsString> = Vec::with_capacity(arguments.len());
    let mut options_end = false;
    for argument in arguments {
        let is_option = |word: &OsString| {
            let bytes = word.as_encoded_bytes();
            bytes.starts_with(b"-") && bytes.len() > 1 && !bytes.contains(&b'=')
        };
        let is_value_of = |option: &OsString| {
            is_negative(&argument) && is_option(option) && !is_negative(option)
                || option == "--edges" && is_number(&argument)
        };
        match joined.last_mut() {
            Some(option) if !options_end && is_value_of(option) => {
                option.push("=");
                option.push(argument);
            }
            _ => {
                options_end |= argument == "--";
                joined.push(argument);
            }
        }
    }
    joined
}

/// Leaves `--help` out after `octray help`: clap takes it for the name of a command.
pub fn with_plain_help(mut arguments: Vec<OsString>) -> Vec<OsString> {
    if arguments.get(1).is_some_and(|first| first == "help") {
        arguments.retain(|argument| argument != "--help" && argument != "-h");
    }
    arguments
}

fn is_number(argument: &OsStr) -> bool {
    argument.to_str().is_some_and(|text| text.parse::<f64>().is_ok())
}

fn is_negative(argument: &OsStr) -> bool {
    matches!(
        argument.as_encoded_bytes(),
        [b'-', b'0'..=b'9', ..] | [b'-', b'.', b'0'..=b'9', ..]
    )
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

#[cfg(test)]
mod tests;
