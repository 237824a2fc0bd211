//! Traces one ray through the wide BVH and counts its cost.

use super::{Passing, RaySlabs, instances::Met, intersect_shape, planes};
use crate::{
    accel::{Bvh, Child, Node8},
    math::Aabb,
    ray::{Hit, InstanceId, PrimitiveId, Ray, SceneHit},
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

/// Subtrees still to visit, each with the distance at which the ray enters it.
type Todo = Vec<(f32, Child)>;

/// The traversal stacks, reused from ray to ray.
#[derive(Debug, Default)]
pub struct Stack {
    own: Todo,
    /// Within a prototype.
    inside: Todo,
}

/// Returns the closest hit and its cost, without that of planes. Nearer children are visited first. Packets and bundles
/// share some of this cost.
///
/// # Panics
/// If the hierarchy was built from another scene.
#[must_use]
pub fn closest_hit(scene: &Scene, bvh: &Bvh, stack: &mut Stack, ray: &Ray) -> (SceneHit, Cost) {
    assert!(bvh.is_of(scene), "this BVH was built from another scene");
    at_level!(Level::current(), |simd| counted(simd, scene, bvh, stack, ray))
}

#[inline(always)]
#[doc(hidden)]
pub fn counted<S: Simd>(simd: S, scene: &Scene, bvh: &Bvh, stack: &mut Stack, ray: &Ray) -> (SceneHit, Cost) {
    let mut cost = Cost::default();
    let Stack { own, inside } = stack;
    let mut best = closest_own(simd, scene, bvh, own, ray, &mut cost).into();
    if let Some(instanced) = bvh.instanced() {
        let (ray, slabs) = (&ray.or_nothing(), RaySlabs::new(ray));
        let visit_instance = |leaf: Child, best: &mut SceneHit, cost: &mut Cost| {
            let (id, i) = (InstanceId(leaf.index() as u32), leaf.index());
            let bounds = scene.instance_bounds(id);
            if let Some(met) = Met::new(&scene.instances()[i], id, bounds, ray, &slabs) {
                let of = instanced.prototype(met.prototype);
                let hit = closest_own(simd, scene, of, inside, &met.up_to(best.t), cost);
                met.offer(&hit, best);
            }
        };
        traverse(
            instanced.nodes(),
            own,
            &slabs,
            &mut cost,
            &mut best,
            |hit| hit.t,
            visit_instance,
        );
    }
    let passing = Passing::CutOuts(scene);
    (planes::closest(simd, (scene, passing), ray, best), cost)
}

/// The closest hit of a hierarchy's own primitives.
#[inline(always)]
fn closest_own<S: Simd>(
    simd: S,
    scene: &Scene,
    bvh: &Bvh,
    stack: &mut Todo,
    ray: &Ray,
    cost: &mut Cost,
) -> Hit {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut best = Hit::miss(ray.t_max);
    let visit_block = |leaf: Child, best: &mut Hit, cost: &mut Cost| {
        let ids = bvh.leaf_ids(leaf);
        for id in ids[..leaf.count()].iter().map(|&id| PrimitiveId(id)) {
            cost.primitives += 1;
            if let Some(hit) = intersect_shape(simd, id, &scene.shape(id), ray, &slabs)
                && best.loses_to(hit.t, id)
                && Passing::CutOuts(scene).counts(ray, &hit)
            {
                *best = hit;
            }
        }
    };
    traverse(
        bvh.nodes(),
        stack,
        &slabs,
        cost,
        &mut best,
        |hit| hit.t,
        visit_block,
    );
    best
}

/// Visits the leaves that a ray enters before its best hit, whose distance is `end`.
#[inline(always)]
fn traverse<T>(
    nodes: &[Node8],
    stack: &mut Todo,
    slabs: &RaySlabs,
    cost: &mut Cost,
    best: &mut T,
    end: impl Fn(&T) -> f32,
    mut leaf: impl FnMut(Child, &mut T, &mut Cost),
) {
    stack.clear();
    if !nodes.is_empty() {
        stack.push((0.0, Child::inner(0)));
    }
    while let Some((near, child)) = stack.pop() {
        if near > end(best) {
            continue;
        }
        if !child.is_inner() {
            leaf(child, best, cost);
            continue;
        }
        cost.nodes += 1;
        let node = &nodes[child.index()];
        let first = stack.len();
        for i in 0..node.count as usize {
            let (lower, upper) = node.corners(i);
            let (near, far) = slabs.interval(Aabb { lower, upper });
            if near <= far && near <= end(best) {
                stack.push((near, node.child[i]));
            }
        }
        stack[first..].sort_by(|a, b| b.0.total_cmp(&a.0));
    }
}
