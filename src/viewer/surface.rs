//! The surface that a camera ray hits, for pictures without shadows and reflections. Scalar code; `shade` shades the
//! ray-traced picture.

use crate::{
    ray::{Hit, PrimitiveId, Ray, SceneHit},
    reference::{
        light,
        shade::{albedo, shading_normal},
    },
    scene::{Material, RayCone, Scene},
};
use glam::Vec3;

/// The intensity of the light at the eye.
const HEADLIGHT: f32 = 0.6;
/// The share of the scene's lights in addition to it.
const SCENE_LIGHTS: f32 = 0.5;

/// Returns the point that the ray hit, scene units.
#[must_use]
pub fn point(ray: &Ray, hit: &Hit) -> Vec3 {
    ray.origin + ray.direction * hit.t
}

/// Returns the material of a primitive.
#[must_use]
pub fn material(scene: &Scene, primitive: PrimitiveId) -> &Material {
    &scene.materials()[scene.material_of(primitive).0 as usize]
}

/// Returns the colour of the preview: a light at the eye and the scene's lights, without shadows. `cone` is that of
/// a pixel.
#[must_use]
pub fn preview(scene: &Scene, ray: &Ray, hit: &SceneHit, cone: RayCone) -> [f32; 3] {
    let albedo = albedo(scene, ray, hit, cone.width(hit.t));
    let own = match *material(scene, hit.primitive) {
        Material::Silhouette { .. } => return albedo,
        // A pale body: the preview follows no rays.
        Material::Glass { .. } | Material::Matte { .. } | Material::Reflection { .. } => albedo,
        Material::BlinnPhong { k_d, .. } => albedo.map(|c| c * k_d),
    };
    let (normal, point) = (shading_normal(scene, ray, hit), point(ray, hit));
    let from_eye = scene.ambient() + HEADLIGHT * normal.dot(-ray.direction).max(0.0);
    let mut light = [from_eye; 3];
    for from_scene in scene.lights() {
        let to_light = from_scene.shape.direction_from(point);
        let facing = SCENE_LIGHTS * normal.dot(to_light).max(0.0);
        for (sum, power) in light.iter_mut().zip(from_scene.power()) {
            *sum += facing * power;
        }
    }
    std::array::from_fn(|c| own[c] * light[c].min(1.0))
}

/// Returns the unoccluded light of a diffuse surface, from the centres of soft lights and without highlights; `None` for
/// emissive, mirroring, refracting and half-transparent surfaces.
#[must_use]
pub fn unoccluded(scene: &Scene, ray: &Ray, hit: &SceneHit, normal: Vec3, cone: RayCone) -> Option<[f32; 3]> {
    let k_d = match *material(scene, hit.primitive) {
        Material::Silhouette { .. } | Material::Glass { .. } | Material::Reflection { .. } => return None,
        Material::Matte { .. } => 1.0,
        Material::BlinnPhong { k_d, .. } => k_d,
    };
    let textures = scene.textures_of(hit.primitive);
    if textures.is_some_and(|textures| textures.emits() || textures.opacity.is_some()) {
        return None;
    }
    let (own, point) = (albedo(scene, ray, hit, cone.width(hit.t)), point(ray, hit));
    // Only the mean matters: how much of the environment arrives is left to the share.
    let around = if scene.environment().is_some() { 1.0 } else { 0.0 };
    let mut light = [scene.ambient() + around; 3];
    for from_scene in scene.lights() {
        let (to_light, power) = light::from_middle(from_scene, point);
        let facing = k_d * normal.dot(to_light);
        // Not at a light, whose direction is NaN.
        if facing > 0.0 {
            for (sum, power) in light.iter_mut().zip(power) {
                *sum += facing * power;
            }
        }
    }
    Some(std::array::from_fn(|c| own[c] * light[c]))
}
