//! Arguments of `octray render` for several pictures, and for comparing them.

use super::{camera, values};
use crate::cli::{
    CliError,
    plan::{
        CompareOptions, FrameRange, Keyframes, NOT_PLAYED_FROM_STANDARD_INPUT, Orbit, Playing, Poses,
        Turntable, has_number, is_standard_stream, keyframes,
    },
    process,
    write::is_animation,
};
use clap::Args;
use std::path::{Path, PathBuf};

/// Frames per second of an animation.
pub(super) const FPS: u32 = 25;

/// What an animation from standard input needs.
pub(super) const FRAMES_OF_STANDARD_INPUT: &str = "the frames of standard input are not known before it is read: give \
                                                   --frames A-B for a scene, or name the file of a mesh that moves";

/// Which pictures are made.
#[derive(Args, Debug)]
#[command(next_help_heading = "Several pictures")]
pub struct SeriesArgs {
    /// Skip pictures whose files exist
    #[arg(long, conflicts_with = "compare")]
    pub skip_existing: bool,

    /// Put all pictures into a contact sheet with this many columns [default of -o: sheet.png]
    #[arg(long, value_name = "COLUMNS", value_parser = values::whole::<{ values::MOST_COLUMNS }>)]
    pub sheet: Option<u32>,

    /// Skip scenes that cannot be loaded, with a message each, and exit with 1 at the end
    #[arg(long)]
    pub keep_going: bool,

    /// Render N frames of a turn around the camera's target, as numbered pictures or as one animation. In -o, a run of #
    /// stands for the number, from 1; .gif, .apng and .y4m are animations, and - is Y4M on standard output
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FRAMES }>)]
    pub turntable: Option<u32>,

    /// Like --turntable, with N cameras spread evenly over a sphere around the target
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FRAMES }>, conflicts_with = "turntable")]
    pub sphere: Option<u32>,

    /// Render the scene from every camera of a NeRF transforms.json or of a COLMAP reconstruction (its folder, images.txt or
    /// images.bin), as pictures or as one animation. In -o, a run of # stands for the number, {pose} for the name in the file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["turntable", "sphere"], conflicts_with_all = camera::OPTIONS)]
    pub poses: Option<PathBuf>,

    /// Write the cameras of all pictures as a NeRF transforms.json, also of those that --frames or --skip-existing leaves out:
    /// calls for parts of a series write the same file
    #[arg(long, value_name = "FILE", conflicts_with_all = ["crop", "sheet"])]
    pub save_poses: Option<PathBuf>,

    /// Render only frames A to B of the turntable, the poses, an animated scene or a glTF animation, so that several machines
    /// can share the work
    #[arg(long, value_name = "A-B", value_parser = values::frames)]
    pub frames: Option<FrameRange>,

    /// Frames per second of an animation; browsers play a .gif of more than 50 too slowly, but not an .apng
    /// [default: 25]
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FPS }>)]
    pub fps: Option<u32>,
}

impl SeriesArgs {
    /// The turntable, or the row of `poses`, if there is one.
    pub fn turntable(&self, poses: Option<&Poses>) -> Option<Turntable> {
        let frames = self.frames;
        let count = poses
            .map(|poses| poses.poses.len() as u32)
            .or(self.turntable)
            .or(self.sphere);
        count.map(|count| Turntable { count, frames })
    }

    /// How the camera goes around its target, if it does.
    pub fn orbit(&self) -> Option<Orbit> {
        let turn = self.turntable.map(|_| Orbit::Turn);
        turn.or(self.sphere.map(|_| Orbit::Sphere))
    }

    /// The frames of each scene, if one of them moves and these options or the name of the `output` ask for all of them.
    /// Only an option that `is_typed` needs frames: a default in the config file is for scenes that have some. Meshes move if
    /// there is `playing`.
    ///
    /// # Errors
    /// [`CliError::Usage`] for options of frames without frames, [`CliError::Load`] for a scene that cannot be read.
    pub fn keyframes(
        &self,
        scenes: &[PathBuf],
        output: Option<&Path>,
        is_typed: &dyn Fn(&str) -> bool,
        playing: Option<Playing<'_>>,
    ) -> Result<Vec<Keyframes>, CliError> {
        let is_named = output.is_some_and(|output| has_number(output) || is_animation(output));
        let option = match (self.frames, self.fps) {
            (Some(_), _) if is_typed("frames") => "--frames",
            (_, Some(_)) if is_typed("fps") => "--fps",
            _ if is_named || self.frames.is_some() => "",
            _ => return Ok(Vec::new()),
        };
        let is_animated = option == "--fps" || output.is_some_and(is_animation);
        // Whether there must be frames.
        let is_asked = is_named || !option.is_empty();
        let is_read_later = || scenes.iter().any(|scene| is_standard_stream(scene));
        if !is_asked && is_read_later() {
            return Ok(Vec::new());
        }
        // Scenes have no animations with names.
        let is_mesh = playing.is_some_and(|playing| playing.animation.is_some() && !playing.is_default);
        if is_mesh && is_read_later() {
            return Err(CliError::Usage(NOT_PLAYED_FROM_STANDARD_INPUT.into()));
        }
        if self.frames.is_none() && is_animated && is_read_later() {
            return Err(CliError::Usage(format!("-: {FRAMES_OF_STANDARD_INPUT}")));
        }
        // Several threads read large files.
        process::start_threads()?;
        let found = keyframes(scenes, self.frames, playing, self.keep_going)?;
        if found.is_empty() && !is_asked {
            return Ok(found);
        }
        if found.is_empty() && playing.is_none() {
            let why = "--animation-time shows one pose: leave it out to play the animation";
            return Err(CliError::Usage(why.into()));
        }
        if found.is_empty() && !option.is_empty() {
            return Err(CliError::Usage(format!(
                "{option} needs --turntable, --sphere, --poses, a scene with keyframes (`at`) or a glTF animation"
            )));
        }
        Ok(found)
    }

    /// Frames per second of an animation.
    pub fn fps(&self) -> u32 {
        self.fps.unwrap_or(FPS)
    }
}

/// What pictures are compared with.
#[derive(Args, Debug)]
#[command(next_help_heading = "Comparison")]
pub struct CompareArgs {
    /// Compare the rendered picture with this one, and exit with 5 if they differ. Pixels with alpha 0 in both are equal; in
    /// EXR files their colours count. If only one of the two has floats (EXR, float TIFF), they become bytes first, as this call
    /// would write them to a PNG. Red, green and blue are compared, and alpha unless both pictures are opaque
    #[arg(long, value_name = "REFERENCE")]
    pub compare: Option<PathBuf>,

    /// Largest difference of a channel that still counts as equal, in levels of 255
    #[arg(long, value_name = "LEVELS", value_parser = values::levels, default_value = "0", requires = "compare")]
    pub tolerance: f32,

    /// Share of all pixels that may differ, such as 0.001
    #[arg(long, value_name = "SHARE", value_parser = values::share, default_value = "0", requires = "compare")]
    pub allow_pixels: f64,

    /// Where to write the difference, brightened, if there is one [default: the picture's name with -difference.png]
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
