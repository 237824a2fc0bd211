//! Binary trees by obvhs: PLOC (Meister and Bittner 2018) and a little reinsertion (*Parallel Reinsertion for
//! Bounding Volume Hierarchy Optimization*, Meister and Bittner 2018).
//!
//! Differs: boxes are jittered, and nothing is reinserted where all overlap, so that rows of equal boxes and clusters of
//! overlapping ones do not take quadratic time. (Far from the origin jitter is lost to rounding, and a row of equal boxes
//! still does.)

use super::boxes::Box8;
use crate::math::Aabb;
use glam::Vec3A;
use obvhs::{
    aabb::Aabb as ObvhsAabb,
    bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};
use rayon::prelude::*;

/// A binary tree with one box per leaf. The root is node 0; a tree over nothing has no nodes.
pub(super) struct BinaryTree {
    nodes: Vec<Bvh2Node>,
    /// The box of each leaf.
    leaves: Vec<u32>,
    /// Node indices, parents before children, left children's nodes before right ones'.
    parents_first: Vec<u32>,
    /// Leaves below each node.
    sizes: Vec<u32>,
}

/// A node of [`BinaryTree`].
pub(super) enum BinaryTreeNode {
    /// Indices of both children.
    Inner([usize; 2]),
    /// Index of one box.
    Leaf(usize),
}

impl BinaryTree {
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    pub(super) fn bounds(&self, node_i: usize) -> Aabb {
        let b = self.nodes[node_i].aabb();
        Aabb {
            lower: b.min.into(),
            upper: b.max.into(),
        }
    }

    pub(super) fn node(&self, node_i: usize) -> BinaryTreeNode {
        let node = &self.nodes[node_i];
        let first = node.first_index as usize;
        if node.is_leaf() {
            BinaryTreeNode::Leaf(self.leaves[first] as usize)
        } else {
            BinaryTreeNode::Inner([first, first + 1])
        }
    }

    /// How many leaves are below a node; 1 for a leaf.
    pub(super) fn size(&self, node_i: usize) -> u32 {
        self.sizes[node_i]
    }

    /// The boxes of all leaves, from left to right, by index.
    pub(super) fn boxes_in_order(&self) -> impl Iterator<Item = usize> {
        self.parents_first
            .iter()
            .filter_map(|&node_i| match self.node(node_i as usize) {
                BinaryTreeNode::Leaf(box_i) => Some(box_i),
                BinaryTreeNode::Inner(_) => None,
            })
    }

    fn sort_parents_first(&mut self) {
        let mut order = Vec::with_capacity(self.nodes.len());
        let mut stack = vec![0_u32];
        while let Some(node_i) = stack.pop() {
            order.push(node_i);
            if let BinaryTreeNode::Inner([left, right]) = self.node(node_i as usize) {
                stack.extend([right as u32, left as u32]);
            }
        }
        self.parents_first = order;
    }

    fn count_leaves(&mut self) {
        let mut sizes = vec![1_u32; self.nodes.len()];
        for &node_i in self.parents_first.iter().rev() {
            if let BinaryTreeNode::Inner([left, right]) = self.node(node_i as usize) {
                sizes[node_i as usize] = sizes[left] + sizes[right];
            }
        }
        self.sizes = sizes;
    }
}

/// Above this overlap nothing is reinserted: the search would take quadratic time, and no tree is good there.
// Measured: docs/lab-notes.md#ploc-roughness
const MAX_OVERLAP: f32 = 256.0;

/// The mean number of boxes that a random line through the box around all of them meets: the sum of their areas over the
/// area of that box.
fn overlap(boxes: &[ObvhsAabb]) -> f32 {
    let sum_and_union = |(sum, all): (f32, ObvhsAabb), b: &ObvhsAabb| (sum + b.half_area(), all.union(b));
    // Summed part by part, in one order for any number of threads.
    let parts: Vec<(f32, ObvhsAabb)> = boxes
        .par_chunks(1 << 14)
        .map(|chunk| chunk.iter().fold((0.0, ObvhsAabb::empty()), sum_and_union))
        .collect();
    let both = |a: (f32, ObvhsAabb), b: (f32, ObvhsAabb)| (a.0 + b.0, a.1.union(&b.1));
    let (sum, all) = parts.into_iter().fold((0.0, ObvhsAabb::empty()), both);
    sum / all.half_area()
}

/// How far the sides of boxes are jittered, as a fraction of their diagonals.
const ROUGHNESS: f32 = 1.0 / 4096.0;
/// The same for boxes that overlap so much that many are inside others.
const ROUGHNESS_OF_OVERLAPS: f32 = 1.0 / 16.0;

/// Moves each side of a box out by up to `roughness` times its diagonal, by the id. PLOC merges mutually nearest
/// boxes; with equal distances hardly any two are, and it takes quadratic time.
fn roughened(bounds: &ObvhsAabb, id: u32, roughness: f32) -> ObvhsAabb {
    // Knuth's multiplicative hash, stretched to four bits per side.
    let mut bits = u64::from(id).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
    let step = bounds.diagonal().length() * roughness / 15.0;
    let mut side = || {
        let steps = (bits & 15) as f32;
        bits >>= 4;
        steps * step
    };
    let mut corner = || Vec3A::new(side(), side(), side());
    ObvhsAabb {
        min: bounds.min - corner(),
        max: bounds.max + corner(),
    }
}

/// A tree over `boxes`: obvhs' "medium" preset with one box per leaf.
pub(super) fn build(boxes: &[Box8]) -> BinaryTree {
    let mut tree = BinaryTree {
        nodes: Vec::new(),
        leaves: Vec::new(),
        parents_first: Vec::new(),
        sizes: Vec::new(),
    };
    if boxes.is_empty() {
        return tree;
    }
    let ids: Vec<u32> = boxes.par_iter().map(|b| b.id().0).collect();
    let mut boxes: Vec<ObvhsAabb> = boxes
        .par_iter()
        .map(|b| {
            let Aabb { lower, upper } = b.bounds();
            ObvhsAabb {
                min: lower.into(),
                max: upper.into(),
            }
        })
        .collect();
    let overlaps = overlap(&boxes) > MAX_OVERLAP;
    let roughness = if overlaps {
        ROUGHNESS_OF_OVERLAPS
    } else {
        ROUGHNESS
    };
    boxes
        .par_iter_mut()
        .zip(&ids)
        .for_each(|(b, &id)| *b = roughened(b, id, roughness));
    let mut bvh: Bvh2 = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    if !overlaps {
        ReinsertionOptimizer::default().run(&mut bvh, 0.05, None);
    }
    (tree.nodes, tree.leaves) = (bvh.nodes, bvh.primitive_indices);
    tree.sort_parents_first();
    tree.count_leaves();
    tree
}
