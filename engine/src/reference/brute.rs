//! Brute force, the test oracle: tests every primitive. Rays pass through cut-outs.

use super::{Passing, RaySlabs, instances::Met, intersect_shape, planes};
use crate::{
    ray::{Hit, InstanceId, PrimitiveId, Ray, SceneHit},
    scene::{Primitive, PrototypeId, Scene, Shape},
    simd::{Level, Simd, at_level},
};

/// Returns every primitive with an area: those of a prototype, or those outside of all prototypes.
fn targets(scene: &Scene, prototype: Option<PrototypeId>) -> impl Iterator<Item = (PrimitiveId, Shape)> + '_ {
    let ids = scene.ids_of(prototype).into_iter().flatten();
    ids.map(PrimitiveId)
        .filter(|&id| match scene.primitive(id) {
            Primitive::Triangle(i) => scene.has_area(i),
            Primitive::Sphere(_) | Primitive::Plane(_) => true,
        })
        .map(|id| (id, scene.shape(id)))
}

#[inline(always)]
fn nearest<S: Simd>(
    simd: S,
    targets: impl Iterator<Item = (PrimitiveId, Shape)>,
    ray: &Ray,
    passing: Passing<'_>,
) -> Hit {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut best = Hit::miss(ray.t_max);
    for (id, shape) in targets {
        if let Some(hit) = intersect_shape(simd, id, &shape, ray, &slabs)
            && best.loses_to(hit.t, id)
            && passing.counts(ray, &hit)
        {
            best = hit;
        }
    }
    best
}

/// Replaces `best` by a nearer hit of an instance; `nearest_in` finds the nearest hit in a prototype.
#[inline(always)]
fn nearest_of_instances(
    scene: &Scene,
    ray: &Ray,
    mut best: SceneHit,
    nearest_in: impl Fn(PrototypeId, &Ray) -> Hit,
) -> SceneHit {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    for (id, instance) in (0..).map(InstanceId).zip(scene.instances()) {
        if let Some(met) = Met::new(instance, id, scene.instance_bounds(id), ray, &slabs) {
            let hit = nearest_in(met.prototype, &met.up_to(best.t));
            met.offer(&hit, &mut best);
        }
    }
    best
}

