//! Arguments of `octray render` for several pictures, and for comparing them.

use super::{
    turntable::{self, Frames},
    value,
};
use clap::Args;
use std::path::PathBuf;

/// Which pictures are made.
#[derive(Args, Debug)]
#[command(next_help_heading = "Several pictures")]
pub struct SeriesArgs {
    /// Leave out pictures whose files are there already
    #[arg(long, conflicts_with = "compare")]
    pub skip_existing: bool,

    /// Go around what the camera looks at in N pictures; a run of # in -o stands for their numbers from 1 on
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub turntable: Option<u32>,

    /// Of a turntable, only the pictures with these numbers, so that several machines can share the work
    #[arg(long, value_name = "A-B", value_parser = turntable::frames, requires = "turntable")]
    pub frames: Option<Frames>,
}

/// What pictures are compared with.
#[derive(Args, Debug)]
#[command(next_help_heading = "Comparison")]
pub struct CompareArgs {
    /// Compare the picture, as it was rendered, with this one, and exit with 5 if they differ
    #[arg(long, value_name = "REFERENCE")]
    pub compare: Option<PathBuf>,

    /// How far a channel may be off before its pixel counts as different, in levels of 255
    #[arg(long, value_name = "LEVELS", value_parser = value::levels, default_value = "0", requires = "compare")]
    pub tolerance: f32,

    /// How many pixels may be different, as a share of all: 0.001 is one in a thousand
    #[arg(long, value_name = "SHARE", value_parser = value::share, default_value = "0", requires = "compare")]
    pub allow_pixels: f64,

    /// Where the difference is shown if there is one, brightened [default: beside the picture, its name with
    /// -difference.png]
    #[arg(long, value_name = "FILE", requires = "compare")]
    pub difference: Option<PathBuf>,
}
