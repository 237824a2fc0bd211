//! Intersects one ray with one primitive, with the same operations in the same order as the `geometry` module, which
//! explains them.

use crate::{
    math::{
        Aabb, max, max_abs, min, min_abs_direction,
        orientation::{self, point},
    },
    ray::{Hit, PrimitiveId, Ray},
    scene::Shape,
    simd::Simd,
};
use glam::{DVec3, Vec3};

const GEOMETRIC_PAD: f32 = 1.0 / 4_194_304.0;
const INTERVAL_PAD: f32 = 4.0 / 16_777_216.0;
/// Bound on the rounding error of an edge function, relative to the longest edge times twice the farthest corner.
const FILTER: f32 = 20.0 / 16_777_216.0;
/// Bound on the rounding error of the plane's distance, relative to the products in its sum.
const PLANE_FILTER: f32 = 20.0 / 16_777_216.0;
const EDGE_ERROR: f64 = 11.5 / 16_777_216.0;
const PLANE_ERROR: f64 = 9.0 / 16_777_216.0;
const PLANE_ERROR_64: f64 = 9.0 / 9_007_199_254_740_992.0;
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
    pub(super) fn primitive_interval(&self, bounds: Aabb) -> (f32, f32) {
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
    let (p, q, at) = ((v1 - v0).abs(), (v2 - v0).abs(), a.abs());
    let products =
        (p.y * q.z + p.z * q.y) * at.x + (p.z * q.x + p.x * q.z) * at.y + (p.x * q.y + p.y * q.x) * at.z;
    let knows_side = plane.abs() > PLANE_FILTER * products;
    if knows_side && smallest < -tolerance {
        return None;
    }
    let (near, far) = slabs.primitive_interval(Aabb {
        lower: v0.min(v1).min(v2),
        upper: v0.max(v1).max(v2),
    });
    let mut t = min(max(plane * side / simd.dot(d, normal * side), near), far);
    if !(knows_side && smallest > tolerance) {
        let found = exactly(ray, [v0, v1, v2]);
        if !found.is_side_known_in_f32 {
            weights = found.weights;
            t = found.t.max(near).min(far);
        }
        if !found.passes(weights) {
            return None;
        }
    }
    let [u, v, w] = [max(weights[0], 0.0), max(weights[1], 0.0), max(weights[2], 0.0)];
    let sum = max(u + v + w, f32::MIN_POSITIVE);
    (near <= far && t > 0.0).then_some((t, u / sum, v / sum))
}

/// The 1-norm, which bounds the length.
#[inline(always)]
fn one_norm(v: Vec3) -> f32 {
    v.x.abs() + v.y.abs() + v.z.abs()
}

/// A triangle before a ray, in `f64`.
struct InF64 {
    /// Whether `f32` determines the side of the plane on which the ray starts.
    is_side_known_in_f32: bool,
    /// Whether `f64` does.
    is_side_known: bool,
    /// Second corner, third, first; positive where the triangle is ahead.
    weights: [f32; 3],
    weights_64: [f64; 3],
    t: f32,
    sizes: [f64; 3],
    /// Whether the line passes through the triangle or, if two weights are within the error of `f64`, between two corners.
    is_passed: bool,
}

/// Decides in `f64` where `f32` cannot.
#[cold]
#[inline(never)]
fn exactly(ray: &Ray, corners: [Vec3; 3]) -> InF64 {
    let [v0, v1, v2] = corners.map(Vec3::as_dvec3);
    let (origin, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let [a, b, c] = [v0, v1, v2].map(|v| v - origin);
    let (e1, e2) = (v1 - v0, v2 - v0);
    let plane = e1.cross(e2).dot(a);
    let (p, q) = (e1.abs(), e2.abs());
    let products = DVec3::new(
        p.y * q.z + p.z * q.y,
        p.z * q.x + p.x * q.z,
        p.x * q.y + p.y * q.x,
    )
    .dot(a.abs());
    let is_side_known = plane.abs() > products * PLANE_ERROR_64;

    let edges = [(c, a, v2 - v0), (a, b, v0 - v1), (b, c, v1 - v2)];
    let sizes = edges.map(|(p, q, edge)| edge.length() * (p.length() + q.length()));
    let weights_64 = edges.map(|(p, q, edge)| d.dot(edge.cross(p + q)));
    let left = weights_64.iter().all(|&weight| weight >= 0.0);
    let right = weights_64.iter().all(|&weight| weight <= 0.0);
    let within = weights_64.iter().zip(sizes);
    let within = within.filter(|(weight, size)| weight.abs() <= size * EDGE_ERROR_64);
    let perpendicular = |v: DVec3| v - d * (v.dot(d) / d.length_squared());
    let is_between = |p: DVec3, q: DVec3| {
        perpendicular(p).dot(perpendicular(q)) <= p.length() * q.length() * ASIDE_ERROR_64
    };
    let is_passed = if within.count() < 2 {
        left || right
    } else {
        is_between(a, b) || is_between(b, c) || is_between(c, a)
    };
    // The ray starts on the plane and meets it nowhere else, unless it lies in the plane and meets neighbouring triangles.
    let starts_in_plane =
        || orientation::sign([corners[0], corners[1], corners[2], ray.origin].map(point)) == 0.0;
    let is_passed = is_passed && (is_side_known || !starts_in_plane());
    let side = if is_side_known {
        plane
    } else {
        weights_64.iter().sum()
    };
    let weights_64 = weights_64.map(|weight| weight * 1.0_f64.copysign(side));
    InF64 {
        is_side_known_in_f32: plane.abs() > products * PLANE_ERROR,
        is_side_known,
        weights: weights_64.map(|weight| weight as f32),
        weights_64,
        t: (plane / e1.cross(e2).dot(d)) as f32,
        sizes,
        is_passed,
    }
}

impl InF64 {
    /// Whether the ray meets the triangle: not if a weight is clearly negative, since the triangle is then behind the ray.
    /// `weights` are those of `f32`, used if `f32` determines the side.
    fn passes(&self, weights: [f32; 3]) -> bool {
        let largest = self.sizes[0].max(self.sizes[1]).max(self.sizes[2]);
        let is_behind = |i: usize| {
            if self.is_side_known_in_f32 {
                f64::from(weights[i]) < -largest * EDGE_ERROR
            } else {
                self.is_side_known && self.weights_64[i] < -largest * EDGE_ERROR_64
            }
        };
        self.is_passed && !(0..3).any(is_behind)
    }
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
