//! Arguments of `octray view`.

use super::{
    camera::{CameraArgs, MeshArgs},
    limits::MemoryArgs,
    trace::TraceArgs,
    values::{self, Size},
};
use crate::cli::{
    CliError,
    plan::{InputPlan, JsonTarget, ViewPlan},
};
use clap::Args;
use std::{path::PathBuf, time::Duration};

/// Arguments of `octray view`.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// Scene (.scn) or mesh (.ply, .obj, .off, .stl, .gltf, .glb, .3mf); - reads one from standard input
    pub scene: PathBuf,

    /// Width and height of the window, pixels
    #[arg(short, long, value_name = "WxH", value_parser = values::size, default_value = "512x512")]
    pub size: Size,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    #[command(flatten)]
    pub trace: TraceArgs,

    /// Time for a frame while the camera moves, milliseconds; slower frames are traced at a lower resolution (a frame of all
    /// pixels may take twice as long, one of a quarter of the window's sides three times)
    #[arg(long, value_name = "MS", value_parser = values::whole::<10_000>, default_value_t = 16)]
    pub budget: u32,

    /// Orbit for this time, print the speed, and exit
    #[arg(long, value_name = "SECONDS", value_parser = values::seconds)]
    pub benchmark: Option<f64>,

    #[command(flatten)]
    pub memory: MemoryArgs,

    /// Write the benchmark's results as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE", requires = "benchmark")]
    pub json: Option<PathBuf>,
}

impl ViewArgs {
    /// Checks the arguments.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn plan(&self) -> Result<ViewPlan, CliError> {
        let settings = self.trace.settings(self.size)?;
        let aspect = f64::from(settings.width) / f64::from(settings.height);
        let (camera, mesh) = (self.camera.options(), self.mesh.options(false));
        Ok(ViewPlan {
            input: InputPlan::new(&self.scene, camera, mesh, aspect)?,
            settings,
            build: self.trace.build,
            budget: Duration::from_millis(u64::from(self.budget)),
            benchmark: self.benchmark.map(Duration::from_secs_f64),
            json: self.json.as_deref().map(JsonTarget::new).transpose()?,
            memory: self.memory.limit(),
        })
    }
}
