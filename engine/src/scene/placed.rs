//! The points of placed meshes, in world space.

use super::{Transform, TriangleMesh};
use crate::math::{AXES, Aabb, spread_directions};
use glam::Vec3;
use rayon::prelude::*;
use std::borrow::Cow;

/// If meshes have more placed points than this, the corners of their boxes replace them: a point takes some nanoseconds.
const MOST_POINTS: usize = 1 << 23;

/// The points that a thread takes at a time.
const PIECE: usize = 1 << 14;

/// A mesh and its placements.
#[derive(Clone, Copy, Debug)]
pub struct PlacedMesh<'a> {
    /// The mesh; only its positions are used.
    pub mesh: &'a TriangleMesh,
    /// The placements.
    pub placements: &'a [Transform],
}

impl<'a> PlacedMesh<'a> {
    /// Returns a mesh placed once, by the identity.
    #[must_use]
    pub fn in_place(mesh: &'a TriangleMesh) -> Self {
        Self {
            mesh,
            placements: &[Transform::IDENTITY],
        }
    }

    /// Returns the box around all placements of meshes, slightly enlarged if they have more than 2^23 placed points.
    #[must_use]
    pub fn bounds(meshes: &[Self]) -> Aabb {
        Points::of(meshes).fold(
            || Aabb::EMPTY,
            |bounds, point| bounds.union(Aabb::around([point])),
            Aabb::union,
        )
    }

    /// Returns the points of meshes that are farthest along each axis and along 122 directions that are spread evenly over
    /// a sphere: nearly as far as all points along any direction.
    #[must_use]
    pub fn extremes(meshes: &[Self]) -> Vec<Vec3> {
        let directions = [&AXES[..], &spread_directions::<{ DIRECTIONS - AXES.len() }>()].concat();
        // Of several farthest points the same one, whatever their order.
        let key = |(reach, p): &(f32, Vec3)| [*reach, p.x, p.y, p.z].map(|number| number + 0.0);
        let farther = |a: (f32, Vec3), b: (f32, Vec3)| if key(&b) > key(&a) { b } else { a };
        let farthest = Points::of(meshes).fold(
            || [(f32::NEG_INFINITY, Vec3::ZERO); DIRECTIONS],
            |mut farthest, point| {
                for (most, direction) in farthest.iter_mut().zip(&directions) {
                    let reach = direction.dot(point);
                    if reach >= most.0 {
                        *most = farther(*most, (reach, point));
                    }
                }
                farthest
            },
            |a, b| std::array::from_fn(|i| farther(a[i], b[i])),
        );
        let found = farthest.into_iter().filter(|(reach, _)| reach.is_finite());
        found.map(|(_, point)| point).collect()
    }

    /// Returns whether any placed point of meshes passes a test.
    #[doc(hidden)]
    pub fn any(meshes: &[Self], test: impl Fn(Vec3) -> bool + Sync + Send) -> bool {
        Points::of(meshes).fold(|| false, |any, point| any || test(point), |a, b| a || b)
    }
}

/// How many directions [`PlacedMesh::extremes`] takes: both of each axis, and others.
const DIRECTIONS: usize = 128;

/// The coordinates of a mesh.
type Columns<'a> = [Cow<'a, [f32]>; 3];

/// All placed points of meshes, each rounded as if the mesh were baked.
pub(super) struct Points<'a> {
    meshes: Vec<(Columns<'a>, &'a [Transform])>,
    /// Whether they are the corners of boxes, because there are too many points.
    pub(super) are_corners: bool,
}

impl<'a> Points<'a> {
    pub(super) fn of(meshes: &[PlacedMesh<'a>]) -> Self {
        Self::with_most(meshes, MOST_POINTS)
    }

    fn with_most(meshes: &[PlacedMesh<'a>], most: usize) -> Self {
        let counts = meshes
            .iter()
            .map(|placed| placed.mesh.x.len().saturating_mul(placed.placements.len()));
        let are_corners = counts.fold(0, usize::saturating_add) > most
            && meshes.iter().any(|placed| placed.placements.len() > 1);
        let positions = |placed: &PlacedMesh<'a>| {
            let TriangleMesh { x, y, z, .. } = placed.mesh;
            let points = if are_corners && placed.placements.len() > 1 {
                corners(placed.mesh).map(|column| Cow::Owned(column.to_vec()))
            } else {
                [x, y, z].map(|column| Cow::Borrowed(&column[..]))
            };
            (points, placed.placements)
        };
        Self {
            meshes: meshes.iter().map(positions).collect(),
            are_corners,
        }
    }

    /// Folds all points from `start`, in pieces on all threads, and joins the results, which must not depend on the order.
    pub(super) fn fold<T: Send>(
        &self,
        start: impl Fn() -> T + Sync + Send,
        add: impl Fn(T, Vec3) -> T + Sync + Send,
        join: impl Fn(T, T) -> T + Sync + Send,
    ) -> T {
        let mut all = start();
        for (columns, placements) in &self.meshes {
            let count = columns[0].len();
            let total = count * placements.len();
            let piece = |number: usize| {
                let (mut sum, mut next) = (start(), number * PIECE);
                let end = total.min(next + PIECE);
                while next < end {
                    let (placement, first) = (&placements[next / count], next % count);
                    let range = first..count.min(first + end - next);
                    next += range.len();
                    sum = each_placed(columns, range, placement, sum, &add);
                }
                sum
            };
            let pieces = (0..total.div_ceil(PIECE)).into_par_iter();
            all = join(all, pieces.map(piece).reduce(&start, &join));
        }
        all
    }
}

/// Visits some points of a mesh in one of its placements.
fn each_placed<T>(
    [x, y, z]: &[Cow<'_, [f32]>; 3],
    range: std::ops::Range<usize>,
    placement: &Transform,
    sum: T,
    add: impl Fn(T, Vec3) -> T,
) -> T {
    let points = x[range.clone()].iter().zip(&y[range.clone()]).zip(&z[range]);
    let points = points.map(|((&x, &y), &z)| Vec3::new(x, y, z));
    if *placement == Transform::IDENTITY {
        points.fold(sum, add)
    } else {
        points.fold(sum, |sum, point| add(sum, placement.point(point)))
    }
}

/// The corners of the box around a mesh.
fn corners(mesh: &TriangleMesh) -> [[f32; 8]; 3] {
    let Aabb { lower, upper } = PlacedMesh::bounds(&[PlacedMesh::in_place(mesh)]);
    let corner = |axis: usize| {
        std::array::from_fn(|i| {
            if i >> axis & 1 == 0 {
                lower[axis]
            } else {
                upper[axis]
            }
        })
    };
    [corner(0), corner(1), corner(2)]
}

#[cfg(test)]
mod tests;
