//! Builds and stores the bounding volume hierarchies. The only module that uses `obvhs`.
//!
//! ```text
//! boxes -> binary tree, top down, binned SAH (tree, split)
//!       -> eight children per node, up to eight primitives per block (plan)
//!       -> nodes and leaf blocks, written in parallel (emit)
//! ```
//!
//! - [`Bvh`]: eight children per node; leaves are blocks of one kind of primitive. For packets and single rays.
//! - [`BinaryBvh`]: two children per node, by obvhs (PLOC and reinsertion), for the scalar baseline.
// Best against PLOC: see docs/lab-notes.md#ploc

mod binary;
mod blocks;
mod boxes;
mod emit;
mod footprint;
mod instances;
mod node;
mod pages;
mod plan;
mod ploc;
mod prefetch;
mod progress;
mod quality;
mod refit;
mod split;
mod tree;

pub use binary::{BinaryBvh, BinaryInstances, BinaryNode};
pub use blocks::{Layout, TriangleBlocks};
pub(crate) use instances::Instanced;
pub use node::{Child, Node8};
pub(crate) use prefetch::{Places, prefetch, prefetch_for_later};
pub use progress::{BuildProgress, OnBuild};
pub use quality::BuildQuality;

use emit::Wide;
use progress::Steps;
use tree::Blocks;

use crate::{
    geometry::SphereBlock,
    lanes::LANES,
    math::Aabb,
    ray::PrimitiveId,
    scene::{PrototypeId, Scene, SceneId},
    simd::{Level, Simd, at_level},
};
use std::{
    sync::OnceLock,
    time::{Duration, Instant},
};

/// A wide bounding volume hierarchy over one scene.
#[derive(Clone, Debug)]
pub struct Bvh {
    nodes: Vec<Node8>,
    triangle_blocks: TriangleBlocks,
    sphere_blocks: Vec<SphereBlock>,
    stats: BvhStats,
    binary: OnceLock<BinaryBvh>,
    /// The hierarchies of instances and prototypes, if the scene has instances.
    instanced: Option<Box<Instanced>>,
    scene: SceneId,
    /// The id of the scene's meshes, which stays the same while instances move.
    meshes: SceneId,
    /// Number of triangles without an area, which are not in the BVH.
    degenerate: usize,
    /// A primitive, and an equal one that is not in the BVH; in order.
    repeats: Vec<[PrimitiveId; 2]>,
}

/// Describes a BVH.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BvhStats {
    /// The requested quality.
    pub quality: BuildQuality,
    /// How triangles are stored.
    pub layout: Layout,
    /// Inner nodes.
    pub nodes: usize,
    /// Leaf blocks of up to 8 triangles.
    pub triangle_blocks: usize,
    /// Leaf blocks of up to 8 spheres.
    pub sphere_blocks: usize,
    /// Inner nodes on the longest path from the root to a leaf.
    pub depth: usize,
    /// Numbers of leaf blocks with 1, 2, ... 8 primitives.
    pub leaf_sizes: [usize; 8],
    /// Numbers of inner nodes with 1, 2, ... 8 children.
    pub child_counts: [usize; 8],
    /// Bytes of nodes and leaf blocks.
    pub memory_bytes: usize,
    /// Wall-clock time of the build.
    pub build_time: Duration,
}

impl BvhStats {
    /// Returns the number of primitives in all leaf blocks.
    #[must_use]
    pub fn primitives(&self) -> usize {
        let of_size = self.leaf_sizes.iter().zip(1..);
        of_size.map(|(blocks, size)| blocks * size).sum()
    }
}

