//! Arguments of `octray info`.

use super::limits::MemoryArgs;
use crate::{
    cli::{
        CliError,
        plan::{InfoPlan, is_standard_input},
    },
    format,
};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `octray info`.
#[derive(Args, Debug)]
pub struct InfoArgs {
    /// Scene (.scn) or mesh (.ply, .obj, .stl, .gltf, .glb)
    pub scene: PathBuf,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,

    #[command(flatten)]
    pub memory: MemoryArgs,
}

impl InfoArgs {
    /// Checks the arguments.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn plan(self) -> Result<InfoPlan, CliError> {
        if !is_standard_input(&self.scene) {
            format::check_file(&self.scene)?;
        }
        Ok(InfoPlan {
            memory: self.memory.limit(),
            path: self.scene,
            json: self.json,
        })
    }
}
