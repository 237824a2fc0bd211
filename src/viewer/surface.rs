//! The surface that a camera ray hits, for pictures without shadows and reflections. Scalar code; `shade` shades the
//! ray-traced picture.

use crate::{
    ray::{Hit, PrimitiveId, Ray},
    reference::shade::{albedo, shading_normal},
    scene::{Material, Scene},
};
use glam::Vec3;

/// The intensity of the light at the eye.
const HEADLIGHT: f32 = 0.6;
/// The share of the scene's lights beside it.
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

/// Returns the colour of the preview: a light at the eye and the scene's lights, without shadows. `pixel_width` is the
/// width of a pixel at distance 1.
#[must_use]
pub fn preview(scene: &Scene, ray: &Ray, hit: &Hit, pixel_width: f32) -> [f32; 3] {
    let albedo = albedo(scene, ray, hit, hit.t * pixel_width);
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
