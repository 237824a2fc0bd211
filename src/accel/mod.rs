//! The bounding volume hierarchies: built with obvhs, stored in our own layout. The only folder that names
//! `obvhs`.
//!
//! - [`Bvh`]: eight children a node, leaves that are blocks of up to eight primitives of one kind, for packets
//!   and SIMD single rays.
//! - [`BinaryBvh`]: two children a node, for the scalar baseline; built only when that is asked for.
//!
//! Both come from the same binary tree (PLOC: Meister and Bittner, *Parallel Locally-Ordered Clustering for
//! Bounding Volume Hierarchy Construction*, 2018, with reinsertion: Meister and Bittner, *Parallel Reinsertion
//! for Bounding Volume Hierarchy Optimization*, 2018).

mod binary;
mod collapse;
mod node;
mod pages;
mod prefetch;
mod source;

pub use binary::{BinaryBvh, BinaryNode};
pub use node::{Child, Node8};
pub use prefetch::prefetch;

use crate::{
    geometry::{SphereBlock, TriangleBlock},
    math::Aabb,
    scene::Scene,
};
use std::{
    sync::OnceLock,
    time::{Duration, Instant},
};

/// A wide bounding volume hierarchy over one scene.
#[derive(Debug)]
pub struct Bvh {
    nodes: Vec<Node8>,
    triangle_blocks: Vec<TriangleBlock>,
    sphere_blocks: Vec<SphereBlock>,
    root: Child,
    stats: BvhStats,
    binary: OnceLock<BinaryBvh>,
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
    /// Builds the hierarchy over the scene's spheres and its triangles that have an area, on the threads of
    /// the current rayon pool.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        let start = Instant::now();
        let tree = source::build_binary(scene);
        let mut bvh = collapse::collapse(scene, &tree);
        fn settled<T: Copy>(from: &[T]) -> Vec<T> {
            let mut to = pages::column(from.len());
            to.extend_from_slice(from);
            to
        }
        bvh.nodes = settled(&bvh.nodes);
        bvh.triangle_blocks = settled(&bvh.triangle_blocks);
        bvh.sphere_blocks = settled(&bvh.sphere_blocks);
        bvh.stats.memory_bytes = std::mem::size_of_val(&bvh.nodes[..])
            + std::mem::size_of_val(&bvh.triangle_blocks[..])
            + std::mem::size_of_val(&bvh.sphere_blocks[..]);
        bvh.stats.build_time = start.elapsed();
        bvh
    }

    /// What the hierarchy is made of.
    #[must_use]
    pub fn stats(&self) -> &BvhStats {
        &self.stats
    }

    /// Inner nodes, indexed by [`Child::index`].
    #[inline(always)]
    #[must_use]
    pub fn nodes(&self) -> &[Node8] {
        &self.nodes
    }

    /// Leaf blocks of triangles, indexed by [`Child::index`].
    #[inline(always)]
    #[must_use]
    pub fn triangle_blocks(&self) -> &[TriangleBlock] {
        &self.triangle_blocks
    }

    /// Leaf blocks of spheres, indexed by [`Child::index`].
    #[inline(always)]
    #[must_use]
    pub fn sphere_blocks(&self) -> &[SphereBlock] {
        &self.sphere_blocks
    }

    /// Where traversal starts: an inner node, even if all primitives would fit into one leaf.
    #[inline(always)]
    #[must_use]
    pub fn root(&self) -> Child {
        self.root
    }

    /// The box around everything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, Node8::bounds)
    }

    /// The most entries that a depth-first traversal keeps on its stack.
    #[must_use]
    pub fn stack_size(&self) -> usize {
        7 * self.stats.depth + 8
    }

    /// The binary hierarchy of the scalar baseline, built from `scene` at the first call.
    pub fn binary(&self, scene: &Scene) -> &BinaryBvh {
        self.binary.get_or_init(|| BinaryBvh::build(scene))
    }
}
