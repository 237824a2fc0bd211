//! What a camera ray hits, for the looks that need no light transport. Plain scalar code; the picture itself is shaded
//! by `shade`.

use crate::{
    ray::{Hit, PrimitiveId, Ray},
    reference::shade::shading_normal,
    scene::{Material, Scene},
};
use glam::Vec3;

/// The headlight's intensity, and the share of the scene's lights beside it.
const HEADLIGHT: f32 = 0.6;
const SCENE_LIGHTS: f32 = 0.5;

/// Where the ray hit, scene units.
#[must_use]
pub fn point(ray: &Ray, hit: &Hit) -> Vec3 {
    ray.origin + ray.direction * hit.t
}

/// The material of what was hit.
#[must_use]
pub fn material(scene: &Scene, primitive: PrimitiveId) -> &Material {
    &scene.materials()[scene.material_of(primitive).0 as usize]
}

/// The preview's colour: a light at the eye and the scene's lights, nothing in their way.
#[must_use]
pub fn preview(scene: &Scene, ray: &Ray, hit: &Hit) -> [f32; 3] {
    let own = match *material(scene, hit.primitive) {
        Material::Silhouette { color } => return color,
        Material::Matte { color } | Material::Reflection { color, .. } => color,
        Material::BlinnPhong { diffuse, k_d, .. } => diffuse.map(|c| c * k_d),
    };
    let (normal, point) = (shading_normal(scene, ray, hit), point(ray, hit));
    let lights = scene.lights();
    let from_eye = scene.ambient() + HEADLIGHT * normal.dot(-ray.direction).max(0.0);
    let mut light = [from_eye; 3];
    for i in 0..lights.intensity.len() {
        let to_light = (lights.position(i) - point).normalize_or_zero();
        let facing = SCENE_LIGHTS * normal.dot(to_light).max(0.0);
        for (sum, power) in light.iter_mut().zip(lights.power(i)) {
            *sum += facing * power;
        }
    }
    std::array::from_fn(|c| own[c] * light[c].min(1.0))
}
