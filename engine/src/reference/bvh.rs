//! The scalar baseline: traces one ray at a time through the binary BVH, the nearer child first.

use super::{Passing, RaySlabs, instances::Met, intersect_shape, planes, shade::Intersect};
use crate::{
    accel::{BinaryBvh, BinaryInstances, BinaryNode, Bvh},
    ray::{Hit, Ray, SceneHit},
    scene::Scene,
    simd::{Level, Simd, at_level},
};

/// The traversal stacks, reused from ray to ray. An entry is a node and the t at which the ray enters it.
#[derive(Debug, Default)]
pub struct Stack {
    /// In the scene's own BVH, or in that of the instances.
    outer: Vec<(u32, f32)>,
    /// In the BVH of an instance's prototype.
    inner: Vec<(u32, f32)>,
}

/// Visits the leaves that the ray enters before its current end, `t_max` at first. `leaf` gets a range of primitives or
/// instances and returns the new end, or `None` to stop.
#[inline(always)]
fn traverse(
    nodes: &[BinaryNode],
    slabs: &RaySlabs,
    t_max: f32,
    stack: &mut Vec<(u32, f32)>,
    mut leaf: impl FnMut(std::ops::Range<usize>) -> Option<f32>,
) {
    stack.clear();
    let Some(root) = nodes.first() else { return };
    let mut limit = t_max;
    let (near, far) = slabs.interval(root.bounds());
    if near > far || near > limit {
        return;
    }
    let mut node_i = 0_usize;
    loop {
        let node = &nodes[node_i];
        if node.count > 0 {
            let first = node.first as usize;
            let Some(new_limit) = leaf(first..first + node.count as usize) else {
                return;
            };
            limit = new_limit;
        } else {
            let first = node.first as usize;
            let (near0, far0) = slabs.interval(nodes[first].bounds());
            let (near1, far1) = slabs.interval(nodes[first + 1].bounds());
            let hit0 = near0 <= far0 && near0 <= limit;
            let hit1 = near1 <= far1 && near1 <= limit;
            match (hit0, hit1) {
                (true, true) => {
                    let (nearer, farther, far_near) = if near0 <= near1 {
                        (first, first + 1, near1)
                    } else {
                        (first + 1, first, near0)
                    };
                    stack.push((farther as u32, far_near));
                    node_i = nearer;
                    continue;
                }
                (true, false) => {
                    node_i = first;
                    continue;
                }
                (false, true) => {
                    node_i = first + 1;
                    continue;
                }
                (false, false) => {}
            }
        }
        loop {
            let Some((next, near)) = stack.pop() else { return };
            if near <= limit {
                node_i = next as usize;
                break;
            }
        }
    }
}

/// Everything that rays can hit in a scene: the binary BVH, planes and instances. Rays pass through cut-outs.
#[doc(hidden)]
pub struct OverScene<'a> {
    scene: &'a Scene,
    bvh: &'a BinaryBvh,
    stack: Stack,
    level: Level,
    /// The scene, if rays pass through parts of its surfaces.
    cut_outs: Option<&'a Scene>,
}

impl<'a> OverScene<'a> {
    /// Takes a scene and the BVH that was built from it.
    pub fn new(scene: &'a Scene, bvh: &'a Bvh, level: Level) -> Self {
        Self {
            scene,
            bvh: bvh.binary(scene),
            stack: Stack::default(),
            level,
            cut_outs: scene.has_cut_outs().then_some(scene),
        }
    }
}

impl OverScene<'_> {
    fn closest(&mut self, ray: &Ray, passing: Passing<'_>) -> SceneHit {
        let best = closest_hit_at(self.level, self.bvh, &mut self.stack, ray, passing);
        if self.scene.planes().is_empty() {
            return best;
        }
        at_level!(self.level, |simd| planes::closest(
            simd,
            (self.scene, passing),
            ray,
            best
        ))
    }
}

impl Intersect for OverScene<'_> {
    fn closest_hit(&mut self, ray: &Ray) -> SceneHit {
        self.closest(ray, Passing::of(self.cut_outs, Passing::CutOuts))
    }

    fn opaque_hit(&mut self, ray: &Ray) -> SceneHit {
        self.closest(ray, Passing::NotOpaque(self.scene))
    }

    fn visible_hit(&mut self, ray: &Ray, only_opaque: bool) -> SceneHit {
        let passing = if only_opaque {
            Passing::BacksNotOpaque(self.scene)
        } else {
            Passing::Backs(self.scene)
        };
        self.closest(ray, passing)
    }

    fn occluded(&mut self, ray: &Ray) -> bool {
        let scene = self.scene;
        !scene.planes().is_empty() && at_level!(self.level, |simd| planes::block(simd, scene, ray))
            || occluded_at(self.level, self.bvh, &mut self.stack, ray, self.cut_outs)
    }
}

