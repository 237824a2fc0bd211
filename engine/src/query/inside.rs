//! Inside tests of a closed mesh: the parity of exact crossings on the way to the nearest side of its bounding box.

use super::{QueryError, sinks::Crossings, unit::UnitRay};
use crate::{
    accel::Bvh,
    scene::{Scene, weld},
    simd::Level,
    trace::visit,
};
use glam::DVec3;
use rayon::prelude::*;

/// Checks that every edge belongs to an even number of triangles, so that all rays from a point have the same parity.
pub(super) fn check_closed(scene: &Scene) -> Result<(), QueryError> {
    if !scene.spheres().radius.is_empty() {
        return Err(QueryError::HasSpheres);
    }
    let vertices = scene.vertices();
    let first = weld(&vertices.x, &vertices.y, &vertices.z);
    let mut edges: Vec<u64> = scene
        .triangles()
        .corners
        .par_iter()
        .flat_map_iter(|corners| {
            let [a, b, c] = corners.map(|vertex| first[vertex as usize]);
            [(a, b), (b, c), (c, a)]
        })
        .filter(|(a, b)| a != b)
        .map(|(a, b)| u64::from(a.min(b)) << 32 | u64::from(a.max(b)))
        .collect();
    edges.par_sort_unstable();
    match edges.chunk_by(|a, b| a == b).find(|same| same.len() % 2 != 0) {
        Some(open) => Err(QueryError::NotClosed {
            edge: [(open[0] >> 32) as u32, open[0] as u32],
        }),
        None => Ok(()),
    }
}

/// Tilt of the directions to the six sides, because many models have edges along the axes.
const ASIDE: [f64; 2] = [0.013_579_1, 0.007_313_7];

/// Returns whether a point, relative to the scene's origin, is inside. The mesh is closed.
pub(super) fn contains(level: Level, bvh: &Bvh, point: DVec3) -> bool {
    let bounds = bvh.bounds();
    let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
    if !(point.cmpge(lower).all() && point.cmple(upper).all()) {
        return false;
    }
    let ways = [upper - point, point - lower];
    let (mut shortest, mut axis, mut sign) = (f64::INFINITY, 0, 1.0);
    for (way, to) in ways.into_iter().zip([1.0, -1.0]) {
        for (i, way) in way.to_array().into_iter().enumerate() {
            if way < shortest {
                (shortest, axis, sign) = (way, i, to);
            }
        }
    }
    let mut direction = DVec3::ZERO;
    direction[axis] = sign;
    direction[(axis + 1) % 3] = ASIDE[0];
    direction[(axis + 2) % 3] = ASIDE[1];
    let unit = UnitRay::of(point, direction, [0.0, f32::INFINITY]);
    let mut crossings = Crossings::new(unit, bvh.repeats());
    visit(level, bvh, &unit.ray, &mut crossings);
    !crossings.into_hits().len().is_multiple_of(2)
}
