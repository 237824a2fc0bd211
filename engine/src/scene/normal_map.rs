//! Normal maps: shading normals from images, in tangent space (Peercy et al., *Efficient Bump Mapping Hardware*, SIGGRAPH
//! 1997; glTF 2.0, section 3.9.3).

use super::{
    Primitive, Scene, Texture, TexturePoint,
    material::check_range,
    texture::{Lookup, dot},
};
use crate::error::SceneError;
use glam::{DVec3, Vec3};

/// The largest absolute [`NormalMap::scale`].
pub const MAX_NORMAL_SCALE: f32 = 1e3;

/// An image of shading normals, made by [`Image::of_numbers`](super::Image::of_numbers).
///
/// The bytes 0 to 255 stand for -1 to 1: red is the normal's component towards the image's right, green towards its top, blue
/// along the surface's shading normal. Only triangles with texture coordinates use it; glass ignores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// The image.
    pub texture: Texture,
    /// Factor of red and green, at most [`MAX_NORMAL_SCALE`] in size.
    pub scale: f32,
}

impl NormalMap {
    pub(super) fn check(&self) -> Result<(), SceneError> {
        let range = (-MAX_NORMAL_SCALE, MAX_NORMAL_SCALE);
        check_range("scale of a normal map", self.scale, range)
    }
}

impl Scene {
    /// Returns the unit shading normal that the map gives at a hit, in world space. `normal` is the surface's own; both are on
    /// the viewer's side, which is behind the surface if `from_behind`.
    ///
    /// Both modes call it. The tangents are those of the vertices, or else of the triangle's texture coordinates, made
    /// orthogonal to `normal`.
    #[must_use]
    pub fn mapped_normal(
        &self,
        map: &NormalMap,
        point: &TexturePoint,
        normal: Vec3,
        from_behind: bool,
    ) -> Vec3 {
        let Primitive::Triangle(i) = self.primitive(point.hit.primitive) else {
            return normal;
        };
        let side = if from_behind { -1.0 } else { 1.0 };
        let own = normal.as_dvec3() * side;
        let tangents = self.vertex_tangents(i, point, own);
        let Some([right, top]) = tangents.or_else(|| self.tangents(i, point, own)) else {
            return normal;
        };
        let lookup = Lookup::new(self, i, point);
        let [x, y, z] = lookup
            .color(self, map.texture)
            .map(|channel| 2.0 * f64::from(channel) - 1.0);
        let scale = f64::from(map.scale);
        let sum = right * (x * scale) + top * (y * scale) + own * z;
        let length = dot(sum, sum).sqrt();
        // Opposite components of a filtered map may leave nothing.
        if length > 1e-6 {
            (sum / length * side).as_vec3()
        } else {
            normal
        }
    }

    /// The directions of [`Scene::tangents`] by the tangents of the vertices; `None` unless all three have one, with the same sign.
    fn vertex_tangents(&self, i: usize, point: &TexturePoint, normal: DVec3) -> Option<[DVec3; 2]> {
        let all = &self.vertices.tangents;
        if all.is_empty() {
            return None;
        }
        let [a, b, c] = self.triangles.corners[i].map(|vertex| all[vertex as usize]);
        let sign = a[3];
        if [a, b, c]
            .iter()
            .any(|&[x, y, z, w]| [x, y, z] == [0.0; 3] || w * sign <= 0.0)
        {
            return None;
        }
        let [a, b, c] = [a, b, c].map(|[x, y, z, _]| Vec3::new(x, y, z).as_dvec3());
        let (u, v) = (f64::from(point.hit.u), f64::from(point.hit.v));
        let mut right = a * (1.0 - u - v) + b * u + c * v;
        let mut sign = f64::from(sign).signum();
        if let Some(instance) = self.instance(point.hit.instance) {
            let (placed, is_mirrored) = instance.placement().direction(right);
            right = placed;
            sign = if is_mirrored { -sign } else { sign };
        }
        let right = unit(without(right, normal))?;
        Some([right, normal.cross(right) * sign])
    }

    /// The directions in which the image's right and top are, unit vectors orthogonal to `normal` and to each other; `None`
    /// if the triangle's texture coordinates have no area.
    fn tangents(&self, i: usize, point: &TexturePoint, normal: DVec3) -> Option<[DVec3; 2]> {
        let [p0, p1, p2] = self.placed_corners(i, point.hit.instance);
        let [a, b, c] = self.corner_coordinates(i);
        let (first, second) = (p1 - p0, p2 - p0);
        let [u1, v1] = [b[0] - a[0], b[1] - a[1]];
        let [u2, v2] = [c[0] - a[0], c[1] - a[1]];
        let sign = (u1 * v2 - u2 * v1).partial_cmp(&0.0)? as i32;
        let sign = f64::from(sign);
        let right = unit(without(first * (v2 * sign) - second * (v1 * sign), normal))?;
        // The rows of an image go down.
        let top = without(first * (u2 * sign) - second * (u1 * sign), normal);
        Some([right, unit(without(top, right))?])
    }
}

/// A vector less its part along a unit vector.
fn without(vector: DVec3, along: DVec3) -> DVec3 {
    vector - along * dot(vector, along)
}

/// A vector of length 1; `None` for one without direction.
fn unit(vector: DVec3) -> Option<DVec3> {
    let length = dot(vector, vector).sqrt();
    (length > 0.0 && length.is_finite()).then(|| vector / length)
}
