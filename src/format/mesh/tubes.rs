//! Lines as tubes: each segment becomes a prism with smooth normals. Its edges have the tube's radius, so its corners lie on
//! the spheres at its ends, which close it: a larger prism would leave gaps where lines bend.

use crate::{error::SceneError, scene::TriangleMesh};
use glam::{DVec3, Vec3};
use std::f64::consts::FRAC_1_SQRT_2;

/// How many sides a prism has.
const SIDES: usize = 8;

/// How many triangles and vertices a segment becomes.
pub(in crate::format) const TRIANGLES: usize = 2 * SIDES;
pub(in crate::format) const VERTICES: usize = 2 * SIDES;

/// The directions of the edges around the axis.
const RING: [[f64; 2]; SIDES] = {
    const D: f64 = FRAC_1_SQRT_2;
    [
        [1.0, 0.0],
        [D, D],
        [0.0, 1.0],
        [-D, D],
        [-1.0, 0.0],
        [-D, -D],
        [0.0, -1.0],
        [D, -D],
    ]
};

/// The ends of the segments that have a length, and their colours.
struct Segments<'a> {
    points: &'a TriangleMesh,
    lines: &'a [[u32; 2]],
}

impl Segments<'_> {
    fn position(&self, i: u32) -> Option<DVec3> {
        let (points, i) = (self.points, i as usize);
        Some(Vec3::new(*points.x.get(i)?, *points.y.get(i)?, *points.z.get(i)?).as_dvec3())
    }

    /// The indices of the ends, their positions and the direction between them.
    fn all(&self) -> impl Iterator<Item = ([u32; 2], [DVec3; 2], DVec3)> {
        self.lines.iter().filter_map(|&ends| {
            let [a, b] = [self.position(ends[0])?, self.position(ends[1])?];
            Some((ends, [a, b], (b - a).try_normalize()?))
        })
    }
}

/// How many segments have a length.
///
/// # Errors
/// [`SceneError::LineIndex`].
pub(super) fn count(points: &TriangleMesh, lines: &[[u32; 2]]) -> Result<usize, SceneError> {
    let vertices = points.x.len();
    let is_beyond = |&index: &u32| index as usize >= vertices;
    if let Some(&index) = lines.as_flattened().iter().find(|index| is_beyond(index)) {
        return Err(SceneError::LineIndex { index, vertices });
    }
    Ok(Segments { points, lines }.all().count())
}

/// Makes prisms of `count` segments.
///
/// # Errors
/// [`SceneError::NoMemory`].
pub(super) fn prisms(
    points: &TriangleMesh,
    lines: &[[u32; 2]],
    radius: f32,
    count: usize,
) -> Result<TriangleMesh, SceneError> {
    let mut mesh = TriangleMesh::default();
    let vertices = count.saturating_mul(VERTICES);
    for column in [&mut mesh.x, &mut mesh.y, &mut mesh.z] {
        reserve(column, vertices)?;
    }
    reserve(&mut mesh.normals, vertices)?;
    let has_colors = !points.colors.is_empty();
    reserve(&mut mesh.colors, if has_colors { vertices } else { 0 })?;
    reserve(&mut mesh.triangles, count.saturating_mul(TRIANGLES))?;
    for (ends, positions, axis) in (Segments { points, lines }).all().take(count) {
        let base = mesh.x.len() as u32;
        let (u, v) = axis.any_orthonormal_pair();
        for (end, position) in ends.into_iter().zip(positions) {
            for [s, t] in RING {
                let outwards = u * s + v * t;
                let corner = (position + outwards * f64::from(radius)).as_vec3();
                mesh.x.push(corner.x);
                mesh.y.push(corner.y);
                mesh.z.push(corner.z);
                mesh.normals.push(outwards.as_vec3());
            }
            if let Some(&color) = points.colors.get(end as usize) {
                mesh.colors.extend([color; SIDES]);
            }
        }
        for i in 0..SIDES as u32 {
            let next = (i + 1) % SIDES as u32;
            let [a, b, c, d] = [i, next, SIDES as u32 + i, SIDES as u32 + next].map(|i| base + i);
            mesh.triangles.extend([[a, b, c], [b, d, c]]);
        }
    }
    Ok(mesh)
}

fn reserve<T>(array: &mut Vec<T>, count: usize) -> Result<(), SceneError> {
    let reserved = array.try_reserve_exact(count);
    reserved.map_err(|_| SceneError::NoMemory { what: "lines" })
}

#[cfg(test)]
mod tests;
