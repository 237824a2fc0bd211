//! The animation of a mesh, whose camera and lights stay where they are while it plays.

use crate::{
    cli::{
        CliError,
        plan::{InputPlan, Playback},
    },
    error::clip_path,
    format::mesh::{Cloud, LoadedMesh, Shown, load_shown},
    scene::{Light, PlacedMesh, TriangleMesh},
};
use glam::DVec3;
use std::fs::Metadata;

/// The outermost points of an animation's poses: the camera frames them, and the lights stand around them.
pub struct Poses {
    points: Vec<DVec3>,
    /// The largest radius of points and lines, if the file has no faces.
    radius: Option<f32>,
    /// Those of the first frame: how bright they are is decided once.
    lights: Vec<Light>,
    /// Size and time of the file, which must not change while it is played.
    file: Option<Metadata>,
}

/// Whether a file is as it was.
fn is_same(before: Option<&Metadata>, after: Option<&Metadata>) -> bool {
    let of = |file: &Metadata| (file.len(), file.modified().ok());
    before.map(of) == after.map(of)
}

impl Poses {
    /// The poses of an animation, of which some are loaded within `memory` bytes.
    ///
    /// # Errors
    /// [`CliError`].
    pub fn of(plan: &InputPlan, playback: &Playback, memory: u64) -> Result<Self, CliError> {
        let (mut points, mut radius, mut lights) = (Vec::new(), None, None);
        let file = plan.path.metadata().ok();
        for frame in playback.some_frames() {
            let shown = Shown {
                images: false,
                moment: Some(playback.moment(frame)),
                ..Shown::default()
            };
            let mesh = load_shown(&plan.path, &mut Vec::new(), memory, shown)?;
            lights.get_or_insert(mesh.lights.clone());
            let extremes = PlacedMesh::extremes(&mesh.placed());
            points.extend(extremes.into_iter().map(|point| point.as_dvec3() + mesh.offset));
            if let Some(cloud) = &mesh.cloud {
                let own = plan.mesh.point_size.map(|diameter| 0.5 * diameter);
                let own = own.unwrap_or(cloud.radius(&mesh.columns));
                radius = Some(own.max(radius.unwrap_or(own)));
            }
        }
        Ok(Self {
            points,
            radius,
            lights: lights.unwrap_or_default(),
            file,
        })
    }

    /// Refuses a file that has changed since.
    ///
    /// # Errors
    /// [`CliError::Failed`].
    pub fn check(&self, plan: &InputPlan) -> Result<(), CliError> {
        if is_same(self.file.as_ref(), plan.path.metadata().ok().as_ref()) {
            return Ok(());
        }
        let path = clip_path(&plan.path);
        Err(CliError::Failed(format!(
            "{path}: the file has changed while it was played"
        )))
    }

    /// The points as a mesh, which takes the place of one pose in the framing. Its cameras are those of the pose.
    pub(super) fn around(&self, pose: &mut LoadedMesh) -> LoadedMesh {
        if let (Some(cloud), Some(_)) = (&mut pose.cloud, self.radius) {
            cloud.radius = self.radius;
        }
        let column = |of: fn(DVec3) -> f64| {
            let coordinate = |point: &DVec3| of(*point - pose.offset) as f32;
            self.points.iter().map(coordinate).collect()
        };
        LoadedMesh {
            columns: TriangleMesh {
                x: column(|point| point.x),
                y: column(|point| point.y),
                z: column(|point| point.z),
                ..TriangleMesh::default()
            },
            offset: pose.offset,
            cloud: self.radius.map(|radius| Cloud {
                radius: Some(radius),
                lines: Vec::new(),
            }),
            cameras: std::mem::take(&mut pose.cameras),
            lights: self.lights.clone(),
            ..LoadedMesh::default()
        }
    }
}
