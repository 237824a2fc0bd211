//! Why something was refused, before its place is known.

use super::budget::BudgetError;
use crate::error::{LoadError, LoadErrorKind, SceneError};
use std::{fmt, path::Path};

/// A sentence, and the kind of the error that it becomes.
#[derive(Debug)]
pub(super) struct Reason {
    pub(super) kind: LoadErrorKind,
    pub(super) message: String,
}

impl Reason {
    /// More of something than octray takes.
    pub(super) fn limit(message: String) -> Self {
        Self {
            kind: LoadErrorKind::Limit,
            message,
        }
    }

    /// Something that octray does not read.
    pub(super) fn unsupported(message: impl Into<String>) -> Self {
        Self {
            kind: LoadErrorKind::Unsupported,
            message: message.into(),
        }
    }

    /// The error about the file at `path`.
    pub(super) fn of_file(self, path: &Path) -> LoadError {
        LoadError::whole_file(path, self.message).with_kind(self.kind)
    }
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<String> for Reason {
    fn from(message: String) -> Self {
        Self {
            kind: LoadErrorKind::Invalid,
            message,
        }
    }
}

impl From<&str> for Reason {
    fn from(message: &str) -> Self {
        message.to_owned().into()
    }
}

impl From<BudgetError> for Reason {
    fn from(error: BudgetError) -> Self {
        Self::limit(error.to_string())
    }
}

impl From<SceneError> for Reason {
    fn from(error: SceneError) -> Self {
        Self {
            kind: (&error).into(),
            message: error.to_string(),
        }
    }
}
