//! Writes the planned tree as nodes and blocks, directly from the scene's arrays, in parallel.
//!
//!   nodes:  [above the subtrees][subtree 0, depth first][subtree 1] ...
//!   blocks:                     [subtree 0, a node's blocks adjacent, before those below it][subtree 1] ...

use super::{
    Child, Layout, Node8,
    blocks::TriangleBlocks,
    boxes::{Box8, corners, sphere_box, triangle_box},
    pages,
    plan::{WIDTH, widen},
    progress::Steps,
    tree::{Counts, Slot, Subtree, Top, TopTree},
};
use crate::{
    geometry::{IndexedBlock, SphereBlock, TriangleBlock},
    lanes::{F32x8, Vec3x8},
    math::Aabb,
    ray::PrimitiveId,
    scene::Scene,
    simd::Simd,
};
use glam::Vec3;
use rayon::prelude::*;
use std::mem::MaybeUninit;

/// The stored form of a BVH, with its blocks of triangles as `B`.
pub(super) struct Wide<B> {
    pub(super) nodes: Vec<Node8>,
    pub(super) triangle_blocks: B,
    pub(super) sphere_blocks: Vec<SphereBlock>,
    pub(super) counts: Counts,
}

impl Wide<TriangleBlocks> {
    /// A root without children.
    pub(super) fn nothing(layout: Layout) -> Self {
        Self {
            nodes: vec![Node8::new(&[])],
            triangle_blocks: TriangleBlocks::none(layout),
            sphere_blocks: Vec::new(),
            counts: Counts {
                nodes: 1,
                depth: 1,
                ..Counts::default()
            },
        }
    }
}

impl<B> Wide<B> {
    /// The same with its blocks converted by `into`.
    pub(super) fn with_blocks<C>(self, into: impl FnOnce(B) -> C) -> Wide<C> {
        Wide {
            nodes: self.nodes,
            triangle_blocks: into(self.triangle_blocks),
            sphere_blocks: self.sphere_blocks,
            counts: self.counts,
        }
    }
}

/// Where the nodes and blocks of a subtree begin.
#[derive(Clone, Copy, Default)]
struct Start {
    node: usize,
    triangle_block: usize,
    sphere_block: usize,
}

/// An array being written, a piece per subtree. It is not zeroed beforehand, which would take as long as writing it: the
/// writing thread touches the memory first.
struct Pieces<'a, T> {
    rest: &'a mut [MaybeUninit<T>],
}

impl<'a, T> Pieces<'a, T> {
    fn of(column: &'a mut Vec<T>, count: usize) -> Self {
        column.reserve_exact(count);
        Self {
            rest: &mut column.spare_capacity_mut()[..count],
        }
    }

    fn take(&mut self, count: usize) -> &'a mut [MaybeUninit<T>] {
        let (piece, rest) = std::mem::take(&mut self.rest).split_at_mut(count);
        self.rest = rest;
        piece
    }
}

/// A block written from a scene.
pub(super) trait FromScene: Sized + Send {
    /// Triangles `ids` of a scene, and the box around them.
    fn of<S: Simd>(simd: S, scene: &Scene, ids: &[PrimitiveId]) -> (Self, Box8);
}

impl FromScene for TriangleBlock {
    #[inline(always)]
    fn of<S: Simd>(simd: S, scene: &Scene, ids: &[PrimitiveId]) -> (Self, Box8) {
        let mut around = Box8::EMPTY;
        // The block's arrays, corner after corner; lanes past the last triangle are a point.
        let mut columns = [[0.0; WIDTH]; 9];
        let mut id = [PrimitiveId::NONE.0; WIDTH];
        for (lane, &triangle) in ids.iter().enumerate().take(WIDTH) {
            id[lane] = triangle.0;
            let [v0, v1, v2] = corners(scene, triangle.0 as usize);
            around = around.union(simd, triangle_box([v0, v1, v2], triangle));
            let numbers = [v0.x, v0.y, v0.z, v1.x, v1.y, v1.z, v2.x, v2.y, v2.z];
            for (column, number) in columns.iter_mut().zip(numbers) {
                column[lane] = number;
            }
        }
        let [x0, y0, z0, x1, y1, z1, x2, y2, z2] = columns;
        let corner8 = |x: [f32; WIDTH], y: [f32; WIDTH], z: [f32; WIDTH]| {
            Vec3x8::new(F32x8::new(x), F32x8::new(y), F32x8::new(z))
        };
        let block = Self {
            v0: corner8(x0, y0, z0),
            v1: corner8(x1, y1, z1),
            v2: corner8(x2, y2, z2),
            id,
        };
        (block, around)
    }
}

