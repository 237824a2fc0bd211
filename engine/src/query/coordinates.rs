//! Stored coordinates: in `f32`, checked, relative to the centre of geometry that is far from 0.

use super::{Points, QueryError, geometry::Sphere};
use crate::scene::{MAX_COORDINATE, MaterialId, Scene, SceneBuilder, TriangleMesh};
use glam::DVec3;

/// Returns a scene of triangles and spheres, and the point that its coordinates are relative to before its own origin.
pub(super) fn scene_of(
    positions: Points<'_>,
    triangles: &[[u32; 3]],
    spheres: &[Sphere],
) -> Result<(Scene, DVec3), QueryError> {
    let offset = offset_of(positions, spheres);
    let [x, y, z] = columns(positions, offset)?;
    let mut builder = SceneBuilder::new();
    let mesh = TriangleMesh {
        x,
        y,
        z,
        normals: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: copied(triangles, "the triangles")?,
    };
    builder.add_mesh(mesh, MaterialId(0))?;
    for (i, sphere) in spheres.iter().enumerate() {
        let center = DVec3::from(sphere.center);
        for (relative, value) in (center - offset).to_array().into_iter().zip(sphere.center) {
            check_coordinate("sphere", i, relative, value)?;
        }
        if !(sphere.radius > 0.0 && sphere.radius <= MAX_COORDINATE) {
            return Err(QueryError::Radius {
                sphere: i,
                radius: sphere.radius,
            });
        }
        builder.add_sphere((center - offset).as_vec3(), sphere.radius, MaterialId(0))?;
    }
    Ok((builder.finish(), offset))
}

/// Returns the centre on each axis on which `f64` coordinates are farther from 0 than they extend, else 0. Coordinates in
/// `f32` need no offset: the scene subtracts one without rounding.
fn offset_of(positions: Points<'_>, spheres: &[Sphere]) -> DVec3 {
    if positions.is_empty() && spheres.is_empty() {
        return DVec3::ZERO;
    }
    let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    if let Points::F64(positions) = positions {
        for &position in positions {
            let position = DVec3::from_array(position);
            (lower, upper) = (lower.min(position), upper.max(position));
        }
    } else if spheres.is_empty() {
        return DVec3::ZERO;
    } else {
        for i in 0..positions.len() {
            (lower, upper) = (lower.min(positions.get(i)), upper.max(positions.get(i)));
        }
    }
    for sphere in spheres {
        let center = DVec3::from_array(sphere.center);
        (lower, upper) = (lower.min(center), upper.max(center));
    }
    far_middle([lower, upper])
}

/// Returns the centre of a box on each axis on which it is farther from 0 than it extends, else 0.
pub(super) fn far_middle([lower, upper]: [DVec3; 2]) -> DVec3 {
    let is_far = (lower.cmpgt(DVec3::ZERO) & upper.cmple(lower * 2.0))
        | (upper.cmplt(DVec3::ZERO) & lower.cmpge(upper * 2.0));
    DVec3::select(is_far, lower * 0.5 + upper * 0.5, DVec3::ZERO)
}

/// Checks a coordinate relative to the centre; `value` is the original one.
fn check_coordinate(what: &'static str, index: usize, relative: f64, value: f64) -> Result<(), QueryError> {
    if relative.abs() <= f64::from(MAX_COORDINATE) {
        Ok(())
    } else {
        Err(QueryError::Coordinate { what, index, value })
    }
}

/// Returns the coordinates relative to a point, in `f32`, checked.
fn columns(positions: Points<'_>, middle: DVec3) -> Result<[Vec<f32>; 3], QueryError> {
    let mut columns = [Vec::new(), Vec::new(), Vec::new()];
    for column in &mut columns {
        reserve(column, positions.len(), "the vertices")?;
    }
    for i in 0..positions.len() {
        let position = positions.get(i);
        let relative = (position - middle).to_array();
        for (axis, column) in columns.iter_mut().enumerate() {
            check_coordinate("vertex", i, relative[axis], position[axis])?;
            column.push(relative[axis] as f32);
        }
    }
    Ok(columns)
}

fn reserve<T>(to: &mut Vec<T>, count: usize, what: &'static str) -> Result<(), QueryError> {
    to.try_reserve_exact(count)
        .map_err(|_| QueryError::NoMemory { what })
}

pub(super) fn copied<T: Copy>(items: &[T], what: &'static str) -> Result<Vec<T>, QueryError> {
    let mut copied = Vec::new();
    reserve(&mut copied, items.len(), what)?;
    copied.extend_from_slice(items);
    Ok(copied)
}
