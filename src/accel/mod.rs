//! The bounding volume hierarchies, stored in our own layout. The only folder that names `obvhs`.
//!
//! - [`Bvh`]: eight children a node, leaves that are blocks of up to eight primitives of one kind, for packets
//!   and SIMD single rays. Built top down by a builder of our own; with [`BuildQuality::Ploc`], to compare, divided as
//!   obvhs divides and made wide by the same code.
//! - [`BinaryBvh`]: two children a node, for the scalar baseline; built only when that is asked for, with obvhs (PLOC and
//!   reinsertion).
//!
//! Lab notes (`cargo bench --bench builds`, Zen 3, eight lanes, all trees built and traced in turn in one process, median
//! of seven, built without LTO; a slow phase of the machine, in which all trees lose up to a third; ten million blobs
//! not measured):
//!
//! | scene | build, one thread: PLOC, best | two threads | rays a second, best's of PLOC's: camera, shadow, mirror |
//! |---|---|---|---|
//! | figurine, 6,000 | 3.3 ms, 1.4 ms | 3.0 ms, 0.8 ms | 113 %, 99 %, 102 % |
//! | figure, 70,000 | 34 ms, 14 ms | 33 ms, 11 ms | 101 %, 103 %, 102 % |
//! | interior, 370,000 | 268 ms, 99 ms | 210 ms, 65 ms | 101 %, 98 %, 105 % |
//! | terrain, 1,000,000 | 920 ms, 272 ms | 587 ms, 152 ms | 113 %, 121 %, 119 % |
//! | spheres, 100,000 | 46 ms, 19 ms | 34 ms, 10 ms | 111 %, 107 %, 115 % |
//!
//! PLOC's leaf blocks are less full, too: 60 to 65 bytes a triangle in place of 49 to 54. So the tree that is built sooner
//! is nowhere slower to trace beyond noise, and nothing takes the other one unless told to.

mod binary;
mod blocks;
mod boxes;
mod emit;
mod node;
mod pages;
mod plan;
mod ploc;
mod prefetch;
mod quality;
mod split;
mod tree;

pub use binary::{BinaryBvh, BinaryNode};
pub use blocks::{Layout, LeafBlocks, TriangleBlocks};
pub use node::{Child, Node8};
pub use prefetch::{Places, prefetch, prefetch_for_later};
pub use quality::BuildQuality;

use emit::Wide;

use crate::{geometry::SphereBlock, math::Aabb, scene::Scene, simd::LANES};
use std::{
    sync::OnceLock,
    time::{Duration, Instant},
};

/// A wide bounding volume hierarchy over one scene.
#[derive(Debug)]
pub struct Bvh {
    nodes: Vec<Node8>,
    triangle_blocks: TriangleBlocks,
    sphere_blocks: Vec<SphereBlock>,
    root: Child,
    stats: BvhStats,
    binary: OnceLock<BinaryBvh>,
}

/// What a BVH is made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BvhStats {
    /// What was asked for.
    pub quality: BuildQuality,
    /// How triangles are stored.
    pub layout: Layout,
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
    /// Builds the hierarchy that is traced fastest over the scene's spheres and its triangles that have an area, on
    /// the threads of the current rayon pool.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        Self::build_with(scene, BuildQuality::Best)
    }

    /// [`Self::build`], with a word on what it may cost. The tree depends on scene and quality alone, not on the
    /// number of threads (with an exception of [`BuildQuality::Ploc`]).
    #[must_use]
    pub fn build_with(scene: &Scene, quality: BuildQuality) -> Self {
        Self::build_as(scene, quality, Layout::for_scene(scene))
    }

    /// [`Self::build_with`], with triangles stored in a given way, to compare them. Both find the same hits.
    #[must_use]
    pub fn build_as(scene: &Scene, quality: BuildQuality, layout: Layout) -> Self {
        let start = Instant::now();
        let mut boxes = boxes::boxes_of(scene);
        let Wide {
            nodes,
            triangle_blocks,
            sphere_blocks,
            counts,
        } = if boxes.is_empty() {
            Wide::nothing(layout)
        } else {
            let top = tree::build(&mut boxes, scene, quality, layout);
            let ids = boxes::into_ids(boxes);
            match layout {
                Layout::Whole => emit::emit(scene, &top, &ids).with_blocks(TriangleBlocks::Whole),
                Layout::Indexed => emit::emit(scene, &top, &ids).with_blocks(TriangleBlocks::Indexed),
            }
        };
        let stats = BvhStats {
            quality,
            layout,
            nodes: counts.nodes,
            triangle_blocks: counts.triangle_blocks,
            sphere_blocks: counts.sphere_blocks,
            depth: counts.depth,
            leaf_sizes: counts.leaf_sizes,
            child_counts: counts.children,
            memory_bytes: size_of_val(&nodes[..]) + triangle_blocks.bytes() + size_of_val(&sphere_blocks[..]),
            build_time: start.elapsed(),
        };
        Self {
            nodes,
            triangle_blocks,
            sphere_blocks,
            root: Child::inner(0),
            stats,
            binary: OnceLock::new(),
        }
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

    /// Leaf blocks of triangles.
    #[inline(always)]
    #[must_use]
    pub fn triangle_blocks(&self) -> &TriangleBlocks {
        &self.triangle_blocks
    }

    /// The ids of a leaf's primitives: the first [`Child::count`] of them.
    ///
    /// # Panics
    /// If `leaf` is no leaf of this hierarchy.
    #[must_use]
    pub fn leaf_ids(&self, leaf: Child) -> [u32; LANES] {
        if leaf.is_triangles() {
            self.triangle_blocks.ids(leaf.index())
        } else {
            self.sphere_blocks[leaf.index()].id
        }
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
