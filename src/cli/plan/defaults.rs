//! The options whose values come from the config file, for errors about them.

use crate::{
    cli::CliError,
    error::{SourcePos, clip},
};

/// An option whose value comes from the config file.
#[derive(Clone, Debug)]
pub struct ConfigDefault {
    /// The option's id.
    pub id: String,
    /// Its long name.
    pub name: String,
    /// Its value, if that is a file's name or free text.
    pub words: Option<String>,
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

/// The same of cameras. Those of scenes have no options; their errors are of loading.
const CAMERA: [(&str, &[&str]); 5] = [
    ("the height of the orthographic view", &["ortho"]),
    ("the aperture", &["aperture", "focus"]),
    ("the distance in focus", &["focus"]),
    ("eye and target", &["eye", "target"]),
    ("the up vector", &["up", "eye", "target"]),
];

/// The error, and where the file sets the option that it is about.
pub fn explained(error: CliError, defaults: &[ConfigDefault]) -> CliError {
    match named(&error, defaults) {
        Some(default) => with_place(error, default),
        None => error,
    }
}

/// The same for an error of a plan. If its text names no option, the cause is the option without which the plan succeeds or,
/// if there is no such option, fails in another way. `planned` plans without the option of an id; `None` if its command line is
/// wrong.
pub fn explained_plan(
    error: CliError,
    defaults: &[ConfigDefault],
    planned: impl Fn(&str) -> Option<Result<(), CliError>>,
) -> CliError {
    let text = error.text();
    let blamed = || {
        let others = defaults.iter().filter_map(|default| match planned(&default.id)? {
            Ok(()) => Some((0, default)),
            Err(other) => (other.text() != text).then_some((1, default)),
        });
        // The first of the best.
        Some(others.min_by_key(|(rank, _)| *rank)?.1)
    };
    match named(&error, defaults).or_else(blamed) {
        Some(default) => with_place(error, default),
        None => error,
    }
}

/// The option that an error's text is about.
fn named<'a>(error: &CliError, defaults: &'a [ConfigDefault]) -> Option<&'a ConfigDefault> {
    let text = match error {
        CliError::Usage(text) | CliError::Failed(text) | CliError::Memory(text) => text,
        CliError::Load(error) => &error.message,
        _ => return None,
    };
    // The first option that a message names is the one that it is about.
    let named = |default: &'a ConfigDefault| Some((position(text, &default.name)?, default));
    let named = defaults.iter().filter_map(named).min_by_key(|(at, _)| *at);
    let of_camera = CAMERA.iter().filter(|_| matches!(error, CliError::Usage(_)));
    let unnamed = || {
        let (_, options) = UNNAMED
            .iter()
            .chain(of_camera)
            .find(|(start, _)| text.starts_with(start))?;
        let find = |id: &&str| defaults.iter().find(|default| default.id == *id);
        options.iter().find_map(find)
    };
    let quoted = || {
        let whole = error.text()?;
        defaults.iter().find(|default| default.is_quoted(&whole))
    };
    named.map(|(_, default)| default).or_else(unnamed).or_else(quoted)
}

/// The error with the place of an option.
fn with_place(error: CliError, default: &ConfigDefault) -> CliError {
    let note = format!("; --{} is set in {}", default.name, default.at);
    match error {
        CliError::Usage(text) => CliError::Usage(text + &note),
        CliError::Failed(text) => CliError::Failed(text + &note),
        CliError::Memory(text) => CliError::Memory(text + &note),
        CliError::Load(ref load) => match error.exit_code() {
            2 => CliError::Usage(load.report() + &note),
            _ => CliError::Failed(load.report() + &note),
        },
        error => error,
    }
}

impl ConfigDefault {
    /// Whether a text has the option's value: in backticks, or as a file's name at its beginning, or after "the reference" or
    /// "write".
    fn is_quoted(&self, text: &str) -> bool {
        let Some(words) = self.words.as_deref().map(clip) else {
            return false;
        };
        let begins = |text: &str| {
            let rest = text.strip_prefix(&words);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(':'))
        };
        let after = ["the reference ", "cannot write "];
        text.contains(&format!("`{words}`"))
            || begins(text)
            || after.iter().any(|word| text.split(word).skip(1).any(begins))
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
