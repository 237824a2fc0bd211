//! Points on instances: transforms the prototypes' points. Scenes without instances never run this pass.

use super::SurfacePacket;
use crate::{
    lanes::LANES,
    math::max_abs,
    ray::{Hit, HitPacket, InstanceId, PrimitiveId, Ray},
    scene::{Base, Instance, Placement, Primitive, Scene},
    shade::queue::{HitQueue, RayQueue},
    simd::Simd,
};
use glam::Vec3;

/// Transforms the points on instances. On input they are in their prototypes' space (points of spheres are not set), with
/// normals on either side.
#[inline(always)]
pub(in crate::shade) fn place<S: Simd>(
    simd: S,
    scene: &Scene,
    (rays, hits): (&RayQueue, &[HitPacket]),
    instances: &[[u32; LANES]],
    by_material: &HitQueue,
    surfaces: &mut [SurfacePacket],
) {
    let mut packets = surfaces.iter_mut();
    // Neighbours are mostly on one instance.
    let mut last: Option<(InstanceId, Placement)> = None;
    by_material.for_each_packet(
        #[inline(always)]
        |ray_i| {
            let Some(surface) = packets.next() else { return };
            for (lane, &i) in ray_i.iter().enumerate() {
                let (p, from) = (i as usize / LANES, i as usize % LANES);
                let id = InstanceId(instances[p][from]);
                let Some(instance) = scene.instance(id) else {
                    continue;
                };
                let placement = match &last {
                    Some((of, placement)) if *of == id => *placement,
                    _ => instance.placement(),
                };
                last = Some((id, placement));
                let hit = hits[p].hit(from);
                if let Primitive::Sphere(sphere_i) = scene.primitive(PrimitiveId(hit.primitive.0)) {
                    let ray = rays.rays.ray(p, from);
                    set_sphere(simd, scene, (sphere_i, instance), &ray, hit.t, (surface, lane));
                }
                place_lane(simd, scene, (surface, lane), &hit, &placement);
            }
        },
    );
}

/// Transforms one point, and turns its normals to the viewer.
#[inline(always)]
fn place_lane<S: Simd>(
    simd: S,
    scene: &Scene,
    (surface, lane): (&mut SurfacePacket, usize),
    hit: &Hit,
    placement: &Placement,
) {
    let bit = 1 << lane;
    let turned = if surface.from_behind & bit == 0 { 1.0 } else { -1.0 };
    let geometric = placement.normal(surface.geometric_normal.lane(lane) * turned);
    let normal = placement.normal(surface.normal.lane(lane) * turned);
    let away = simd.dot(geometric, surface.direction.lane(lane)) > 0.0;
    surface.from_behind = surface.from_behind & !bit | u32::from(away) << lane;
    let point = placement.point(surface.point.lane(lane));
    surface.point.set(lane, point);
    surface
        .geometric_normal
        .set(lane, if away { -geometric } else { geometric });
    if scene.smooth_shadows() {
        let base = Base {
            point,
            geometric,
            from_behind: away,
        };
        let rise = scene.rise(simd, hit, Some(placement), &base);
        surface.rise.as_mut_array()[lane] = rise;
        surface.raised = surface.raised & !bit | u32::from(rise > 0.0) << lane;
    }
    surface.normal.set(lane, if away { -normal } else { normal });
    let magnitude = &mut surface.magnitude.as_mut_array()[lane];
    *magnitude = placement.magnitude(*magnitude);
}

/// Sets the point of a sphere in its prototype's space.
#[inline(always)]
fn set_sphere<S: Simd>(
    simd: S,
    scene: &Scene,
    (i, instance): (usize, &Instance),
    ray: &Ray,
    distance: f32,
    (surface, lane): (&mut SurfacePacket, usize),
) {
    let Some(image) = instance.image(ray) else { return };
    let (center, radius) = (scene.spheres().center(i), scene.spheres().radius[i]);
    let from_center = image.ray.origin - center;
    let outward: Vec3 =
        simd.normalize(simd.mul_add3(image.ray.direction, image.of_distance(distance), from_center));
    surface.from_behind &= !(1 << lane);
    surface.point.set(lane, simd.mul_add3(outward, radius, center));
    surface.geometric_normal.set(lane, outward);
    surface.normal.set(lane, outward);
    surface.magnitude.as_mut_array()[lane] = max_abs(center) + radius;
}
