//! Why a command failed, and its exit code.

use crate::{
    error::{LoadError, LoadErrorKind, clip_path, io_reason},
    render::RenderError,
    scene::CameraError,
};
use std::{io, path::Path};

/// Why a command failed.
#[derive(Debug)]
pub enum CliError {
    /// The arguments are wrong. Exit code 2.
    Usage(String),
    /// The arguments are wrong, and clap has said so already. Exit code 2.
    UsageShown,
    /// The scene cannot be loaded. Exit code 1, or 2 if it does not have the animation that is asked for.
    Load(LoadError),
    /// The disk or a limit failed. Exit code 1.
    Failed(String),
    /// More memory is needed than there is or than the limit allows. Exit code 1.
    Memory(String),
    /// The reader of the output has gone. Not reported. Exit code 1.
    ClosedPipe,
    /// There is no display for a window. Exit code 3.
    NoDisplay(String),
    /// A comparison differs. Exit code 5.
    Differs(String),
    /// Stopped by a signal, which ends the process where signals can. Exit code 130 elsewhere.
    Interrupted,
}

impl CliError {
    /// The program's exit code.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Load(error) if error.kind() == LoadErrorKind::Absent => 2,
            Self::Load(_) | Self::Failed(_) | Self::Memory(_) | Self::ClosedPipe => 1,
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
            Self::Usage(text)
            | Self::Failed(text)
            | Self::Memory(text)
            | Self::NoDisplay(text)
            | Self::Differs(text) => Some(text.clone()),
            Self::Load(error) => Some(error.report()),
            Self::UsageShown | Self::ClosedPipe | Self::Interrupted => None,
        }
    }

    /// `what` could not be written.
    #[must_use]
    pub fn writing(what: &str, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::ClosedPipe,
            // A file that is written need not exist, but its directory must.
            io::ErrorKind::NotFound => {
                Self::Failed(format!("cannot write {what}: its directory does not exist"))
            }
            _ => Self::Failed(format!("cannot write {what}: {}", io_reason(error))),
        }
    }

    /// A directory could not be made.
    #[must_use]
    pub fn making(folder: &Path, error: &io::Error) -> Self {
        let is_file = |path: &&Path| path.exists() && !path.is_dir();
        let why = match folder.ancestors().find(is_file) {
            Some(file) => format!("`{}` is a file, expected a directory", clip_path(file)),
            // Of /proc and the like.
            None if error.kind() == io::ErrorKind::NotFound => "no directory can be made there".into(),
            None => io_reason(error),
        };
        Self::Failed(format!("cannot make the directory {}: {why}", clip_path(folder)))
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
            RenderError::Memory(text) => Self::Memory(text),
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
