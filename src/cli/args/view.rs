//! Arguments of `octray view`.

use super::{
    camera::{CameraArgs, MeshArgs},
    config,
    limits::MemoryArgs,
    picture::{EdgeArgs, SampleArgs, StyleArgs, TransferArgs},
    series::FPS,
    trace::TraceArgs,
    values::{self, Size},
};
use crate::cli::{
    CliError,
    plan::{Backdrop, InputPlan, JsonTarget, Look, Looks, MeshOptions, PictureOptions, ViewPlan},
    write::Z_STEP,
};
use clap::Args;
use std::{path::PathBuf, time::Duration};

/// Samples of the last picture at rest.
const SAMPLES_AT_REST: u32 = 64;
/// Help of `--samples` here.
const SAMPLES_HELP: &str = "Samples per pixel of the last picture at rest. auto takes at most 16 and auto:N at most N, \
                            fewer where a pixel looks like its neighbours. It may miss details thinner than a pixel, seldom \
                            from auto:64 on. [default: 64; auto:64 for meshes, unless --style plain]";

/// Arguments of `octray view`.
#[derive(Args, Debug)]
#[command(mut_arg("samples", |samples| samples.help(SAMPLES_HELP)))]
pub struct ViewArgs {
    /// Scene (.scn) or mesh (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu); - reads one from standard input
    pub scene: PathBuf,

    /// Width and height of the window, pixels; one number for a square
    #[arg(short, long, value_name = "WxH", value_parser = values::size, default_value = "512x512")]
    pub size: Size,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    #[command(flatten)]
    pub style: StyleArgs,

    #[command(flatten)]
    pub transfer: TransferArgs,

    #[command(flatten)]
    pub edges: EdgeArgs,

    #[command(flatten)]
    pub sampling: SampleArgs,

    #[command(flatten)]
    pub trace: TraceArgs,

    /// Time per frame while the camera moves, milliseconds; slower frames are traced at a lower resolution
    #[arg(long, value_name = "MS", value_parser = values::whole::<10_000>, default_value_t = 16)]
    pub budget: u32,

    /// Frames per second of an animated scene or mesh
    #[arg(long, value_name = "N", value_parser = values::whole::<{ values::MOST_FPS }>, default_value_t = FPS)]
    pub fps: u32,

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
        let aspect = f64::from(self.size.width) / f64::from(self.size.height);
        let style = self.style.style();
        let mesh = MeshOptions {
            style,
            is_style_given: self.style.style.is_some(),
            ..self.mesh.options(None)
        };
        Ok(ViewPlan {
            input: InputPlan::new(&self.scene, self.camera.options(), mesh, aspect)?,
            looks: self.looks()?,
            has_config: config::is_present(),
            build: self.trace.build,
            budget: Duration::from_millis(u64::from(self.budget)),
            fps: self.fps,
            benchmark: self.benchmark.map(Duration::from_secs_f64),
            json: self.json.as_deref().map(JsonTarget::new).transpose()?,
            memory: self.memory.limit(),
        })
    }

    /// How the last picture at rest is made.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn looks(&self) -> Result<Looks, CliError> {
        Ok(Looks {
            scene: self.look(false)?,
            mesh: self.look(self.style.style().is_soft())?,
        })
    }

    /// How it is made: of scenes and plain meshes, or of meshes in a soft style.
    fn look(&self, is_soft: bool) -> Result<Look, CliError> {
        let mut settings = self.trace.settings(self.size)?;
        self.sampling.apply(&mut settings, is_soft, SAMPLES_AT_REST)?;
        let transfer = self.transfer.transfer(is_soft);
        settings.edges = self.edges.edges(transfer);
        settings.validate()?;
        let picture = PictureOptions {
            transfer,
            byte_transfer: transfer,
            backdrop: Backdrop::Scene,
            aovs: Vec::new(),
            z_step: Z_STEP,
            has_color_bar: false,
        };
        Ok(Look { settings, picture })
    }
}
