//! Arguments of `octray merge`.

use super::limits::MemoryArgs;
use crate::cli::plan::{MergePlan, Origin, PicturePath};
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

    /// Print no closing line
    #[arg(short, long)]
    pub quiet: bool,

    #[command(flatten)]
    pub memory: MemoryArgs,
}

impl MergeArgs {
    /// As plain values.
    pub fn plan(self) -> MergePlan {
        MergePlan {
            tiles: self.tiles,
            output: PicturePath {
                path: self.output,
                origin: Origin::Typed,
            },
            skip_existing: self.skip_existing,
            memory: self.memory.limit(),
            quiet: self.quiet,
        }
    }
}
