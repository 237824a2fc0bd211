//! Camera placement that frames a mesh.

use super::{CameraError, PlacedMesh, TriangleMesh, placed::Points};
use crate::math;
use glam::{DVec3, Vec3};
use std::f64::consts::TAU;

/// Free space around the mesh, as a share of the picture's half width and height.
const MARGIN: f64 = 0.06;

/// The placement of a camera, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Position of the camera.
    pub eye: DVec3,
    /// The point to look at, at the depth of the mesh's centre.
    pub target: DVec3,
    /// Height of the view at the target, scene units: that of an orthographic view.
    pub height: f64,
}

/// The orientation and shape of the view to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitView {
    /// From the object towards the viewer; any length.
    pub towards_viewer: DVec3,
    /// The up vector, any length.
    pub up: DVec3,
    /// Vertical field of view, degrees; `None` for an orthographic view.
    pub fov_degrees: Option<f64>,
    /// Width over height, above 0.
    pub aspect: f64,
}

impl FitView {
    /// Returns the nearest eye that sees every vertex of `mesh` with a small margin, centred in the picture.
    ///
    /// Exact: each side of the picture is a plane through the eye, so only the extents of the points along the four
    /// planes' normals matter.
    ///
    /// # Errors
    /// [`CameraError`] if these directions do not define a view.
    ///
    /// # Panics
    /// If `x`, `y` and `z` differ in length.
    pub fn fit(&self, mesh: &TriangleMesh) -> Result<Fit, CameraError> {
        self.fit_around(&[PlacedMesh::in_place(mesh)], 0.0)
    }

