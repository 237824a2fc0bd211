//! What the picture shows, besides where the camera is.

use crate::{
    accel::Bvh,
    render::Settings,
    scene::{Camera, Scene},
};
use std::sync::Arc;

use super::orbit::Pose;

/// What a pixel's colour tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// The ray-traced picture.
    Full,
    /// Camera rays, a light at the eye and the scene's lights, without shadows and mirrors.
    Preview,
    /// Normals as colours: x, y and z from -1 to 1 are red, green and blue from 0 to 1.
    Normals,
    /// What a camera ray costs: nodes and primitives, as [`crate::reference::cost`] counts them.
    Cost,
}

/// Which boxes of the BVH are drawn over the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boxes {
    /// None.
    #[default]
    Hidden,
    /// Those of all leaves.
    Leaves,
    /// Those that are so many steps below the box around everything.
    Level(usize),
}

/// All that the keys switch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// What is shown.
    pub look: Look,
    /// Every ray tests every primitive.
    pub brute: bool,
    /// More than one sample a pixel at rest.
    pub antialias: bool,
    /// Boxes over the picture.
    pub boxes: Boxes,
    /// Depth, shadows, mode and threads; the size is that of the window.
    pub settings: Settings,
}

/// A scene ready for tracing.
#[derive(Debug)]
pub struct Model {
    /// The scene.
    pub scene: Scene,
    /// Built from it.
    pub bvh: Bvh,
}

/// What should be on the screen.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The scene.
    pub model: Arc<Model>,
    /// Where the camera is.
    pub pose: Pose,
    /// The same, ready for rays.
    pub camera: Camera,
    /// What the picture shows.
    pub style: Style,
    /// Pixels of the window, across and down.
    pub size: [u32; 2],
}

impl Wanted {
    /// Whether the same picture answers both.
    #[must_use]
    pub fn same_picture(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.model, &other.model)
            && self.pose == other.pose
            && self.style == other.style
            && self.size == other.size
    }

    /// The same picture, with the BVH instead of brute force.
    #[must_use]
    pub fn by_bvh(&self) -> Self {
        let style = Style {
            brute: false,
            ..self.style
        };
        Self {
            style,
            ..self.clone()
        }
    }

    /// Whether a pixel costs about the same in both: what was learnt of one is of use for the other.
    #[must_use]
    pub fn same_rays(&self, other: &Self) -> bool {
        let (a, b) = (&self.style, &other.style);
        Arc::ptr_eq(&self.model, &other.model)
            && (a.look, a.brute, a.settings) == (b.look, b.brute, b.settings)
    }
}
