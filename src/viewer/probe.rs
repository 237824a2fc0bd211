//! Describes the pixel under the mouse.

use super::{surface, timeline::Model};
use crate::{
    ray::{InstanceId, Ray, SceneHit},
    reference::{
        cost::{self, Cost, Stack},
        shade::shading_normal,
    },
    scene::{Camera, Material, Primitive},
};
use glam::DVec3;

/// Traces the ray through the centres of a pixel (row 0 at the top) and the lens, and returns its cost. One ray is fast
/// enough for the window's own thread.
#[must_use]
pub fn pick(
    model: &Model,
    camera: &Camera,
    [width, height]: [u32; 2],
    [x, y]: [u32; 2],
) -> (Ray, SceneHit, Cost) {
    let rays = camera.pixel_rays(&model.scene, width, height, 1);
    let ray = rays.ray(x, y, [0, 0]);
    let (hit, cost) = cost::closest_hit(&model.scene, &model.bvh, &mut Stack::default(), &ray);
    (ray, hit, cost)
}

/// Describes what a pixel shows, in lines of text.
#[must_use]
pub fn describe(model: &Model, camera: &Camera, size: [u32; 2], [x, y]: [u32; 2]) -> Vec<String> {
    let scene = &model.scene;
    let (ray, hit, cost) = pick(model, camera, size, [x, y]);
    let vector = |v: DVec3| format!("{:.4} {:.4} {:.4}", v.x, v.y, v.z);
    let mut lines = vec![format!("pixel     {x},{y}")];
    if hit.is_hit() {
        let primitive = match scene.primitive(hit.primitive) {
            Primitive::Triangle(i) => format!("triangle {i}"),
            Primitive::Sphere(i) => format!("sphere {i}"),
            Primitive::Plane(i) => format!("plane {i}"),
        };
        let within = match hit.instance {
            InstanceId::NONE => String::new(),
            InstanceId(id) => format!(" of instance {id}"),
        };
        let material = match surface::material(scene, hit.primitive) {
            Material::Silhouette { .. } => "silhouette",
            Material::Matte { .. } => "matte",
            Material::BlinnPhong { .. } => "Blinn-Phong",
            Material::Reflection { .. } => "reflection",
            Material::Glass { .. } => "glass",
        };
        let opacity = match scene.opacity(hit.primitive, [hit.u, hit.v]) {
            1.0 => String::new(),
            opacity => format!(", opacity {opacity:.3}"),
        };
        lines.push(format!("hit       {primitive}{within}, {material}{opacity}"));
        lines.push(format!("distance  {:.6}", hit.t));
        lines.push(format!(
            "point     {}",
            vector(scene.world_point(surface::point(&ray, &hit)))
        ));
        let normal = shading_normal(scene, &ray, &hit).as_dvec3();
        lines.push(format!("normal    {}", vector(normal)));
    } else {
        lines.push("hit       nothing".into());
    }
    lines.push(format!(
        "cost      {} nodes, {} primitives",
        cost.nodes, cost.primitives
    ));
    lines
}

#[cfg(test)]
mod tests;
