//! `--poses` and `--save-poses`: cameras in a NeRF `transforms.json`, as Instant NGP and Nerfstudio read and write it, and of
//! [COLMAP](colmap).
//!
//! A matrix maps the space of a camera that looks along -z, with y up, to the scene.

mod colmap;
mod lens;
mod saved;

pub use saved::{PoseFiles, SavedPoses};

use crate::{
    cli::{CliError, plan::stem},
    error::{LoadError, clip, clip_path, io_reason},
    format::open_file,
    scene::{Camera, Projection, View},
};
use glam::DVec3;
use lens::{Lens, Model};
use serde::Deserialize;
use std::{
    io::Read,
    path::{Path, PathBuf},
};

/// The largest file, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// The most poses: the frames of a call.
const MAX_POSES: usize = super::render::MOST_PICTURES as usize;

/// A file of poses.
#[derive(Debug)]
pub struct PoseFile {
    path: PathBuf,
    frames: Vec<Frame>,
}

/// The poses of a file, for pictures of one size.
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
    /// The path of its picture as the file has it; empty if it has none.
    pub picture: String,
    pub camera: Camera,
}

#[derive(Deserialize)]
struct Transforms {
    #[serde(flatten)]
    lens: Lens,
    frames: Vec<Frame>,
}

#[derive(Debug, Deserialize)]
struct Frame {
    #[serde(default)]
    file_path: String,
    transform_matrix: Vec<[f64; 4]>,
    #[serde(flatten)]
    lens: Lens,
}

impl PoseFile {
    /// Reads a file, or COLMAP's files in a folder.
    ///
    /// # Errors
    /// [`CliError::Load`].
    pub fn read(path: &Path) -> Result<Self, CliError> {
        let path = colmap::images_in(path).map_err(CliError::Load)?;
        let Transforms { lens: common, frames } = if colmap::is_images(&path) {
            Transforms {
                lens: Lens::default(),
                frames: colmap::frames(&path).map_err(CliError::Load)?,
            }
        } else {
            transforms(&path).map_err(CliError::Load)?
        };
        if frames.is_empty() || frames.len() > MAX_POSES {
            let why = format!("{} frames, expected 1 to {MAX_POSES}", frames.len());
            return Err(CliError::Load(LoadError::whole_file(&path, why)));
        }
        Ok(Self {
            path,
            frames: frames
                .into_iter()
                .map(|frame| Frame {
                    lens: frame.lens.or(&common),
                    ..frame
                })
                .collect(),
        })
    }

    /// The files that were read.
    pub fn files(&self) -> Vec<PathBuf> {
        let cameras = colmap::is_images(&self.path).then(|| colmap::cameras_beside(&self.path));
        [self.path.clone()].into_iter().chain(cameras).collect()
    }

    /// The size of the pictures, if all have the same.
    pub fn size(&self) -> Option<[u32; 2]> {
        let first = self.frames.first()?.lens.size()?;
        let is_shared = self.frames.iter().all(|frame| frame.lens.size() == Some(first));
        is_shared.then_some(first)
    }

    /// The first two sizes of pictures that differ.
    fn different_sizes(&self) -> Option<[[u32; 2]; 2]> {
        let mut sizes = self.frames.iter().filter_map(|frame| frame.lens.size());
        let first = sizes.next()?;
        sizes.find(|size| *size != first).map(|other| [first, other])
    }

    /// The cameras, for pictures of that size, which the user may have chosen.
    ///
    /// # Errors
    /// [`CliError::Load`] if one of them does not define a picture.
    pub fn poses(&self, size: [u32; 2], is_chosen: bool) -> Result<Poses, CliError> {
        let mut poses = Vec::new();
        for (i, frame) in self.frames.iter().enumerate() {
            let camera = frame.camera(f64::from(size[0]) / f64::from(size[1]));
            let camera = camera.map_err(|why| {
                // Those of COLMAP are sorted.
                let which = if colmap::is_images(&self.path) {
                    clip(&frame.file_path)
                } else {
                    format!("frames[{i}]")
                };
                let why = format!("{which}: {why}");
                CliError::Load(LoadError::whole_file(&self.path, why))
            })?;
            let name = stem(Path::new(&frame.file_path)).to_string_lossy();
            let name = if frame.file_path.is_empty() {
                (i + 1).to_string()
            } else {
                name.into_owned()
            };
            poses.push(Pose {
                name,
                picture: frame.file_path.clone(),
                camera,
            });
        }
        Ok(Poses {
            poses,
            notes: self.notes(size, is_chosen),
        })
    }

