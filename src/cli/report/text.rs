//! Numbers and paths as text.

use crate::error::escape;
use std::{borrow::Cow, ffi::OsStr, path::Path};

/// The version of all JSON output. Increased when a field changes its meaning or is removed.
pub const SCHEMA: u32 = 1;

/// "1 without area, 2 duplicate, 3 inverted".
pub fn faults_text(degenerate: usize, duplicate: Option<usize>, inverted: Option<usize>) -> String {
    let mut text = format!("{} without area", grouped(degenerate as u64));
    for (count, what) in [(duplicate, "duplicate"), (inverted, "inverted")] {
        if let Some(count) = count {
            text.push_str(&format!(", {} {what}", grouped(count as u64)));
        }
    }
    text
}

/// `1234567` as `1 234 567`.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// A path as an argument for a shell: never an option.
pub fn quoted_path(path: &Path) -> String {
    if path.as_os_str().as_encoded_bytes().starts_with(b"-") {
        quoted(Path::new(".").join(path).as_os_str())
    } else {
        quoted(path.as_os_str())
    }
}

/// A word, quoted for a shell if need be. What does not print is `\ooo` in `$'...'`, which bash, zsh and POSIX of 2024 know.
pub fn quoted(word: &OsStr) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/._-:+,".contains(c) || cfg!(windows) && c == '\\';
    match word.to_str() {
        Some(text) if text.chars().all(plain) => text.to_owned(),
        Some(text) if matches!(escape(text), Cow::Borrowed(_)) => {
            format!("'{}'", text.replace('\'', "'\\''"))
        }
        _ => format!("$'{}'", in_octal(word.as_encoded_bytes())),
    }
}

/// The inside of `$'...'`.
fn in_octal(bytes: &[u8]) -> String {
    let mut inside = String::new();
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            let text = c.to_string();
            match c {
                '\'' | '\\' => inside.extend(['\\', c]),
                _ if matches!(escape(&text), Cow::Borrowed(_)) => inside.push(c),
                _ => push_octal(&mut inside, text.as_bytes()),
            }
        }
        push_octal(&mut inside, chunk.invalid());
    }
    inside
}

fn push_octal(to: &mut String, bytes: &[u8]) {
    for byte in bytes {
        to.push_str(&format!("\\{byte:03o}"));
    }
}

#[cfg(test)]
mod tests;
