//! Numbers and paths as text.

use crate::error::escape;
use std::path::Path;

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

/// A path, quoted for a shell if need be.
pub fn quoted(path: &Path) -> String {
    let text = path.to_string_lossy();
    let plain = |c: char| c.is_alphanumeric() || "/\\._-:+,".contains(c);
    if text.chars().all(plain) {
        text.into_owned()
    } else {
        format!("'{}'", escape(&text).replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests;
