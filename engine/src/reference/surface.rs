//! The point on a surface that a ray hits, its normals, and the offset of secondary rays.

use super::{planes, shade::Surface};
use crate::{
    math::{max, max_abs, scale_to_one},
    ray::{Hit, Ray, SceneHit},
    scene::{Base, Instance, Primitive, Scene, TexturePoint},
    simd::Simd,
};
use glam::Vec3;

#[inline(always)]
pub(super) fn surface<S: Simd>(simd: S, scene: &Scene, ray: &Ray, hit: &SceneHit) -> Surface {
    let (point, geometric, normal, magnitude) =
        match (scene.instance(hit.instance), scene.primitive(hit.primitive)) {
            (Some(instance), _) => placed(simd, scene, instance, ray, hit),
            (None, Primitive::Triangle(i)) => triangle(simd, scene, i, hit),
            (None, Primitive::Sphere(i)) => sphere(simd, scene, i, ray, hit.t),
            (None, Primitive::Plane(i)) => planes::surface(simd, &scene.planes()[i], ray, hit),
        };
    let away = simd.dot(geometric, ray.direction) > 0.0;
    let mut rise = 0.0;
    if scene.smooth_shadows() {
        let base = Base {
            point,
            geometric,
            from_behind: away,
        };
        let placement = scene.instance(hit.instance).map(Instance::placement);
        rise = scene.rise(simd, hit, placement.as_ref(), &base);
    }
    Surface {
        from_behind: away,
        occlusion: 1.0,
        point,
        rise,
        geometric_normal: if away { -geometric } else { geometric },
        normal: if away { -normal } else { normal },
        direction: ray.direction,
        magnitude,
    }
}

/// A surface with its normal and its occlusion by the maps that it has.
#[inline(always)]
pub(super) fn mapped(scene: &Scene, hit: &SceneHit, width: f32, mut surface: Surface) -> Surface {
    let textures = scene.textures_of(hit.primitive);
    let (normals, occlusion) = textures.map_or((None, None), |all| (all.normal_map, all.occlusion_map));
    if normals.is_some() || occlusion.is_some() {
        let point = TexturePoint {
            hit: *hit,
            point: surface.point,
            normal: surface.geometric_normal,
            direction: surface.direction,
            width,
        };
        if let Some(map) = normals {
            surface.normal = scene.mapped_normal(&map, &point, surface.normal, surface.from_behind);
        }
        if let Some(map) = occlusion {
            surface.occlusion = scene.occlusion(&map, &point);
        }
    }
    surface
}

/// The point on a sphere that a ray hits at `t`, both normals, and the magnitude for offsets.
#[inline(always)]
fn sphere<S: Simd>(simd: S, scene: &Scene, i: usize, ray: &Ray, t: f32) -> (Vec3, Vec3, Vec3, f32) {
    let (center, radius) = (scene.spheres().center(i), scene.spheres().radius[i]);
    let outward = simd.normalize(simd.mul_add3(ray.direction, t, ray.origin - center));
    let point = simd.mul_add3(outward, radius, center);
    (point, outward, outward, max_abs(center) + radius)
}

/// The same on an instance: the prototype's point, transformed.
#[inline(always)]
fn placed<S: Simd>(
    simd: S,
    scene: &Scene,
    instance: &Instance,
    ray: &Ray,
    hit: &SceneHit,
) -> (Vec3, Vec3, Vec3, f32) {
    let (point, geometric, normal, magnitude) = match scene.primitive(hit.primitive) {
        Primitive::Triangle(i) => triangle(simd, scene, i, hit),
        Primitive::Sphere(i) => {
            let image = instance.image(ray);
            let (ray, t) = image.map_or((*ray, hit.t), |image| (image.ray, image.of_distance(hit.t)));
            sphere(simd, scene, i, &ray, t)
        }
        Primitive::Plane(i) => planes::surface(simd, &scene.planes()[i], ray, hit),
    };
    let placement = instance.placement();
    (
        placement.point(point),
        placement.normal(geometric),
        placement.normal(normal),
        placement.magnitude(magnitude),
    )
}

#[inline(always)]
fn triangle<S: Simd>(simd: S, scene: &Scene, i: usize, hit: &Hit) -> (Vec3, Vec3, Vec3, f32) {
    let [v0, v1, v2] = scene.triangle(i);
    let facet = simd.cross(v1 - v0, v2 - v0);
    let geometric = simd.normalize(facet * scale_to_one(max_abs(facet)));
    let mut normal = geometric;
    let normals = &scene.vertices().normals;
    if !normals.is_empty() {
        let [n0, n1, n2] = scene.triangles().corners[i].map(|vertex| normals[vertex as usize]);
        let smooth = interpolate(simd, [n0, n1, n2], hit);
        if [n0, n1, n2].iter().all(|&n| n != Vec3::ZERO) && max_abs(smooth) > 0.0 {
            normal = simd.normalize(smooth * scale_to_one(max_abs(smooth)));
        }
    }
    let magnitude = max(max(max_abs(v0), max_abs(v1)), max_abs(v2));
    (interpolate(simd, [v0, v1, v2], hit), geometric, normal, magnitude)
}

/// Returns the mean of a triangle's corners by a hit's barycentric weights.
#[inline(always)]
pub(super) fn interpolate<S: Simd>(simd: S, [a, b, c]: [Vec3; 3], hit: &Hit) -> Vec3 {
    let (u, v) = (hit.u, hit.v);
    let w = 1.0 - u - v;
    simd.mul_add3(b, u, simd.mul_add3(c, v, a * w))
}
