//! A line of a scene file and its place.

use super::words::Word;
use crate::error::{LoadError, LoadErrorKind, SourcePos};
use std::{path::PathBuf, sync::Arc};

/// A line and its place.
pub(super) struct Line<'a> {
    pub(super) file: &'a Arc<PathBuf>,
    /// 1-based.
    pub(super) number: u32,
    pub(super) bytes: &'a [u8],
    /// The text after it.
    pub(super) rest: &'a [u8],
    /// The places of the `include` statements that lead to its file, from the scene inwards.
    pub(super) includes: &'a [SourcePos],
}

impl Line<'_> {
    /// The place of the byte `start`.
    pub(super) fn at(&self, start: usize) -> SourcePos {
        SourcePos {
            file: Arc::clone(self.file),
            line: self.number,
            column: u32::try_from(start + 1).unwrap_or(u32::MAX),
        }
    }

    /// An error about the `width` bytes from `start`.
    pub(super) fn error(&self, start: usize, width: usize, message: impl AsRef<str>) -> LoadError {
        LoadError::new(self.at(start), message).with_line(self.bytes, start..start.saturating_add(width))
    }

    /// An error about a statement that is one too many.
    pub(super) fn too_many(&self, word: &Word<'_>, message: impl AsRef<str>) -> LoadError {
        self.error_at(word, message).with_kind(LoadErrorKind::Limit)
    }

    /// An error about a word.
    pub(super) fn error_at(&self, word: &Word<'_>, message: impl AsRef<str>) -> LoadError {
        self.error(word.start, word.width(), message)
    }
}
