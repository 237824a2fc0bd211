//! From the binary tree to wide nodes and leaf blocks.

use super::{
    Bvh, BvhStats, Child, Node8,
    source::{BinaryTree, BinaryTreeNode},
};
use crate::{
    geometry::{SphereBlock, TriangleBlock},
    ray::PrimitiveId,
    scene::{Primitive, Scene},
};
use std::sync::OnceLock;

/// The most children of a node, and primitives of a block.
const WIDTH: usize = 8;

/// Cost of a step from a binary node to its children, in units of a wide node's visit: a wide node replaces
/// about seven of them.
const STEP_COST: f32 = 0.22;
/// Cost of a visit to a block, and of each primitive in it.
const BLOCK_COST: f32 = 0.8;
const PRIMITIVE_COST: f32 = 0.05;

/// Which primitives are below a binary node.
#[derive(Clone, Copy, Default)]
struct Below {
    triangles: u8,
    spheres: u8,
    /// Whether the subtree becomes one block.
    is_block: bool,
    cost: f32,
}

impl Below {
    fn fits_block(self) -> bool {
        let (t, s) = (usize::from(self.triangles), usize::from(self.spheres));
        (t == 0 && s <= WIDTH) || (s == 0 && t <= WIDTH)
    }
}

/// Decides from the leaves up which subtrees become blocks, by the surface area heuristic.
fn decide(scene: &Scene, tree: &BinaryTree) -> Vec<Below> {
    let mut below = vec![Below::default(); tree.len()];
    for &node_i in tree.parents_first().iter().rev() {
        let node_i = node_i as usize;
        let area = tree.half_area(node_i);
        below[node_i] = match tree.node(node_i) {
            BinaryTreeNode::Leaf(id) => {
                let triangle = matches!(scene.primitive(id), Primitive::Triangle(_));
                Below {
                    triangles: u8::from(triangle),
                    spheres: u8::from(!triangle),
                    is_block: true,
                    cost: area * (BLOCK_COST + PRIMITIVE_COST),
                }
            }
            BinaryTreeNode::Inner([left, right]) => {
                let (l, r) = (below[left], below[right]);
                let mut node = Below {
                    triangles: l.triangles.saturating_add(r.triangles).min(WIDTH as u8 + 1),
                    spheres: l.spheres.saturating_add(r.spheres).min(WIDTH as u8 + 1),
                    is_block: false,
                    cost: area * STEP_COST + l.cost + r.cost,
                };
                if node.fits_block() {
                    let count = f32::from(node.triangles + node.spheres);
                    let block = area * (BLOCK_COST + PRIMITIVE_COST * count);
                    node.is_block = block <= node.cost;
                    node.cost = node.cost.min(block);
                }
                node
            }
        };
    }
    below
}

struct Collapse<'a> {
    scene: &'a Scene,
    tree: &'a BinaryTree,
    below: &'a [Below],
    nodes: Vec<Node8>,
    triangle_blocks: Vec<TriangleBlock>,
    sphere_blocks: Vec<SphereBlock>,
    leaf_sizes: [usize; WIDTH],
    child_counts: [usize; WIDTH],
}

/// The wide hierarchy of a binary one.
pub(super) fn collapse(scene: &Scene, tree: &BinaryTree) -> Bvh {
    let below = if tree.is_empty() {
        Vec::new()
    } else {
        decide(scene, tree)
    };
    let mut collapse = Collapse {
        scene,
        tree,
        below: &below,
        nodes: vec![Node8::new(&[])],
        triangle_blocks: Vec::new(),
        sphere_blocks: Vec::new(),
        leaf_sizes: [0; WIDTH],
        child_counts: [0; WIDTH],
    };
    let mut depth = 1;
    // Wide node, the binary node that it stands for, its depth.
    let mut todo = if tree.is_empty() {
        vec![]
    } else {
        vec![(0_usize, 0_usize, 1_usize)]
    };
    while let Some((wide_i, binary_i, level)) = todo.pop() {
        depth = depth.max(level);
        let mut children = Vec::with_capacity(WIDTH);
        for child_i in collapse.widen(binary_i) {
            let child = if below[child_i].is_block {
                collapse.block(child_i)
            } else {
                collapse.nodes.push(Node8::new(&[]));
                todo.push((collapse.nodes.len() - 1, child_i, level + 1));
                Child::inner(collapse.nodes.len() - 1)
            };
            children.push((child, tree.bounds(child_i)));
        }
        collapse.child_counts[children.len() - 1] += 1;
        collapse.nodes[wide_i] = Node8::new(&children);
    }
    let Collapse {
        nodes,
        triangle_blocks,
        sphere_blocks,
        leaf_sizes,
        child_counts,
        ..
    } = collapse;
    let stats = BvhStats {
        nodes: nodes.len(),
        triangle_blocks: triangle_blocks.len(),
        sphere_blocks: sphere_blocks.len(),
        depth,
        leaf_sizes,
        child_counts,
        ..BvhStats::default()
    };
    Bvh {
        nodes,
        triangle_blocks,
        sphere_blocks,
        root: Child::inner(0),
        stats,
        binary: OnceLock::new(),
    }
}

impl Collapse<'_> {
    /// The up to eight binary nodes that become the children of the node for `binary_i`: the largest by
    /// area is opened until there are eight or only blocks are left (Wald, Benthin and Boulos 2008).
    fn widen(&self, binary_i: usize) -> Vec<usize> {
        let mut open = vec![binary_i];
        while open.len() < WIDTH {
            let largest = (0..open.len())
                .filter(|&slot| !self.below[open[slot]].is_block)
                .max_by(|&a, &b| {
                    self.tree
                        .half_area(open[a])
                        .total_cmp(&self.tree.half_area(open[b]))
                });
            let Some(slot) = largest else { break };
            if let BinaryTreeNode::Inner([left, right]) = self.tree.node(open[slot]) {
                open[slot] = left;
                open.insert(slot + 1, right);
            }
        }
        open
    }

    fn block(&mut self, binary_i: usize) -> Child {
        let mut ids: Vec<PrimitiveId> = Vec::with_capacity(WIDTH);
        let mut stack = vec![binary_i];
        while let Some(node_i) = stack.pop() {
            match self.tree.node(node_i) {
                BinaryTreeNode::Leaf(id) => ids.push(id),
                BinaryTreeNode::Inner([left, right]) => stack.extend([right, left]),
            }
        }
        self.leaf_sizes[ids.len() - 1] += 1;
        if self.below[binary_i].triangles > 0 {
            let triangles: Vec<_> = ids
                .iter()
                .map(|&id| (id, self.scene.triangle(id.0 as usize)))
                .collect();
            self.triangle_blocks.push(TriangleBlock::new(&triangles));
            Child::triangles(self.triangle_blocks.len() - 1, ids.len())
        } else {
            let spheres: Vec<_> = ids.iter().map(|&id| self.sphere(id)).collect();
            self.sphere_blocks.push(SphereBlock::new(&spheres));
            Child::spheres(self.sphere_blocks.len() - 1, ids.len())
        }
    }

    fn sphere(&self, id: PrimitiveId) -> (PrimitiveId, glam::Vec3, f32) {
        let i = id.0 as usize - self.scene.triangles().v0.len();
        (id, self.scene.spheres().center(i), self.scene.spheres().radius[i])
    }
}
