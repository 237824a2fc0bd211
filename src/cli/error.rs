//! Why a command failed, and its exit code.

use crate::{error::LoadError, render::RenderError, scene::CameraError};
use std::io;

/// Why a command failed.
#[derive(Debug)]
pub enum CliError {
    /// The arguments are wrong. Exit code 2.
    Usage(String),
    /// The arguments are wrong, and clap has said so already. Exit code 2.
    UsageShown,
    /// The scene cannot be loaded. Exit code 1.
    Load(LoadError),
    /// The disk or a limit failed. Exit code 1.
    Failed(String),
    /// The reader of the output has gone. Not reported. Exit code 1.
    ClosedPipe,
    /// There is no display for a window. Exit code 3.
    NoDisplay(String),
    /// A comparison differs. Exit code 5.
    Differs(String),
    /// Stopped by a signal. Exit code 130.
    Interrupted,
}

impl CliError {
    /// The program's exit code.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Load(_) | Self::Failed(_) | Self::ClosedPipe => 1,
            Self::Usage(_) | Self::UsageShown => 2,
            Self::NoDisplay(_) => 3,
            Self::Differs(_) => 5,
            Self::Interrupted => 130,
        }
    }

    /// What to print, if anything.
    #[must_use]
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Usage(text) | Self::Failed(text) | Self::NoDisplay(text) | Self::Differs(text) => {
                Some(text.clone())
            }
            Self::Load(error) => Some(error.report()),
            Self::UsageShown | Self::ClosedPipe | Self::Interrupted => None,
        }
    }

    /// `what` could not be written.
    #[must_use]
    pub fn writing(what: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::ClosedPipe,
            _ => Self::Failed(format!("cannot write {what}: {}", reason(error))),
        }
    }
}

impl From<LoadError> for CliError {
    fn from(error: LoadError) -> Self {
        Self::Load(error)
    }
}

impl From<RenderError> for CliError {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Cancelled => Self::Interrupted,
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<CameraError> for CliError {
    /// A scene's own cameras are checked when it is loaded, so the fault is in the arguments.
    fn from(error: CameraError) -> Self {
        Self::Usage(match error {
            CameraError::UpParallel => {
                "the up vector is zero or parallel to the view direction: choose another, such as \
                                        --up 0,1,0 for a view straight down"
                    .into()
            }
            other => other.to_string(),
        })
    }
}

/// The reason, in words without an error number where possible.
fn reason(error: &io::Error) -> String {
    use io::ErrorKind as Kind;
    match error.kind() {
        Kind::NotFound => "no such file or directory".into(),
        Kind::PermissionDenied => "permission denied".into(),
        Kind::ReadOnlyFilesystem => "the file system is read-only".into(),
        Kind::StorageFull => "no space left on the device".into(),
        Kind::QuotaExceeded => "the disk quota is used up".into(),
        Kind::FileTooLarge => "the file would be too large".into(),
        Kind::InvalidFilename => "the name is too long or not allowed".into(),
        Kind::IsADirectory => "it is a directory".into(),
        Kind::NotADirectory => "a part of the path is not a directory".into(),
        _ => error.to_string(),
    }
}
