//! The binary tree that both layouts are made from.

use crate::{
    geometry::padded,
    math::Aabb,
    ray::PrimitiveId,
    scene::{Primitive, Scene},
};
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

    pub(super) fn half_area(&self, node_i: usize) -> f32 {
        self.nodes[node_i].aabb().half_area()
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
    pub(super) fn parents_first(&self) -> Vec<u32> {
        let mut order = Vec::with_capacity(self.len());
        let mut stack = vec![0_u32];
        while let Some(node_i) = stack.pop() {
            order.push(node_i);
            if let BinaryTreeNode::Inner(children) = self.node(node_i as usize) {
                stack.extend(children.map(|c| c as u32));
            }
        }
        order
    }
}

fn primitive_bounds(scene: &Scene, id: PrimitiveId) -> ObvhsAabb {
    let bounds = padded(match scene.primitive(id) {
        Primitive::Triangle(i) => Aabb::around(scene.triangle(i)),
        Primitive::Sphere(i) => scene.sphere_bounds(i),
    });
    ObvhsAabb {
        min: Vec3A::from(bounds.lower),
        max: Vec3A::from(bounds.upper),
    }
}

/// PLOC and a little reinsertion: obvhs' "medium" preset with one primitive a leaf (our collapse makes the
/// leaves).
pub(super) fn build_binary(scene: &Scene) -> BinaryTree {
    let has_box = |id: &PrimitiveId| match scene.primitive(*id) {
        Primitive::Triangle(i) => scene.has_area(i),
        Primitive::Sphere(_) => true,
    };
    let ids = (0..scene.primitive_count() as u32)
        .into_par_iter()
        .map(PrimitiveId);
    let primitives: Vec<PrimitiveId> = if scene.degenerate_triangles() == 0 {
        ids.collect()
    } else {
        ids.filter(has_box).collect()
    };
    if primitives.is_empty() {
        return BinaryTree {
            nodes: Vec::new(),
            primitives,
        };
    }
    let boxes: Vec<ObvhsAabb> = primitives
        .par_iter()
        .map(|&id| primitive_bounds(scene, id))
        .collect();
    let mut bvh: Bvh2 = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    ReinsertionOptimizer::default().run(&mut bvh, 0.05, None);
    let primitives = bvh
        .primitive_indices
        .par_iter()
        .map(|&i| primitives[i as usize])
        .collect();
    BinaryTree {
        nodes: bvh.nodes,
        primitives,
    }
}
