//! Words of a text and their positions. Lines are counted only for an error.

use super::budget::BudgetError;
use crate::error::{LoadError, LoadErrorKind};
use std::{ops::Range, path::Path};

/// The byte order mark that some editors put before UTF-8.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// The error about [`has_lone_returns`].
pub(super) const LONE_RETURNS: &str =
    "its lines end in CR only, as on Macs before 2001, expected LF or CR LF";

/// Whether a text is UTF-16, which some editors call "Unicode".
pub(super) fn is_utf16(text: &[u8]) -> bool {
    text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff")
}

/// Whether a file is the text that Git has instead of a large file until Git LFS fetches it.
pub(super) fn is_lfs_pointer(text: &[u8]) -> bool {
    text.starts_with(b"version https://git-lfs.github.com/spec/")
}

/// The error about [`is_lfs_pointer`].
pub(super) const LFS_POINTER: &str = "a Git LFS pointer instead of the file: `git lfs pull` fetches the file";

/// Whether lines end with carriage returns without newlines.
pub(super) fn has_lone_returns(text: &[u8]) -> bool {
    let text = text.trim_ascii_end();
    !text.contains(&b'\n') && text.contains(&b'\r')
}

/// Where the text begins after its byte order mark, if it has one.
pub(super) fn after_mark(text: &[u8]) -> usize {
    if text.starts_with(BYTE_ORDER_MARK) {
        BYTE_ORDER_MARK.len()
    } else {
        0
    }
}

/// A fault of some bytes of a text, or of the whole text.
#[derive(Debug)]
pub(super) struct TextFault {
    range: Option<Range<usize>>,
    message: String,
    kind: LoadErrorKind,
}

impl TextFault {
    pub(super) fn new(range: Range<usize>, message: impl Into<String>) -> Self {
        Self {
            range: Some(range),
            message: message.into(),
            kind: LoadErrorKind::Invalid,
        }
    }

    /// A fault without a place in a text, as of binary data.
    #[cfg(feature = "vtk")]
    pub(super) fn of_file(message: impl Into<String>) -> Self {
        Self {
            range: None,
            message: message.into(),
            kind: LoadErrorKind::Invalid,
        }
    }

    /// Whether the file may be right, but takes more than there is.
    pub(super) fn is_limit(&self) -> bool {
        self.kind == LoadErrorKind::Limit
    }

    /// Sets the kind of its error.
    pub(super) fn with_kind(self, kind: LoadErrorKind) -> Self {
        Self { kind, ..self }
    }

    /// Adds line and column; `text` is the text of `file`.
    pub(super) fn into_error(self, text: &[u8], file: &Path) -> LoadError {
        let error = match self.range {
            Some(range) => LoadError::in_text(file, text, range, self.message),
            None => LoadError::whole_file(file, self.message),
        };
        error.with_kind(self.kind)
    }
}

impl From<BudgetError> for TextFault {
    fn from(error: BudgetError) -> Self {
        Self {
            range: None,
            message: error.to_string(),
            kind: LoadErrorKind::Limit,
        }
    }
}

/// Refuses binary data; `expected` says what the file should be.
pub(super) fn refuse_binary(bytes: &[u8], expected: &str) -> Result<(), TextFault> {
    if is_utf16(bytes) {
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

/// Words between spaces, each with its range in the text.
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

    /// The end of the last word read.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// The bytes of a range.
    pub(super) fn text(&self, range: Range<usize>) -> &'a [u8] {
        self.text.get(range).unwrap_or_default()
    }

    /// Where the last word ends.
    pub(super) fn end_of_words(&self) -> usize {
        self.rest().end
    }

    /// The range of the words that are left to read; empty at the end.
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