impl FromScene for IndexedBlock {
    #[inline(always)]
    fn of<S: Simd>(simd: S, scene: &Scene, ids: &[PrimitiveId]) -> (Self, Box8) {
        let mut around = Box8::EMPTY;
        let mut triangles = [(PrimitiveId::NONE, [0; 3], [Vec3::ZERO; 3]); WIDTH];
        for (lane, &id) in ids.iter().enumerate().take(WIDTH) {
            let i = id.0 as usize;
            triangles[lane] = (id, scene.triangles().corners[i], corners(scene, i));
            around = around.union(simd, triangle_box(triangles[lane].2, id));
        }
        let block = Self::new(&triangles[..ids.len()]);
        (block.expect("what has too many vertices is divided"), around)
    }
}

/// Writes out `top`, whose leaves' order is that of `ids`.
pub(super) fn emit<S: Simd, B: FromScene>(
    simd: S,
    (scene, ids): (&Scene, &[PrimitiveId]),
    top: &Top,
    steps: &Steps<'_>,
) -> Wide<Vec<B>> {
    let mut above = Above::default();
    let depth = match top {
        Top::Subtree(subtree) => {
            above.subtrees.push(subtree);
            subtree.counts.depth
        }
        Top::Inner(_) => above.write(top),
    };
    let mut counts = above.counts;
    let mut starts = Vec::with_capacity(above.subtrees.len());
    for subtree in &above.subtrees {
        starts.push(Start {
            node: counts.nodes,
            triangle_block: counts.triangle_blocks,
            sphere_block: counts.sphere_blocks,
        });
        counts.add(&subtree.counts);
    }
    counts.depth = depth;

    let mut wide = Wide {
        nodes: pages::vec(counts.nodes),
        triangle_blocks: pages::vec(counts.triangle_blocks),
        sphere_blocks: pages::vec(counts.sphere_blocks),
        counts,
    };
    let mut nodes = Pieces::of(&mut wide.nodes, counts.nodes);
    let mut triangle_blocks = Pieces::of(&mut wide.triangle_blocks, counts.triangle_blocks);
    let mut sphere_blocks = Pieces::of(&mut wide.sphere_blocks, counts.sphere_blocks);
    above.emit(nodes.take(above.nodes.len()), &starts);
    let jobs: Vec<_> = above
        .subtrees
        .iter()
        .zip(&starts)
        .map(|(subtree, &start)| Emission {
            simd,
            scene,
            ids: &ids[subtree.first..],
            slots: &subtree.slots,
            steps,
            primitives: subtree.counts.primitives(),
            start,
            written: Start::default(),
            nodes: nodes.take(subtree.counts.nodes),
            triangle_blocks: triangle_blocks.take(subtree.counts.triangle_blocks),
            sphere_blocks: sphere_blocks.take(subtree.counts.sphere_blocks),
        })
        .collect();
    jobs.into_par_iter().with_max_len(1).for_each(Emission::run);
    // SAFETY: `above` has written its nodes, and each subtree all of its nodes and blocks, which `run` checks. Their sums
    // are the counts, for which the capacity was reserved.
    unsafe {
        wide.nodes.set_len(counts.nodes);
        wide.triangle_blocks.set_len(counts.triangle_blocks);
        wide.sphere_blocks.set_len(counts.sphere_blocks);
    }
    wide
}

impl Counts {
    fn add(&mut self, other: &Self) {
        self.nodes += other.nodes;
        self.triangle_blocks += other.triangle_blocks;
        self.sphere_blocks += other.sphere_blocks;
        for i in 0..WIDTH {
            self.leaf_sizes[i] += other.leaf_sizes[i];
            self.children[i] += other.children[i];
        }
    }
}

/// The nodes above the subtrees.
#[derive(Default)]
struct Above<'a> {
    /// Children and their boxes.
    nodes: Vec<Vec<(Part, Aabb)>>,
    /// From left to right.
    subtrees: Vec<&'a Subtree>,
    counts: Counts,
}

/// A child of a node above the subtrees: another such node, or the root of a subtree, by index.
#[derive(Clone, Copy)]
enum Part {
    Node(usize),
    Subtree(usize),
}

