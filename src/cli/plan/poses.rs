//! `--poses` and `--save-poses`: cameras in a NeRF `transforms.json`, as Instant NGP and Nerfstudio read and write it, and of
//! [COLMAP](colmap).
//!
//! A matrix maps the space of a camera that looks along -z, with y up, to the scene.

mod colmap;

use crate::{
    cli::{CliError, plan::stem},
    error::{LoadError, clip_path, io_reason},
    format::open_file,
    scene::{Camera, Projection, View},
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::{io::Read, path::Path};

/// The largest file, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The most poses: the frames of a call.
const MAX_POSES: usize = super::render::MOST_PICTURES as usize;

/// The poses of a file.
#[derive(Debug)]
pub struct Poses {
    pub poses: Vec<Pose>,
    /// Notes about ignored contents.
    pub notes: Vec<String>,
}

/// A camera of the file.
#[derive(Debug)]
pub struct Pose {
    /// The name of its picture without folder and extension; its number if it has none.
    pub name: String,
    pub camera: Camera,
}

/// The intrinsics of a camera: of the whole file, or of one frame.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
struct Lens {
    /// Radians.
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
    /// Focal lengths and middle, pixels of a picture of `w` x `h`.
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    w: Option<f64>,
    h: Option<f64>,
    k1: f64,
    k2: f64,
    p1: f64,
    p2: f64,
}

#[derive(Deserialize)]
struct Transforms {
    #[serde(flatten)]
    lens: Lens,
    frames: Vec<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    #[serde(default)]
    file_path: String,
    transform_matrix: Vec<[f64; 4]>,
    #[serde(flatten)]
    lens: Lens,
}

impl Lens {
    /// Takes missing values from `other`.
    fn or(self, other: Self) -> Self {
        Self {
            camera_angle_x: self.camera_angle_x.or(other.camera_angle_x),
            camera_angle_y: self.camera_angle_y.or(other.camera_angle_y),
            fl_x: self.fl_x.or(other.fl_x),
            fl_y: self.fl_y.or(other.fl_y),
            w: self.w.or(other.w),
            h: self.h.or(other.h),
            ..self
        }
    }

    /// The vertical field of view of a picture, radians.
    fn fov(&self, aspect: f64) -> Option<f64> {
        let angle = |side: Option<f64>, focal: Option<f64>| Some(2.0 * libm::atan(side? / (2.0 * focal?)));
        let along_y = angle(self.h, self.fl_y).or(self.camera_angle_y);
        let along_x = || {
            angle(self.w, self.fl_x)
                .or(self.camera_angle_x)
                .filter(|angle| (0.0..std::f64::consts::PI).contains(angle))
        };
        along_y.or_else(|| Some(2.0 * libm::atan(libm::tan(along_x()? * 0.5) / aspect)))
    }

    /// Whether the lens has distortion.
    fn is_curved(&self) -> bool {
        [self.k1, self.k2, self.p1, self.p2].iter().any(|&k| k != 0.0)
    }

    /// Whether the principal point is off the picture's centre by more than a pixel.
    fn is_shifted(&self) -> bool {
        let off = |middle: Option<f64>, side: Option<f64>| {
            middle
                .zip(side)
                .is_some_and(|(middle, side)| (middle - 0.5 * side).abs() > 1.0)
        };
        off(self.cx, self.w) || off(self.cy, self.h)
    }
}

impl Poses {
    /// Reads a file, for pictures of that width over height.
    ///
    /// # Errors
    /// [`CliError::Load`].
    pub fn read(path: &Path, aspect: f64) -> Result<Self, CliError> {
        let whole = |message: String| CliError::Load(LoadError::whole_file(path, message));
        let Transforms { lens: common, frames } = if colmap::is_images(path) {
            Transforms {
                lens: Lens::default(),
                frames: colmap::frames(path).map_err(CliError::Load)?,
            }
        } else {
            let text = read(path).map_err(|error| whole(io_reason(&error)))?;
            if text.trim_ascii().is_empty() {
                return Err(whole(
                    "the file is empty, expected a NeRF transforms.json".to_owned(),
                ));
            }
            serde_json::from_slice(&text).map_err(|error| {
                let place = [error.line(), error.column()];
                let message = error.to_string();
                let what = if text.trim_ascii_start().starts_with(b"{") {
                    "not a NeRF transforms.json"
                } else {
                    "neither a NeRF transforms.json nor COLMAP's images.txt or images.bin"
                };
                CliError::Load(LoadError::in_json(path, place, what, &message))
            })?
        };
        if frames.is_empty() || frames.len() > MAX_POSES {
            return Err(whole(format!(
                "{} frames, expected 1 to {MAX_POSES}",
                frames.len()
            )));
        }
        let (mut curved, mut shifted) = (common.is_curved(), common.is_shifted());
        let mut poses = Vec::new();
        for (i, frame) in frames.iter().enumerate() {
            curved |= frame.lens.is_curved();
            shifted |= frame.lens.is_shifted();
            let camera = frame.lens.or(common).fov(aspect).ok_or(
                "no field of view: expected `fl_y` and `h`, or `camera_angle_x` in radians, from 0 to pi"
                    .to_owned(),
            );
            let camera = camera.and_then(|fov| frame.camera(fov));
            let camera = camera.map_err(|why| whole(format!("frames[{i}]: {why}")))?;
            let name = stem(Path::new(&frame.file_path)).to_string_lossy();
            let name = if frame.file_path.is_empty() {
                (i + 1).to_string()
            } else {
                name.into_owned()
            };
            poses.push(Pose { name, camera });
        }
        let path = clip_path(path);
        let notes = [
            (curved, "curved lenses"),
            (shifted, "an off-centre principal point"),
        ];
        let notes = notes.into_iter().filter(|(is, _)| *is);
        Ok(Self {
            poses,
            notes: notes
                .map(|(_, what)| format!("{path}: left out: {what}"))
                .collect(),
        })
    }
}

impl Frame {
    fn camera(&self, fov: f64) -> Result<Camera, String> {
        let [x, y, z] = match self.transform_matrix.get(..3) {
            Some(&[x, y, z]) if self.transform_matrix.len() <= 4 => [x, y, z],
            _ => {
                let rows = self.transform_matrix.len();
                return Err(format!(
                    "transform_matrix has {rows} rows, expected 3 or 4 of 4 numbers"
                ));
            }
        };
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let eye = column(3);
        let forward = -column(2).normalize_or_zero();
        Camera::new(&View {
            eye,
            target: eye + forward,
            up: column(1),
            projection: Projection::Perspective {
                fov_degrees: fov.to_degrees(),
            },
            lens: crate::scene::Lens::PINHOLE,
        })
        .map_err(|error| error.to_string())
    }
}

fn read(path: &Path) -> std::io::Result<Vec<u8>> {
    let file = open_file(path)?;
    let mut text = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut text)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(std::io::Error::other(format!(
            "it has more than {MAX_BYTES} bytes"
        )));
    }
    Ok(text)
}

