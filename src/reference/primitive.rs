//! One ray against one primitive. The operations and their order are those of `geometry`; see there for why.

use crate::{
    math::{Aabb, cross, dot, max, max_abs, min, min_abs_direction, mul_add, mul_add3},
    ray::{Hit, PrimitiveId, Ray},
    scene::Shape,
};
use glam::Vec3;

const GEOMETRIC_PAD: f32 = 1.0 / 4_194_304.0;
const INTERVAL_PAD: f32 = 4.0 / 16_777_216.0;
const EDGE_TOLERANCE: f32 = 24.0 / 16_777_216.0;

/// What the slab test needs of a ray.
#[derive(Clone, Copy, Debug)]
pub struct RaySlabs {
    origin: Vec3,
    inv_direction: Vec3,
}

impl RaySlabs {
    /// Of `ray`.
    #[must_use]
    pub fn new(ray: &Ray) -> Self {
        let inv = |d: f32| 1.0 / min_abs_direction(d);
        let d = ray.direction;
        Self {
            origin: ray.origin,
            inv_direction: Vec3::new(inv(d.x), inv(d.y), inv(d.z)),
        }
    }

    /// Where the ray enters and leaves the box; the entry is above the exit where it does not.
    #[must_use]
    pub fn interval(&self, bounds: Aabb) -> (f32, f32) {
        let t0 = (bounds.lower - self.origin) * self.inv_direction;
        let t1 = (bounds.upper - self.origin) * self.inv_direction;
        let near = max(max(min(t0.x, t1.x), min(t0.y, t1.y)), max(min(t0.z, t1.z), 0.0));
        let far = min(min(max(t0.x, t1.x), max(t0.y, t1.y)), max(t0.z, t1.z));
        (near * (1.0 - INTERVAL_PAD), far * (1.0 + INTERVAL_PAD))
    }

    fn primitive_interval(&self, bounds: Aabb) -> (f32, f32) {
        let pad = Vec3::splat(max(max_abs(bounds.lower), max_abs(bounds.upper)) * GEOMETRIC_PAD);
        self.interval(Aabb {
            lower: bounds.lower - pad,
            upper: bounds.upper + pad,
        })
    }
}

/// Where `ray` hits primitive `id`, which has this shape, regardless of the ray's `t_max`.
#[inline]
#[must_use]
pub fn intersect_shape(id: PrimitiveId, shape: &Shape, ray: &Ray, slabs: &RaySlabs) -> Option<Hit> {
    let (t, u, v) = match *shape {
        Shape::Triangle(corners) => triangle(corners, ray, slabs)?,
        Shape::Sphere(center, radius) => (sphere(center, radius, ray, slabs)?, 0.0, 0.0),
    };
    Some(Hit {
        t,
        u,
        v,
        primitive: id,
    })
}

fn triangle([v0, v1, v2]: [Vec3; 3], ray: &Ray, slabs: &RaySlabs) -> Option<(f32, f32, f32)> {
    let d = ray.direction;
    let (a, b) = (v0 - ray.origin, v1 - ray.origin);
    let (e1, e2, e3) = (v1 - v0, v2 - v0, v2 - v1);
    let normal = cross(e1, e2);
    let plane = dot(normal, a);
    let side = if plane.is_sign_negative() { -1.0 } else { 1.0 };

    let longest = max(max(max_abs(e1), max_abs(e2)), max_abs(e3));
    let farthest = max(max_abs(a), max_abs(b));
    let tolerance = longest * farthest * EDGE_TOLERANCE;
    let edge = |e: Vec3| {
        let e = e * side;
        mul_add(d.x, e.x, mul_add(d.y, e.y, mul_add(d.z, e.z, tolerance)))
    };
    let (u, v, w) = (edge(cross(e2, a)), edge(cross(a, e1)), edge(cross(b, e3)));
    if u.is_sign_negative() || v.is_sign_negative() || w.is_sign_negative() {
        return None;
    }
    let determinant = dot(d, normal * side);
    if determinant <= 0.0 || determinant.is_nan() {
        return None;
    }
    let (near, far) = slabs.primitive_interval(Aabb {
        lower: v0.min(v1).min(v2),
        upper: v0.max(v1).max(v2),
    });
    let t = min(max(plane * side / determinant, near), far);
    let sum = u + v + w;
    (near <= far && t > 0.0).then_some((t, u / sum, v / sum))
}

fn sphere(center: Vec3, radius: f32, ray: &Ray, slabs: &RaySlabs) -> Option<f32> {
    let from_center = ray.origin - center;
    let nearest = -dot(from_center, ray.direction);
    let aside = mul_add3(ray.direction, nearest, from_center);
    let discriminant = radius * radius - dot(aside, aside);
    if discriminant < 0.0 || discriminant.is_nan() {
        return None;
    }
    let half_chord = discriminant.sqrt();
    let (t0, t1) = (nearest - half_chord, nearest + half_chord);
    let t = if t0 > 0.0 { t0 } else { t1 };

    let size = Vec3::splat(radius);
    let (near, far) = slabs.primitive_interval(Aabb {
        lower: center - size,
        upper: center + size,
    });
    let held = min(max(t, near), far);
    (t > 0.0 && held > 0.0 && near <= far).then_some(held)
}
