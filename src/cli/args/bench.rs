//! Arguments of `octray bench`.

use super::{
    camera::{self, CameraArgs, MeshArgs},
    limits::MemoryArgs,
    values::{self, Size},
};
use crate::{
    accel::BuildQuality,
    bench::Method,
    cli::{
        CliError,
        plan::{BenchPlan, BenchScenes, Build, InputPlan, JsonTarget},
    },
    render::Settings,
};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `octray bench`.
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// Scene (.scn) or mesh (.ply, .obj, .off, .stl, .gltf, .glb, .3mf, .vtk, .vtp, .vtu); - reads one from standard input
    #[arg(required_unless_present = "all", conflicts_with = "all")]
    pub scene: Option<PathBuf>,

    /// Benchmark a suite of generated scenes, from a few thousand to ten million triangles
    #[arg(long, conflicts_with_all = camera::OPTIONS, conflicts_with_all = camera::MESH_OPTIONS)]
    pub all: bool,

    /// Use smaller scenes with --all
    #[arg(long, requires = "all", conflicts_with = "scene")]
    pub quick: bool,

    /// Camera rays across and down; one number for a square
    #[arg(short, long, value_name = "WxH", value_parser = values::size, default_value = "1024x1024")]
    pub size: Size,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    /// How often each method runs; the median is reported
    #[arg(long, value_name = "N", value_parser = values::whole::<100_000>, default_value_t = 9)]
    pub repeat: u32,

    /// Which BVH is traced; auto counts the camera and shadow rays of all runs
    #[arg(long, value_enum, value_name = "QUALITY", default_value_t = Build::Quality(BuildQuality::Best))]
    pub build: Build,

    /// Methods to time, separated by commas or in several options [default: all]
    #[arg(long = "method", value_name = "METHOD", value_enum, value_delimiter = ',')]
    pub methods: Vec<Method>,

    /// Time N whole frames instead, with one thread and with all threads in turn
    #[arg(long, value_name = "N", value_parser = values::whole::<100_000>, conflicts_with_all = ["methods", "json", "repeat"])]
    pub frames: Option<u32>,

    /// Write the results as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,

    #[command(flatten)]
    pub memory: MemoryArgs,
}

impl BenchArgs {
    /// Checks the arguments.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn plan(&self) -> Result<BenchPlan, CliError> {
        let Size { width, height } = self.size;
        let settings = Settings {
            width,
            height,
            threads: Some(1),
            ..Settings::default()
        };
        settings.validate()?;
        let scenes = match &self.scene {
            None => BenchScenes::Suite { quick: self.quick },
            Some(path) => {
                if self.mesh.environment.is_some() {
                    let why = "bench shows meshes in plain light, so --environment has no effect";
                    return Err(CliError::Usage(why.to_owned()));
                }
                let aspect = f64::from(width) / f64::from(height);
                let (camera, mesh) = (self.camera.options(), self.mesh.options(None));
                BenchScenes::One(Box::new(InputPlan::new(path, camera, mesh, aspect)?))
            }
        };
        Ok(BenchPlan {
            scenes,
            memory: self.memory.limit(),
            methods: if self.methods.is_empty() {
                Method::ALL.to_vec()
            } else {
                self.methods.clone()
            },
            settings,
            repeat: self.frames.unwrap_or(self.repeat),
            frames_only: self.frames.is_some(),
            build: self.build,
            json: self.json.as_deref().map(JsonTarget::new).transpose()?,
        })
    }
}
