//! Arguments of `octray info`.

use super::limits::MemoryArgs;
use crate::{
    cli::{
        CliError,
        plan::{InfoPlan, JsonTarget, is_standard_stream},
    },
    format,
};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `octray info`.
#[derive(Args, Debug)]
pub struct InfoArgs {
    /// Scene (.scn) or mesh (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu); - reads one from standard input
    pub scene: PathBuf,

    /// Write JSON instead of text, to a file or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    #[command(flatten)]
    pub memory: MemoryArgs,
}

impl InfoArgs {
    /// Checks the arguments.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn plan(self) -> Result<InfoPlan, CliError> {
        if !is_standard_stream(&self.scene) {
            format::check_file(&self.scene)?;
        }
        Ok(InfoPlan {
            memory: self.memory.limit(),
            path: self.scene,
            json: self.json.as_deref().map(JsonTarget::new).transpose()?,
        })
    }
}
