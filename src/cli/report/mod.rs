//! The output of a call: messages, progress, statistics.

mod aov;
pub mod bench;
mod bvh;
mod cameras;
pub mod info;
mod lights;
mod materials;
mod message;
mod positions;
mod progress;
mod scalars;
mod stats;
mod text;
mod verdicts;
pub mod verify;
pub mod version;
mod written;

pub use aov::AovReport;
pub use message::{
    check_stdout, end, error, flush, note, notes_to_terminal, print, print_bytes, prints_to_terminal,
    skipped, tame_json, warnings,
};
pub use progress::{RenderBar, StageBar, VerifyBar, remove_bar};
pub use stats::{RenderReport, Times};
#[cfg(feature = "viewer")]
pub use text::quoted;
pub use text::{SCHEMA, faults_text, grouped, quoted_path};
pub use verdicts::Verdicts;
pub use written::Written;
