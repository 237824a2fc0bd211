//! Decides which program is right where they disagree on a hit or its distance: tests every primitive in `f64`, in which
//! differences of `f32` coordinates are exact and their products nearly so.

use octray::{
    ray::Ray,
    scene::{Scene, Shape},
};
use rayon::prelude::*;

/// A ray that hits something before its end for one program only. Shadow rays may be traced from different ends, which
/// rounds differently.
#[derive(Clone, Copy, Debug)]
pub struct Dispute {
    pub ours: Ray,
    pub embree: Ray,
    /// What octray says; Embree says the opposite.
    pub we_hit: bool,
}

/// A ray that both programs say hits something, at different distances.
#[derive(Clone, Copy, Debug)]
pub struct Distances {
    pub ray: Ray,
    pub ours: f32,
    pub embree: f32,
}

/// Distances that differ by less than this fraction are equal.
pub const TOLERANCE: f32 = 1e-4;

/// How often each program is right about the ray that it traced.
#[derive(Clone, Copy, Debug, Default)]
pub struct Right {
    pub disputes: usize,
    pub ours: usize,
    pub embree: usize,
}

/// At most this many are decided: each costs a test of every primitive.
const MOST: usize = 1000;

/// Decides the first thousand of the disputes; none in scenes with instances, which it does not know.
pub fn decide(scene: &Scene, disputes: &[Dispute]) -> Right {
    let mut right = Right::default();
    for dispute in disputes.iter().take(most(scene)) {
        right.disputes += 1;
        right.ours += usize::from(hits(scene, &dispute.ours) == dispute.we_hit);
        right.embree += usize::from(hits(scene, &dispute.embree) != dispute.we_hit);
    }
    right
}

fn most(scene: &Scene) -> usize {
    if scene.instances().is_empty() { MOST } else { 0 }
}

/// Like [`decide`], for distances: right is within [`TOLERANCE`] of the nearest hit.
pub fn decide_distances(scene: &Scene, disputes: &[Distances]) -> Right {
    let mut right = Right::default();
    for dispute in disputes.iter().take(most(scene)) {
        let truth = nearest(scene, &dispute.ray);
        // Neither is right if there is no hit.
        let is_right =
            |t: f32| truth.is_finite() && (f64::from(t) - truth).abs() <= f64::from(TOLERANCE) * truth;
        right.disputes += 1;
        right.ours += usize::from(is_right(dispute.ours));
        right.embree += usize::from(is_right(dispute.embree));
    }
    right
}

/// Whether the ray hits anything in (0, `t_max`), edges included.
fn hits(scene: &Scene, ray: &Ray) -> bool {
    let primitives = (0..scene.primitive_count() as u32).into_par_iter();
    primitives
        .flat_map_iter(|id| distances(scene, id, ray))
        .any(|t| is_within(t, ray))
}

/// The nearest hit in (0, `t_max`), edges included; infinite if the ray hits nothing.
fn nearest(scene: &Scene, ray: &Ray) -> f64 {
    let primitives = (0..scene.primitive_count() as u32).into_par_iter();
    primitives
        .flat_map_iter(|id| distances(scene, id, ray))
        .filter(|&t| is_within(t, ray))
        .reduce(|| f64::INFINITY, f64::min)
}

fn is_within(t: f64, ray: &Ray) -> bool {
    t > 0.0 && t < f64::from(ray.t_max)
}

/// Where the ray's line meets the primitive: up to two distances, else NaN.
fn distances(scene: &Scene, id: u32, ray: &Ray) -> [f64; 2] {
    let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    match scene.shape(octray::ray::PrimitiveId(id)) {
        Shape::Triangle(corners) => {
            let [a, b, c] = corners.map(|corner| corner.as_dvec3() - origin);
            let (u, v, w) = (
                direction.dot(c.cross(b)),
                direction.dot(a.cross(c)),
                direction.dot(b.cross(a)),
            );
            let inside = u.min(v).min(w) >= 0.0 || u.max(v).max(w) <= 0.0;
            let t = (a * u + b * v + c * w).dot(direction) / ((u + v + w) * direction.length_squared());
            [if inside { t } else { f64::NAN }, f64::NAN]
        }
        Shape::Sphere(center, radius) => {
            let from_center = origin - center.as_dvec3();
            let (half_b, c) = (
                from_center.dot(direction),
                from_center.length_squared() - f64::from(radius).powi(2),
            );
            let a = direction.length_squared();
            // NaN if the line misses.
            let root = (half_b * half_b - a * c).sqrt();
            [(-half_b - root) / a, (root - half_b) / a]
        }
    }
}
