//! What `octray job` does: a folder of files that an engine runs.

use super::RenderPlan;
use std::path::PathBuf;

/// What `octray job` does.
#[derive(Debug)]
pub struct JobPlan {
    /// All pictures, checked as `octray render` does.
    pub render: RenderPlan,
    /// The options of `octray render` that all tasks share, each with its value.
    pub options: Vec<String>,
    /// The pattern of `--output`.
    pub output: Option<String>,
    pub engine: Engine,
    pub folder: PathBuf,
    /// Columns and rows of tiles.
    pub tiles: Option<[u32; 2]>,
    /// Frames or tiles of a task.
    pub chunk: u32,
    pub quiet: bool,
}

/// The engine that runs the tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Open Job Description, version 2023-09.
    OpenJd,
    Slurm,
    /// GNU parallel.
    Parallel,
}
