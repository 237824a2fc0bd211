//! Messages about the program's options, in the words of the Python package.

use octray::{cli::CliError, error::LoadErrorKind};
use pyo3::{
    exceptions::{PyFileNotFoundError, PyMemoryError, PyValueError},
    prelude::*,
};
use std::io::ErrorKind;

/// What messages say to users of the program, and to those of the package.
const PHRASES: [(&str, &str); 8] = [
    (
        "use --view or --eye",
        "choose a viewpoint from 1 to 6, or give a dictionary, such as {\"from\": \"front\"} or {\"eye\": (4, 3, 2)}",
    ),
    (
        "use --from or --eye",
        "give a dictionary, such as {\"from\": \"front\"} or {\"eye\": (4, 3, 2)}",
    ),
    ("choose it with --camera 1", "choose it with camera=\"1\""),
    (
        "give its diameter with --aperture",
        "give its diameter as aperture",
    ),
    ("--up 0,1,0", "\"up\": (0, 1, 0)"),
    ("--ortho fit", "\"ortho\": \"fit\""),
    ("a side with --from", "a side as \"from\""),
    (" (see --max-memory)", ""),
];

/// The program's options that are arguments, or keys of a camera, by the same name.
const OPTIONS: [&str; 17] = [
    "from",
    "focus",
    "style",
    "ground",
    "up-axis",
    "smooth-angle",
    "point-size",
    "color-by",
    "color-map",
    "color-range",
    "animation-time",
    "animation",
    "lit-from",
    "environment-rotate",
    "environment",
    "samples",
    "max-depth",
];

/// A message of the program with the names of Python's arguments.
pub fn in_python(text: &str) -> String {
    let replace = |text: String, (theirs, ours): &(&str, &str)| text.replace(theirs, ours);
    let phrased = PHRASES.iter().fold(text.to_owned(), replace);
    let words: Vec<String> = phrased.split(' ').map(without_dashes).collect();
    words.join(" ")
}

/// An option as an argument, and any other word as it is.
fn without_dashes(word: &str) -> String {
    let Some(option) = word.strip_prefix("--") else {
        return word.to_owned();
    };
    let end = option.find(|letter: char| !letter.is_ascii_lowercase() && letter != '-');
    match option.split_at(end.unwrap_or(option.len())) {
        (name, rest) if OPTIONS.contains(&name) => name.replace('-', "_") + rest,
        _ => word.to_owned(),
    }
}

/// The error for Python.
pub fn raised(error: &CliError) -> PyErr {
    let text = error.text().unwrap_or_else(|| "interrupted".to_owned());
    let text = match error {
        // Names of files, which may contain any words.
        CliError::Load(error) if matches!(error.kind(), LoadErrorKind::Io(_)) => text,
        _ => in_python(&text),
    };
    match error {
        CliError::Memory(_) => PyMemoryError::new_err(text),
        CliError::Load(error)
            if error.cause.is_none() && error.kind() == LoadErrorKind::Io(ErrorKind::NotFound) =>
        {
            PyFileNotFoundError::new_err(text)
        }
        _ => PyValueError::new_err(text),
    }
}
