//! Arguments of `octray render` for several pictures, and for comparing them.

use super::values;
use crate::cli::{
    CliError,
    plan::{CompareOptions, FrameRange, Poses, Turntable},
};
use clap::Args;
use std::path::PathBuf;

/// What `--poses` takes the place of.
const CAMERAS: [&str; 10] = [
    "turntable",
    "camera",
    "view",
    "eye",
    "target",
    "up",
    "fov",
    "ortho",
    "aperture",
    "focus",
];

/// Frames of a film a second.
const FPS: u32 = 25;

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

    /// Render N frames of a turn around the camera's target: numbered pictures (a run of # in -o is the number, from 1 on), or
    /// a film in one file (.gif, .apng or .y4m); - writes Y4M to standard output
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FRAMES }>)]
    pub turntable: Option<u32>,

    /// Render the scene from every camera of a NeRF transforms.json, or of the images.txt or images.bin of a COLMAP
    /// reconstruction: pictures, whose number is a run of # in -o and whose name in the file is {pose}, or a film
    #[arg(long, value_name = "FILE", conflicts_with_all = CAMERAS)]
    pub poses: Option<PathBuf>,

    /// Write the cameras of all pictures as a NeRF transforms.json
    #[arg(long, value_name = "FILE")]
    pub save_poses: Option<PathBuf>,

    /// Render only frames A to B of the turntable or poses, so that several machines can share the work
    #[arg(long, value_name = "A-B", value_parser = values::frames)]
    pub frames: Option<FrameRange>,

    /// Frames of a film a second [default: 25]
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FPS }>)]
    pub fps: Option<u32>,
}

impl SeriesArgs {
    /// The turntable, or the row of `poses`, if there is one.
    ///
    /// # Errors
    /// [`CliError::Usage`] for options of frames without frames.
    pub fn turntable(&self, poses: Option<&Poses>) -> Result<Option<Turntable>, CliError> {
        let frames = self.frames;
        let count = poses.map(|poses| poses.poses.len() as u32).or(self.turntable);
        let without = match (count, self.frames, self.fps) {
            (None, Some(_), _) => "--frames",
            (None, _, Some(_)) => "--fps",
            _ => return Ok(count.map(|count| Turntable { count, frames })),
        };
        Err(CliError::Usage(format!("{without} needs --turntable or --poses")))
    }

    /// Frames of a film a second.
    pub fn fps(&self) -> u32 {
        self.fps.unwrap_or(FPS)
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
