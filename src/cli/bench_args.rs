//! Arguments of `octray bench`.

use super::{
    camera_args::{CameraArgs, MeshArgs},
    trace_args::BuildArg,
    value::{self, Size},
};
use crate::{accel::Layout, scene::Scene};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Arguments of `octray bench`.
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// The scene (.scn), or a mesh: .ply, .obj, .stl, .gltf or .glb
    #[arg(required_unless_present = "all", conflicts_with = "all")]
    pub scene: Option<PathBuf>,

    /// Instead of a scene: a suite of generated ones, from a few thousand triangles to ten million
    #[arg(long, conflicts_with_all = ["camera", "view", "eye", "target", "up", "fov", "up_axis", "ground", "smooth_angle"])]
    pub all: bool,

    /// With --all: smaller scenes
    #[arg(long, requires = "all", conflicts_with = "scene")]
    pub quick: bool,

    /// Camera rays across and down
    #[arg(long, value_name = "WxH", value_parser = value::size, default_value = "1024x1024")]
    pub size: Size,

    #[command(flatten)]
    pub camera: CameraArgs,

    #[command(flatten)]
    pub mesh: MeshArgs,

    /// How often each method runs; the median counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), default_value_t = 9)]
    pub repeat: u32,

    /// Which BVH is traced; auto counts camera and shadow rays of all runs
    #[arg(long, value_enum, value_name = "QUALITY", default_value_t = BuildArg::Best)]
    pub build: BuildArg,

    /// How the BVH stores triangles
    #[arg(long, value_enum, value_name = "LAYOUT", default_value_t = LayoutArg::Auto)]
    pub layout: LayoutArg,

    /// What to time, all by default; may be given several times or separated by commas
    #[arg(long = "method", value_name = "METHOD", value_enum, value_delimiter = ',')]
    pub methods: Vec<BenchMethod>,

    /// Instead of ways of tracing: time so many whole frames with one thread and with all, in turns
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["methods", "json", "repeat"])]
    pub frames: Option<u32>,

    /// Write the results as JSON to a file, or to standard output (-)
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// See [`Layout`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LayoutArg {
    /// Indexed from four million triangles on if there are no more vertices, else whole
    Auto,
    /// Each triangle with its corners
    Whole,
    /// The triangles of a leaf with the vertices they share
    Indexed,
}

impl LayoutArg {
    /// What is built over a scene.
    pub fn layout(self, scene: &Scene) -> Layout {
        match self {
            Self::Auto => Layout::for_scene(scene),
            Self::Whole => Layout::Whole,
            Self::Indexed => Layout::Indexed,
        }
    }
}

/// What `octray bench` can time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum BenchMethod {
    /// The scalar reference over the BVH, one ray at a time
    Scalar,
    /// Packets of eight rays
    Packet,
    /// One ray against eight boxes at a time
    Single,
    /// What the renderer uses: up to 512 rays together, packets or single rays
    Render,
}
