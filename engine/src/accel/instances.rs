//! The BVH over instances, above those of their prototypes (two levels, as in Wald, Benthin and Slusallek, *Distributed
//! Interactive Ray Tracing of Dynamic Scenes*, 2003).

use super::{
    BuildQuality, Bvh, BvhStats, Child, Layout, Node8,
    boxes::Box8,
    plan::{WIDTH, widen},
    progress::Steps,
    tree::{self, Blocks, Slot, Top},
};
use crate::{
    geometry::padded,
    math::Aabb,
    ray::{InstanceId, PrimitiveId},
    scene::{PrototypeId, Scene},
    simd::Simd,
};
use rayon::prelude::*;
use std::sync::Arc;

/// The hierarchies of a scene with instances.
#[derive(Clone, Debug)]
pub(crate) struct Instanced {
    nodes: Vec<Node8>,
    /// By [`PrototypeId`]; clones share them.
    prototypes: Arc<[Bvh]>,
}

impl Instanced {
    /// Builds them at a level.
    pub(super) fn build<S: Simd>(simd: S, scene: &Scene, quality: BuildQuality, steps: &Steps<'_>) -> Self {
        let ids = (0..scene.prototypes().len() as u32).map(PrototypeId);
        let of_one = |id: PrototypeId| {
            let prototype = &scene.prototypes()[id.0 as usize];
            let layout = Layout::suiting(prototype.triangles.len(), prototype.vertices.len());
            Bvh::of_part(simd, (scene, Some(id)), quality, layout, steps)
        };
        let prototypes = ids.map(of_one).collect();
        Self {
            nodes: nodes_over(simd, scene, quality, steps),
            prototypes,
        }
    }

    /// Rebuilds the upper BVH at an instruction set level.
    pub(super) fn follow<S: Simd>(&mut self, simd: S, scene: &Scene, quality: BuildQuality) {
        let steps = Steps::of(scene, &|_| ());
        self.nodes = nodes_over(simd, scene, quality, &steps);
    }

    /// The nodes, the root first. A leaf is a block of one sphere, whose index is that of an instance; the child's box is the
    /// instance's padded box.
    #[inline(always)]
    pub fn nodes(&self) -> &[Node8] {
        &self.nodes
    }

    /// The hierarchy of a prototype.
    #[inline(always)]
    pub fn prototype(&self, id: PrototypeId) -> &Bvh {
        &self.prototypes[id.0 as usize]
    }

    /// The deepest hierarchy of a prototype.
    pub fn deepest(&self) -> Option<&Bvh> {
        self.prototypes.iter().max_by_key(|bvh| bvh.stats().depth)
    }

    /// Statistics of the upper hierarchy, and the sums of those of all prototypes with the largest depth.
    pub fn stats(&self) -> (BvhStats, BvhStats) {
        let mut upper = BvhStats {
            nodes: self.nodes.len(),
            memory_bytes: size_of_val(&self.nodes[..]),
            ..BvhStats::default()
        };
        // Parents are first.
        let mut depths = vec![1; self.nodes.len()];
        for (i, node) in self.nodes.iter().enumerate() {
            upper.depth = upper.depth.max(depths[i]);
            upper.child_counts[node.count.max(1) as usize - 1] += 1;
            for child in &node.child[..node.count as usize] {
                if child.is_inner() {
                    depths[child.index()] = depths[i] + 1;
                }
            }
        }
        let mut below = BvhStats::default();
        for stats in self.prototypes.iter().map(Bvh::stats) {
            below.nodes += stats.nodes;
            below.triangle_blocks += stats.triangle_blocks;
            below.sphere_blocks += stats.sphere_blocks;
            below.depth = below.depth.max(stats.depth);
            below.memory_bytes += stats.memory_bytes;
            for i in 0..WIDTH {
                below.leaf_sizes[i] += stats.leaf_sizes[i];
                below.child_counts[i] += stats.child_counts[i];
            }
        }
        (upper, below)
    }

    /// Bytes of all nodes and blocks.
    pub fn bytes(&self) -> usize {
        let of_prototypes = self.prototypes.iter().map(|bvh| bvh.stats().memory_bytes);
        size_of_val(&self.nodes[..]) + of_prototypes.sum::<usize>()
    }
}

/// The nodes over all instances.
fn nodes_over<S: Simd>(simd: S, scene: &Scene, quality: BuildQuality, steps: &Steps<'_>) -> Vec<Node8> {
    let mut boxes = instance_boxes(scene);
    let mut nodes = Nodes(Vec::new());
    let top = tree::build(simd, &mut boxes, Blocks::SINGLE, quality, steps);
    nodes.write(&top, &boxes);
    nodes.0.shrink_to_fit();
    nodes.0
}

/// The boxes of all instances.
pub(super) fn instance_boxes(scene: &Scene) -> Vec<Box8> {
    let ids = (0..scene.instances().len() as u32)
        .into_par_iter()
        .with_min_len(1 << 10);
    ids.map(|i| Box8::new(padded(scene.instance_bounds(InstanceId(i))), PrimitiveId(i)))
        .collect()
}

/// Nodes being written, parents first.
struct Nodes(Vec<Node8>);

impl Nodes {
    /// Writes a tree whose leaves' order is that of `boxes`.
    fn write(&mut self, top: &Top, boxes: &[Box8]) {
        match top {
            Top::Subtree(subtree) => {
                let mut slots = &subtree.slots[..];
                self.write_node(&mut slots, &boxes[subtree.first..]);
            }
            Top::Inner(_) => {
                let node_i = self.0.len();
                self.0.push(Node8::new(&[]));
                let mut children = Vec::with_capacity(WIDTH);
                for child in widen(&tree::TopTree::default(), top).iter() {
                    children.push((Child::inner(self.0.len()), child.bounds().bounds()));
                    self.write(child, boxes);
                }
                self.0[node_i] = Node8::new(&children);
            }
        }
    }

    /// Writes the next node and all below it; returns the box around it.
    fn write_node(&mut self, slots: &mut &[Slot], boxes: &[Box8]) -> Aabb {
        let node_i = self.0.len();
        self.0.push(Node8::new(&[]));
        let count = slots.iter().take_while(|slot| !slot.is_last()).count() + 1;
        let (own, rest) = slots.split_at(count);
        *slots = rest;
        let mut children = [(Child::NONE, Aabb::EMPTY); WIDTH];
        for (child, slot) in children.iter_mut().zip(own) {
            *child = if let Some(range) = slot.block() {
                let leaf = &boxes[range.start];
                (Child::spheres(leaf.id().0 as usize, 1), leaf.bounds())
            } else {
                let below = Child::inner(self.0.len());
                (below, self.write_node(slots, boxes))
            };
        }
        self.0[node_i] = Node8::new(&children[..count]);
        self.0[node_i].bounds()
    }
}
