//! Files without faces: their vertices become spheres, and the lines between them tubes.

use super::tubes;
use crate::{
    error::SceneError,
    scene::{MaterialId, SceneBuilder, SphereCloud, TriangleMesh},
};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The number of points whose neighbours are searched: each is compared with all points.
// Tuned: see docs/lab-notes.md#point-spacing
const SAMPLES: usize = 128;

/// The neighbour whose distance is used. In a grid the third is as near as the first; among random points the first is often
/// much nearer than most others.
const NEIGHBOUR: usize = 3;

/// Radius of the spheres relative to that distance: on a square grid they overlap and leave only small gaps.
const RADIUS: f32 = 0.65;

/// Radius of points without neighbours, scene units.
const ALONE: f32 = 0.5;

/// Radius of lines, in diagonals of the box around them.
const LINES: f64 = 1.0 / 400.0;

/// How many points a thread compares with all samples: they stay in its cache.
const PIECE: usize = 1 << 12;

/// How many distances are computed before their least is looked at.
const BLOCK: usize = 64;

/// Vertices without faces: points, or ends of lines.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cloud {
    /// Radius of the points and lines, scene units; `None` for that of [`Cloud::radius`].
    pub radius: Option<f32>,
    /// The segments of lines: the vertices at their ends, 0-based. Empty if each vertex is a point.
    pub lines: Vec<[u32; 2]>,
}

impl Cloud {
    /// Returns the radius of points and lines: as set, else from the positions, the same on every machine and any number of
    /// threads.
    ///
    /// With lines, it is 1/400 of the diagonal of the box around these. Of points, and if no line has a length, it is 0.65
    /// times the median distance to the third nearest neighbour (the nearest, if there are fewer) over 128 of them. Points at
    /// the same position are no neighbours. Points that are all at one position get 0.5, or 1/1000 of their largest coordinate.
    #[must_use]
    pub fn radius(&self, points: &TriangleMesh) -> f32 {
        let of_lines = || Some((LINES * self.diagonal(points)) as f32).filter(|radius| *radius > 0.0);
        let of_points = || spacing(points).map(|distance| RADIUS * distance);
        let found = || of_lines().or_else(of_points);
        self.radius.or_else(found).unwrap_or_else(|| alone(points))
    }

    /// The diagonal of the box around the lines; 0 without lines. Other points do not count: one far away would make the
    /// lines thick.
    fn diagonal(&self, points: &TriangleMesh) -> f64 {
        let ends = || self.lines.iter().flatten();
        let length = |column: &[f32]| {
            let values = ends().filter_map(|&end| column.get(end as usize));
            let [low, high] = values.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &x| {
                [low.min(x), high.max(x)]
            });
            (f64::from(high) - f64::from(low)).max(0.0)
        };
        DVec3::from([&points.x, &points.y, &points.z].map(|column| length(column))).length()
    }

    /// Adds spheres at the vertices, which are moved, and prisms around the lines to a scene. Other arrays are dropped.
    pub(super) fn add_to(
        self,
        points: TriangleMesh,
        builder: &mut SceneBuilder,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let each = self.radius(&points);
        let count = tubes::count(&points, &self.lines)?;
        let mut prisms = None;
        if count > 0 {
            let vertices = count.saturating_mul(tubes::VERTICES);
            let vectors = if points.colors.is_empty() { 1 } else { 2 };
            let counts = [count.saturating_mul(tubes::TRIANGLES), points.x.len(), vertices];
            builder.check_room(counts, vertices.saturating_mul(vectors))?;
            prisms = Some(tubes::prisms(&points, &self.lines, each, count)?);
        }
        drop(self.lines);
        builder.add_spheres(spheres(points, each)?, material)?;
        prisms.map_or(Ok(()), |prisms| builder.add_mesh_without_edges(prisms, material))
    }
}

