//! `--save-poses`: a `transforms.json` of the rendered pictures.

use crate::{
    cli::CliError,
    scene::{Camera, Distortion},
};
use serde::Serialize;

/// Poses to be written, of pictures of one size.
#[derive(Debug)]
pub struct SavedPoses {
    size: [u32; 2],
    /// Units of a step of depth in files.
    depth_step: f64,
    poses: Vec<(SavedLens, SavedPose)>,
}

/// The files of a pose, relative to the file of poses.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PoseFiles {
    #[serde(rename = "file_path")]
    pub picture: String,
    #[serde(rename = "mask_path", skip_serializing_if = "Option::is_none")]
    pub mask: Option<String>,
    /// As Nerfstudio reads it.
    #[serde(rename = "depth_file_path", skip_serializing_if = "Option::is_none")]
    pub depth: Option<String>,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct SavedLens {
    camera_angle_x: f64,
    camera_angle_y: f64,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    w: u32,
    h: u32,
    #[serde(flatten)]
    distortion: Option<SavedDistortion>,
}

/// Coefficients that are 0 are left out where Instant NGP would read them instead of others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
struct SavedDistortion {
    camera_model: &'static str,
    /// For Instant NGP.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    is_fisheye: bool,
    k1: f64,
    k2: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    k3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k4: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k5: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k6: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p2: Option<f64>,
}

#[derive(Debug, Serialize)]
struct SavedPose {
    #[serde(flatten)]
    files: PoseFiles,
    /// The same file of depth for Instant NGP.
    #[serde(skip_serializing_if = "Option::is_none")]
    depth_path: Option<String>,
    transform_matrix: [[f64; 4]; 4],
}

/// The file. Nerfstudio reads the intrinsics of frames only if the file has none for all of them, but the model only from
/// the file.
#[derive(Debug, Serialize)]
struct SavedFile<'a> {
    #[serde(flatten)]
    lens: Option<SavedLens>,
    #[serde(skip_serializing_if = "Option::is_none")]
    camera_model: Option<&'static str>,
    /// For Instant NGP.
    #[serde(skip_serializing_if = "Option::is_none")]
    integer_depth_scale: Option<f64>,
    frames: Vec<SavedFrame<'a>>,
}

#[derive(Debug, Serialize)]
struct SavedFrame<'a> {
    #[serde(flatten)]
    lens: Option<SavedLens>,
    #[serde(flatten)]
    pose: &'a SavedPose,
}

impl SavedLens {
    fn new(camera: &Camera, [w, h]: [u32; 2]) -> Option<Self> {
        let intrinsics = camera.intrinsics(w, h)?;
        let ([fl_x, fl_y], [cx, cy]) = (intrinsics.focal, intrinsics.principal_point);
        let angle = |side: u32, focal: f64| 2.0 * libm::atan(0.5 * f64::from(side) / focal);
        Some(Self {
            camera_angle_x: angle(w, fl_x),
            camera_angle_y: angle(h, fl_y),
            fl_x,
            fl_y,
            cx,
            cy,
            w,
            h,
            distortion: camera.distortion().map(SavedDistortion::from),
        })
    }

    /// Whether both project alike. What was read and computed again is not exact.
    fn is_like(&self, other: &Self) -> bool {
        let numbers = |lens: &Self| [lens.fl_x, lens.fl_y, lens.cx, lens.cy];
        let [ours, others] = [self, other].map(numbers);
        let mut pairs = ours.into_iter().zip(others);
        pairs.all(|(a, b)| (a - b).abs() <= 1e-6 * self.fl_x.max(self.fl_y))
            && self.distortion == other.distortion
    }

    fn model(&self) -> Option<&'static str> {
        Some(self.distortion?.camera_model)
    }
}

impl From<Distortion> for SavedDistortion {
    fn from(distortion: Distortion) -> Self {
        let other = |k: f64| Some(k).filter(|&k| k != 0.0);
        match distortion {
            Distortion::Fisheye {
                radial: [k1, k2, k3, k4],
            } => Self {
                camera_model: "OPENCV_FISHEYE",
                is_fisheye: true,
                k1,
                k2,
                k3: Some(k3),
                k4: Some(k4),
                ..Self::default()
            },
            Distortion::Perspective {
                radial: [k1, k2, k3, k4],
                divisor,
                tangential: [p1, p2],
            } => {
                let is_full = divisor != [0.0; 3];
                let [d1, d2, d3] = divisor;
                Self {
                    camera_model: if is_full { "FULL_OPENCV" } else { "OPENCV" },
                    k1,
                    k2,
                    k3: other(k3),
                    k4: other(if is_full { d1 } else { k4 }),
                    k5: other(d2),
                    k6: other(d3),
                    p1: Some(p1),
                    p2: Some(p2),
                    is_fisheye: false,
                }
            }
        }
    }
}

impl SavedPoses {
    /// Poses of pictures of this size; `depth_step` is the unit of their files of depth.
    pub fn new(size: [u32; 2], depth_step: f64) -> Self {
        Self {
            size,
            depth_step,
            poses: Vec::new(),
        }
    }

    /// Refuses a camera that cannot be saved.
    ///
    /// # Errors
    /// [`CliError::Usage`] for orthographic cameras.
    pub fn check(camera: &Camera) -> Result<(), CliError> {
        if camera.intrinsics(1, 1).is_some() {
            return Ok(());
        }
        let why = "--save-poses: an orthographic camera has no focal length";
        Err(CliError::Usage(why.into()))
    }

    /// Adds the camera of a picture, which [`Self::check`] allows.
    pub fn push(&mut self, files: PoseFiles, camera: &Camera) {
        let Some(lens) = SavedLens::new(camera, self.size) else {
            return;
        };
        let view = camera.view();
        let back = (view.eye - view.target).normalize_or_zero();
        let right = view.up.cross(back).normalize_or_zero();
        let up = back.cross(right);
        let row = |i: usize| [right[i], up[i], back[i], view.eye[i]];
        let pose = SavedPose {
            depth_path: files.depth.clone(),
            files,
            transform_matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        };
        self.poses.push((lens, pose));
    }

    /// The contents of the file: intrinsics once, or for each frame where they differ.
    pub fn file(&self) -> impl Serialize {
        let first = self.poses.first().map(|&(lens, _)| lens);
        let shared = first.filter(|first| self.poses.iter().all(|(lens, _)| first.is_like(lens)));
        let model = self.poses.first().and_then(|(lens, _)| lens.model());
        let has_model = shared.is_none() && self.poses.iter().all(|(lens, _)| lens.model() == model);
        let has_depth = self.poses.iter().any(|(_, pose)| pose.depth_path.is_some());
        SavedFile {
            lens: shared,
            camera_model: model.filter(|_| has_model),
            integer_depth_scale: has_depth.then_some(self.depth_step),
            frames: self
                .poses
                .iter()
                .map(|(lens, pose)| SavedFrame {
                    lens: shared.is_none().then_some(*lens),
                    pose,
                })
                .collect(),
        }
    }
}
