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

/// Cost of a visit to an inner node, to a block, and of each primitive in a block.
const NODE_COST: f32 = 1.0;
const BLOCK_COST: f32 = 0.8;
const PRIMITIVE_COST: f32 = 0.05;

/// The best that a subtree of the binary tree can become, by the surface area heuristic.
#[derive(Clone, Copy, Default)]
struct Plan {
    /// Cost as one to seven children of a wide node: `cost[i - 1]` with at most i of them.
    cost: [f32; WIDTH - 1],
    /// Primitives below, up to one more than fit a block.
    triangles: u8,
    spheres: u8,
    /// Whether the subtree, as one child, is a block.
    is_block: bool,
}

impl Plan {
    fn fits_block(&self) -> bool {
        let (t, s) = (usize::from(self.triangles), usize::from(self.spheres));
        (t == 0 && s <= WIDTH) || (s == 0 && t <= WIDTH)
    }

    fn block_cost(&self, area: f32) -> f32 {
        area * (BLOCK_COST + PRIMITIVE_COST * f32::from(self.triangles + self.spheres))
    }

    fn leaf(is_triangle: bool, area: f32) -> Self {
        let (triangles, spheres) = if is_triangle { (1, 0) } else { (0, 1) };
        let mut plan = Self {
            cost: [0.0; WIDTH - 1],
            triangles,
            spheres,
            is_block: true,
        };
        plan.cost = [plan.block_cost(area); WIDTH - 1];
        plan
    }

    fn inner(left: &Self, right: &Self, area: f32) -> Self {
        let most = WIDTH as u8 + 1;
        let mut plan = Self {
            cost: [0.0; WIDTH - 1],
            triangles: left.triangles.saturating_add(right.triangles).min(most),
            spheres: left.spheres.saturating_add(right.spheres).min(most),
            is_block: false,
        };
        plan.cost[0] = area * NODE_COST + best_split(left, right, WIDTH).1;
        if plan.fits_block() {
            let block = plan.block_cost(area);
            plan.is_block = block <= plan.cost[0];
            plan.cost[0] = plan.cost[0].min(block);
        }
        for i in 2..WIDTH {
            plan.cost[i - 1] = plan.cost[i - 2].min(best_split(left, right, i).1);
        }
        plan
    }
}

/// How to share `children` slots out between two subtrees: the left one's share, and the cost.
fn best_split(left: &Plan, right: &Plan, children: usize) -> (usize, f32) {
    let cost = |share: usize| left.cost[share - 1] + right.cost[children - share - 1];
    (1..children)
        .map(|share| (share, cost(share)))
        .fold(
            (1, f32::INFINITY),
            |best, split| {
                if split.1 < best.1 { split } else { best }
            },
        )
}

/// Plans from the leaves up: the optimal collapse of Ylitie, Karras and Laine, *Efficient Incoherent Ray Traversal
/// on GPUs Through Compressed Wide BVHs*, 2017, with blocks of one kind of primitive.
///
/// Tried: opening the largest child until there are eight (Wald, Benthin and Boulos 2008), with blocks decided
/// beforehand. A third of the nodes had two children.
fn plan(scene: &Scene, tree: &BinaryTree) -> Vec<Plan> {
    let mut plans = vec![Plan::default(); tree.len()];
    for &node_i in tree.parents_first().iter().rev() {
        let node_i = node_i as usize;
        let area = tree.half_area(node_i);
        plans[node_i] = match tree.node(node_i) {
            BinaryTreeNode::Leaf(id) => {
                Plan::leaf(matches!(scene.primitive(id), Primitive::Triangle(_)), area)
            }
            BinaryTreeNode::Inner([left, right]) => Plan::inner(&plans[left], &plans[right], area),
        };
    }
    plans
}

struct Collapse<'a> {
    scene: &'a Scene,
    tree: &'a BinaryTree,
    plans: &'a [Plan],
    nodes: Vec<Node8>,
    triangle_blocks: Vec<TriangleBlock>,
    sphere_blocks: Vec<SphereBlock>,
    leaf_sizes: [usize; WIDTH],
    child_counts: [usize; WIDTH],
}

/// The wide hierarchy of a binary one.
pub(super) fn collapse(scene: &Scene, tree: &BinaryTree) -> Bvh {
    let plans = if tree.is_empty() {
        Vec::new()
    } else {
        plan(scene, tree)
    };
    let mut collapse = Collapse {
        scene,
        tree,
        plans: &plans,
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
            let child = if plans[child_i].is_block {
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
    /// The up to eight binary nodes that become the children of the node for `binary_i`, as planned.
    fn widen(&self, binary_i: usize) -> Vec<usize> {
        let mut children = Vec::with_capacity(WIDTH);
        let mut todo = vec![(binary_i, WIDTH)];
        while let Some((node_i, mut slots)) = todo.pop() {
            let plan = &self.plans[node_i];
            let opened = node_i == binary_i && !plan.is_block;
            // Fewer slots where more do not pay.
            while !opened && slots > 1 && (slots == WIDTH || plan.cost[slots - 1] == plan.cost[slots - 2]) {
                slots -= 1;
            }
            match self.tree.node(node_i) {
                BinaryTreeNode::Inner([left, right]) if slots > 1 => {
                    let share = best_split(&self.plans[left], &self.plans[right], slots).0;
                    todo.extend([(right, slots - share), (left, share)]);
                }
                _ => children.push(node_i),
            }
        }
        children
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
        if self.plans[binary_i].triangles > 0 {
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
