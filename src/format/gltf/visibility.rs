//! Hidden nodes: the extension `KHR_node_visibility`, The Khronos Group, 2025.
//!
//! A hidden node shows nothing, nor do the nodes below it. Cameras and joints stay.

use gltf::json;
use serde::{Deserialize, de::IgnoredAny};

const EXTENSION: &str = "KHR_node_visibility";

/// Which nodes are hidden; empty if the file does not use the extension.
pub(super) struct Hidden(Vec<bool>);

/// The parts of the JSON that matter here.
#[derive(Default, Deserialize)]
#[serde(default)]
struct File {
    nodes: Vec<Node>,
}

/// A faulty node is visible.
#[derive(Deserialize)]
#[serde(untagged)]
enum Node {
    Read { extensions: Extensions },
    Other(IgnoredAny),
}

#[derive(Deserialize)]
struct Extensions {
    #[serde(rename = "KHR_node_visibility")]
    visibility: Visibility,
}

#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "visible")]
    visible: bool,
}

fn visible() -> bool {
    true
}

impl Hidden {
    /// Reads the JSON once more, but only if it names the extension.
    pub(super) fn of(text: &[u8]) -> Self {
        if !super::has(text, EXTENSION) {
            return Self(Vec::new());
        }
        let File { nodes } = json::deserialize::from_slice(text).unwrap_or_default();
        let is_hidden =
            |node: Node| matches!(node, Node::Read { extensions } if !extensions.visibility.visible);
        Self(nodes.into_iter().map(is_hidden).collect())
    }

    /// How many nodes are hidden themselves.
    pub(super) fn count(&self) -> usize {
        self.0.iter().filter(|is_hidden| **is_hidden).count()
    }

    /// Whether a node is hidden itself.
    pub(super) fn is_at(&self, node: usize) -> bool {
        self.0.get(node).is_some_and(|is_hidden| *is_hidden)
    }
}
