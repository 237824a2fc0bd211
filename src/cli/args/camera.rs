//! The camera and how a mesh is shown: arguments of `render`, `view` and `bench`.

use super::values;
use crate::{
    cli::plan::{CameraOptions, ColorBy, ColorMap, MeshOptions, Orbit, Shading, Side, StartView},
    format::mesh::{Moment, UpAxis},
    scene::Projection,
};
use clap::Args;
use glam::DVec3;
use std::path::PathBuf;

/// The names of all arguments of [`CameraArgs`].
pub(super) const OPTIONS: [&str; 10] = [
    "camera", "view", "from", "eye", "target", "up", "fov", "ortho", "aperture", "focus",
];

/// The names of all arguments of [`MeshArgs`].
pub(super) const MESH_OPTIONS: [&str; 12] = [
    "up_axis",
    "ground",
    "smooth_angle",
    "point_size",
    "color_by",
    "color_map",
    "color_range",
    "animation",
    "animation_time",
    "lit_from",
    "environment",
    "environment_rotate",
];

/// The camera.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// A camera of the file or of its meshes, by name or number [default: the scene's first camera, else --view 1; a mesh is
    /// framed]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["view", "eye"])]
    pub camera: Option<String>,

    /// One of the six classic viewpoints
    #[arg(long, value_name = "1..6", value_parser = values::whole::<6>, conflicts_with = "eye")]
    pub view: Option<u32>,

    /// The side from which a mesh is framed: front, right, back, left, top, bottom, or AZIMUTH,ELEVATION in degrees, to the
    /// right of its front and upwards [default: 35,27; 35,20 with --style plain]
    #[arg(long, value_name = "SIDE", value_parser = values::side, allow_hyphen_values = true, conflicts_with_all = ["camera", "view", "eye"])]
    pub from: Option<Side>,

    /// Position of the camera
    #[arg(long, value_name = "x,y,z", value_parser = values::vector, allow_hyphen_values = true)]
    pub eye: Option<DVec3>,

    /// Point the camera looks at [default: the scene camera's target; 0,0,0.5 with --eye or --view; the centre of a mesh]
    #[arg(long, value_name = "x,y,z", value_parser = values::vector, allow_hyphen_values = true)]
    pub target: Option<DVec3>,

    /// Up direction of the camera [default: the scene camera's; 0,0,1 with --eye or --view; the up axis of a mesh]
    #[arg(long, value_name = "x,y,z", value_parser = values::vector, allow_hyphen_values = true)]
    pub up: Option<DVec3>,

    /// Vertical field of view, degrees [default: the scene camera's; 45 for a mesh, or with --eye or --view]
    #[arg(long, value_name = "DEG", value_parser = values::field_of_view, allow_negative_numbers = true)]
    pub fov: Option<f64>,

    /// Orthographic view of this height instead of a field of view, scene units; `fit` frames a mesh
    #[arg(long, value_name = "HEIGHT", value_parser = values::ortho, allow_negative_numbers = true, conflicts_with = "fov")]
    pub ortho: Option<Ortho>,

    /// Diameter of the lens for depth of field, scene units; needs many --samples [default: the scene camera's; else 0, a
    /// pinhole]
    #[arg(long, value_name = "DIAMETER", value_parser = values::length, allow_negative_numbers = true)]
    pub aperture: Option<f64>,

    /// Distance of the plane in focus, scene units [default: the scene camera's; else the target's]
    #[arg(long, value_name = "DISTANCE", value_parser = values::length, allow_negative_numbers = true)]
    pub focus: Option<f64>,
}

/// Height of an orthographic view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ortho {
    /// Scene units.
    Height(f64),
    /// All of the mesh.
    Fit,
}

/// How a mesh without a scene is shown.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Meshes")]
pub struct MeshArgs {
    /// Up axis of the mesh: x, y, z, -x, -y or -z [default: z for .stl, .3mf, .vtk, .vtp, .vtu and for .ply with a comment
    /// `up z`, else y]
    #[arg(long, value_name = "AXIS", allow_hyphen_values = true)]
    pub up_axis: Option<UpAxis>,

    /// Put the mesh on a ground plane
    #[arg(long)]
    pub ground: bool,

    /// Smooth a mesh without normals where faces meet at no more than this angle, degrees
    #[arg(long, value_name = "DEG", value_parser = values::angle)]
    pub smooth_angle: Option<f64>,

