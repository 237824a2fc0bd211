//! Builds the binary tree top down and converts it to the structure of a wide tree.
//!
//!   all boxes -> top: threads share each division -> subtrees of 1024 to 4096 primitives
//!   subtree: built, planned and stored as slots of a wide tree by one thread, in its cache
//!
//! After Wald, *Fast Construction of SAH BVHs on the Intel Many Integrated Core (MIC) Architecture*, 2012. Differs:
//! threads also make their subtrees wide.

use super::{
    BuildQuality, Layout,
    boxes::Box8,
    footprint::footprint,
    plan::{Plan, Planned, WIDTH, widen},
    ploc::{self, BinaryTree, BinaryTreeNode},
    progress::Steps,
    split::{Effort, divide},
};
use crate::{geometry::IndexedBlock, scene::Scene, simd::Simd};
use rayon::prelude::*;
use std::marker::PhantomData;

/// Maximum primitives of a subtree that one thread builds: few enough for its cache, and for all threads to have some. It
/// does not depend on the number of threads, so that every machine builds the same tree.
// Tried: see docs/lab-notes.md#subtrees
pub(super) fn subtree_size(count: usize) -> usize {
    (count / 32).clamp(1024, 4096)
}

/// Sets of more primitives find their centres' box in parallel: idle threads against the cost of tasks.
// Tuned: see docs/lab-notes.md#varied-constants
pub(super) const PARALLEL: usize = 1 << 15;

/// The number of levels that the [`Divider`] decides in a tree of `count` primitives; below, sets are halved.
fn most_levels(count: usize) -> u32 {
    3 * (usize::BITS - count.leading_zeros()) + 16
}

/// The tree above the subtrees.
#[expect(
    clippy::large_enum_variant,
    reason = "the larger one is the more frequent one"
)]
pub(super) enum Top {
    /// A subtree.
    Subtree(Subtree),
    /// Two of them, or more.
    Inner(Box<TopInner>),
}

pub(super) struct TopInner {
    pub(super) children: [Top; 2],
    bounds: Box8,
    plan: Plan,
}

impl Top {
    pub(super) fn plan(&self) -> &Plan {
        match self {
            Self::Subtree(subtree) => &subtree.plan,
            Self::Inner(inner) => &inner.plan,
        }
    }

    pub(super) fn bounds(&self) -> Box8 {
        match self {
            Self::Subtree(subtree) => subtree.bounds,
            Self::Inner(inner) => inner.bounds,
        }
    }
}

/// The tree above the subtrees as a [`Planned`] tree.
#[derive(Default)]
pub(super) struct TopTree<'a>(PhantomData<&'a Top>);

impl<'a> Planned for TopTree<'a> {
    type Node = &'a Top;

    fn plan(&self, node: &'a Top) -> &Plan {
        node.plan()
    }

    fn children(&self, node: &'a Top) -> Option<[&'a Top; 2]> {
        match node {
            Top::Subtree(_) => None,
            Top::Inner(inner) => Some(inner.children.each_ref()),
        }
    }
}

/// Counts of a tree.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Counts {
    pub(super) nodes: usize,
    pub(super) triangle_blocks: usize,
    pub(super) sphere_blocks: usize,
    /// Nodes on the longest path down.
    pub(super) depth: usize,
    /// Blocks of 1, 2, ... 8 primitives.
    pub(super) leaf_sizes: [usize; WIDTH],
    /// Nodes with 1, 2, ... 8 children.
    pub(super) children: [usize; WIDTH],
}

impl Counts {
    /// Primitives of all blocks.
    pub(super) fn primitives(&self) -> usize {
        let of_size = self.leaf_sizes.iter().zip(1..);
        of_size.map(|(blocks, size)| blocks * size).sum()
    }
}

/// A wide subtree without its boxes; the primitives are in the order of its leaves.
pub(super) struct Subtree {
    /// Index of its first primitive.
    pub(super) first: usize,
    pub(super) bounds: Box8,
    pub(super) plan: Plan,
    pub(super) counts: Counts,
    /// For each node, before those below it: its [`Slot`]s, the last of them marked.
    pub(super) slots: Vec<Slot>,
}

