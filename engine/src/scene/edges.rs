//! Edges of triangles in pictures: how much of a camera ray's sample the nearest edge of the triangle that it hits covers.
//!
//! ```text
//!           e          n = (p - e) x (q - e) is normal to the plane through the eye e and the edge pq. A ray's direction d
//!         / | \        has d·n = 0 on the edge, and d·n changes by (dx·n, dy·n) from pixel to pixel, so the edge is
//!        /  |d \
//!       p---+---q          |d·n| / |(dx·n, dy·n)|  pixels away.
//! ```
//! That is exact for a pinhole, in front of the eye and behind it; with the roles of origin and direction exchanged for
//! parallel rays; and near the edge for a distorted picture. With a lens, the eye is the ray's point of it. All of it is
//! `f64` arithmetic of single rays, so both modes and all instruction sets share it.

use super::{Distortion, PixelRays, Scene, SceneHit};
use crate::ray::{InstanceId, Ray};
use glam::{DVec3, Vec3};

/// Heights of triangles in pixels, relative to the width of lines: lower triangles have no edges, higher ones all of them, and
/// those in between faint ones. Else dense meshes would turn black.
const FAINT: [f64; 2] = [1.5, 6.0];

/// The edges of triangles as lines, and the camera rays of a picture.
#[derive(Clone, Copy, Debug)]
pub struct EdgeLines {
    rays: PixelRays,
    /// A pixel's sides where the depth is 1, or everywhere if rays are parallel, without distortion.
    across: DVec3,
    down: DVec3,
    /// The unit view direction.
    forward: DVec3,
    /// Pixels.
    width: f64,
    /// Width of a sample, pixels.
    sample: f64,
    /// Linear RGB.
    color: [f32; 3],
}

/// The edges of a triangle as a ray sees it.
#[derive(Clone, Copy, Debug)]
pub struct TriangleEdges {
    corners: [DVec3; 3],
    /// For each edge, the vector n of the module's description, relative to the change of d·n per pixel.
    normals: [DVec3; 3],
    /// From 0 for small triangles to 1.
    strength: f64,
}

impl EdgeLines {
    /// Makes lines of a width in pixels and a linear colour, for a picture with `samples` samples per pixel.
    #[must_use]
    pub fn new(rays: PixelRays, width: f32, color: [f32; 3], samples: u32) -> Self {
        let pixel = 2.0 * f64::from(rays.step) * f64::from(rays.samples_per_axis);
        let (right, up) = (rays.right.as_dvec3(), rays.up.as_dvec3());
        let axis = up.cross(right);
        Self {
            rays,
            across: right * pixel,
            down: up * pixel,
            forward: axis / axis.dot(rays.forward.as_dvec3()),
            width: width.into(),
            sample: 1.0 / f64::from(samples).sqrt(),
            color,
        }
    }

    /// Returns whether all rays see the same [`TriangleEdges`] of a triangle.
    #[must_use]
    pub fn are_shared(&self) -> bool {
        self.rays.lens.is_none() && self.rays.undistortion.is_none()
    }

    /// Returns the share of a camera ray's sample that an edge covers. Spheres, planes and misses have none.
    #[must_use]
    pub fn cover(&self, scene: &Scene, ray: &Ray, hit: &SceneHit) -> f32 {
        let edges = self.of_hit(scene, ray, hit);
        edges.map_or(0.0, |edges| self.cover_by(&edges, ray))
    }

    /// Returns the edges of what a ray hits, if it has any.
    #[must_use]
    pub fn of_hit(&self, scene: &Scene, ray: &Ray, hit: &SceneHit) -> Option<TriangleEdges> {
        let corners = scene.edged_triangle(hit)?;
        let [a, b, c] = corners;
        let (origin, direction, [across, down]) =
            (ray.origin.as_dvec3(), self.direction(ray), self.steps(ray));
        let (forward, is_parallel) = (self.forward(ray), self.rays.is_parallel);
        let face = (b - a).cross(c - a);
        // d·n at the corner opposite to an edge, times the corner's depth: the same for all three.
        let volume = if is_parallel { direction } else { a - origin }.dot(face).abs();
        let (mut height, mut is_in_front) = (f64::INFINITY, true);
        let normals = [(a, b, c), (b, c, a), (c, a, b)].map(|(p, q, opposite)| {
            let (normal, depth) = if is_parallel {
                (direction.cross(q - p), 1.0)
            } else {
                ((p - origin).cross(q - p), (opposite - origin).dot(forward))
            };
            let (x, y) = (across.dot(normal), down.dot(normal));
            let per_pixel = (x * x + y * y).sqrt();
            height = height.min(volume / (depth.max(0.0) * per_pixel));
            is_in_front &= depth > 0.0;
            normal / per_pixel
        });
        // A triangle that reaches behind the eye is large.
        if !is_in_front {
            height = f64::INFINITY;
        }
        let [none, all] = FAINT;
        let share = ((height / self.width.max(1.0) - none) / (all - none)).clamp(0.0, 1.0);
        Some(TriangleEdges {
            corners,
            normals,
            strength: share * share * (3.0 - 2.0 * share),
        })
    }

