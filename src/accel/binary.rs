//! The binary hierarchy of the scalar baseline: 32 bytes a node, siblings side by side (a layout common since Wald
//! and Bikker).

use super::{
    boxes::{Box8, boxes_of},
    ploc::{self, BinaryTree, BinaryTreeNode},
};
use crate::{
    math::Aabb,
    ray::PrimitiveId,
    scene::{Scene, Shape},
};
use glam::Vec3;

/// The most primitives of a leaf.
const LEAF_SIZE: u32 = 4;

/// A node: its own box, and either the first of two adjacent children or a range of primitives.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct BinaryNode {
    /// Lower corner of the box.
    pub lower: Vec3,
    /// Index of the first child, or of the first primitive.
    pub first: u32,
    /// Upper corner of the box.
    pub upper: Vec3,
    /// Primitives of a leaf; 0 for an inner node.
    pub count: u32,
}

impl BinaryNode {
    /// Returns the node's box.
    #[inline(always)]
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        Aabb {
            lower: self.lower,
            upper: self.upper,
        }
    }
}

/// A binary bounding volume hierarchy over one scene.
#[derive(Clone, Debug)]
pub struct BinaryBvh {
    /// Nodes; the root is node 0. Empty for a scene of nothing.
    pub nodes: Vec<BinaryNode>,
    /// Primitives in the order of the leaves.
    pub primitives: Vec<PrimitiveId>,
    /// Their shapes, so that a leaf reads contiguous memory.
    pub shapes: Vec<Shape>,
}

impl BinaryBvh {
    /// Builds the hierarchy over the scene's spheres and its triangles with an area.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        let (boxes, _) = boxes_of(scene);
        let tree = ploc::build(&boxes);
        let mut bvh = Self {
            nodes: Vec::new(),
            primitives: Vec::new(),
            shapes: Vec::new(),
        };
        if tree.is_empty() {
            return bvh;
        }
        bvh.nodes.push(box_only(tree.bounds(0)));
        let mut todo = vec![(0_usize, 0_usize)];
        while let Some((own_i, tree_i)) = todo.pop() {
            match tree.node(tree_i) {
                BinaryTreeNode::Inner(children) if tree.size(tree_i) > LEAF_SIZE => {
                    let first = bvh.nodes.len();
                    bvh.nodes.extend(children.map(|c| box_only(tree.bounds(c))));
                    bvh.nodes[own_i].first = first as u32;
                    todo.extend([(first + 1, children[1]), (first, children[0])]);
                }
                _ => {
                    bvh.nodes[own_i].first = bvh.primitives.len() as u32;
                    bvh.nodes[own_i].count = tree.size(tree_i);
                    bvh.push_primitives(&boxes, &tree, tree_i);
                }
            }
        }
        bvh.shapes = bvh.primitives.iter().map(|&id| scene.shape(id)).collect();
        bvh
    }

    fn push_primitives(&mut self, boxes: &[Box8], tree: &BinaryTree, tree_i: usize) {
        let mut stack = vec![tree_i];
        while let Some(node_i) = stack.pop() {
            match tree.node(node_i) {
                BinaryTreeNode::Leaf(box_i) => self.primitives.push(boxes[box_i].id()),
                BinaryTreeNode::Inner([left, right]) => stack.extend([right, left]),
            }
        }
    }
}

fn box_only(bounds: Aabb) -> BinaryNode {
    BinaryNode {
        lower: bounds.lower,
        first: 0,
        upper: bounds.upper,
        count: 0,
    }
}
