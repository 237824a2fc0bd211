//! The bounding volume hierarchy: built with obvhs, stored in our own layout. The only folder that names
//! `obvhs`.

use crate::scene::Scene;
use std::time::Duration;

/// A wide bounding volume hierarchy over one scene.
#[derive(Debug)]
pub struct Bvh {
    stats: BvhStats,
}

/// What a BVH is made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BvhStats {
    /// Inner nodes.
    pub nodes: usize,
    /// Leaf blocks of up to 8 triangles.
    pub triangle_blocks: usize,
    /// Leaf blocks of up to 8 spheres.
    pub sphere_blocks: usize,
    /// Inner nodes on the longest way from the root to a leaf.
    pub depth: usize,
    /// How many leaf blocks hold 1, 2, ... 8 primitives.
    pub leaf_sizes: [usize; 8],
    /// How many inner nodes have 1, 2, ... 8 children.
    pub child_counts: [usize; 8],
    /// Bytes of nodes and leaf blocks.
    pub memory_bytes: usize,
    /// Wall-clock time of the build.
    pub build_time: Duration,
}

impl Bvh {
    /// Builds the hierarchy over the scene's spheres and its triangles that have an area.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        let _ = scene;
        Self {
            stats: BvhStats::default(),
        }
    }

    /// What the hierarchy is made of.
    #[must_use]
    pub fn stats(&self) -> &BvhStats {
        &self.stats
    }
}