    /// Returns the share of a ray's sample that the nearest edge covers.
    #[must_use]
    pub fn cover_by(&self, edges: &TriangleEdges, ray: &Ray) -> f32 {
        let (origin, direction) = (ray.origin.as_dvec3(), self.direction(ray));
        let mut nearest = f64::INFINITY;
        for (normal, corner) in edges.normals.iter().zip(edges.corners) {
            let across = if self.rays.is_parallel {
                corner - origin
            } else {
                direction
            };
            // `min` ignores NaN, which an edge has that is seen as a point.
            nearest = nearest.min(across.dot(*normal).abs());
        }
        // The part of a square sample that a line covers, as if it were parallel to a side.
        let most = self.width.min(self.sample);
        let cover = (0.5 * (self.width + self.sample) - nearest).clamp(0.0, most) / self.sample;
        (cover * edges.strength) as f32
    }

    /// Returns the unit vector along which depths count: the view direction, or the direction of a fisheye's ray, because there may
    /// be points beside the eye.
    fn forward(&self, ray: &Ray) -> DVec3 {
        match &self.rays.undistortion {
            Some(all) if matches!(all.inverse.distortion, Distortion::Fisheye { .. }) => {
                ray.direction.as_dvec3()
            }
            _ => self.forward,
        }
    }

    /// Returns a ray's direction at depth 1.
    fn direction(&self, ray: &Ray) -> DVec3 {
        let direction = ray.direction.as_dvec3();
        direction / direction.dot(self.forward(ray))
    }

    /// Returns how the direction at depth 1, or else the origin of parallel rays, changes from pixel to pixel.
    fn steps(&self, ray: &Ray) -> [DVec3; 2] {
        let Some(undistortion) = &self.rays.undistortion else {
            return [self.across, self.down];
        };
        let (right, down, forward) = (
            undistortion.right.as_dvec3(),
            -self.rays.up.as_dvec3(),
            self.forward,
        );
        let direction = self.direction(ray);
        let seen = DVec3::new(direction.dot(right), direction.dot(down), direction.dot(forward));
        let in_scene = |DVec3 { x, y, z }| right * x + down * y + forward * z;
        let [by_right, by_down] = undistortion.inverse.slopes(seen).map(in_scene);
        [by_right * self.across.length(), by_down * self.down.length()]
    }

    /// Returns a sample's colour and opacity under an edge that covers a share of it.
    #[must_use]
    pub fn over(&self, [r, g, b, alpha]: [f32; 4], cover: f32) -> [f32; 4] {
        if cover <= 0.0 {
            return [r, g, b, alpha];
        }
        let [r, g, b] = [(r, 0), (g, 1), (b, 2)].map(|(c, i)| c * (1.0 - cover) + self.color[i] * cover);
        [r, g, b, alpha + (1.0 - alpha) * cover]
    }
}

impl Scene {
    /// Returns the corners of the triangle of a hit, relative to [`Scene::origin`]; `None` if it has no edges.
    fn edged_triangle(&self, hit: &SceneHit) -> Option<[DVec3; 3]> {
        let id = hit.primitive.0;
        if id as usize >= self.triangles.corners.len() || self.is_edgeless(id) {
            return None;
        }
        let corners = self.triangle(id as usize).map(Vec3::as_dvec3);
        if hit.instance == InstanceId::NONE {
            return Some(corners);
        }
        let placement = self.instances[hit.instance.0 as usize].placement();
        Some(corners.map(|corner| placement.point_in_f64(corner)))
    }

    /// Whether triangle `i` was added without edges.
    fn is_edgeless(&self, i: u32) -> bool {
        let all = &self.triangles.edgeless;
        let at = all.partition_point(|range| range.end <= i);
        all.get(at).is_some_and(|range| range.start <= i)
    }
}

#[cfg(test)]
mod tests;
