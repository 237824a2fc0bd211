//! Intersects one ray with one primitive, with the same operations in the same order as the `geometry` module, which
//! explains them.

use crate::{
    math::{Aabb, max, max_abs, min, min_abs_direction},
    ray::{Hit, PrimitiveId, Ray},
    scene::Shape,
    simd::Simd,
};
use glam::{DVec3, Vec3};

const GEOMETRIC_PAD: f32 = 1.0 / 4_194_304.0;
const INTERVAL_PAD: f32 = 4.0 / 16_777_216.0;
/// Bound on the rounding error of an edge function, relative to the longest edge times twice the farthest corner.
const FILTER: f32 = 20.0 / 16_777_216.0;
const EDGE_ERROR: f64 = 11.5 / 16_777_216.0;
const EDGE_ERROR_64: f64 = 11.5 / 9_007_199_254_740_992.0;
const ASIDE_ERROR_64: f64 = 22.0 / 9_007_199_254_740_992.0;

/// A ray prepared for the slab test.
#[derive(Clone, Copy, Debug)]
pub struct RaySlabs {
    origin: Vec3,
    inv_direction: Vec3,
}

impl RaySlabs {
    /// Prepares `ray`.
    #[inline(always)]
    #[must_use]
    pub fn new(ray: &Ray) -> Self {
        let inv = |d: f32| 1.0 / min_abs_direction(d);
        let d = ray.direction;
        Self {
            origin: ray.origin,
            inv_direction: Vec3::new(inv(d.x), inv(d.y), inv(d.z)),
        }
    }

    /// Returns the t at which the ray enters and leaves the box; entry > exit if it misses.
    #[inline(always)]
    #[must_use]
    pub fn interval(&self, bounds: Aabb) -> (f32, f32) {
        let t0 = (bounds.lower - self.origin) * self.inv_direction;
        let t1 = (bounds.upper - self.origin) * self.inv_direction;
        let near = max(max(min(t0.x, t1.x), min(t0.y, t1.y)), max(min(t0.z, t1.z), 0.0));
        let far = min(min(max(t0.x, t1.x), max(t0.y, t1.y)), max(t0.z, t1.z));
        (near * (1.0 - INTERVAL_PAD), far * (1.0 + INTERVAL_PAD))
    }

    #[inline(always)]
    fn primitive_interval(&self, bounds: Aabb) -> (f32, f32) {
        let pad = Vec3::splat(max(max_abs(bounds.lower), max_abs(bounds.upper)) * GEOMETRIC_PAD);
        self.interval(Aabb {
            lower: bounds.lower - pad,
            upper: bounds.upper + pad,
        })
    }
}

/// Intersects `ray` with primitive `id` of the given shape, ignoring the ray's `t_max`.
#[inline(always)]
#[must_use]
pub(crate) fn intersect_shape<S: Simd>(
    simd: S,
    id: PrimitiveId,
    shape: &Shape,
    ray: &Ray,
    slabs: &RaySlabs,
) -> Option<Hit> {
    let (t, u, v) = match *shape {
        Shape::Triangle(corners) => triangle(simd, corners, ray, slabs)?,
        Shape::Sphere(center, radius) => (sphere(simd, center, radius, ray, slabs)?, 0.0, 0.0),
    };
    Some(Hit {
        t,
        u,
        v,
        primitive: id,
    })
}

#[inline(always)]
fn triangle<S: Simd>(
    simd: S,
    [v0, v1, v2]: [Vec3; 3],
    ray: &Ray,
    slabs: &RaySlabs,
) -> Option<(f32, f32, f32)> {
    let d = ray.direction;
    let (a, b, c) = (v0 - ray.origin, v1 - ray.origin, v2 - ray.origin);
    let normal = simd.cross(v1 - v0, v2 - v0);
    let plane = simd.dot(normal, a);
    let side = if plane.is_sign_negative() { -1.0 } else { 1.0 };

    let edges = [(v2 - v0, c + a), (v0 - v1, a + b), (v1 - v2, b + c)];
    let (mut weights, mut longest) = ([0.0; 3], 0.0);
    for (weight, (edge, sum)) in weights.iter_mut().zip(edges) {
        *weight = simd.dot(d, simd.cross(edge, sum) * side);
        longest = max(longest, one_norm(edge));
    }
    let farthest = max(max(one_norm(a), one_norm(b)), one_norm(c));
    let tolerance = FILTER * longest * 2.0 * farthest;
    let smallest = min(min(weights[0], weights[1]), weights[2]);
    let inside = smallest > tolerance || smallest >= -tolerance && passes_through(ray, [v0, v1, v2], weights);
    if !inside {
        return None;
    }
    let (near, far) = slabs.primitive_interval(Aabb {
        lower: v0.min(v1).min(v2),
        upper: v0.max(v1).max(v2),
    });
    let t = min(max(plane * side / simd.dot(d, normal * side), near), far);
    let [u, v, w] = [max(weights[0], 0.0), max(weights[1], 0.0), max(weights[2], 0.0)];
    let sum = max(u + v + w, f32::MIN_POSITIVE);
    (near <= far && t > 0.0).then_some((t, u / sum, v / sum))
}

/// The 1-norm, which bounds the length.
#[inline(always)]
fn one_norm(v: Vec3) -> f32 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

/// Decides in `f64` where `f32` cannot: whether the ray's line passes through the triangle or, if two edge functions are
/// within the error of `f64`, between two corners. False if an edge function is clearly negative in `f32`: then the
/// triangle is behind the ray.
#[cold]
#[inline(never)]
fn passes_through(ray: &Ray, corners: [Vec3; 3], weights: [f32; 3]) -> bool {
    let [v0, v1, v2] = corners.map(Vec3::as_dvec3);
    let (origin, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let [a, b, c] = [v0, v1, v2].map(|v| v - origin);
    let edges = [(c, a, v2 - v0), (a, b, v0 - v1), (b, c, v1 - v2)];
    let sizes = edges.map(|(p, q, edge)| edge.length() * (p.length() + q.length()));
    let largest = sizes[0].max(sizes[1]).max(sizes[2]);
    if weights
        .iter()
        .any(|&weight| f64::from(weight) < -largest * EDGE_ERROR)
    {
        return false;
    }
    let (mut left, mut right, mut within) = (0, 0, 0);
    for ((p, q, edge), size) in edges.into_iter().zip(sizes) {
        let weight = d.dot(edge.cross(p + q));
        left += i32::from(weight >= 0.0);
        right += i32::from(weight <= 0.0);
        within += i32::from(weight.abs() <= size * EDGE_ERROR_64);
    }
    if within < 2 {
        return left == 3 || right == 3;
    }
    let perpendicular = |v: DVec3| v - d * (v.dot(d) / d.length_squared());
    let is_between = |p: DVec3, q: DVec3| {
        perpendicular(p).dot(perpendicular(q)) <= p.length() * q.length() * ASIDE_ERROR_64
    };
    is_between(a, b) || is_between(b, c) || is_between(c, a)
}

#[inline(always)]
fn sphere<S: Simd>(simd: S, center: Vec3, radius: f32, ray: &Ray, slabs: &RaySlabs) -> Option<f32> {
    let from_center = ray.origin - center;
    let nearest = -simd.dot(from_center, ray.direction);
    let perpendicular = simd.mul_add3(ray.direction, nearest, from_center);
    let discriminant = radius * radius - simd.dot(perpendicular, perpendicular);
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
    let clamped = min(max(t, near), far);
    (t > 0.0 && clamped > 0.0 && near <= far).then_some(clamped)
}