    /// Diameter of the points or lines of a file without faces, scene units [default: 1.3 times the distance between
    /// neighbouring points; with lines, 1/200 of the diagonal of the box around them]
    #[arg(long, value_name = "DIAMETER", value_parser = values::diameter, allow_negative_numbers = true)]
    pub point_size: Option<f32>,

    /// Colour the mesh by a number per vertex or face instead of its own colours. NAME is x, y or z, a coordinate in the
    /// file, or the name of a scalar property: of vertices or faces in a PLY or VTK file, of vertices in a glTF file. octray info
    /// lists the names in a file
    #[arg(long, value_name = "NAME")]
    pub color_by: Option<String>,

    /// The colours of --color-by; rdbu, rdylbu, brbg, piyg and spectral are diverging; rainbow is cyclic, for angles
    /// [default: viridis]
    #[arg(
        long,
        value_name = "MAP",
        value_enum,
        ignore_case = true,
        requires = "color_by"
    )]
    pub color_map: Option<ColorMap>,

    /// Values at the two ends of the map; LOW above HIGH reverses it [default: the smallest and the largest number]
    #[arg(long, value_name = "LOW,HIGH", value_parser = values::range, allow_hyphen_values = true, requires = "color_by")]
    pub color_range: Option<[f64; 2]>,

    /// Show a glTF file in the pose of this animation, by name or number. octray render plays it with -o a.gif or
    /// a-#.png [default: the stored pose; the first animation with --animation-time, a.gif or #]
    #[arg(long, value_name = "NAME")]
    pub animation: Option<String>,

    /// The time of the pose in the animation [default: 0 with --animation]
    #[arg(long, value_name = "SECONDS", value_parser = values::moment, allow_negative_numbers = true)]
    pub animation_time: Option<f64>,

    /// Light the mesh as if it were seen from this direction [default: the direction of the eye]
    #[arg(long, value_name = "x,y,z", value_parser = values::direction, allow_hyphen_values = true)]
    pub lit_from: Option<DVec3>,

    /// Light the mesh by an environment map, equirectangular (.hdr, .exr or another picture), at a brightness that suits the
    /// mesh. The image's centre is straight behind the mesh, seen from its front. Needs many samples, such as
    /// --samples auto:64
    #[arg(long, value_name = "FILE", conflicts_with = "lit_from")]
    pub environment: Option<PathBuf>,

    /// Turn the environment map counterclockwise as seen from above, degrees
    #[arg(long, value_name = "DEG", value_parser = values::degrees, allow_negative_numbers = true, requires = "environment",
          default_value_t = 0.0)]
    pub environment_rotate: f64,
}

impl CameraArgs {
    /// As plain values.
    pub fn options(&self) -> CameraOptions {
        let start = match (&self.camera, self.view, self.eye, self.from) {
            (Some(name), ..) => StartView::Named(name.clone()),
            (None, Some(number), ..) => StartView::Classic(number),
            (None, None, Some(eye), _) => StartView::Eye(eye),
            (None, None, None, Some(side)) => StartView::Side(side),
            (None, None, None, None) => StartView::Default,
        };
        CameraOptions {
            start,
            target: self.target,
            up: self.up,
            projection: match (self.fov, self.ortho) {
                (_, Some(Ortho::Height(height))) => Some(Projection::Orthographic { height }),
                (Some(fov_degrees), None) => Some(Projection::Perspective { fov_degrees }),
                (_, None | Some(Ortho::Fit)) => None,
            },
            fits_ortho: self.ortho == Some(Ortho::Fit),
            aperture: self.aperture,
            focus: self.focus,
            defaults: Vec::new(),
        }
    }
}

impl MeshArgs {
    /// As plain values. With an `orbit`, the camera goes around the mesh.
    pub fn options(&self, orbit: Option<Orbit>) -> MeshOptions {
        MeshOptions {
            up_axis: self.up_axis,
            ground: self.ground,
            smooth_degrees: self.smooth_angle,
            point_size: self.point_size,
            color_by: ColorBy {
                values: self.color_by.as_deref().map_or(Shading::Own, Shading::named),
                map: self.color_map.unwrap_or_default(),
                range: self.color_range,
            },
            moment: (self.animation.is_some() || self.animation_time.is_some()).then(|| Moment {
                animation: self.animation.clone(),
                seconds: self.animation_time.unwrap_or(0.0),
            }),
            lit_from: self.lit_from,
            environment: self
                .environment
                .clone()
                .map(|path| (path, self.environment_rotate)),
            orbit,
            ..MeshOptions::default()
        }
    }
}

#[cfg(test)]
mod tests;