/// A child of a node: an inner node, which follows in this order, or a block and where its primitives begin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot(u32);

impl Slot {
    const LAST: u32 = 1 << 31;

    fn new(first: usize, block: usize, is_last: bool) -> Self {
        Self((first as u32) << 4 | block as u32 | if is_last { Self::LAST } else { 0 })
    }

    /// Whether this is its node's last child.
    pub(super) fn is_last(self) -> bool {
        self.0 & Self::LAST != 0
    }

    /// Primitives of a block; none for an inner node.
    pub(super) fn block(self) -> Option<std::ops::Range<usize>> {
        let first = (self.0 & !Self::LAST) as usize >> 4;
        match self.0 as usize & 15 {
            0 => None,
            count => Some(first..first + count),
        }
    }
}

/// Decides where sets of primitives are divided.
trait Divider: Copy + Sync + Send {
    /// Divides `boxes` in place and returns how many are in the first part, at least one and not all, and the
    /// dividers of the parts. If `halve`, both parts are equal.
    fn divide<S: Simd>(self, simd: S, boxes: &mut [Box8], effort: Effort, halve: bool) -> (usize, [Self; 2]);
}

/// The [surface area heuristic](super::split).
#[derive(Clone, Copy)]
struct BySurfaceArea;

impl Divider for BySurfaceArea {
    #[inline(always)]
    fn divide<S: Simd>(self, simd: S, boxes: &mut [Box8], effort: Effort, halve: bool) -> (usize, [Self; 2]) {
        let centers = around_centers(simd, boxes);
        (divide(simd, boxes, centers, effort, halve), [self; 2])
    }
}

/// Divides like an existing binary tree, whose leaf order the boxes have, down to sets that may fit a block; below
/// those by the surface area heuristic.
#[derive(Clone, Copy)]
struct AsIn<'a> {
    tree: &'a BinaryTree,
    /// The node of the set.
    node_i: Option<usize>,
}

impl Divider for AsIn<'_> {
    fn divide<S: Simd>(self, simd: S, boxes: &mut [Box8], effort: Effort, halve: bool) -> (usize, [Self; 2]) {
        let with = |node_i| Self { node_i, ..self };
        match self.node_i.map(|node_i| self.tree.node(node_i)) {
            Some(BinaryTreeNode::Inner([left, right])) if boxes.len() > WIDTH && !halve => {
                let count = self.tree.size(left) as usize;
                (count, [with(Some(left)), with(Some(right))])
            }
            _ => {
                let (count, _) = BySurfaceArea.divide(simd, boxes, effort, halve);
                (count, [with(None); 2])
            }
        }
    }
}

/// Which boxes may be in a block.
#[derive(Clone, Copy)]
pub(super) struct Blocks<'a> {
    /// Ids from here on are spheres.
    first_sphere: u32,
    /// The corners of all triangles, if those of a block must fit an [`IndexedBlock`].
    shared: Option<&'a [[u32; 3]]>,
    /// The most boxes of a block.
    most: usize,
}

impl<'a> Blocks<'a> {
    /// Those of a scene's primitives.
    pub(super) fn of(scene: &'a Scene, layout: Layout) -> Self {
        let triangles = &scene.triangles().corners[..];
        Self {
            first_sphere: triangles.len() as u32,
            shared: (layout == Layout::Indexed).then_some(triangles),
            most: WIDTH,
        }
    }

    /// Each box is a block, one of spheres.
    pub(super) const SINGLE: Self = Self {
        first_sphere: 0,
        shared: None,
        most: 1,
    };
}

/// Builds over `boxes` and puts them into the order of the leaves.
pub(super) fn build<S: Simd>(
    simd: S,
    boxes: &mut [Box8],
    blocks: Blocks<'_>,
    quality: BuildQuality,
    steps: &Steps<'_>,
) -> Top {
    let job = Job {
        simd,
        blocks,
        effort: quality.effort(),
        subtree: subtree_size(boxes.len()),
        footprint: footprint(simd, boxes, blocks.most == 1),
        steps,
    };
    let levels = most_levels(boxes.len());
    if quality != BuildQuality::Ploc {
        return build_top(boxes, 0, job, BySurfaceArea, levels);
    }
    let tree = ploc::build(boxes);
    let ordered: Vec<Box8> = tree.boxes_in_order().map(|box_i| boxes[box_i]).collect();
    boxes.copy_from_slice(&ordered);
    drop(ordered);
    let as_in_tree = AsIn {
        tree: &tree,
        node_i: Some(0),
    };
    build_top(boxes, 0, job, as_in_tree, levels)
}