    /// What pictures of that size do not show as the file has it.
    fn notes(&self, [width, height]: [u32; 2], is_chosen: bool) -> Vec<String> {
        let path = clip_path(&self.path);
        let is_other_shape = |lens: &Lens| {
            let [w, h] = lens.size()?.map(f64::from);
            Some((w / h * f64::from(height) - f64::from(width)).abs() >= 1.0)
        };
        let mut lenses = self.frames.iter().map(|frame| &frame.lens);
        let is_unknown = lenses.clone().any(|lens| lens.model() == Model::Unknown);
        let is_unplaced = lenses.clone().any(Lens::is_unplaced);
        let is_mirrored = self.frames.iter().any(Frame::is_mirrored);
        let other = lenses.find(|lens| is_other_shape(lens) == Some(true));
        let mut notes = Vec::new();
        if is_unknown {
            notes.push(format!(
                "{path}: left out: lens distortion of a model that octray does not know (its cameras are rendered as pinholes)"
            ));
        }
        if is_unplaced {
            notes.push(format!(
                "{path}: left out: a principal point without the size `w` and `h` of its picture"
            ));
        }
        if is_mirrored {
            notes.push(format!(
                "{path}: left out: mirroring (a transform_matrix has an x axis that points to the left of the picture)"
            ));
        }
        if self.frames.iter().any(Frame::is_sheared) {
            notes.push(format!(
                "{path}: left out: shear (a transform_matrix has axes that are not at right angles)"
            ));
        }
        if let Some([[w, h], [other_w, other_h]]) = self.different_sizes().filter(|_| !is_chosen) {
            notes.push(format!(
                "{path}: has pictures of {w}x{h} and {other_w}x{other_h}, but all are rendered with {width}x{height}: give --size"
            ));
        } else if let Some([w, h]) = other.and_then(Lens::size) {
            notes.push(format!(
                "{path}: has pictures of {w}x{h}, another shape than {width}x{height}: the height of the view is kept, not its \
                 width"
            ));
        }
        notes
    }
}

/// Reads a `transforms.json`.
fn transforms(path: &Path) -> Result<Transforms, LoadError> {
    let whole = |message: String| LoadError::whole_file(path, message);
    let text = read(path).map_err(|error| whole(io_reason(&error)))?;
    // A byte order mark.
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&text);
    if text.trim_ascii().is_empty() {
        return Err(whole(
            "the file is empty, expected a NeRF transforms.json".to_owned(),
        ));
    }
    serde_json::from_slice(text).map_err(|error| {
        let place = [error.line(), error.column()];
        let message = error.to_string();
        let what = if text.trim_ascii_start().starts_with(b"{") {
            "not a NeRF transforms.json"
        } else {
            "neither a NeRF transforms.json nor COLMAP's images.txt or images.bin"
        };
        LoadError::in_json(path, place, what, &message)
    })
}

/// The largest cosine of two axes that are taken for a right angle: matrices are often written with few digits.
const MOST_SHEAR: f64 = 1e-2;

impl Frame {
    /// The right, up and back axes of the camera, of length 1; `None` if the matrix has none.
    fn axes(&self) -> Option<[DVec3; 3]> {
        let &[x, y, z] = self.transform_matrix.get(..3)? else {
            return None;
        };
        Some([0, 1, 2].map(|i| DVec3::new(x[i], y[i], z[i]).normalize_or_zero()))
    }

    /// Whether the matrix is left-handed.
    fn is_mirrored(&self) -> bool {
        self.axes()
            .is_some_and(|[right, up, back]| right.dot(up.cross(back)) < 0.0)
    }

    /// Whether the axes are not at right angles.
    fn is_sheared(&self) -> bool {
        self.axes().is_some_and(|[right, up, back]| {
            [right.dot(up), up.dot(back), back.dot(right)]
                .iter()
                .any(|cosine| cosine.abs() > MOST_SHEAR)
        })
    }

    /// The camera, for pictures of that width over height.
    fn camera(&self, aspect: f64) -> Result<Camera, String> {
        if let Some(why) = self.lens.fault() {
            return Err(why);
        }
        let fov = self.lens.fov(aspect).ok_or(
            "no field of view: expected `fl_y` and `h`, or `camera_angle_x` in radians, from 0 to pi",
        )?;
        let [x, y, z] = match self.transform_matrix.get(..3) {
            Some(&[x, y, z]) if self.transform_matrix.len() <= 4 => [x, y, z],
            _ => {
                let rows = self.transform_matrix.len();
                return Err(format!(
                    "transform_matrix has {rows} rows, expected 3 or 4 of 4 numbers"
                ));
            }
        };
        if let Some(last) = self.transform_matrix.get(3)
            && last
                .iter()
                .zip([0.0, 0.0, 0.0, 1.0])
                .any(|(a, b)| (a - b).abs() > 1e-6)
        {
            return Err(format!(
                "the last row of transform_matrix is {last:?}, expected [0, 0, 0, 1]: rows and columns may be exchanged"
            ));
        }
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        for (i, name) in ["first", "second", "third"].into_iter().enumerate() {
            if column(i).try_normalize().is_none() {
                let length = column(i).length();
                return Err(format!(
                    "the {name} column of transform_matrix has length {length}"
                ));
            }
        }
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
        .and_then(|camera| camera.with_image_plane(self.lens.image_plane()))
        .and_then(|camera| match self.lens.model() {
            Model::Distorted(distortion) => camera.with_distortion(Some(distortion)),
            Model::Pinhole | Model::Unknown => Ok(camera),
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

#[cfg(test)]
mod tests;