/// Poses to be written: of pictures of one size and field of view.
#[derive(Debug, Serialize)]
pub struct SavedPoses {
    camera_angle_x: f64,
    camera_angle_y: f64,
    fl_x: f64,
    fl_y: f64,
    cx: f64,
    cy: f64,
    w: u32,
    h: u32,
    /// Units of a step of depth, for Instant NGP.
    #[serde(skip_serializing_if = "Option::is_none")]
    integer_depth_scale: Option<f64>,
    frames: Vec<SavedPose>,
}

/// The files of a pose, relative to the file of poses.
#[derive(Debug, Default, Serialize)]
pub struct PoseFiles {
    #[serde(rename = "file_path")]
    pub picture: String,
    #[serde(rename = "mask_path", skip_serializing_if = "Option::is_none")]
    pub mask: Option<String>,
    /// As Nerfstudio reads it.
    #[serde(rename = "depth_file_path", skip_serializing_if = "Option::is_none")]
    pub depth: Option<String>,
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

impl SavedPoses {
    /// Poses of pictures of this size, all with the field of view of `camera`.
    ///
    /// # Errors
    /// [`CliError::Failed`] for orthographic cameras.
    pub fn new(camera: &Camera, [w, h]: [u32; 2]) -> Result<Self, CliError> {
        let Projection::Perspective { fov_degrees } = camera.view().projection else {
            let why = "--save-poses: an orthographic camera has no focal length";
            return Err(CliError::Failed(why.into()));
        };
        let camera_angle_y = fov_degrees.to_radians();
        let (width, height) = (f64::from(w), f64::from(h));
        let focal = 0.5 * height / libm::tan(0.5 * camera_angle_y);
        Ok(Self {
            camera_angle_x: 2.0 * libm::atan(0.5 * width / focal),
            camera_angle_y,
            fl_x: focal,
            fl_y: focal,
            cx: 0.5 * width,
            cy: 0.5 * height,
            w,
            h,
            integer_depth_scale: None,
            frames: Vec::new(),
        })
    }

    /// Whether cameras of `other` can be added.
    ///
    /// # Errors
    /// [`CliError::Failed`] for another field of view.
    pub fn check_fits(&self, other: &Self) -> Result<(), CliError> {
        // Focal lengths that were read and computed again are not exact.
        if (self.fl_x - other.fl_x).abs() <= 1e-6 * self.fl_x {
            return Ok(());
        }
        let why = "--save-poses: the cameras have different fields of view, expected one for all pictures";
        Err(CliError::Failed(why.into()))
    }

