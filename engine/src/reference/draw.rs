//! The scalar version of `shade::draw`: random directions, with the same operations in the same order.

use crate::{
    math::{COS, SIN, max, min},
    simd::Simd,
};
use glam::Vec3;

/// Returns the point of the unit disc for one of the unit square.
#[inline(always)]
pub(crate) fn disc([u, v]: [f32; 2]) -> [f32; 2] {
    let (a, b) = (u + u - 1.0, v + v - 1.0);
    let is_steep = b.abs() > a.abs();
    let (long, short) = if is_steep { (b, a) } else { (a, b) };
    let slope = if long == 0.0 { 0.0 } else { short / long };
    let square = slope * slope;
    let series = |[a, b, c, d, e]: [f32; 5]| (((e * square + d) * square + c) * square + b) * square + a;
    let (along, across) = (long * series(COS), long * (slope * series(SIN)));
    if is_steep {
        [across, along]
    } else {
        [along, across]
    }
}

/// Returns the vector with the components x, y and z in an orthonormal basis whose z axis is `axis`.
#[inline(always)]
fn around<S: Simd>(simd: S, axis: Vec3, [x, y, z]: [f32; 3]) -> Vec3 {
    let sign = 1.0_f32.copysign(axis.z);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    let across = Vec3::new(1.0 + sign * axis.x * axis.x * a, sign * b, -(sign * axis.x));
    let other = Vec3::new(b, sign + axis.y * axis.y * a, -axis.y);
    simd.mul_add3(across, x, simd.mul_add3(other, y, axis * z))
}

/// Returns a direction, distributed by the cosine to `normal`.
#[inline(always)]
pub(super) fn by_cosine<S: Simd>(simd: S, normal: Vec3, point: [f32; 2]) -> Vec3 {
    let [x, y] = disc(point);
    let z = max(1.0 - (x * x + y * y), 0.0).sqrt();
    around(simd, normal, [x, y, z])
}

/// Returns a direction, distributed by the cosine to `normal`, on the geometric normal's side.
#[inline(always)]
pub(super) fn scattered<S: Simd>(simd: S, normal: Vec3, geometric: Vec3, point: [f32; 2]) -> Vec3 {
    let direction = by_cosine(simd, normal, point);
    let below = min(simd.dot(geometric, direction), 0.0);
    simd.mul_add3(geometric, -2.0 * below, direction)
}

/// Returns the unit direction to a random point of a sphere, and the distance in that direction.
#[inline(always)]
pub(super) fn cone<S: Simd>(simd: S, to_center: Vec3, radius: f32, point: [f32; 2]) -> (Vec3, f32) {
    let radius_squared = radius * radius;
    let squared = simd.dot(to_center, to_center);
    let length = squared.sqrt();
    let sine = min(radius_squared / squared, 1.0);
    let width = sine / (1.0 + (1.0 - sine).sqrt());
    let [x, y] = disc(point);
    let from_axis = width * (x * x + y * y);
    let cosine = 1.0 - from_axis;
    let spread = (width * (1.0 + cosine)).sqrt();
    let axis = to_center * (1.0 / length);
    let sine = from_axis * (1.0 + cosine);
    let inside = max(radius_squared - squared * sine, 0.0).sqrt();
    (
        around(simd, axis, [x * spread, y * spread, cosine]),
        length * cosine - inside,
    )
}
