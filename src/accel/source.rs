//! The binary tree of the scalar baseline.

use super::boxes::boxes_of;
use crate::{math::Aabb, ray::PrimitiveId, scene::Scene};
use glam::Vec3A;
use obvhs::{
    aabb::Aabb as ObvhsAabb,
    bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};
use rayon::prelude::*;

/// A binary tree with one primitive a leaf. Root is node 0; an empty scene has no nodes.
pub(super) struct BinaryTree {
    nodes: Vec<Bvh2Node>,
    primitives: Vec<PrimitiveId>,
    /// Node indices, parents before children.
    parents_first: Vec<u32>,
}

/// A node of [`BinaryTree`].
pub(super) enum BinaryTreeNode {
    /// Indices of both children.
    Inner([usize; 2]),
    /// One primitive.
    Leaf(PrimitiveId),
}

impl BinaryTree {
    pub(super) fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    pub(super) fn len(&self) -> usize {
        self.nodes.len()
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
            BinaryTreeNode::Leaf(self.primitives[first])
        } else {
            BinaryTreeNode::Inner([first, first + 1])
        }
    }

    /// Node indices, parents before children.
    pub(super) fn parents_first(&self) -> &[u32] {
        &self.parents_first
    }

    fn sort_parents_first(&mut self) {
        let mut order = Vec::with_capacity(self.len());
        let mut stack = vec![0_u32];
        while let Some(node_i) = stack.pop() {
            order.push(node_i);
            if let BinaryTreeNode::Inner(children) = self.node(node_i as usize) {
                stack.extend(children.map(|c| c as u32));
            }
        }
        self.parents_first = order;
    }
}

/// Reinsertion looks for a better place for a subtree wherever that may be; where all boxes overlap, that is
/// everywhere, and takes quadratic time (100,000 equal boxes: 3.5 s). No tree is good there anyway.
const MAX_OVERLAP: f32 = 256.0;

/// In how many of the boxes a random line through all of them is at once: the sum of their areas as a share of
/// the area of the box around them.
fn overlap(boxes: &[ObvhsAabb]) -> f32 {
    let sum_and_union = |(sum, all): (f32, ObvhsAabb), b: &ObvhsAabb| (sum + b.half_area(), all.union(b));
    let (sum, all) = boxes
        .par_chunks(1 << 14)
        .map(|chunk| chunk.iter().fold((0.0, ObvhsAabb::empty()), sum_and_union))
        .reduce(|| (0.0, ObvhsAabb::empty()), |a, b| (a.0 + b.0, a.1.union(&b.1)));
    sum / all.half_area()
}

/// By how much boxes are roughened, as a share of their diagonals.
const ROUGHNESS: f32 = 1.0 / 4096.0;
/// The same where boxes overlap so much that many are inside others.
const ROUGHNESS_OF_CROWDS: f32 = 1.0 / 16.0;

/// The box with each side moved out by up to `roughness` times its diagonal, as the id says. PLOC merges what
/// is mutually nearest; where distances are equal, as in a row of equal boxes or for boxes inside one another,
/// hardly any two are, and it takes quadratic time (10,000 spheres in a row: 3 s).
fn roughened(bounds: &ObvhsAabb, id: PrimitiveId, roughness: f32) -> ObvhsAabb {
    // Knuth's multiplicative hash, stretched to four bits a side.
    let mut bits = u64::from(id.0).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
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

/// PLOC and a little reinsertion: obvhs' "medium" preset with one primitive a leaf
/// ([`BinaryBvh`](super::BinaryBvh) makes the leaves).
pub(super) fn build_binary(scene: &Scene) -> BinaryTree {
    let (primitives, mut boxes): (Vec<PrimitiveId>, Vec<ObvhsAabb>) = boxes_of(scene)
        .into_par_iter()
        .map(|b| {
            let Aabb { lower, upper } = b.bounds();
            let bounds = ObvhsAabb {
                min: lower.into(),
                max: upper.into(),
            };
            (b.id(), bounds)
        })
        .unzip();
    if primitives.is_empty() {
        return BinaryTree {
            nodes: Vec::new(),
            primitives,
            parents_first: Vec::new(),
        };
    }
    let crowded = overlap(&boxes) > MAX_OVERLAP;
    let roughness = if crowded { ROUGHNESS_OF_CROWDS } else { ROUGHNESS };
    boxes
        .par_iter_mut()
        .zip(&primitives)
        .for_each(|(b, &id)| *b = roughened(b, id, roughness));
    let mut bvh: Bvh2 = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    if !crowded {
        ReinsertionOptimizer::default().run(&mut bvh, 0.05, None);
    }
    let primitives = bvh
        .primitive_indices
        .par_iter()
        .map(|&i| primitives[i as usize])
        .collect();
    let mut tree = BinaryTree {
        nodes: bvh.nodes,
        primitives,
        parents_first: Vec::new(),
    };
    tree.sort_parents_first();
    tree
}
