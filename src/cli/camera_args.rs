//! Which camera looks, and how a mesh is shown: arguments of `render`, `view` and `bench`.

use super::value;
use clap::{Args, ValueEnum};
use glam::DVec3;

/// Which way to look.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// One of the file's own cameras, by name or number; of a scene's meshes, too [default: a scene's own first one, else
    /// --view 1; a mesh is framed whole]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["view", "eye"])]
    pub camera: Option<String>,

    /// One of the course's viewpoints
    #[arg(long, value_name = "1..6", value_parser = clap::value_parser!(u32).range(1..=6), conflicts_with = "eye")]
    pub view: Option<u32>,

    /// Where the camera stands, instead of the scene's camera or a viewpoint
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,

    /// What the camera looks at [default: what the scene's camera does; 0,0,0.5 with --eye or --view; a mesh's middle]
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub target: Option<DVec3>,

    /// Which way is up [default: as the scene's camera has it; 0,0,1 with --eye or --view; a mesh's up axis]
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub up: Option<DVec3>,

    /// Vertical field of view, degrees [default: that of the scene's camera; 45 with --eye or --view]
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub fov: Option<f64>,
}

/// How a mesh is shown that comes without a scene.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Meshes")]
pub struct MeshArgs {
    /// The camera will turn around the mesh, which is to stay whole in the picture.
    #[arg(skip)]
    pub turning: bool,

    /// Which axis of the mesh points up [default: y for .obj, .gltf and .glb, z for .ply and .stl]
    #[arg(long, value_enum, value_name = "AXIS")]
    pub up_axis: Option<UpArg>,

    /// Put the mesh on a ground
    #[arg(long)]
    pub ground: bool,

    /// If the mesh has no normals, smooth it where faces meet at no more than this angle, degrees
    #[arg(long, value_name = "DEG", value_parser = value::angle)]
    pub smooth_angle: Option<f64>,

    /// Light the mesh as it is lit when seen from this direction [default: that of the eye]
    #[arg(long, value_name = "x,y,z", value_parser = value::vector, allow_hyphen_values = true)]
    pub lit_from: Option<DVec3>,
}

/// See [`UpAxis`](crate::format::mesh::UpAxis).
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UpArg {
    /// As in glTF
    Y,
    /// As in scenes
    Z,
}
