//! Vertices so far from all others that these are a dot in a picture of the whole mesh: a broken record of a scan, or a vertex
//! at 0 among map coordinates.

use super::LoadedMesh;
use crate::math::Aabb;
use glam::Vec3;
use rayon::prelude::*;

/// How much longer stray vertices make a mesh: a picture has about this many pixels.
const LEAST_RATIO: f32 = 1000.0;

/// A vertex is not stray within this many lengths of the middle half.
const REACH: f32 = 16.0;

/// At most one vertex in this many is stray.
const MOST: usize = 5;

/// The fewest vertices that are worth another thread.
const MIN_PIECE: usize = 1 << 14;

/// What there is to note about stray vertices of a mesh with these bounds, whose vertices' middle half is in `middle`.
pub(super) fn note(mesh: &LoadedMesh, whole: &Aabb, middle: &Aabb) -> Option<String> {
    let long = length(whole);
    // Nearly all meshes are done here: without stray vertices they are at least as long as the middle half.
    if long < LEAST_RATIO * length(middle) || !mesh.shared.is_empty() {
        return None;
    }
    let (center, reach) = ((middle.lower + middle.upper) * 0.5, REACH * length(middle));
    let columns = &mesh.columns;
    let points = columns.x.par_iter().zip(&columns.y).zip(&columns.z);
    let near = points.with_min_len(MIN_PIECE).filter_map(|((&x, &y), &z)| {
        let point = Vec3::new(x, y, z);
        let is_near = (point - center).abs().max_element() <= reach;
        is_near.then(|| (Aabb::around([point]), 1))
    });
    let join = |a: (Aabb, usize), b: (Aabb, usize)| (a.0.union(b.0), a.1 + b.1);
    let (others, near) = near.reduce(|| (Aabb::EMPTY, 0), join);
    let (count, without) = (columns.x.len() - near, length(&others));
    let are_few = count > 0 && count * MOST <= columns.x.len();
    if !are_few || long < LEAST_RATIO * without {
        return None;
    }
    let (vertices, them) = if count == 1 {
        ("vertex is", "it")
    } else {
        ("vertices are", "them")
    };
    Some(format!(
        "{count} {vertices} far from all others: the mesh is {long} long, but {without} without {them}, so the rest is a dot \
         in a picture of all"
    ))
}

fn length(bounds: &Aabb) -> f32 {
    (bounds.upper - bounds.lower).max_element()
}
