//! The scalar version of `shade::through`.

use super::{
    shade::{Intersect, SURFACE_OFFSET, tinted},
    surface::surface,
};
use crate::{
    ray::{Hit, Ray, SceneHit},
    scene::{Crossing, MaterialId, Passage, RayCone, Scene, skipped},
    simd::{Level, Simd, at_level},
};

/// Returns what a camera ray sees.
pub(crate) fn seen_at(level: Level, scene: &Scene, intersect: &mut dyn Intersect, ray: &Ray) -> SceneHit {
    at_level!(level, |simd| seen(simd, scene, intersect, ray))
}

/// Returns the hit whose surface a camera ray shows.
pub fn first_hit_at(level: Level, scene: &Scene, intersect: &mut dyn Intersect, ray: &Ray) -> SceneHit {
    at_level!(level, |simd| if scene.dims_light() {
        opaque_first(simd, scene, intersect, ray, true)
    } else {
        seen(simd, scene, intersect, ray)
    })
}

/// Returns the closest hit of a ray that passes the backs of one-sided surfaces.
#[inline(always)]
pub(super) fn seen<S: Simd>(simd: S, scene: &Scene, intersect: &mut dyn Intersect, ray: &Ray) -> SceneHit {
    let hit = intersect.closest_hit(ray);
    if !hit.is_hit() || !scene.is_one_sided(hit.primitive) || !surface(simd, scene, ray, &hit).from_behind {
        return hit;
    }
    intersect.visible_hit(ray, false)
}

/// Returns the closest hit of a ray, an opaque surface before others in the same place; see [`skipped`]. `passes_backs`: see
/// [`seen`].
#[inline(always)]
pub(super) fn opaque_first<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    ray: &Ray,
    passes_backs: bool,
) -> SceneHit {
    let hit = if passes_backs {
        seen(simd, scene, intersect, ray)
    } else {
        intersect.closest_hit(ray)
    };
    if !hit.is_hit() || scene.is_opaque(hit.primitive, [hit.u, hit.v]) {
        return hit;
    }
    in_place_of(simd, scene, intersect, (ray, hit), passes_backs)
}

// Not inlined: see `follow`.
#[inline(never)]
fn in_place_of<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    (ray, hit): (&Ray, SceneHit),
    passes_backs: bool,
) -> SceneHit {
    let skipped = simd.call(
        #[inline(always)]
        || {
            let s = surface(simd, scene, ray, &hit);
            let at = (s.point, s.geometric_normal);
            skipped(simd, ray, hit.t, at, s.magnitude * SURFACE_OFFSET)
        },
    );
    let found = skipped.map_or(hit, |skipped| {
        if passes_backs {
            intersect.visible_hit(&skipped, true)
        } else {
            intersect.opaque_hit(&skipped)
        }
    });
    if !found.is_hit() || found.primitive == hit.primitive {
        return hit;
    }
    SceneHit {
        hit: Hit {
            t: hit.t,
            ..found.hit
        },
        ..found
    }
}

/// Returns the share of light that is left along a shadow ray, by channel; `None` if nothing is left. `is_from_light`: the
/// direction of the ray; `medium`: the tinted glass at the surface.
#[inline(always)]
pub(super) fn light_through<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    (ray, is_from_light): (Ray, bool),
    medium: Option<MaterialId>,
) -> Option<[f32; 3]> {
    if !scene.dims_light() {
        return (!intersect.occluded(&ray)).then_some([1.0; 3]);
    }
    let passage = Passage::along(&ray, is_from_light, medium);
    follow(simd, scene, intersect, (ray, passage))
}

// Long and called twice, so not inlined. It therefore enters the level itself.
#[inline(never)]
fn follow<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    light: (Ray, Passage),
) -> Option<[f32; 3]> {
    simd.call(
        #[inline(always)]
        || cross_all(simd, scene, intersect, light),
    )
}

#[inline(always)]
fn cross_all<S: Simd>(
    simd: S,
    scene: &Scene,
    intersect: &mut dyn Intersect,
    (mut ray, mut passage): (Ray, Passage),
) -> Option<[f32; 3]> {
    while ray.t_max > 0.0 {
        let hit = opaque_first(simd, scene, intersect, &ray, false);
        if !hit.is_hit() {
            passage.arrive(scene, ray.t_max);
            break;
        }
        let s = surface(simd, scene, &ray, &hit);
        let width = RayCone::default().width(hit.t);
        let base = tinted(simd, scene, &ray, &hit, width).0.base_color();
        let crossing = Crossing {
            direction: s.direction,
            geometric_normal: s.geometric_normal,
            normal: s.normal,
            from_behind: s.from_behind,
            ..Crossing::at(&hit, base)
        };
        if !passage.cross(simd, scene, &crossing) {
            return None;
        }
        let offset = -(s.magnitude * SURFACE_OFFSET);
        let behind = simd.mul_add3(s.geometric_normal, offset, s.point);
        ray = passage.onward(simd, behind, ray.direction);
    }
    (passage.left != [0.0; 3]).then_some(passage.left)
}
