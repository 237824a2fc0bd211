//! The tinted glass that the eye of a camera is in.

use super::{shade::SURFACE_OFFSET, surface::surface};
use crate::{
    math::{AXES, spread_directions},
    ray::{Ray, SceneHit},
    scene::{Material, MaterialId, Scene},
    simd::{Level, Simd, at_level},
};
use glam::{DVec3, Vec3};

/// Rays that are spread over all directions.
const RAYS: usize = 120;

/// The most surfaces that a ray passes.
const MOST_LAYERS: usize = 64;

/// Returns the tinted glass around an eye, relative to the scene's origin, that looks `forward`. Rays ahead, along the axes and
/// in many other directions look for a surface whose back they meet first: an open body, such as water up to a plane, has one in
/// some directions only. `closest_hit` traces a ray.
#[doc(hidden)]
pub fn medium_at(
    level: Level,
    scene: &Scene,
    closest_hit: &mut dyn FnMut(&Ray) -> SceneHit,
    (eye, forward): (Vec3, DVec3),
) -> Option<MaterialId> {
    if !scene.materials().iter().any(Material::tints) {
        return None;
    }
    let ahead = forward.normalize_or(DVec3::X).as_vec3();
    let mut directions = [ahead].into_iter().chain(AXES).chain(spread_directions::<RAYS>());
    directions.find_map(|direction| {
        let ray = Ray::new(eye, direction);
        at_level!(level, |simd| medium_behind(simd, scene, closest_hit, ray))
    })
}

/// Returns the tinted glass whose back a ray meets, behind half-transparent surfaces and backs of one-sided ones only.
#[inline(always)]
fn medium_behind<S: Simd>(
    simd: S,
    scene: &Scene,
    closest_hit: &mut dyn FnMut(&Ray) -> SceneHit,
    mut ray: Ray,
) -> Option<MaterialId> {
    for _ in 0..MOST_LAYERS {
        let hit = closest_hit(&ray);
        if !hit.is_hit() {
            return None;
        }
        let surface = surface(simd, scene, &ray, &hit);
        let id = scene.material_of(hit.primitive);
        let material = &scene.materials()[id.0 as usize];
        if matches!(material, Material::Glass { .. }) {
            return (surface.from_behind && material.tints()).then_some(id);
        }
        let is_back = surface.from_behind && scene.is_one_sided(hit.primitive);
        if !is_back && scene.opacity(hit.primitive, [hit.u, hit.v]) >= 1.0 {
            return None;
        }
        let offset = -(surface.magnitude * SURFACE_OFFSET);
        ray.origin = simd.mul_add3(surface.geometric_normal, offset, surface.point);
    }
    None
}
