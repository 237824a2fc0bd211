//! One ray over the wide hierarchy, counting what it costs.

use super::{RaySlabs, intersect_shape};
use crate::{
    accel::{Bvh, Child},
    math::Aabb,
    ray::{Hit, PrimitiveId, Ray},
    scene::Scene,
};

/// What a ray costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Inner nodes that were opened, of up to eight children each.
    pub nodes: u32,
    /// Primitives that were tested.
    pub primitives: u32,
}

impl Cost {
    /// Nodes and primitives together.
    #[must_use]
    pub fn total(self) -> u32 {
        self.nodes.saturating_add(self.primitives)
    }
}

/// Memory of a traversal, reused from ray to ray: what is still to visit, and where the ray enters it.
#[derive(Debug, Default)]
pub struct Todo(Vec<(f32, Child)>);

/// The nearest hit, as every other traversal finds it, and what it took: nearer children first, alone, without what
/// packets and bundles save.
#[must_use]
pub fn closest_hit(scene: &Scene, bvh: &Bvh, Todo(todo): &mut Todo, ray: &Ray) -> (Hit, Cost) {
    let slabs = RaySlabs::new(ray);
    let mut best = Hit::miss(ray.t_max);
    let mut cost = Cost::default();
    todo.clear();
    if !bvh.nodes().is_empty() {
        todo.push((0.0, bvh.root()));
    }
    while let Some((near, child)) = todo.pop() {
        if near > best.t {
            continue;
        }
        if child.is_inner() {
            cost.nodes += 1;
            let node = &bvh.nodes()[child.index()];
            let first = todo.len();
            for i in 0..node.count as usize {
                let (lower, upper) = node.corners(i);
                let (near, far) = slabs.interval(Aabb { lower, upper });
                if near <= far && near <= best.t {
                    todo.push((near, node.child[i]));
                }
            }
            todo[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
        } else {
            let ids = bvh.leaf_ids(child);
            for id in ids[..child.count()].iter().map(|&id| PrimitiveId(id)) {
                cost.primitives += 1;
                if let Some(hit) = intersect_shape(id, &scene.shape(id), ray, &slabs)
                    && best.loses_to(hit.t, id)
                {
                    best = hit;
                }
            }
        }
    }
    (best, cost)
}
