//! Kinds of load errors, for programs that react to them.

use super::SceneError;
use std::io;

/// The kind of a [`LoadError`](super::LoadError).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum LoadErrorKind {
    /// A file cannot be read: [`io::ErrorKind::NotFound`] if it does not exist.
    Io(io::ErrorKind),
    /// A format that octray does not read, or a file that needs something that octray does not support.
    Unsupported,
    /// Loading would take more memory than its limit or than there is, or more of something than octray takes.
    Limit,
    /// The file does not have what is asked for, such as an animation.
    Absent,
    /// The contents are wrong.
    #[default]
    Invalid,
}

impl From<&io::Error> for LoadErrorKind {
    fn from(error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::FileTooLarge | io::ErrorKind::OutOfMemory => Self::Limit,
            io::ErrorKind::InvalidData => Self::Invalid,
            io::ErrorKind::Unsupported => Self::Unsupported,
            kind => Self::Io(kind),
        }
    }
}

impl From<&SceneError> for LoadErrorKind {
    fn from(error: &SceneError) -> Self {
        match error {
            SceneError::TooMany { .. } | SceneError::OverLimit { .. } | SceneError::NoMemory { .. } => {
                Self::Limit
            }
            _ => Self::Invalid,
        }
    }
}