    /// Adds the camera of a picture.
    pub fn push(&mut self, files: PoseFiles, camera: &Camera) {
        let view = camera.view();
        let back = (view.eye - view.target).normalize_or_zero();
        let right = view.up.cross(back).normalize_or_zero();
        let up = back.cross(right);
        let row = |i: usize| [right[i], up[i], back[i], view.eye[i]];
        let depth_path = files.depth.clone();
        self.integer_depth_scale = depth_path.as_ref().map(|_| 0.001);
        self.frames.push(SavedPose {
            files,
            depth_path,
            transform_matrix: [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]],
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str, aspect: f64) -> Result<Poses, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.json");
        std::fs::write(&path, text).expect("a file");
        Poses::read(&path, aspect).map_err(|error| error.text().unwrap_or_default())
    }

    #[test]
    fn saved_poses_are_read_again() {
        let cameras = [
            (DVec3::new(3.0, -2.0, 1.0), DVec3::Z),
            (DVec3::new(0.1, 0.2, -4.0), DVec3::Y),
        ]
        .map(|(eye, up)| Camera::look_at(eye, DVec3::new(0.0, 0.0, 0.5), up, 40.0).expect("a camera"));
        let mut saved = SavedPoses::new(&cameras[0], [640, 360]).expect("poses");
        for camera in &cameras {
            let picture = "train/r_7.png".into();
            saved.push(
                PoseFiles {
                    picture,
                    ..PoseFiles::default()
                },
                camera,
            );
        }
        let text = serde_json::to_string(&saved).expect("JSON");
        let read = found(&text, 16.0 / 9.0).expect("poses");
        assert!(read.notes.is_empty());
        for (pose, camera) in read.poses.iter().zip(&cameras) {
            assert_eq!(pose.name, "r_7");
            let (a, b) = (pose.camera.view(), camera.view());
            let direction = |view: &View| (view.target - view.eye).normalize();
            assert!((a.eye - b.eye).length() < 1e-12 && (direction(&a) - direction(&b)).length() < 1e-12);
            let (Projection::Perspective { fov_degrees: a }, Projection::Perspective { fov_degrees: b }) =
                (a.projection, b.projection)
            else {
                panic!("perspective cameras")
            };
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    /// The file of the synthetic NeRF scenes has a horizontal angle alone.
    #[test]
    fn a_horizontal_angle_is_enough() {
        let frame = r#"{"file_path":"./train/r_0","rotation":0.1,"transform_matrix":[[1,0,0,0],[0,0,-1,-4],[0,1,0,0.5],[0,0,0,1]]}"#;
        let text = format!(r#"{{"camera_angle_x":0.6911,"frames":[{frame}]}}"#);
        let poses = found(&text, 1.0).expect("poses");
        let view = poses.poses[0].camera.view();
        assert_eq!(view.eye, DVec3::new(0.0, -4.0, 0.5));
        assert_eq!(
            (view.target - view.eye, poses.poses[0].name.as_str()),
            (DVec3::Y, "r_0")
        );
        let wide = found(&text, 2.0).expect("poses").poses[0].camera.view();
        assert!(format!("{:?}", wide.projection) < format!("{:?}", view.projection));
        let curved = text.replacen('{', r#"{"k1":0.1,"cx":10,"w":40,"#, 1);
        assert_eq!(found(&curved, 1.0).expect("poses").notes.len(), 2);
    }

    #[test]
    fn broken_files_are_refused() {
        let frame =
            |matrix: &str| format!(r#"{{"camera_angle_x":1,"frames":[{{"transform_matrix":{matrix}}}]}}"#);
        for (text, expected) in [
            (
                String::new(),
                "t.json: the file is empty, expected a NeRF transforms.json",
            ),
            (
                "{".to_owned(),
                "1:1: not a NeRF transforms.json: the file is cut short",
            ),
            (r#"{"frames":[]}"#.to_owned(), "0 frames"),
            (frame("[[1,0,0]]"), "not a NeRF transforms.json"),
            (frame("[[1,0,0,0]]"), "frames[0]: transform_matrix has 1 rows"),
            (
                frame("[[0,0,0,0],[0,0,0,0],[0,0,0,0]]"),
                "frames[0]: eye and target",
            ),
            (
                frame("[[1,0,0,1e999],[0,1,0,0],[0,0,1,0]]"),
                "not a NeRF transforms.json",
            ),
            (
                frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]").replace("\"camera_angle_x\":1,", ""),
                "no field of view",
            ),
            (
                frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]").replace("x\":1,", "x\":9,"),
                "field of view",
            ),
        ] {
            let error = found(&text, 1.0).expect_err(&text);
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
