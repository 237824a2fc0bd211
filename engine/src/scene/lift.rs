//! Smooth shadows: where the shadow rays of a triangle with vertex normals start.
//!
//! A flat triangle blocks light that grazes the smooth surface for which its vertex normals stand, so facets show there.
//! After Hanika, *Hacking the Shadow Terminator*, Ray Tracing Gems II ch. 4, 2021: the point is projected onto the
//! tangent planes of the vertices that are above it, and the mean by its barycentric weights is taken. Two
//! differences: the point moves only along the geometric normal, and only for light that grazes the facet or is below it
//! (`shade::soft::lift`).
//!
//! The packet version, with the same operations in the same order, is in `shade::surface`.

use super::{Placement, Primitive, Scene};
use crate::{
    math::{max, max_abs, scale_to_one},
    ray::Hit,
    simd::Simd,
};
use glam::Vec3;

/// A point on a triangle, in the space of the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Base {
    pub point: Vec3,
    /// The unit geometric normal, on either side.
    pub geometric: Vec3,
    /// Whether the viewer is on the other side.
    pub from_behind: bool,
}

impl Scene {
    /// Returns whether shadow rays of triangles with vertex normals start on the smooth surface for which these stand.
    #[inline]
    #[must_use]
    pub fn smooth_shadows(&self) -> bool {
        self.smooth_shadows
    }

    /// Returns how far the smooth surface is above a hit, on the viewer's side, scene units; 0 without
    /// vertex normals, and on spheres and planes.
    ///
    /// Moving along the geometric normal also limits what normals far off the face do: a vertex counts for at most half its
    /// distance, and at 90 degrees for nothing. And points never move sideways, under the floor on which a box stands.
    #[inline(always)]
    pub(crate) fn rise<S: Simd>(&self, simd: S, hit: &Hit, placement: Option<&Placement>, at: &Base) -> f32 {
        let normals = &self.vertices.normals;
        let Primitive::Triangle(i) = self.primitive(hit.primitive) else {
            return 0.0;
        };
        if normals.is_empty() {
            return 0.0;
        }
        let normals = self.triangles.corners[i].map(|vertex| normals[vertex as usize]);
        if normals.contains(&Vec3::ZERO) {
            return 0.0;
        }
        let corners = self.triangle(i);
        let [a, b, c] = [0, 1, 2].map(
            #[inline(always)]
            |k| {
                let (corner, normal) = match placement {
                    Some(placement) => (placement.point(corners[k]), placement.normal(normals[k])),
                    None => (corners[k], normals[k]),
                };
                let slope = slope(simd, normal, at.geometric);
                let above = simd.dot(corner - at.point, slope);
                max(if at.from_behind { -above } else { above }, 0.0)
            },
        );
        let (u, v) = (hit.u, hit.v);
        let w = 1.0 - u - v;
        simd.mul_add(b, u, simd.mul_add(c, v, a * w))
    }
}

/// The vector whose dot product with the way to a vertex is the height of the vertex's tangent plane, along `geometric`.
#[inline(always)]
fn slope<S: Simd>(simd: S, normal: Vec3, geometric: Vec3) -> Vec3 {
    let normal = normal * scale_to_one(max_abs(normal));
    normal * (max(simd.dot(normal, geometric), 0.0) / simd.dot(normal, normal))
}