    /// As [`FitView::fit`], for all placements of several meshes, with a sphere of radius `reach` (scene units) around every
    /// vertex. If there are more than 2^23 placed vertices, boxes around the meshes are fitted.
    ///
    /// # Errors
    /// As [`FitView::fit`].
    pub fn fit_around(&self, meshes: &[PlacedMesh<'_>], reach: f64) -> Result<Fit, CameraError> {
        if let Some(degrees) = self.fov_degrees.filter(|fov| !(*fov > 0.0 && *fov < 180.0)) {
            return Err(CameraError::FieldOfView(degrees));
        }
        let forward = math::moderate(-self.towards_viewer)
            .try_normalize()
            .ok_or(CameraError::EyeOnTarget)?;
        let right = forward
            .cross(math::moderate(self.up))
            .try_normalize()
            .ok_or(CameraError::UpParallel)?;
        let up = right.cross(forward);
        // At a distance of 1; 0 if all rays are parallel.
        let slope = self
            .fov_degrees
            .map_or(0.0, |fov| libm::tan(fov.to_radians() * 0.5));
        let half_height = slope * (1.0 - MARGIN);
        let half_width = half_height * self.aspect;
        // Right, left, up, down, backward, forward.
        let outward = [
            right - forward * half_width,
            -right - forward * half_width,
            up - forward * half_height,
            -up - forward * half_height,
            -forward,
            forward,
        ];
        let points = Points::of(meshes);
        let Some(mut extents) = extents(&points, &outward) else {
            return Ok(Fit {
                eye: -forward,
                target: DVec3::ZERO,
                height: 1.0,
            });
        };
        for (extent, outward) in extents.iter_mut().zip(outward) {
            *extent += reach * outward.length();
        }
        let [r, l, u, d, near, far] = extents;
        // A flat mesh or a single point needs some distance too.
        let size = (r + l).max(u + d).max(near + far);
        let least = if size > 0.0 { size } else { 1.0 } * 1e-9;
        let gap = (0.01 * (near + far)).max(1e-6 * near.abs()).max(least);
        let parallel_height = (u + d).max((r + l) / self.aspect).max(gap) / (1.0 - MARGIN);
        // In the frame (right, up, forward), the eye must be behind both planes of each pair.
        let depths = match self.fov_degrees {
            Some(_) => [-(r + l) / (2.0 * half_width), -(u + d) / (2.0 * half_height)],
            None => [-near - parallel_height; 2],
        };
        let depth = depths[0].min(depths[1]).min(-near - gap);
        let sides = [(right, [r, l], half_width), (up, [u, d], half_height)];
        let mut eye = forward * depth;
        for ((side, [most, least], half), own) in sides.into_iter().zip(depths) {
            // Both planes touch the points only at their own depth.
            let middle = if own > depth && half > 0.0 {
                middle_of_view(&points, [side, forward], depth, reach, half)
            } else {
                (most - least) * 0.5
            };
            eye += side * middle;
        }
        let distance = (far - near) * 0.5 - depth;
        Ok(Fit {
            eye,
            target: eye + forward * distance,
            height: match self.fov_degrees {
                Some(_) => 2.0 * slope * distance,
                None => parallel_height,
            },
        })
    }

    /// As [`FitView::fit_around`], for a turntable: every vertex stays visible while the camera turns about the up axis
    /// through the target, which is on the axis through the middle of the meshes' box.
    ///
    /// # Errors
    /// As [`FitView::fit`].
    pub fn fit_turning_around(&self, meshes: &[PlacedMesh<'_>], reach: f64) -> Result<Fit, CameraError> {
        let axis = math::moderate(self.up)
            .try_normalize()
            .ok_or(CameraError::UpParallel)?;
        let (middle, rings) = swept_rings(axis, meshes);
        let fit = self.fit_around(&[PlacedMesh::in_place(&rings)], reach)?;
        // The target is where the line of sight meets the axis.
        let forward = (fit.target - fit.eye).normalize();
        let (slope, arm) = (axis.dot(forward), fit.eye - middle);
        let along = (slope * axis.dot(arm) - forward.dot(arm)) / (1.0 - slope * slope);
        if along.is_nan() || along <= 0.0 {
            return Ok(fit);
        }
        let height = axis.dot(fit.eye + forward * along - middle);
        let target = middle + axis * height;
        Ok(Fit { target, ..fit })
    }
}

impl FitView {
    /// As [`FitView::fit_around`], for a camera that may be anywhere on a sphere around the target, the middle of the meshes'
    /// box.
    ///
    /// # Errors
    /// As [`FitView::fit`].
    pub fn fit_sphere_around(&self, meshes: &[PlacedMesh<'_>], reach: f64) -> Result<Fit, CameraError> {
        let (middle, sphere) = bounding_sphere(meshes);
        let fit = self.fit_around(&[PlacedMesh::in_place(&sphere)], reach)?;
        // The points are almost symmetrical.
        Ok(Fit {
            eye: fit.eye + middle - fit.target,
            target: middle,
            ..fit
        })
    }
}

/// Returns the middle of the meshes' box and points around the sphere that contains them.
fn bounding_sphere(meshes: &[PlacedMesh<'_>]) -> (DVec3, TriangleMesh) {
    const ROWS: usize = 48;
    let mut sphere = TriangleMesh::default();
    let points = Points::of(meshes);
    let Some(middle) = middle_of_box(&points) else {
        return (DVec3::ZERO, sphere);
    };
    let radius = points.fold(
        || 0.0_f64,
        |most, point| most.max((point.as_dvec3() - middle).length()),
        f64::max,
    );
    // The polyhedron circumscribes the sphere: its faces are half a step away from their corners in both directions.
    let step = std::f64::consts::PI / ROWS as f64;
    let radius = radius / libm::cos(0.5 * step).powi(2);
    for row in 0..=ROWS {
        let (out, height) = libm::sincos(step * row as f64);
        for column in 0..2 * ROWS {
            let (sin, cos) = libm::sincos(step * column as f64);
            let point = middle + DVec3::new(out * cos, out * sin, height) * radius;
            sphere.x.push(point.x as f32);
            sphere.y.push(point.y as f32);
            sphere.z.push(point.z as f32);
        }
    }
    (middle, sphere)
}

/// Returns the middle of the points' box; `None` without points.
fn middle_of_box(points: &Points<'_>) -> Option<DVec3> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let [x, y, z, left, front, bottom] = extents(points, &axes)?;
    Some(DVec3::new(x - left, y - front, z - bottom) * 0.5)
}

/// Bounds the volume that meshes sweep when they turn about the centre of their box. Returns the centre and the corners of
/// polygonal rings around the volume.
fn swept_rings(axis: DVec3, meshes: &[PlacedMesh<'_>]) -> (DVec3, TriangleMesh) {
    const SLICES: usize = 64;
    const CORNERS: usize = 96;
    let mut rings = TriangleMesh::default();
    let points = Points::of(meshes);
    let Some(middle) = middle_of_box(&points) else {
        return (DVec3::ZERO, rings);
    };
    let height_and_radius = |point: Vec3| {
        let arm = point.as_dvec3() - middle;
        let height = axis.dot(arm);
        (height, (arm - axis * height).length())
    };
    let ends = points.fold(
        || [f64::INFINITY, f64::NEG_INFINITY],
        |[low, high], point| {
            let (height, _) = height_and_radius(point);
            [low.min(height), high.max(height)]
        },
        |[a, b], [c, d]| [a.min(c), b.max(d)],
    );
    let step = ((ends[1] - ends[0]) / SLICES as f64).max(f64::MIN_POSITIVE);
    let mut widest = points.fold(
        || [0.0_f64; SLICES],
        |mut widest, point| {
            let (height, radius) = height_and_radius(point);
            let slice = ((height - ends[0]) / step) as usize;
            if let Some(most) = widest.get_mut(slice.min(SLICES - 1)) {
                *most = most.max(radius);
            }
            widest
        },
        |a, b| std::array::from_fn(|i| a[i].max(b[i])),
    );
    if points.are_corners {
        // A box is in slices between its corners, too.
        widest = [widest.into_iter().fold(0.0, f64::max); SLICES];
    }
    let side = axis.any_orthonormal_vector();
    let other = axis.cross(side);
    // The polygon circumscribes the circle.
    let corner = TAU / CORNERS as f64;
    let outside = 1.0 / libm::cos(0.5 * corner);
    for (slice, radius) in widest.into_iter().enumerate() {
        for end in [slice, slice + 1] {
            for i in 0..CORNERS {
                let (sin, cos) = libm::sincos(corner * i as f64);
                let out = (side * cos + other * sin) * radius * outside;
                let point = middle + axis * (ends[0] + step * end as f64) + out;
                rings.x.push(point.x as f32);
                rings.y.push(point.y as f32);
                rings.z.push(point.z as f32);
            }
        }
    }
    (middle, rings)
}

/// Returns the eye's place along a side of the picture, at this depth, from which the points reach equally far to both ends.
/// `axes` are the side and the forward axis; `slope` is the half side at a distance of 1, with room to spare.
///
/// The slope at which both ends touch the points is the zero of a convex function, which Newton's method finds in a few
/// passes.
fn middle_of_view(points: &Points<'_>, axes: [DVec3; 2], depth: f64, reach: f64, mut slope: f64) -> f64 {
    const MOST_PASSES: usize = 16;
    let mut middle = 0.0;
    for _ in 0..MOST_PASSES {
        let [(most, at_most), (least, at_least)] = touching(points, axes, slope);
        middle = (most - least) * 0.5;
        let length = (1.0 + slope * slope).sqrt();
        let excess = most + least + 2.0 * (slope * depth + reach * length);
        let rate = 2.0 * (depth + reach * slope / length) - at_most - at_least;
        let next = (slope - excess / rate).max(0.0);
        if next.is_nan() || (next - slope).abs() <= 1e-9 * slope {
            break;
        }
        slope = next;
    }
    middle
}

/// Returns the extent of the points along the normals of both planes of a slope, and the depth of a point that reaches it.
fn touching(points: &Points<'_>, [side, forward]: [DVec3; 2], slope: f64) -> [(f64, f64); 2] {
    // Among points on the plane the deepest counts, so their order does not matter.
    let farther = |a: (f64, f64), b: (f64, f64)| if b > a { b } else { a };
    points.fold(
        || [(f64::NEG_INFINITY, f64::NEG_INFINITY); 2],
        |[most, least], point| {
            let point = point.as_dvec3();
            let (across, depth) = (side.dot(point), forward.dot(point));
            [
                farther(most, (across - slope * depth, depth)),
                farther(least, (-across - slope * depth, depth)),
            ]
        },
        |[a, b], [c, d]| [farther(a, c), farther(b, d)],
    )
}

/// Returns the extent of the points along each direction; `None` without points.
fn extents(points: &Points<'_>, directions: &[DVec3; 6]) -> Option<[f64; 6]> {
    let reach = points.fold(
        || [f64::NEG_INFINITY; 6],
        |mut reach, point| {
            let point = point.as_dvec3();
            for (most, direction) in reach.iter_mut().zip(directions) {
                *most = most.max(direction.dot(point));
            }
            reach
        },
        |a, b| std::array::from_fn(|i| a[i].max(b[i])),
    );
    reach[0].is_finite().then_some(reach)
}

#[cfg(test)]
mod tests;
