//! What the window asks the worker to show.

use super::{objects::Objects, orbit::Pose};
use crate::{
    accel::Bvh,
    render::{Filter, Pattern, Settings, Transfer},
    scene::{Camera, Scene},
};
use std::sync::{Arc, OnceLock};

/// What the colour of a pixel shows.
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

/// Which boxes of the BVH are drawn over the picture.
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
    /// More than one sample a pixel at rest.
    pub antialias: bool,
    /// Boxes over the picture.
    pub boxes: Boxes,
    /// How the last picture at rest is traced. The size is ignored: the window has its own.
    pub settings: Settings,
    /// How linear channels become bytes.
    pub transfer: Transfer,
}

impl Style {
    /// Returns the samples a pixel of the last picture at rest.
    #[must_use]
    pub fn last_samples(&self) -> u32 {
        if self.antialias { self.settings.samples } else { 1 }
    }

    /// Returns the settings of a picture of `size` with a number of samples a pixel. A single one goes through the centre.
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

/// A scene ready for tracing.
#[derive(Debug)]
pub struct Model {
    /// The scene.
    pub scene: Scene,
    /// Its BVH.
    pub bvh: Bvh,
    objects: OnceLock<Objects>,
}

impl Model {
    /// Puts a scene and its BVH together.
    #[must_use]
    pub fn new(scene: Scene, bvh: Bvh) -> Self {
        Self {
            scene,
            bvh,
            objects: OnceLock::new(),
        }
    }

    /// Returns the objects of the scene; finds them on the first call.
    pub fn objects(&self) -> &Objects {
        self.objects.get_or_init(|| Objects::new(&self.scene))
    }

    /// Whether [`Self::objects`] returns at once: they are known, or the scene is small.
    #[must_use]
    pub fn has_objects(&self) -> bool {
        const SMALL: usize = 200_000;
        self.objects.get().is_some() || self.scene.primitive_count() <= SMALL
    }
}

/// What should be on the screen.
#[derive(Clone, Debug)]
pub struct Request {
    /// The scene.
    pub model: Arc<Model>,
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
    pub fn of_view(model: &Arc<Model>, view: u32) -> Self {
        let pose = Pose::classic_view(view).unwrap();
        Self {
            model: Arc::clone(model),
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
        let mut request = self.clone();
        request.style.brute = false;
        request
    }

    /// Whether a pixel costs about the same in both, so that measured times of one apply to the other.
    #[must_use]
    pub fn same_rays(&self, other: &Self) -> bool {
        let (a, b) = (&self.style, &other.style);
        Arc::ptr_eq(&self.model, &other.model)
            && (a.look, a.brute, a.settings) == (b.look, b.brute, b.settings)
    }
}
