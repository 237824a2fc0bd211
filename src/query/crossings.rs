//! Through which triangles a ray's line passes where it meets an edge or a vertex, exactly: one of two at an edge, an
//! even number of those of a closed mesh in all.
//!
//! The canonical test tells all triangles that touch. Here the line is moved by less than that test's rounding, the
//! same way for all triangles of a ray, so that it meets no edge; signs of determinants are exact (Shewchuk 1997, by
//! the crate `robust`).

use crate::ray::Ray;
use glam::{DVec3, Vec3};
use robust::{Coord3D, orient3d};

/// The corners of a triangle that the line of a ray may pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing(pub [Vec3; 3]);

/// Lines that are tried until one meets no edge. Each after the first is needed in one of thousands of cases.
const TRIES: i32 = 16;

/// How far the line is turned, as a fraction of its length: far less than the rounding of `f32`, and far more than that
/// of `f64`.
const TURN: f64 = 1.0 / (1_u64 << 34) as f64;

fn exact(v: DVec3) -> Coord3D<f64> {
    Coord3D {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

/// Returns for each triangle whether the ray passes through it.
pub(super) fn decide(ray: &Ray, triangles: &[Crossing]) -> Vec<bool> {
    if triangles.is_empty() {
        return Vec::new();
    }
    let origin = ray.origin.as_dvec3();
    // As long as everything is far, so that the line through origin and end is the ray's but for a rounding of `f64`.
    let far = triangles
        .iter()
        .flat_map(|Crossing(corners)| corners)
        .map(|corner| corner.as_dvec3().abs().max_element())
        .fold(origin.abs().max_element(), f64::max);
    let length = far.max(f64::from(f32::MIN_POSITIVE)) * 4.0;
    for attempt in 0..TRIES {
        // Fractions without a short period, so that no two attempts and no ordinary plane agree.
        let part = |ratio: f64| (f64::from(attempt + 1) * ratio).fract() - 0.5;
        let turn = DVec3::new(
            part(0.819_172_513_396_164_4),
            part(0.671_043_606_703_789_2),
            part(0.549_700_477_901_970_3),
        );
        let end = origin + (ray.direction.as_dvec3() + turn * TURN) * length;
        let decided: Option<Vec<bool>> = triangles
            .iter()
            .map(|triangle| passes(origin, end, triangle))
            .collect();
        if let Some(decided) = decided {
            return decided;
        }
    }
    // The origin is on the line of an edge, whatever the direction: a ray from the surface.
    let end = origin + ray.direction.as_dvec3() * length;
    triangles
        .iter()
        .map(|triangle| passes(origin, end, triangle).unwrap_or(false))
        .collect()
}

/// Whether the line from `origin` through `end` passes through a triangle ahead of the origin; `None` if it meets an
/// edge's line.
fn passes(origin: DVec3, end: DVec3, Crossing(corners): &Crossing) -> Option<bool> {
    let [a, b, c] = corners.map(|corner| exact(corner.as_dvec3()));
    let (o, e) = (exact(origin), exact(end));
    let sides = [orient3d(o, e, a, b), orient3d(o, e, b, c), orient3d(o, e, c, a)];
    if sides.contains(&0.0) {
        return None;
    }
    let is_left = sides.iter().all(|&side| side > 0.0);
    let is_right = sides.iter().all(|&side| side < 0.0);
    if !is_left && !is_right {
        return Some(false);
    }
    // The origin and the end of a line that is long enough are on different sides of the plane.
    let plane = orient3d(a, b, c, o);
    let ahead = orient3d(a, b, c, e);
    Some(plane != 0.0 && (plane > 0.0) != (ahead > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fans around a vertex, and rays at it: one triangle is passed.
    #[test]
    fn one_triangle_of_a_fan_is_passed() {
        let mut random = fastrand::Rng::with_seed(11);
        for round in 0..2000 {
            let count = 3 + round % 6;
            let mut unit = || random.f32() * 2.0 - 1.0;
            let tip = Vec3::new(unit(), unit(), 5.0 + unit());
            let rim: Vec<Vec3> = (0..count)
                .map(|i| {
                    let angle = (i as f32) * std::f32::consts::TAU / count as f32;
                    Vec3::new(3.0 * angle.cos(), 3.0 * angle.sin(), 5.0 + unit())
                })
                .collect();
            let fan: Vec<Crossing> = (0..count)
                .map(|i| Crossing([tip, rim[i], rim[(i + 1) % count]]))
                .collect();
            let on_edge = tip.lerp(rim[0], 0.25);
            for to in [tip, on_edge] {
                let ray = Ray::new(Vec3::ZERO, to.normalize());
                let passed = decide(&ray, &fan);
                assert_eq!(passed.iter().filter(|&&passed| passed).count(), 1, "{round} {to}");
            }
        }
    }
}
