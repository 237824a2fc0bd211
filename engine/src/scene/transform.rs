//! Affine transforms of meshes, computed in f64 and rounded once.

use super::{Light, LightShape, Projection, Spot, Step, TriangleMesh, View};
use crate::{error::SceneError, math};
use glam::{DMat3, DVec3, Vec3};

/// An affine transform `linear * p + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    linear: DMat3,
    offset: DVec3,
}

impl Transform {
    /// The identity.
    pub const IDENTITY: Self = Self {
        linear: DMat3::IDENTITY,
        offset: DVec3::ZERO,
    };

    /// Returns this followed by a scaling by `factors` about the origin. Negative factors mirror.
    #[must_use]
    pub fn then_scale(self, factors: DVec3) -> Self {
        self.then(DMat3::from_diagonal(factors))
    }

    /// Returns this followed by a rotation by `degrees` about `axis` through the origin, counterclockwise as seen from
    /// the tip of the axis. The axis may have any length; a zero one rotates nothing. Quarter turns about the coordinate
    /// axes are exact.
    #[must_use]
    pub fn then_rotate(self, axis: DVec3, degrees: f64) -> Self {
        let Some(DVec3 { x, y, z }) = math::moderate(axis).try_normalize() else {
            return self;
        };
        let (sin, cos) = sin_cos_degrees(degrees);
        let rest = 1.0 - cos;
        // Rodrigues' rotation formula.
        self.then(DMat3::from_cols(
            DVec3::new(x * x * rest + cos, x * y * rest + z * sin, x * z * rest - y * sin),
            DVec3::new(x * y * rest - z * sin, y * y * rest + cos, y * z * rest + x * sin),
            DVec3::new(x * z * rest + y * sin, y * z * rest - x * sin, z * z * rest + cos),
        ))
    }

    /// Returns this followed by a translation by `offset`, scene units.
    #[must_use]
    pub fn then_translate(self, offset: DVec3) -> Self {
        Self {
            offset: self.offset + offset,
            ..self
        }
    }

    /// Returns this followed by a step.
    #[must_use]
    pub fn then_step(self, step: &Step) -> Self {
        match *step {
            Step::Scale(factors) => self.then_scale(factors),
            Step::Rotate { axis, degrees } => self.then_rotate(axis, degrees),
            Step::Translate(offset) => self.then_translate(offset),
        }
    }

    /// Returns the transform of a 3x4 matrix, row by row.
    #[must_use]
    pub fn from_rows([a, b, c]: [[f64; 4]; 3]) -> Self {
        let column = |i: usize| DVec3::new(a[i], b[i], c[i]);
        Self {
            linear: DMat3::from_cols(column(0), column(1), column(2)),
            offset: column(3),
        }
    }

    /// Returns this followed by another.
    #[must_use]
    pub fn then_transform(self, next: &Self) -> Self {
        Self {
            linear: next.linear * self.linear,
            offset: next.linear * self.offset + next.offset,
        }
    }

    /// Returns the transformed point, rounded.
    #[inline]
    #[must_use]
    pub fn point(&self, point: Vec3) -> Vec3 {
        (self.linear * point.as_dvec3() + self.offset).as_vec3()
    }

    /// Returns the light with its position and direction transformed; intensity, falloff and size stay.
    ///
    /// # Errors
    /// [`SceneError::NotPositive`] if nothing is left of the direction.
    #[doc(hidden)]
    pub fn light(&self, light: &Light) -> Result<Light, SceneError> {
        let mut placed = *light;
        match &mut placed.shape {
            LightShape::Point { position: at }
            | LightShape::Sphere { center: at, .. }
            | LightShape::Rectangle { center: at, .. } => *at = self.point(*at),
            LightShape::Directional { to_light, .. } => {
                let turned = LightShape::directional(self.linear * to_light.as_dvec3(), 0.0)?;
                if let LightShape::Directional { to_light: turned, .. } = turned {
                    *to_light = turned;
                }
            }
        }
        if let Some(spot) = &mut placed.spot {
            let [inner, outer] = spot.degrees();
            *spot = Spot::new(self.linear * spot.direction().as_dvec3(), inner, outer)?;
        }
        Ok(placed)
    }

