//! Rays against infinite planes.

use crate::simd::{Lanes, Vec3Lanes};

/// Planes end at this distance from the start of a ray, scene units: what leaves the points there keeps coordinates whose
/// products are finite.
const HORIZON: f32 = 1e9;

/// Returns the rays that hit a plane, given a point of it and its unit normal, and where.
///
/// The sign of the numerator is that of the side on which a ray starts, exactly along a coordinate axis and else within
/// the offset of secondary rays.
#[inline(always)]
#[must_use]
pub(crate) fn plane_hits<V: Lanes>(
    (point, normal): (Vec3Lanes<V>, Vec3Lanes<V>),
    (origin, direction): (Vec3Lanes<V>, Vec3Lanes<V>),
) -> (V::Mask, V) {
    let t = normal.dot(point - origin) / normal.dot(direction);
    (t.gt(t.all(0.0)) & t.lt(t.all(HORIZON)), t)
}
