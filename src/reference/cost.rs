//! Traces one ray through the wide BVH and counts its cost.

use super::{RaySlabs, counts, intersect_shape, planes};
use crate::{
    accel::{Bvh, Child},
    math::Aabb,
    ray::{Hit, PrimitiveId, Ray},
    scene::Scene,
    simd::{Level, Simd, at_level},
};

/// The traversal cost of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Visited inner nodes, of up to eight children each.
    pub nodes: u32,
    /// Tested primitives.
    pub primitives: u32,
}

impl Cost {
    /// Returns the sum of nodes and primitives.
    #[must_use]
    pub fn total(self) -> u32 {
        self.nodes.saturating_add(self.primitives)
    }
}

/// The traversal stack, reused from ray to ray: the entry distance and the subtree.
#[derive(Debug, Default)]
pub struct Stack(Vec<(f32, Child)>);

/// Returns the closest hit and its cost, without that of planes. Nearer children come first; packets and bundles would share some of the cost.
#[must_use]
pub fn closest_hit(scene: &Scene, bvh: &Bvh, stack: &mut Stack, ray: &Ray) -> (Hit, Cost) {
    at_level!(Level::current(), |simd| counted(simd, scene, bvh, stack, ray))
}

#[inline(always)]
pub(super) fn counted<S: Simd>(
    simd: S,
    scene: &Scene,
    bvh: &Bvh,
    Stack(stack): &mut Stack,
    ray: &Ray,
) -> (Hit, Cost) {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut best = Hit::miss(ray.t_max);
    let mut cost = Cost::default();
    stack.clear();
    if !bvh.nodes().is_empty() {
        stack.push((0.0, bvh.root()));
    }
    while let Some((near, child)) = stack.pop() {
        if near > best.t {
            continue;
        }
        if child.is_inner() {
            cost.nodes += 1;
            let node = &bvh.nodes()[child.index()];
            let first = stack.len();
            for i in 0..node.count as usize {
                let (lower, upper) = node.corners(i);
                let (near, far) = slabs.interval(Aabb { lower, upper });
                if near <= far && near <= best.t {
                    stack.push((near, node.child[i]));
                }
            }
            stack[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
        } else {
            let ids = bvh.leaf_ids(child);
            for id in ids[..child.count()].iter().map(|&id| PrimitiveId(id)) {
                cost.primitives += 1;
                if let Some(hit) = intersect_shape(simd, id, &scene.shape(id), ray, &slabs)
                    && best.loses_to(hit.t, id)
                    && counts(Some(scene), &hit)
                {
                    best = hit;
                }
            }
        }
    }
    (planes::closest(simd, scene, ray, best), cost)
}