    /// Returns a sphere around the transformed centre with the volume of the transformed sphere.
    #[doc(hidden)]
    pub fn sphere(&self, center: DVec3, radius: f64) -> (DVec3, f64) {
        let scale = libm::cbrt(self.linear.determinant().abs());
        (self.linear * center + self.offset, radius * scale)
    }

    /// Returns whether it flattens everything onto a line or a point, so that no triangle has an area.
    #[must_use]
    pub fn collapses(&self) -> bool {
        let [a, b, c] = [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis];
        [a.cross(b), b.cross(c), c.cross(a)]
            .iter()
            .all(|&area| area == DVec3::ZERO)
    }

    /// Returns whether all its numbers are finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.linear.is_finite() && self.offset.is_finite()
    }

    /// The matrix, and the image of a point.
    pub(crate) fn about(&self, point: DVec3) -> (DMat3, DVec3) {
        (self.linear, self.linear * point + self.offset)
    }

    fn then(self, linear: DMat3) -> Self {
        Self {
            linear: linear * self.linear,
            offset: linear * self.offset,
        }
    }

    /// Returns the coefficients as bits, with -0 as 0: equal for transforms that give the same coordinates.
    #[must_use]
    pub fn bits(&self) -> [u64; 12] {
        let mut bits = [0; 12];
        let numbers = self
            .linear
            .to_cols_array()
            .into_iter()
            .chain(self.offset.to_array());
        for (bits, number) in bits.iter_mut().zip(numbers) {
            *bits = (number + 0.0).to_bits();
        }
        bits
    }

    /// Returns the view of a camera that moves with the mesh: its field of view stays, and lengths are scaled like the up
    /// vector.
    #[must_use]
    pub fn view(&self, view: &View) -> View {
        let up = self.linear * view.up;
        let scale = up.length() / view.up.length();
        View {
            eye: self.linear * view.eye + self.offset,
            target: self.linear * view.target + self.offset,
            up,
            lens: view.lens.scaled(scale),
            projection: match view.projection {
                Projection::Orthographic { height } => Projection::Orthographic {
                    height: height * scale,
                },
                perspective @ Projection::Perspective { .. } => perspective,
            },
        }
    }

    /// Transforms the vertices, normals and tangents of a mesh. Triangles of a mirrored mesh change their winding, so that their
    /// front stays in front. Arrays of unequal length are left for the builder to reject.
    pub fn apply(&self, mesh: &mut TriangleMesh) {
        if *self == Self::IDENTITY {
            return;
        }
        let TriangleMesh { x, y, z, .. } = mesh;
        for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
            let old = DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z));
            let new = (self.linear * old + self.offset).as_vec3();
            (*x, *y, *z) = (new.x, new.y, new.z);
        }
        // The inverse transpose without its division by the determinant: lengths do not matter here, and the sign
        // follows the winding.
        let [a, b, c] = [self.linear.x_axis, self.linear.y_axis, self.linear.z_axis];
        let mirrored = self.linear.determinant() < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        let normal_matrix = DMat3::from_cols(b.cross(c) * sign, c.cross(a) * sign, a.cross(b) * sign);
        for normal in &mut mesh.normals {
            let transformed = (normal_matrix * normal.as_dvec3()).try_normalize();
            *normal = transformed.map_or(Vec3::ZERO, DVec3::as_vec3);
        }
        for [x, y, z, w] in &mut mesh.tangents {
            let old = DVec3::new(f64::from(*x), f64::from(*y), f64::from(*z));
            let new = (self.linear * old).normalize_or_zero().as_vec3();
            // So that the image of a mirrored surface is mirrored.
            [*x, *y, *z, *w] = [new.x, new.y, new.z, *w * sign as f32];
        }
        if mirrored {
            mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
    }
}

/// Returns sine and cosine, exact at multiples of 90 degrees.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let (sin, cos) = libm::sincos((degrees - 90.0 * quarters).to_radians());
    match quarters.rem_euclid(4.0) as u32 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

#[cfg(test)]
mod tests;
