//! The binary BVH of the scalar baseline: 32 bytes per node, siblings adjacent (a layout common since Wald and Bikker).

use super::{
    boxes::{Box8, boxes_of},
    instances::instance_boxes,
    ploc::{self, BinaryTree, BinaryTreeNode},
};
use crate::{
    math::Aabb,
    ray::{InstanceId, PrimitiveId},
    scene::{Instance, PrototypeId, Scene, Shape},
};
use glam::Vec3;

/// The most primitives of a leaf: primitives tested against nodes visited.
// Tuned: see docs/lab-notes.md#varied-constants
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
    /// Nodes; the root is node 0. Empty for an empty scene.
    pub nodes: Vec<BinaryNode>,
    /// Primitives in the order of the leaves.
    pub primitives: Vec<PrimitiveId>,
    /// Their shapes, so that a leaf reads contiguous memory.
    pub shapes: Vec<Shape>,
    /// Over the instances of the scene, if it has any.
    pub instances: Option<Box<BinaryInstances>>,
}

/// A hierarchy over instances, and those of the prototypes.
#[derive(Clone, Debug)]
pub struct BinaryInstances {
    /// Nodes, whose leaves are ranges of `instances`.
    pub nodes: Vec<BinaryNode>,
    /// Instances in the order of the leaves.
    pub instances: Vec<(InstanceId, Instance)>,
    /// Their boxes, not padded.
    pub boxes: Vec<Aabb>,
    /// By [`PrototypeId`].
    pub prototypes: Vec<BinaryBvh>,
}

impl BinaryBvh {
    /// Builds the hierarchy over the scene's spheres and its triangles with an area.
    #[must_use]
    pub fn build(scene: &Scene) -> Self {
        let instances = (!scene.instances().is_empty()).then(|| {
            let prototypes = (0..scene.prototypes().len() as u32).map(PrototypeId);
            let prototypes = prototypes.map(|id| Self::of_part(scene, Some(id))).collect();
            Box::new(BinaryInstances::over(scene, prototypes))
        });
        Self {
            instances,
            ..Self::of_part(scene, None)
        }
    }

    /// Rebuilds the level over the instances after they moved.
    pub(super) fn follow(&mut self, scene: &Scene) {
        if let Some(instances) = &mut self.instances {
            let prototypes = std::mem::take(&mut instances.prototypes);
            **instances = BinaryInstances::over(scene, prototypes);
        }
    }

    /// Builds over a prototype, or over what is outside of all.
    fn of_part(scene: &Scene, prototype: Option<PrototypeId>) -> Self {
        let (boxes, _) = boxes_of(scene, &scene.ids_of(prototype));
        let (nodes, primitives) = nodes_over(&boxes, LEAF_SIZE);
        Self {
            nodes,
            shapes: primitives.iter().map(|&id| scene.shape(id)).collect(),
            primitives,
            instances: None,
        }
    }
}

impl BinaryInstances {
    fn over(scene: &Scene, prototypes: Vec<BinaryBvh>) -> Self {
        let (nodes, ids) = nodes_over(&instance_boxes(scene), 1);
        let ids = ids.into_iter().map(|id| InstanceId(id.0));
        let instances: Vec<_> = ids.map(|id| (id, scene.instances()[id.0 as usize])).collect();
        let boxes = instances.iter().map(|&(id, _)| scene.instance_bounds(id));
        Self {
            nodes,
            boxes: boxes.collect(),
            instances,
            prototypes,
        }
    }
}

/// The nodes over boxes, at most `leaf_size` in a leaf, and the ids in the order of the leaves.
fn nodes_over(boxes: &[Box8], leaf_size: u32) -> (Vec<BinaryNode>, Vec<PrimitiveId>) {
    let tree = ploc::build(boxes);
    let (mut nodes, mut ids) = (Vec::new(), Vec::new());
    if tree.is_empty() {
        return (nodes, ids);
    }
    nodes.push(box_only(tree.bounds(0)));
    let mut todo = vec![(0_usize, 0_usize)];
    while let Some((own_i, tree_i)) = todo.pop() {
        match tree.node(tree_i) {
            BinaryTreeNode::Inner(children) if tree.size(tree_i) > leaf_size => {
                let first = nodes.len();
                nodes.extend(children.map(|c| box_only(tree.bounds(c))));
                nodes[own_i].first = first as u32;
                todo.extend([(first + 1, children[1]), (first, children[0])]);
            }
            _ => {
                nodes[own_i].first = ids.len() as u32;
                nodes[own_i].count = tree.size(tree_i);
                push_ids(&mut ids, boxes, &tree, tree_i);
            }
        }
    }
    (nodes, ids)
}

fn push_ids(ids: &mut Vec<PrimitiveId>, boxes: &[Box8], tree: &BinaryTree, tree_i: usize) {
    let mut stack = vec![tree_i];
    while let Some(node_i) = stack.pop() {
        match tree.node(node_i) {
            BinaryTreeNode::Leaf(box_i) => ids.push(boxes[box_i].id()),
            BinaryTreeNode::Inner([left, right]) => stack.extend([right, left]),
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