/// Makes spheres of the vertices, which are moved.
fn spheres(points: TriangleMesh, each: f32) -> Result<SphereCloud, SceneError> {
    let TriangleMesh { x, y, z, colors, .. } = points;
    let mut radius = Vec::new();
    let reserved = radius.try_reserve_exact(x.len());
    reserved.map_err(|_| SceneError::NoMemory { what: "spheres" })?;
    radius.resize(x.len(), each);
    Ok(SphereCloud {
        x,
        y,
        z,
        radius,
        colors,
    })
}

/// The radius of points without neighbours: large enough that rounding leaves a sphere.
fn alone(points: &TriangleMesh) -> f32 {
    let position = |i: usize| Some(Vec3::new(*points.x.get(i)?, *points.y.get(i)?, *points.z.get(i)?));
    ALONE.max(position(0).map_or(0.0, |p| p.abs().max_element()) / 1000.0)
}

/// The median distance to the neighbours of evenly chosen points; `None` if none has a neighbour.
fn spacing(points: &TriangleMesh) -> Option<f32> {
    let count = points.x.len().min(points.y.len()).min(points.z.len());
    let samples: Vec<[f32; 3]> = (0..count.min(SAMPLES))
        .map(|i| (i as u64 * count as u64 / count.min(SAMPLES) as u64) as usize)
        .map(|i| [points.x[i], points.y[i], points.z[i]])
        .collect();
    let columns = (
        points.x.par_chunks(PIECE),
        points.y.par_chunks(PIECE),
        points.z.par_chunks(PIECE),
    );
    // The least of all distances do not depend on their order.
    let none = || vec![Nearest::NONE; samples.len()];
    let nearest = columns
        .into_par_iter()
        .fold(none, |mut nearest, (x, y, z)| {
            for (nearest, &sample) in nearest.iter_mut().zip(&samples) {
                nearest.add_points(sample, x, y, z);
            }
            nearest
        })
        .reduce(none, |mut a, b| {
            for (nearest, other) in a.iter_mut().zip(b) {
                other.0.into_iter().for_each(|squared| nearest.add(squared));
            }
            a
        });
    let mut distances: Vec<f32> = nearest.iter().filter_map(Nearest::squared).collect();
    if distances.is_empty() {
        return None;
    }
    let middle = distances.len() / 2;
    let (_, median, _) = distances.select_nth_unstable_by(middle, f32::total_cmp);
    Some(median.sqrt())
}

/// The squares of the least distances so far, ascending; infinite until there are enough.
#[derive(Clone, Copy)]
struct Nearest([f32; NEIGHBOUR]);

impl Nearest {
    const NONE: Self = Self([f32::INFINITY; NEIGHBOUR]);

    /// The square of the distance that counts.
    fn squared(&self) -> Option<f32> {
        let [first, .., last] = self.0;
        [last, first].into_iter().find(|squared| squared.is_finite())
    }

    fn add(&mut self, mut squared: f32) {
        for least in &mut self.0 {
            if squared < *least {
                std::mem::swap(least, &mut squared);
            }
        }
    }

    /// Adds the distances from a position to all points that are not at it.
    fn add_points(&mut self, [px, py, pz]: [f32; 3], x: &[f32], y: &[f32], z: &[f32]) {
        let blocks = x.chunks(BLOCK).zip(y.chunks(BLOCK)).zip(z.chunks(BLOCK));
        for ((x, y), z) in blocks {
            let mut squared = [f32::INFINITY; BLOCK];
            for (((squared, x), y), z) in squared.iter_mut().zip(x).zip(y).zip(z) {
                let (dx, dy, dz) = (x - px, y - py, z - pz);
                let distance = dx * dx + dy * dy + dz * dz;
                *squared = if distance > 0.0 { distance } else { f32::INFINITY };
            }
            let [.., last] = self.0;
            // A minimum, not `any`, so that the loop vectorises.
            let least = squared.iter().fold(
                f32::INFINITY,
                |least, &next| if next < least { next } else { least },
            );
            if least < last {
                for squared in squared {
                    self.add(squared);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