/// Blocks wider than this many bundles may be divided.
// Tuned: see docs/lab-notes.md#wide-blocks
const WIDE: f32 = 16.0;

/// The parameters of a tree.
#[derive(Clone, Copy)]
struct Job<'a, S> {
    simd: S,
    blocks: Blocks<'a>,
    effort: Effort,
    /// See [`subtree_size`].
    subtree: usize,
    /// Half of the area that a bundle of rays covers; see [`footprint`].
    footprint: f32,
    steps: &'a Steps<'a>,
}

impl<S: Simd> Job<'_, S> {
    /// How often bundles visit a box, in units of area.
    #[inline(always)]
    fn visits(&self, bounds: Box8) -> f32 {
        bounds.half_area(self.simd) + self.footprint
    }

    /// Whether triangles, at most eight, can be a block of their own.
    #[inline(always)]
    fn is_block(&self, boxes: &[Box8]) -> bool {
        match self.blocks.shared {
            Some(triangles) => IndexedBlock::fits(boxes.iter().map(|b| triangles[b.id().0 as usize])),
            None => true,
        }
    }

    /// Whether a set that fits a block may still be divided, because it is far wider than a bundle. (In a row along an axis
    /// bundles have no width.)
    #[inline(always)]
    fn pays_to_divide(&self, count: usize, bounds: Box8) -> bool {
        let is_wide = self.footprint > 0.0 && bounds.half_area(self.simd) > WIDE * self.footprint;
        self.effort.divides_blocks && count > 1 && is_wide
    }
}

/// `levels`: for how many more levels the divider decides; below, sets are halved.
fn build_top<D: Divider, S: Simd>(
    boxes: &mut [Box8],
    first: usize,
    job: Job<'_, S>,
    divider: D,
    levels: u32,
) -> Top {
    if boxes.len() <= job.subtree {
        return Top::Subtree(Subtree::new(boxes, first, job, divider, levels));
    }
    let (count, [left_divider, right_divider]) = divider.divide(job.simd, boxes, job.effort, levels == 0);
    job.steps.divided(boxes.len());
    let (left, right) = boxes.split_at_mut(count);
    let levels = levels.saturating_sub(1);
    let (left, right) = rayon::join(
        || build_top(left, first, job, left_divider, levels),
        || build_top(right, first + count, job, right_divider, levels),
    );
    let bounds = left.bounds().union(job.simd, right.bounds());
    let plan = Plan::inner(left.plan(), right.plan(), job.visits(bounds), true);
    Top::Inner(Box::new(TopInner {
        children: [left, right],
        bounds,
        plan,
    }))
}

#[inline(always)]
fn around_centers<S: Simd>(simd: S, boxes: &[Box8]) -> Box8 {
    let of_part = |boxes: &[Box8]| {
        simd.call(
            #[inline(always)]
            || Box8::around_centers(simd, boxes),
        )
    };
    if boxes.len() <= PARALLEL {
        return of_part(boxes);
    }
    boxes
        .par_chunks(PARALLEL / 2)
        .map(of_part)
        .reduce(|| Box8::EMPTY, |a, b| a.union(simd, b))
}

/// A node of a binary subtree; the left child follows it.
struct Node {
    plan: Plan,
    first: u32,
    count: u32,
    /// Index of the right child; 0 for a leaf.
    right: u32,
}

struct Builder<'a, S> {
    nodes: Vec<Node>,
    job: Job<'a, S>,
}

impl<S: Simd> Planned for Builder<'_, S> {
    type Node = usize;

    fn plan(&self, node_i: usize) -> &Plan {
        &self.nodes[node_i].plan
    }

    fn children(&self, node_i: usize) -> Option<[usize; 2]> {
        let right = self.nodes[node_i].right as usize;
        (right != 0).then_some([node_i + 1, right])
    }
}

