//! Everything that octray prints. Messages begin like clap's.
//!
//! Messages may contain names and values of untrusted files. Their authors clip each value; here the whole message is made
//! safe again: escaped, and truncated to about a screen.

use crate::{
    cli::CliError,
    error::{clip_path, escape, is_unprintable},
};
use std::{
    io::{self, IsTerminal, Write},
    path::Path,
};

/// The longest message, bytes.
const MOST_BYTES: usize = 4000;
/// The longest message, lines.
const MOST_LINES: usize = 60;
/// The longest line, bytes.
const MOST_OF_LINE: usize = 1800;
/// Warnings about one input.
const MOST_WARNINGS: usize = 20;

/// Writes a command's result to standard output.
///
/// # Errors
/// [`CliError::ClosedPipe`] if the reader has gone, else [`CliError::Failed`].
pub fn print(text: &str) -> Result<(), CliError> {
    let lines: Vec<_> = text.split('\n').map(escape).collect();
    print_bytes(lines.join("\n").as_bytes())
}

/// Writes a picture, a script or JSON to standard output, as it is.
///
/// # Errors
/// As [`print`].
pub fn print_bytes(bytes: &[u8]) -> Result<(), CliError> {
    check_stdout()?;
    let mut stdout = io::stdout().lock();
    stdout
        .write_all(bytes)
        .and_then(|()| stdout.flush())
        .map_err(|error| CliError::writing("standard output", &error))
}

/// Refuses a standard output that was closed or opened for reading: the standard library would ignore failed writes.
///
/// # Errors
/// [`CliError::Failed`].
pub fn check_stdout() -> Result<(), CliError> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{OFlags, fcntl_getfl};
        let flags = fcntl_getfl(io::stdout());
        if !flags.is_ok_and(|flags| flags.intersects(OFlags::WRONLY | OFlags::RDWR)) {
            return Err(CliError::Failed(
                "cannot write standard output: it is closed, or open for reading only".into(),
            ));
        }
    }
    Ok(())
}

/// Flushes standard output after a library has written to it.
///
/// # Errors
/// As [`print`].
pub fn flush() -> Result<(), CliError> {
    check_stdout()?;
    (io::stdout().flush()).map_err(|error| CliError::writing("standard output", &error))
}

/// Whether standard output is a terminal.
pub fn prints_to_terminal() -> bool {
    io::stdout().is_terminal()
}

/// Whether messages go to a terminal, where progress can be shown.
pub fn notes_to_terminal() -> bool {
    io::stderr().is_terminal()
}

/// Writes to standard error. A closed standard error is not a failure.
pub fn note(text: &str) {
    let _ = io::stderr().write_all(on_a_screen(text).as_bytes());
}

/// Warns on standard error.
fn warning(text: &str) {
    note(&format!("warning: {}\n", escape(text)));
}

/// Prints these warnings, or the first ones and the number of others.
pub fn warnings(texts: impl IntoIterator<Item = String>) {
    let mut texts = texts.into_iter();
    texts.by_ref().take(MOST_WARNINGS).for_each(|text| warning(&text));
    match texts.count() {
        0 => {}
        1 => note("warning: and 1 more warning\n"),
        more => note(&format!("warning: and {more} more warnings\n")),
    }
}

/// Prints the error of a command on standard error.
pub fn error(text: &str) {
    note(&format!("error: {text}\n"));
}

/// Says why a scene is skipped.
pub fn skipped(path: &Path, why: &CliError) {
    let (path, text) = (clip_path(path), why.text().unwrap_or_default());
    // Errors of loading begin with the path, too.
    let path = match text.strip_prefix(&path) {
        Some(rest) if rest.starts_with(':') => String::new(),
        _ => format!("{path}: "),
    };
    error(&format!("skipped: {path}{text}"));
}

/// The end of a call that skipped this many scenes.
///
/// # Errors
/// [`CliError::Failed`] if there are any.
pub fn end(skipped: usize) -> Result<(), CliError> {
    match skipped {
        0 => Ok(()),
        1 => Err(CliError::Failed("1 scene was skipped".into())),
        count => Err(CliError::Failed(format!("{count} scenes were skipped"))),
    }
}

/// The lines of `text`, escaped, if they fit on a screen; else the first and the last of them: the last cause of an error
/// is the one that matters.
fn on_a_screen(text: &str) -> String {
    let (body, end) = match text.strip_suffix('\n') {
        Some(body) => (body, "\n"),
        None => (text, ""),
    };
    let total = body.split('\n').count();
    let whole = first_lines(body.split('\n'), MOST_LINES, MOST_BYTES);
    if whole.len() == total {
        return whole.join("\n") + end;
    }
    let mut lines = body.split('\n');
    let mut shown = first_lines(lines.by_ref(), MOST_LINES / 2, MOST_BYTES / 2);
    let mut last = first_lines(lines.rev(), MOST_LINES / 2, MOST_BYTES / 2);
    last.reverse();
    match total - shown.len() - last.len() {
        0 => {}
        1 => shown.push("... 1 line ...".into()),
        left => shown.push(format!("... {left} lines ...")),
    }
    shown.extend(last);
    shown.join("\n") + end
}

/// Takes lines, escaped, as long as they fit, at least one.
fn first_lines<'a>(
    lines: impl Iterator<Item = &'a str>,
    most_lines: usize,
    most_bytes: usize,
) -> Vec<String> {
    let (mut taken, mut bytes) = (Vec::new(), 0);
    for line in lines {
        let line = shortened(line);
        bytes += line.len() + 1;
        if taken.len() == most_lines || (bytes > most_bytes && !taken.is_empty()) {
            break;
        }
        taken.push(line);
    }
    taken
}

/// A line, escaped. It may hold several values, each of which was cut before.
fn shortened(line: &str) -> String {
    let head = &line[..line.floor_char_boundary(MOST_OF_LINE)];
    let escaped = escape(head);
    let end = escaped.floor_char_boundary(MOST_OF_LINE);
    if head.len() == line.len() && end == escaped.len() {
        return escaped.into_owned();
    }
    format!("{}...", &escaped[..end])
}

/// JSON without characters that control a terminal. Outside of strings JSON has none but the newline at the end.
pub fn tame_json(json: &str) -> String {
    let is_odd = |c: char| c != '\n' && is_unprintable(c);
    if !json.contains(is_odd) {
        return json.to_owned();
    }
    let mut tame = String::with_capacity(json.len() + 16);
    for c in json.chars() {
        if is_odd(c) {
            for unit in c.encode_utf16(&mut [0; 2]) {
                tame.push_str(&format!("\\u{unit:04x}"));
            }
        } else {
            tame.push(c);
        }
    }
    tame
}

#[cfg(test)]
mod tests;
