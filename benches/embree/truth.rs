//! Who is right where the two disagree on whether a ray hits: every primitive in `f64`, in which the differences of `f32`
//! coordinates are exact and their products nearly so.

use octray::{
    ray::Ray,
    scene::{Scene, Shape},
};
use rayon::prelude::*;

/// A ray that one of the two says hits something before its end, and the other not. They may trace it from different ends
/// (shadow rays), which rounds differently.
#[derive(Clone, Copy, Debug)]
pub struct Dispute {
    pub ours: Ray,
    pub embree: Ray,
    /// What octray says; Embree says the opposite.
    pub we_hit: bool,
}

/// In how many disputes each is right about the ray that it traced.
#[derive(Clone, Copy, Debug, Default)]
pub struct Right {
    pub disputes: usize,
    pub ours: usize,
    pub embree: usize,
}

/// More than this are not looked at: each costs a test of every primitive.
const MOST: usize = 1000;

/// Decides the first thousand of the disputes.
pub fn decide(scene: &Scene, disputes: &[Dispute]) -> Right {
    let mut right = Right::default();
    for dispute in disputes.iter().take(MOST) {
        right.disputes += 1;
        right.ours += usize::from(hits(scene, &dispute.ours) == dispute.we_hit);
        right.embree += usize::from(hits(scene, &dispute.embree) != dispute.we_hit);
    }
    right
}

/// Whether the ray hits anything in (0, `t_max`), edges included.
fn hits(scene: &Scene, ray: &Ray) -> bool {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let is_within = |t: f64| t > 0.0 && t < f64::from(ray.t_max);
    (0..scene.primitive_count() as u32).into_par_iter().any(|id| {
        match scene.shape(octray::ray::PrimitiveId(id)) {
            Shape::Triangle(corners) => {
                let [a, b, c] = corners.map(|corner| corner.as_dvec3() - origin);
                let (u, v, w) = (
                    direction.dot(c.cross(b)),
                    direction.dot(a.cross(c)),
                    direction.dot(b.cross(a)),
                );
                let inside = u.min(v).min(w) >= 0.0 || u.max(v).max(w) <= 0.0;
                inside
                    && is_within(
                        (a * u + b * v + c * w).dot(direction) / ((u + v + w) * direction.length_squared()),
                    )
            }
            Shape::Sphere(center, radius) => {
                let from_center = origin - center.as_dvec3();
                let (half_b, c) = (
                    from_center.dot(direction),
                    from_center.length_squared() - f64::from(radius).powi(2),
                );
                let a = direction.length_squared();
                let discriminant = half_b * half_b - a * c;
                let root = discriminant.max(0.0).sqrt();
                discriminant >= 0.0 && (is_within((-half_b - root) / a) || is_within((root - half_b) / a))
            }
        }
    })
}