impl<'a> Above<'a> {
    /// Appends the node for `top`, then what is below it; returns its depth.
    fn write(&mut self, top: &'a Top) -> usize {
        let node_i = self.nodes.len();
        self.nodes.push(Vec::new());
        let children = widen(&TopTree::default(), top);
        self.counts.nodes += 1;
        self.counts.children[children.len() - 1] += 1;
        let mut depth = 0;
        for child in children.iter() {
            let (part, below) = match child {
                Top::Subtree(subtree) => {
                    self.subtrees.push(subtree);
                    (Part::Subtree(self.subtrees.len() - 1), subtree.counts.depth)
                }
                Top::Inner(_) => {
                    let node = Part::Node(self.nodes.len());
                    (node, self.write(child))
                }
            };
            self.nodes[node_i].push((part, child.bounds().bounds()));
            depth = depth.max(below);
        }
        depth + 1
    }

    fn emit(&self, nodes: &mut [MaybeUninit<Node8>], starts: &[Start]) {
        for (children, node) in self.nodes.iter().zip(nodes) {
            let children: Vec<_> = children
                .iter()
                .map(|&(part, bounds)| match part {
                    Part::Node(i) => (Child::inner(i), bounds),
                    Part::Subtree(i) => (Child::inner(starts[i].node), bounds),
                })
                .collect();
            node.write(Node8::new(&children));
        }
    }
}

/// One subtree being written.
struct Emission<'a, S, B> {
    simd: S,
    scene: &'a Scene,
    /// From the subtree's first on.
    ids: &'a [PrimitiveId],
    slots: &'a [Slot],
    steps: &'a Steps<'a>,
    primitives: usize,
    start: Start,
    written: Start,
    nodes: &'a mut [MaybeUninit<Node8>],
    triangle_blocks: &'a mut [MaybeUninit<B>],
    sphere_blocks: &'a mut [MaybeUninit<SphereBlock>],
}

impl<S: Simd, B: FromScene> Emission<'_, S, B> {
    fn run(mut self) {
        self.node();
        let all = (
            self.nodes.len(),
            self.triangle_blocks.len(),
            self.sphere_blocks.len(),
        );
        let Start {
            node,
            triangle_block,
            sphere_block,
        } = self.written;
        assert!(
            all == (node, triangle_block, sphere_block),
            "a subtree is written as counted"
        );
        self.steps.finished(self.primitives);
    }

    /// Writes the next node and all below it; returns the box around it.
    fn node(&mut self) -> Box8 {
        let simd = self.simd;
        simd.call(
            #[inline(always)]
            || self.node_at(simd),
        )
    }

    #[inline(always)]
    fn node_at(&mut self, simd: S) -> Box8 {
        let node_i = self.written.node;
        self.written.node += 1;
        let count = self.slots.iter().take_while(|slot| !slot.is_last()).count() + 1;
        let (slots, rest) = self.slots.split_at(count);
        self.slots = rest;
        let mut children = [(Child::NONE, Aabb::EMPTY); WIDTH];
        let mut bounds = Box8::EMPTY;
        for (i, slot) in slots.iter().enumerate() {
            if let Some(range) = slot.block() {
                let (block, around) = self.block(simd, &self.ids[range]);
                children[i] = (block, around.bounds());
                bounds = bounds.union(simd, around);
            }
        }
        for (i, slot) in slots.iter().enumerate() {
            if slot.block().is_none() {
                let below = Child::inner(self.start.node + self.written.node);
                let around = self.node();
                children[i] = (below, around.bounds());
                bounds = bounds.union(simd, around);
            }
        }
        self.nodes[node_i].write(Node8::new(&children[..count]));
        bounds
    }

    /// Writes the next block; returns the box around it.
    #[inline(always)]
    fn block(&mut self, simd: S, ids: &[PrimitiveId]) -> (Child, Box8) {
        let first_sphere = self.scene.triangles().corners.len();
        if (ids[0].0 as usize) < first_sphere {
            let (block, around) = B::of(simd, self.scene, ids);
            let block_i = self.written.triangle_block;
            self.written.triangle_block += 1;
            self.triangle_blocks[block_i].write(block);
            let child = Child::triangles(self.start.triangle_block + block_i, ids.len());
            (child, around)
        } else {
            let mut around = Box8::EMPTY;
            let mut spheres = [(PrimitiveId::NONE, Vec3::ZERO, 0.0); WIDTH];
            for (lane, &id) in ids.iter().enumerate().take(WIDTH) {
                let i = id.0 as usize - first_sphere;
                around = around.union(simd, sphere_box(self.scene, i, id));
                spheres[lane] = (id, self.scene.spheres().center(i), self.scene.spheres().radius[i]);
            }
            let block_i = self.written.sphere_block;
            self.written.sphere_block += 1;
            self.sphere_blocks[block_i].write(SphereBlock::new(&spheres[..ids.len()]));
            let child = Child::spheres(self.start.sphere_block + block_i, ids.len());
            (child, around)
        }
    }
}
