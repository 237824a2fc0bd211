//! How pictures are made, and what their pixels hold.

use crate::{
    cli::write::AovKind,
    render::{Settings, Transfer},
};

/// How pictures are made.
#[derive(Debug, PartialEq)]
pub struct Look {
    pub settings: Settings,
    pub picture: PictureOptions,
}

/// The looks of scenes and of meshes. Both have the same size, crop and AOVs, and that of meshes takes at least as much
/// memory.
#[derive(Debug)]
pub struct Looks {
    pub scene: Look,
    pub mesh: Look,
}

impl Looks {
    /// The look of a mesh, or of a scene.
    pub fn of(&self, is_mesh: bool) -> &Look {
        if is_mesh { &self.mesh } else { &self.scene }
    }
}

/// What the pixels hold.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureOptions {
    /// How linear channels become bytes.
    pub transfer: Transfer,
    /// Pixels that show nothing get alpha 0.
    pub transparent: bool,
    pub aovs: Vec<AovKind>,
    /// Units of a step of depth in a PNG file.
    pub z_step: f64,
}