/// [`nearest_of_instances`] of all prototypes' primitives.
#[inline(always)]
fn nearest_placed<S: Simd>(
    simd: S,
    (scene, passing): (&Scene, Passing<'_>),
    ray: &Ray,
    best: SceneHit,
) -> SceneHit {
    nearest_of_instances(
        scene,
        ray,
        best,
        #[inline(always)]
        |id, ray| nearest(simd, targets(scene, Some(id)), ray, passing),
    )
}

/// Returns the closest hit; at equal t the one with the lowest id of instance, none first, then of primitive.
#[must_use]
pub fn closest_hit(scene: &Scene, ray: &Ray) -> SceneHit {
    at_level!(Level::current(), |simd| closest(
        simd,
        scene,
        ray,
        Passing::CutOuts(scene)
    ))
}

/// Returns the closest hit of an opaque surface.
#[must_use]
pub fn opaque_hit(scene: &Scene, ray: &Ray) -> SceneHit {
    at_level!(Level::current(), |simd| closest(
        simd,
        scene,
        ray,
        Passing::NotOpaque(scene)
    ))
}

/// Returns the closest hit that is not on the back of a one-sided surface, on an opaque one if `only_opaque`.
#[must_use]
pub fn visible_hit(scene: &Scene, ray: &Ray, only_opaque: bool) -> SceneHit {
    let passing = if only_opaque {
        Passing::BacksNotOpaque(scene)
    } else {
        Passing::Backs(scene)
    };
    at_level!(Level::current(), |simd| closest(simd, scene, ray, passing))
}

#[inline(always)]
#[doc(hidden)]
pub fn closest<S: Simd>(simd: S, scene: &Scene, ray: &Ray, passing: Passing<'_>) -> SceneHit {
    let best = nearest(simd, targets(scene, None), ray, passing);
    let best = nearest_placed(simd, (scene, passing), ray, best.into());
    planes::closest(simd, (scene, passing), ray, best)
}

/// Returns whether anything is hit before the ray's end.
#[must_use]
pub fn occluded(scene: &Scene, ray: &Ray) -> bool {
    at_level!(Level::current(), |simd| any(simd, scene, ray))
}

#[inline(always)]
#[doc(hidden)]
pub fn any<S: Simd>(simd: S, scene: &Scene, ray: &Ray) -> bool {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let passing = Passing::Light(scene);
    for (id, shape) in targets(scene, None) {
        let hit = intersect_shape(simd, id, &shape, ray, &slabs);
        if hit.is_some_and(|hit| hit.t < ray.t_max && passing.counts(ray, &hit)) {
            return true;
        }
    }
    let miss = SceneHit::miss(ray.t_max);
    nearest_placed(simd, (scene, passing), ray, miss).is_hit() || planes::block(simd, scene, ray)
}

/// Returns all hits of triangles and spheres before the ray's end, by id, of a sphere only the nearest one. Ignores
/// instances.
#[must_use]
pub fn all_hits(scene: &Scene, ray: &Ray) -> Vec<Hit> {
    at_level!(Level::current(), |simd| all(simd, scene, ray))
}

#[inline(always)]
fn all<S: Simd>(simd: S, scene: &Scene, ray: &Ray) -> Vec<Hit> {
    let ray = &ray.or_nothing();
    let slabs = RaySlabs::new(ray);
    let mut hits = Vec::new();
    for (id, shape) in targets(scene, None) {
        if let Some(hit) = intersect_shape(simd, id, &shape, ray, &slabs)
            && hit.t < ray.t_max
            && Passing::CutOuts(scene).counts(ray, &hit)
        {
            hits.push(hit);
        }
    }
    hits
}

/// The shapes of a scene, collected once for many rays.
#[derive(Clone, Debug)]
pub struct Shapes<'a> {
    scene: &'a Scene,
    /// Shapes outside of all prototypes.
    own: Vec<(PrimitiveId, Shape)>,
    /// By prototype.
    prototypes: Vec<Vec<(PrimitiveId, Shape)>>,
}

impl<'a> Shapes<'a> {
    /// Collects the shapes of `scene`.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            own: targets(scene, None).collect(),
            prototypes: (0..scene.prototypes().len() as u32)
                .map(|id| targets(scene, Some(PrototypeId(id))).collect())
                .collect(),
        }
    }

    /// Returns what [`closest_hit`] returns.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> SceneHit {
        let passing = self.passing(Passing::CutOuts);
        at_level!(Level::current(), |simd| {
            let best = self.nearest(simd, ray, passing);
            planes::closest(simd, (self.scene, Passing::CutOuts(self.scene)), ray, best)
        })
    }

    /// Returns what [`occluded`] returns.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        let passing = self.passing(Passing::Light);
        at_level!(Level::current(), |simd| {
            self.nearest(simd, ray, passing).is_hit() || planes::block(simd, self.scene, ray)
        })
    }

    fn passing(&self, passing: fn(&'a Scene) -> Passing<'a>) -> Passing<'a> {
        Passing::of(self.scene.has_cut_outs().then_some(self.scene), passing)
    }

    #[inline(always)]
    fn nearest<S: Simd>(&self, simd: S, ray: &Ray, passing: Passing<'_>) -> SceneHit {
        let best = nearest(simd, self.own.iter().copied(), ray, passing);
        nearest_of_instances(
            self.scene,
            ray,
            best.into(),
            #[inline(always)]
            |id, ray| {
                let shapes = self.prototypes[id.0 as usize].iter().copied();
                nearest(simd, shapes, ray, passing)
            },
        )
    }
}
