//! Errors about bytes of a text: their line, found only when there is an error.

use crate::error::{LoadError, SourcePos};
use std::{
    ops::Range,
    path::{Path, PathBuf},
    sync::Arc,
};

/// What is wrong with which bytes of a text.
#[derive(Debug)]
pub(super) struct TextFault {
    pub(super) range: Range<usize>,
    pub(super) message: String,
}

impl TextFault {
    pub(super) fn new(range: Range<usize>, message: impl Into<String>) -> Self {
        Self {
            range,
            message: message.into(),
        }
    }

    /// The fault with its line and column in `text`, the text of `file`.
    pub(super) fn into_error(self, text: &[u8], file: &Path) -> LoadError {
        text_error(text, &Arc::new(file.to_path_buf()), self.range, &self.message)
    }
}

/// An error about bytes `range` of `text`.
pub(super) fn text_error(text: &[u8], file: &Arc<PathBuf>, range: Range<usize>, message: &str) -> LoadError {
    let (before, rest) = text.split_at(range.start.min(text.len()));
    let line_start = before.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
    let column = before.len() - line_start;
    let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
    let line_end = before.len() + rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
    let shown = text.get(line_start..line_end).unwrap_or_default();
    let width = range.end.min(line_end).saturating_sub(range.start).max(1);
    let at = SourcePos {
        file: Arc::clone(file),
        line: u32::try_from(line).unwrap_or(u32::MAX),
        column: u32::try_from(column + 1).unwrap_or(u32::MAX),
    };
    LoadError::new(at, message).with_line(shown, column..column + width)
}

/// Refuses what cannot be a text; `expected` says what the file should be.
pub(super) fn refuse_binary(bytes: &[u8], expected: &str) -> Result<(), TextFault> {
    // What an editor writes that says "Unicode" and means UTF-16.
    if let [0xff, 0xfe, ..] | [0xfe, 0xff, ..] = bytes {
        let message = format!("this is UTF-16, expected {expected} in UTF-8 or ASCII");
        return Err(TextFault::new(0..2, message));
    }
    match bytes.iter().position(|&byte| byte == 0) {
        Some(nul) => {
            let message = format!("found a NUL byte: this is binary data, expected {expected}");
            Err(TextFault::new(nul..nul + 1, message))
        }
        None => Ok(()),
    }
}

/// Words between blanks, each with the place where it starts.
#[derive(Clone)]
pub(super) struct Words<'a> {
    text: &'a [u8],
    at: usize,
    end: usize,
}

impl<'a> Words<'a> {
    /// The words of `range` of `text`.
    pub(super) fn new(text: &'a [u8], range: Range<usize>) -> Self {
        Self {
            text,
            at: range.start,
            end: range.end.min(text.len()),
        }
    }

    /// Right behind the word read last.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// Bytes of the text.
    pub(super) fn text(&self, range: Range<usize>) -> &'a [u8] {
        self.text.get(range).unwrap_or_default()
    }

    /// Where the last word ends.
    pub(super) fn end_of_words(&self) -> usize {
        self.rest().end
    }

    /// What has not been read: a place behind the last word if nothing is left.
    pub(super) fn rest(&self) -> Range<usize> {
        let text = self.text.get(self.at..self.end).unwrap_or_default();
        let lead = text.len() - text.trim_ascii_start().len();
        let start = if lead == text.len() {
            self.at
        } else {
            self.at + lead
        };
        start..start + text.trim_ascii().len()
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = (&'a [u8], Range<usize>);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let text = self.text.get(self.at..self.end)?;
        let start = text.iter().position(|byte| !byte.is_ascii_whitespace())?;
        let word = text.get(start..)?;
        let length = word.iter().position(u8::is_ascii_whitespace);
        let word = word.get(..length.unwrap_or(word.len()))?;
        let start = self.at + start;
        self.at = start + word.len();
        Some((word, start..self.at))
    }
}
