//! Requests of the window to the worker.

use super::{pose::Pose, timeline::Timeline};
use crate::{
    render::{Edges, Filter, Pattern, Settings, Transfer},
    scene::Camera,
};
use std::sync::Arc;

/// The quantity that pixels show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// The ray-traced picture.
    Full,
    /// Camera rays, a light at the eye and the scene's lights, without shadows and reflections.
    Preview,
    /// Normals as colours: x, y and z from -1 to 1 are red, green and blue from 0 to 1.
    Normals,
    /// The cost of a camera ray: nodes and primitives, as [`crate::reference::cost`] counts them.
    Cost,
}

/// The boxes of the BVH that are drawn over the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Boxes {
    /// None.
    #[default]
    Hidden,
    /// Those of all leaves.
    Leaves,
    /// Those at this depth below the root.
    Level(usize),
}

/// Everything that the keys toggle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// What is shown.
    pub look: Look,
    /// Every ray tests every primitive.
    pub brute: bool,
    /// More than one sample per pixel at rest.
    pub antialias: bool,
    /// Boxes over the picture.
    pub boxes: Boxes,
    /// How the last picture at rest is traced. The size is ignored: the window has its own.
    pub settings: Settings,
    /// How linear channels become bytes.
    pub transfer: Transfer,
}

impl Style {
    /// Returns the samples per pixel of the last picture at rest.
    #[must_use]
    pub fn last_samples(&self) -> u32 {
        if self.antialias { self.settings.samples } else { 1 }
    }

    /// Switches edges on, as the options have them, or off.
    pub fn toggle_edges(&mut self, options: Option<Edges>) {
        let edges = &mut self.settings.edges;
        *edges = edges.is_none().then(|| options.unwrap_or_default());
    }

    /// Returns the layer of `octray render --aov` that shows the same; none shows the cost of brute force.
    #[must_use]
    pub fn layer(&self) -> Option<&'static str> {
        match self.look {
            Look::Normals => Some("normal"),
            Look::Cost if !self.brute => Some("heat"),
            Look::Cost | Look::Full | Look::Preview => None,
        }
    }

    /// Returns the settings of a picture of `size` with a number of samples per pixel. A single one goes through the centre.
    /// Brute force takes all samples in all pixels; normals and costs take those of a regular grid.
    #[must_use]
    pub fn settings(&self, [width, height]: [u32; 2], samples: u32) -> Settings {
        let settings = Settings {
            width,
            height,
            samples,
            adaptive: self.settings.adaptive && !self.brute,
            ..self.settings
        };
        let regular = Settings {
            adaptive: false,
            pattern: Pattern::Grid,
            ..settings
        };
        match self.look {
            Look::Full if samples == 1 => regular,
            Look::Full => settings,
            _ => Settings {
                samples: samples.isqrt().pow(2),
                filter: Filter::Box,
                ..regular
            },
        }
    }
}

/// What should be on the screen.
#[derive(Clone, Debug)]
pub struct Request {
    /// The scene.
    pub timeline: Arc<Timeline>,
    /// Its frame.
    pub frame: u32,
    /// The camera.
    pub pose: Pose,
    /// The same camera, ready for rays.
    pub camera: Camera,
    /// What the picture shows.
    pub style: Style,
    /// Pixels of the window, across and down.
    pub size: [u32; 2],
}

impl Request {
    /// A small picture of a classic viewpoint.
    ///
    /// # Panics
    /// If there is no such viewpoint.
    #[cfg(test)]
    pub fn of_view(timeline: &Arc<Timeline>, view: u32) -> Self {
        let pose = Pose::classic_view(view).unwrap();
        Self {
            timeline: Arc::clone(timeline),
            frame: 1,
            pose,
            camera: pose.camera().unwrap(),
            style: Style {
                look: Look::Full,
                brute: false,
                antialias: true,
                boxes: Boxes::Hidden,
                settings: Settings::default(),
                transfer: Transfer::Linear,
            },
            size: [64, 48],
        }
    }

    /// Whether both show the same scene at the same frame.
    #[must_use]
    pub fn same_scene(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.timeline, &other.timeline) && self.frame == other.frame
    }

    /// Whether both request the same picture.
    #[must_use]
    pub fn same_picture(&self, other: &Self) -> bool {
        self.same_scene(other)
            && self.pose == other.pose
            && self.style == other.style
            && self.size == other.size
    }

    /// Whether the picture uses the lens. Only the ray-traced one does: the others are as sharp as AOVs.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        self.style.look == Look::Full && self.camera.has_lens()
    }

    /// The camera of the picture.
    #[must_use]
    pub fn seen_from(&self) -> Camera {
        if self.has_lens() {
            self.camera
        } else {
            self.camera.without_lens()
        }
    }

    /// The picture while the camera moves: through a pinhole, since single samples of a lens would be noise; with the BVH
    /// instead of brute force if requested.
    #[must_use]
    pub fn in_motion(&self, by_bvh: bool) -> Self {
        let mut request = self.clone();
        request.camera = self.camera.without_lens();
        request.style.brute &= !by_bvh;
        request
    }

    /// Whether a pixel costs about the same in both, so that measured times of one apply to the other.
    #[must_use]
    pub fn same_rays(&self, other: &Self) -> bool {
        let (a, b) = (&self.style, &other.style);
        Arc::ptr_eq(&self.timeline, &other.timeline)
            && (a.look, a.brute, a.settings) == (b.look, b.brute, b.settings)
    }
}
