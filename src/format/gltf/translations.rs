//! The translations of nodes in `f64`, for files far from 0: the gltf crate rounds them to `f32`.

use crate::format::offset::Offset;
use glam::DVec3;
use gltf::json;
use serde::Deserialize;

/// The translations, by node; empty unless the file is read relative to an offset.
#[derive(Default)]
pub(super) struct Translations(Vec<Node>);

/// The parts of the JSON that matter here.
#[derive(Deserialize)]
struct Scene {
    #[serde(default)]
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    #[serde(default)]
    translation: Option<[f64; 3]>,
    #[serde(default)]
    matrix: Option<[f64; 16]>,
}

impl Translations {
    /// Reads the JSON once more, but only for an offset.
    pub(super) fn of(text: &[u8], offset: Offset) -> Self {
        if offset.is_none() {
            return Self::default();
        }
        let scene = json::deserialize::from_slice(text).map(|scene: Scene| scene.nodes);
        Self(scene.unwrap_or_default())
    }

    /// The translation of a node, if it has one.
    pub(super) fn of_node(&self, node: usize) -> Option<DVec3> {
        let Node { translation, matrix } = self.0.get(node)?;
        let of_matrix = || matrix.as_ref().map(|matrix| DVec3::from_slice(&matrix[12..]));
        translation.map(DVec3::from_array).or_else(of_matrix)
    }
}