impl Bvh {
    /// Builds the hierarchy that is traced fastest over the scene's spheres and its triangles with an area, on the
    /// threads of the current rayon pool.
    ///
    /// # Panics
    /// If it would have more than [`Child::MAX_BLOCKS`] nodes or leaf blocks of a kind, which take 30 GB and more.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        Self::build_with(scene, BuildQuality::Best)
    }

    /// Builds a hierarchy of a given quality. The tree depends only on scene and quality, not on the number of threads (but
    /// see [`BuildQuality::Ploc`]).
    ///
    /// # Panics
    /// As [`Bvh::build`].
    #[must_use]
    pub fn build_with(scene: &Scene, quality: BuildQuality) -> Self {
        Self::build_as(scene, quality, Layout::for_scene(scene))
    }

    /// As [`build_with`](Self::build_with), and reports progress.
    ///
    /// # Panics
    /// As [`Bvh::build`].
    #[must_use]
    pub fn build_watched(scene: &Scene, quality: BuildQuality, on_build: OnBuild<'_>) -> Self {
        Self::build_in((scene, quality), Layout::for_scene(scene), on_build)
    }

    /// Builds a hierarchy with triangles in a given layout, to compare layouts. Both find the same hits.
    ///
    /// # Panics
    /// As [`Bvh::build`].
    #[must_use]
    pub fn build_as(scene: &Scene, quality: BuildQuality, layout: Layout) -> Self {
        Self::build_in((scene, quality), layout, &|_| ())
    }

    fn build_in((scene, quality): (&Scene, BuildQuality), layout: Layout, on_build: OnBuild<'_>) -> Self {
        let steps = Steps::of(scene, on_build);
        at_level!(Level::current(), |simd| Self::build_at(
            simd, scene, quality, layout, &steps
        ))
    }

    /// Builds a hierarchy at a level; the tree is the same at all of them.
    fn build_at<S: Simd>(
        simd: S,
        scene: &Scene,
        quality: BuildQuality,
        layout: Layout,
        steps: &Steps<'_>,
    ) -> Self {
        let start = Instant::now();
        let mut bvh = Self::of_part(simd, (scene, None), quality, layout, steps);
        if !scene.instances().is_empty() {
            let instanced = Instanced::build(simd, scene, quality, steps);
            bvh.stats.memory_bytes += instanced.bytes();
            bvh.stats.build_time = start.elapsed();
            bvh.instanced = Some(Box::new(instanced));
        }
        bvh
    }

    /// Follows a scene whose instances [moved](Scene::set_time): rebuilds the level over them and keeps everything below.
    ///
    /// # Panics
    /// If the hierarchy was built from another scene.
    pub fn follow(&mut self, scene: &Scene) {
        assert!(
            self.meshes == scene.meshes_id(),
            "this BVH was built from another scene"
        );
        if self.is_of(scene) {
            return;
        }
        let start = Instant::now();
        self.scene = scene.id();
        if let Some(instanced) = &mut self.instanced {
            let before = instanced.bytes();
            at_level!(Level::current(), |simd| instanced.follow(
                simd,
                scene,
                self.stats.quality
            ));
            self.stats.memory_bytes = self.stats.memory_bytes - before + instanced.bytes();
        }
        if let Some(mut binary) = self.binary.take() {
            binary.follow(scene);
            self.binary = binary.into();
        }
        self.stats.build_time = start.elapsed();
    }

    /// Builds over a prototype, or over what is outside of all.
    fn of_part<S: Simd>(
        simd: S,
        (scene, prototype): (&Scene, Option<PrototypeId>),
        quality: BuildQuality,
        layout: Layout,
        steps: &Steps<'_>,
    ) -> Self {
        let start = Instant::now();
        let (mut boxes, repeats) = boxes::boxes_of(scene, &scene.ids_of(prototype));
        steps.finished(boxes.len());
        let Wide {
            nodes,
            triangle_blocks,
            sphere_blocks,
            counts,
        } = if boxes.is_empty() {
            Wide::nothing(layout)
        } else {
            let top = tree::build(simd, &mut boxes, Blocks::of(scene, layout), quality, steps);
            let ids = boxes::into_ids(boxes);
            let from = (scene, &ids[..]);
            match layout {
                Layout::Whole => emit::emit(simd, from, &top, steps).with_blocks(TriangleBlocks::Whole),
                Layout::Indexed => emit::emit(simd, from, &top, steps).with_blocks(TriangleBlocks::Indexed),
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
            stats,
            binary: OnceLock::new(),
            instanced: None,
            scene: scene.id(),
            meshes: scene.meshes_id(),
            degenerate: scene.degenerate_triangles(),
            repeats,
        }
    }

    /// Returns pairs of a primitive and one of equal shape, which the BVH leaves out because it is never the closest.
    pub(crate) fn repeats(&self) -> &[[PrimitiveId; 2]] {
        &self.repeats
    }

    /// Returns whether the hierarchy was built from this scene, and has followed it since it moved.
    #[must_use]
    pub fn is_of(&self, scene: &Scene) -> bool {
        self.scene == scene.id()
    }

    /// Returns statistics of the hierarchy.
    #[must_use]
    pub fn stats(&self) -> &BvhStats {
        &self.stats
    }

    /// Returns statistics of the hierarchy over instances, and the sums of those of their prototypes with the largest depth;
    /// `None` without instances. Quality, layout and time are those of [`Self::stats`].
    #[doc(hidden)]
    #[must_use]
    pub fn instanced_stats(&self) -> Option<(BvhStats, BvhStats)> {
        self.instanced().map(Instanced::stats)
    }

    /// Returns the inner nodes, indexed by [`Child::index`].
    #[inline(always)]
    #[must_use]
    pub fn nodes(&self) -> &[Node8] {
        &self.nodes
    }

    /// Returns the leaf blocks of triangles.
    #[inline(always)]
    #[must_use]
    pub fn triangle_blocks(&self) -> &TriangleBlocks {
        &self.triangle_blocks
    }

    /// Returns the ids of a leaf's primitives: the first [`Child::count`] of them.
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

    /// Returns the leaf blocks of spheres, indexed by [`Child::index`].
    #[inline(always)]
    #[must_use]
    pub fn sphere_blocks(&self) -> &[SphereBlock] {
        &self.sphere_blocks
    }

    /// Returns where traversal starts: an inner node, even if all primitives fit into one leaf.
    #[inline(always)]
    #[must_use]
    pub fn root(&self) -> Child {
        Child::inner(0)
    }

    /// Returns the hierarchies of instances and prototypes, if the scene has instances.
    #[inline(always)]
    pub(crate) fn instanced(&self) -> Option<&Instanced> {
        self.instanced.as_deref()
    }

    /// Returns the box around everything.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        let bounds = |nodes: &[Node8]| nodes.first().map_or(Aabb::EMPTY, Node8::bounds);
        let instances = self
            .instanced()
            .map_or(Aabb::EMPTY, |instanced| bounds(instanced.nodes()));
        bounds(&self.nodes).union(instances)
    }

    /// Returns the most entries that a depth-first traversal keeps on its stack.
    #[must_use]
    pub fn stack_size(&self) -> usize {
        7 * self.stats.depth + 8
    }

    /// Returns the binary hierarchy of the scalar baseline, built at the first call.
    ///
    /// # Panics
    /// If this hierarchy was built from another scene.
    pub fn binary(&self, scene: &Scene) -> &BinaryBvh {
        assert!(self.is_of(scene), "this BVH was built from another scene");
        if let Some(binary) = self.binary.get() {
            return binary;
        }
        // Not while the lock is held: the build may run a task of the same pool that waits for this lock.
        let built = BinaryBvh::build(scene);
        self.binary.get_or_init(|| built)
    }
}
