//! Arguments of `octray merge`.

use super::limits::MemoryArgs;
use crate::cli::{
    CliError,
    plan::{JsonTarget, MergePlan, Origin, PicturePath, is_standard_stream},
};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `octray merge`.
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Tiles of one picture by `octray render --crop`, in any order: .png, .ppm, .qoi, .bmp, .tiff or .exr
    #[arg(required = true, value_name = "TILE")]
    pub tiles: Vec<PathBuf>,

    /// The whole picture, in the format of the tiles; - writes PNG tiles to standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,

    /// Do nothing if the picture exists
    #[arg(long)]
    pub skip_existing: bool,

    /// Write the picture's name, size and number of tiles as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    /// Print no closing line
    #[arg(short, long)]
    pub quiet: bool,

    #[command(flatten)]
    pub memory: MemoryArgs,
}

impl MergeArgs {
    /// As plain values.
    ///
    /// # Errors
    /// [`CliError`], as of [`JsonTarget::new`].
    pub fn plan(self) -> Result<MergePlan, CliError> {
        let json = self.json.as_deref().map(JsonTarget::new).transpose()?;
        if json == Some(JsonTarget::Stdout) && is_standard_stream(&self.output) {
            return Err(CliError::Usage(JsonTarget::BESIDE_PICTURE.into()));
        }
        Ok(MergePlan {
            json,
            tiles: self.tiles,
            output: PicturePath {
                path: self.output,
                origin: Origin::Typed,
            },
            skip_existing: self.skip_existing,
            memory: self.memory.limit(),
            quiet: self.quiet,
        })
    }
}
