//! Arguments of `octray render` for several pictures, and for comparing them.

use super::values;
use crate::cli::plan::{CompareOptions, FrameRange, Turntable};
use clap::Args;
use std::path::PathBuf;

/// Which pictures are made.
#[derive(Args, Debug)]
#[command(next_help_heading = "Several pictures")]
pub struct SeriesArgs {
    /// Skip pictures whose files exist already
    #[arg(long, conflicts_with = "compare")]
    pub skip_existing: bool,

    /// Put all pictures into one, side by side, with their names below [default of -o: sheet.png]
    #[arg(long, value_name = "COLUMNS", value_parser = values::whole::<{ values::MOST_COLUMNS }>)]
    pub sheet: Option<u32>,

    /// Skip scenes that cannot be loaded, say why, and exit with 1 at the end
    #[arg(long)]
    pub keep_going: bool,

    /// Render N frames of a turn around the camera's target: pictures, whose number is a run of # in -o, from 1 on; or a film
    /// in one file, .gif, .apng or .y4m; - writes Y4M to standard output
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FRAMES }>)]
    pub turntable: Option<u32>,

    /// Render only frames A to B of the turntable, so that several machines can share the work
    #[arg(long, value_name = "A-B", value_parser = values::frames, requires = "turntable")]
    pub frames: Option<FrameRange>,

    /// Frames of a film a second
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FPS }>, default_value = "25", requires = "turntable")]
    pub fps: u32,
}

impl SeriesArgs {
    /// The turntable, if there is one.
    pub fn turntable(&self) -> Option<Turntable> {
        let frames = self.frames;
        self.turntable.map(|count| Turntable { count, frames })
    }
}

/// What pictures are compared with.
#[derive(Args, Debug)]
#[command(next_help_heading = "Comparison")]
pub struct CompareArgs {
    /// Compare the rendered picture with this one, and exit with 5 if they differ
    #[arg(long, value_name = "REFERENCE")]
    pub compare: Option<PathBuf>,

    /// Largest difference of a channel that still counts as equal, in levels of 255
    #[arg(long, value_name = "LEVELS", value_parser = values::levels, default_value = "0", requires = "compare")]
    pub tolerance: f32,

    /// Share of all pixels that may differ: 0.001 is one in a thousand
    #[arg(long, value_name = "SHARE", value_parser = values::share, default_value = "0", requires = "compare")]
    pub allow_pixels: f64,

    /// Where to show the difference, brightened, if there is one [default: beside the picture, its name with
    /// -difference.png]
    #[arg(long, value_name = "FILE", requires = "compare")]
    pub difference: Option<PathBuf>,
}

impl CompareArgs {
    /// As plain values; `None` without `--compare`. The name of the difference is the user's if `is_typed`.
    pub fn options(&self, is_typed: bool) -> Option<CompareOptions<'_>> {
        Some(CompareOptions {
            reference: self.compare.as_deref()?,
            difference: self.difference.as_deref(),
            is_typed,
            tolerance: self.tolerance,
            allow_pixels: self.allow_pixels,
        })
    }
}
