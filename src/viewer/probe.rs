//! What is under the mouse, in words.

use super::{look::Model, surface};
use crate::{
    ray::Ray,
    reference::{
        cost::{self, Stack},
        shade::shading_normal,
    },
    scene::{Camera, Material, Primitive},
};
use glam::Vec3;

/// Lines about a pixel of a picture of this size, row 0 on top. One ray: nothing to wait for.
#[must_use]
pub fn describe(model: &Model, camera: &Camera, [width, height]: [u32; 2], [x, y]: [u32; 2]) -> Vec<String> {
    let scene = &model.scene;
    let rays = camera.pixel_rays(scene, width, height, 1);
    let ray = Ray::new(rays.eye(), rays.direction(x, y, [0, 0]));
    let (hit, cost) = cost::closest_hit(scene, &model.bvh, &mut Stack::default(), &ray);
    let vector = |v: Vec3| format!("{:.4} {:.4} {:.4}", v.x, v.y, v.z);
    let mut lines = vec![format!("pixel     {x},{y}")];
    if hit.is_hit() {
        let primitive = match scene.primitive(hit.primitive) {
            Primitive::Triangle(i) => format!("triangle {i}"),
            Primitive::Sphere(i) => format!("sphere {i}"),
        };
        let material = match surface::material(scene, hit.primitive) {
            Material::Silhouette { .. } => "silhouette",
            Material::Matte { .. } => "matte",
            Material::BlinnPhong { .. } => "Blinn-Phong",
            Material::Reflection { .. } => "reflection",
        };
        lines.push(format!("hit       {primitive}, {material}"));
        lines.push(format!("distance  {:.6}", hit.t));
        lines.push(format!(
            "point     {}",
            vector(scene.origin() + surface::point(&ray, &hit))
        ));
        lines.push(format!("normal    {}", vector(shading_normal(scene, &ray, &hit))));
    } else {
        lines.push("hit       nothing".into());
    }
    lines.push(format!(
        "cost      {} nodes, {} primitives",
        cost.nodes, cost.primitives
    ));
    lines
}
