//! The cameras and animations of a scene or mesh, as text and as JSON.

use super::{info::list, positions::Positions};
use crate::{
    error::clip,
    format::mesh::MeshAnimation,
    scene::{NamedCamera, Projection},
};
use serde::Serialize;

#[derive(Debug, Serialize)]
pub(super) struct CameraInfo {
    name: Option<String>,
    /// Eye and target as in the text.
    #[serde(skip)]
    rounded: [[f64; 3]; 2],
    eye: [f64; 3],
    target: [f64; 3],
    up: [f64; 3],
    /// Vertical field of view of a perspective camera, degrees.
    #[serde(skip_serializing_if = "Option::is_none")]
    fov: Option<f64>,
    /// Height of an orthographic view.
    #[serde(skip_serializing_if = "Option::is_none")]
    ortho: Option<f64>,
    /// Diameter of the lens, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    aperture: Option<f64>,
    /// Distance in focus of the lens, if it is not the target's.
    #[serde(skip_serializing_if = "Option::is_none")]
    focus: Option<f64>,
}

#[derive(Debug, Serialize)]
pub(super) struct AnimationInfo {
    name: Option<String>,
    /// The time of its last keyframe; null if the file does not say.
    seconds: Option<f64>,
}

impl CameraInfo {
    pub(super) fn new(camera: &NamedCamera, positions: Positions) -> Self {
        let (view, has_lens) = (camera.camera.view(), camera.camera.has_lens());
        let (fov, ortho) = match view.projection {
            Projection::Perspective { fov_degrees } => (Some(fov_degrees), None),
            Projection::Orthographic { height } => (None, Some(height)),
        };
        Self {
            name: camera.name.clone(),
            rounded: [view.eye, view.target].map(|point| positions.rounded(point)),
            eye: view.eye.to_array(),
            target: view.target.to_array(),
            up: view.up.to_array(),
            fov,
            ortho,
            aperture: has_lens.then_some(view.lens.aperture),
            focus: view.lens.focus.filter(|_| has_lens),
        }
    }

    pub(super) fn text(&self) -> String {
        let name = self
            .name
            .as_ref()
            .map_or_else(String::new, |name| format!("\"{}\" ", clip(name)));
        let mut text = format!(
            "{name}eye {} target {} up {}",
            list(self.rounded[0]),
            list(self.rounded[1]),
            list(rounded(self.up)),
        );
        for (key, value) in [
            ("fov", self.fov),
            ("ortho", self.ortho),
            ("aperture", self.aperture),
            ("focus", self.focus),
        ] {
            if let Some(value) = value {
                text += &format!(" {key} {}", value as f32);
            }
        }
        text
    }
}

impl AnimationInfo {
    pub(super) fn new(MeshAnimation { name, seconds }: MeshAnimation) -> Self {
        Self {
            name: Some(name).filter(|name| !name.is_empty()),
            seconds,
        }
    }

    /// `"walk" 1.25 s`.
    pub(super) fn text(&self) -> String {
        let name = self.name.as_ref().map(|name| format!("\"{}\"", clip(name)));
        let length = self.seconds.map(|seconds| format!("{} s", seconds as f32));
        let known: Vec<String> = name.into_iter().chain(length).collect();
        if known.is_empty() {
            "unnamed".to_owned()
        } else {
            known.join(" ")
        }
    }
}

/// Directions of meshes' cameras are made of `f32`: more digits would be noise.
fn rounded(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|number| number as f32)
}

#[cfg(test)]
mod tests;