/// Returns the closest hit, ignoring cut-outs; at equal t the one with the lowest id.
#[must_use]
pub fn closest_hit(bvh: &BinaryBvh, stack: &mut Stack, ray: &Ray) -> SceneHit {
    closest_hit_at(Level::current(), bvh, stack, ray, Passing::Nowhere)
}

/// [`closest_hit`] at a level; `passing` are the surfaces that rays pass through.
fn closest_hit_at(
    level: Level,
    bvh: &BinaryBvh,
    stack: &mut Stack,
    ray: &Ray,
    passing: Passing<'_>,
) -> SceneHit {
    at_level!(level, |simd| {
        let best = closest(simd, bvh, &mut stack.outer, ray, passing).into();
        match &bvh.instances {
            Some(instances) => closest_of_instances(simd, instances, stack, ray, best, passing),
            None => best,
        }
    })
}

/// Returns the closest hit of the instances if it is nearer than `best`, else `best`.
#[inline(always)]
fn closest_of_instances<S: Simd>(
    simd: S,
    over: &BinaryInstances,
    stack: &mut Stack,
    ray: &Ray,
    mut best: SceneHit,
    passing: Passing<'_>,
) -> SceneHit {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let Stack { outer, inner } = stack;
    traverse(
        &over.nodes,
        &slabs,
        best.t,
        outer,
        #[inline(always)]
        |range| {
            for i in range {
                let (id, instance) = &over.instances[i];
                if let Some(met) = Met::new(instance, *id, over.boxes[i], ray, &slabs) {
                    let prototype = &over.prototypes[met.prototype.0 as usize];
                    let hit = closest(simd, prototype, inner, &met.up_to(best.t), passing);
                    met.offer(&hit, &mut best);
                }
            }
            Some(best.t)
        },
    );
    best
}

#[inline(always)]
fn closest<S: Simd>(
    simd: S,
    bvh: &BinaryBvh,
    stack: &mut Vec<(u32, f32)>,
    ray: &Ray,
    passing: Passing<'_>,
) -> Hit {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut best = Hit::miss(ray.t_max);
    traverse(
        &bvh.nodes,
        &slabs,
        ray.t_max,
        stack,
        #[inline(always)]
        |range| {
            for (&id, shape) in bvh.primitives[range.clone()].iter().zip(&bvh.shapes[range]) {
                if let Some(hit) = intersect_shape(simd, id, shape, ray, &slabs)
                    && best.loses_to(hit.t, id)
                    && passing.counts(ray, &hit)
                {
                    best = hit;
                }
            }
            Some(best.t)
        },
    );
    best
}

/// Returns whether any surface is hit before the ray's end, ignoring cut-outs.
#[must_use]
pub fn occluded(bvh: &BinaryBvh, stack: &mut Stack, ray: &Ray) -> bool {
    occluded_at(Level::current(), bvh, stack, ray, None)
}

/// [`occluded`] at a level. Rays pass through what lets ambient light pass in the scene `cut_outs`.
fn occluded_at(
    level: Level,
    bvh: &BinaryBvh,
    stack: &mut Stack,
    ray: &Ray,
    cut_outs: Option<&Scene>,
) -> bool {
    let passing = Passing::of(cut_outs, Passing::Light);
    at_level!(level, |simd| {
        any(simd, bvh, &mut stack.outer, ray, passing)
            || bvh.instances.as_ref().is_some_and(|instances| {
                let miss = SceneHit::miss(ray.or_nothing().t_max);
                closest_of_instances(simd, instances, stack, ray, miss, passing).is_hit()
            })
    })
}

#[inline(always)]
fn any<S: Simd>(
    simd: S,
    bvh: &BinaryBvh,
    stack: &mut Vec<(u32, f32)>,
    ray: &Ray,
    passing: Passing<'_>,
) -> bool {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut found = false;
    traverse(
        &bvh.nodes,
        &slabs,
        ray.t_max,
        stack,
        #[inline(always)]
        |range| {
            for (&id, shape) in bvh.primitives[range.clone()].iter().zip(&bvh.shapes[range]) {
                let hit = intersect_shape(simd, id, shape, ray, &slabs);
                if hit.is_some_and(|hit| hit.t < ray.t_max && passing.counts(ray, &hit)) {
                    found = true;
                    return None;
                }
            }
            Some(ray.t_max)
        },
    );
    found
}