impl<S: Simd> Builder<'_, S> {
    /// Appends the tree over `boxes` and returns the box around them.
    fn divide<D: Divider>(&mut self, boxes: &mut [Box8], first: usize, divider: D, levels: u32) -> Box8 {
        let simd = self.job.simd;
        simd.call(
            #[inline(always)]
            || self.divide_at(simd, boxes, first, divider, levels),
        )
    }

    #[inline(always)]
    fn divide_at<D: Divider>(
        &mut self,
        simd: S,
        boxes: &mut [Box8],
        first: usize,
        divider: D,
        levels: u32,
    ) -> Box8 {
        let node_i = self.nodes.len();
        self.nodes.push(Node {
            plan: Plan::default(),
            first: first as u32,
            count: boxes.len() as u32,
            right: 0,
        });
        let (mut first_part, mut may_be_block) = (None, true);
        if boxes.len() <= WIDTH {
            let spheres = boxes
                .iter()
                .filter(|b| b.id().0 >= self.job.blocks.first_sphere)
                .count();
            if spheres != 0 && spheres != boxes.len() {
                // A block is of one kind.
                boxes.sort_unstable_by_key(Box8::id);
                first_part = Some(boxes.len() - spheres);
            } else {
                let bounds = Box8::around(simd, boxes);
                may_be_block =
                    boxes.len() <= self.job.blocks.most && (spheres != 0 || self.job.is_block(boxes));
                if may_be_block && !self.job.pays_to_divide(boxes.len(), bounds) {
                    let visits = self.job.visits(bounds);
                    self.nodes[node_i].plan = Plan::block(boxes.len() - spheres, spheres, visits);
                    return bounds;
                }
            }
        }
        let (count, [left_divider, right_divider]) = match first_part {
            Some(count) => (count, [divider; 2]),
            None => divider.divide(simd, boxes, self.job.effort, levels == 0),
        };
        let (left, right) = boxes.split_at_mut(count);
        let levels = levels.saturating_sub(1);
        let left_bounds = self.divide(left, first, left_divider, levels);
        let right_i = self.nodes.len();
        let bounds = self
            .divide(right, first + count, right_divider, levels)
            .union(simd, left_bounds);
        let plan = Plan::inner(
            &self.nodes[node_i + 1].plan,
            &self.nodes[right_i].plan,
            self.job.visits(bounds),
            may_be_block,
        );
        let node = &mut self.nodes[node_i];
        (node.plan, node.right) = (plan, right_i as u32);
        bounds
    }
}

impl Subtree {
    fn new<D: Divider, S: Simd>(
        boxes: &mut [Box8],
        first: usize,
        job: Job<'_, S>,
        divider: D,
        levels: u32,
    ) -> Self {
        let mut builder = Builder {
            nodes: Vec::with_capacity(2 * boxes.len()),
            job,
        };
        let bounds = builder.divide(boxes, 0, divider, levels);
        let mut subtree = Self {
            first,
            bounds,
            plan: builder.nodes[0].plan.as_one_child(),
            counts: Counts::default(),
            slots: Vec::with_capacity(boxes.len() / 2),
        };
        subtree.write_node(&builder, 0, 1);
        job.steps.finished(boxes.len());
        subtree
    }

    fn write_node<S: Simd>(&mut self, builder: &Builder<'_, S>, node_i: usize, depth: usize) {
        let children = widen(builder, node_i);
        let counts = &mut self.counts;
        counts.nodes += 1;
        counts.depth = counts.depth.max(depth);
        counts.children[children.len() - 1] += 1;
        for (i, child_i) in children.iter().enumerate() {
            let node = &builder.nodes[child_i];
            let is_last = i + 1 == children.len();
            let mut block = 0;
            if node.plan.is_block {
                block = node.count as usize;
                counts.leaf_sizes[block - 1] += 1;
                if node.plan.has_triangles() {
                    counts.triangle_blocks += 1;
                } else {
                    counts.sphere_blocks += 1;
                }
            }
            self.slots.push(Slot::new(node.first as usize, block, is_last));
        }
        for child_i in children.iter() {
            if !builder.nodes[child_i].plan.is_block {
                self.write_node(builder, child_i, depth + 1);
            }
        }
    }
}
