//! The options whose values come from the config file, for errors about them.

use crate::{cli::CliError, error::SourcePos};

/// An option whose value comes from the config file.
#[derive(Clone, Debug)]
pub struct ConfigDefault {
    /// The option's id.
    pub id: String,
    /// Its long name.
    pub name: String,
    /// Where the file sets it.
    pub at: SourcePos,
}

/// How messages begin that do not name the options that they may be about.
const UNNAMED: [(&str, &[&str]); 4] = [
    // Of typed frames the count is to blame.
    ("--frames", &["turntable", "sphere", "poses"]),
    ("there is no animation in", &["animation", "animation_time"]),
    ("there is no animation", &["animation"]),
    ("several frames", &["turntable", "poses", "frames"]),
];

/// The error, and where the file sets the option that it is about.
pub fn explained(error: CliError, defaults: &[ConfigDefault]) -> CliError {
    let note = |text: &str| {
        // The first option that a message names is the one that it is about.
        let named = |default: &ConfigDefault| Some((position(text, &default.name)?, default.clone()));
        let named = defaults.iter().filter_map(named).min_by_key(|(at, _)| *at);
        let unnamed = || {
            let (_, options) = UNNAMED.iter().find(|(start, _)| text.starts_with(start))?;
            let default = defaults
                .iter()
                .find(|default| options.contains(&default.id.as_str()));
            default.cloned()
        };
        let default = named.map(|(_, default)| default).or_else(unnamed)?;
        Some(format!("; --{} is set in {}", default.name, default.at))
    };
    let with_note = |text: String| match note(&text) {
        Some(note) => text + &note,
        None => text,
    };
    match error {
        CliError::Usage(text) => CliError::Usage(with_note(text)),
        CliError::Failed(text) => CliError::Failed(with_note(text)),
        CliError::Load(error) => match note(&error.message) {
            Some(note) => CliError::Failed(error.report() + &note),
            None => CliError::Load(error),
        },
        error => error,
    }
}

/// Where a text names an option.
fn position(text: &str, name: &str) -> Option<usize> {
    let option = format!("--{name}");
    let is_whole = |&(at, _): &(usize, &str)| {
        let rest = text.get(at + option.len()..).unwrap_or_default();
        !rest.starts_with(|next: char| next.is_alphanumeric() || next == '-' || next == '_')
    };
    text.match_indices(&option).find(is_whole).map(|(at, _)| at)
}

#[cfg(test)]
mod tests;
