//! Rays against infinite planes.

use crate::simd::{Lanes, Vec3Lanes};

/// Planes end at this distance from the start of a ray, scene units, so that products of coordinates of secondary rays
/// stay finite.
const HORIZON: f32 = 1e9;

/// Returns the rays that hit a plane, given a point of it and its unit normal, and their t.
///
/// The sign of the numerator is the side on which a ray starts: exact for planes across a coordinate axis, else within the
/// offset of secondary rays.
#[inline(always)]
#[must_use]
pub(crate) fn plane_hits<V: Lanes>(
    (point, normal): (Vec3Lanes<V>, Vec3Lanes<V>),
    (origin, direction): (Vec3Lanes<V>, Vec3Lanes<V>),
) -> (V::Mask, V) {
    let t = normal.dot(point - origin) / normal.dot(direction);
    (t.gt(t.all(0.0)) & t.lt(t.all(HORIZON)), t)
}
