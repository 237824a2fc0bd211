//! All hits of rays, as columns.

use crate::arrays::{make_room, room};
use octray::{Geometry, QueryError, query::Rays, ray::PrimitiveId};

/// Rays, triangles and distances of hits.
pub type HitColumns = (Vec<i64>, Vec<i64>, Vec<f32>);

/// Rays of which all hits are found between two checks for Ctrl-C: where thousands of triangles overlap, each takes
/// milliseconds.
pub const STEP: usize = 1 << 5;

/// Which hits a call wants.
pub struct AllWanted {
    pub limit: Option<usize>,
    pub crossings: bool,
    pub starts: bool,
    /// One triangle of those at the same edge or vertex.
    pub once: bool,
}

impl AllWanted {
    /// Appends the hits of a few rays, `first` and those after it. They are one task of the library, on this thread.
    pub fn append(
        &self,
        geometry: &Geometry,
        rays: Rays<'_>,
        first: usize,
        to: &mut HitColumns,
    ) -> Result<(), QueryError> {
        let trace = || match (self.crossings, self.starts) {
            (true, _) => geometry.crossings_each(rays),
            (false, true) => geometry.exact_hits_each(rays, self.limit, self.once),
            (false, false) => geometry.all_hits_each(rays, self.limit),
        };
        let (all, at_start) = if self.starts {
            geometry.with_starts(rays, self.once, trace)
        } else {
            (trace(), Vec::new())
        };
        let count = all.hits.len() + at_start.len();
        make_room(&mut to.0, count)?;
        make_room(&mut to.1, count)?;
        make_room(&mut to.2, count)?;
        let mut at_start = at_start.into_iter().peekable();
        for i in 0..rays.len() {
            let own = std::iter::from_fn(|| at_start.next_if(|&(ray, _)| ray == i));
            let own: Vec<(PrimitiveId, f32)> = own.map(|(_, triangle)| (triangle, 0.0)).collect();
            let rest = all.of_ray(i).iter().map(|hit| (hit.primitive, hit.t));
            for (triangle, t) in own.into_iter().chain(rest).take(self.limit.unwrap_or(usize::MAX)) {
                to.0.push((first + i) as i64);
                to.1.push(id_of(triangle));
                to.2.push(t);
            }
        }
        Ok(())
    }
}

/// The hits of all parts.
pub fn joined(parts: Vec<HitColumns>) -> Result<HitColumns, QueryError> {
    let count = parts.iter().map(|part| part.0.len()).sum();
    let (mut ray, mut triangle, mut t) = (room(count)?, room(count)?, room(count)?);
    for part in parts {
        ray.extend(part.0);
        triangle.extend(part.1);
        t.extend(part.2);
    }
    Ok((ray, triangle, t))
}

pub fn id_of(primitive: PrimitiveId) -> i64 {
    if primitive == PrimitiveId::NONE {
        -1
    } else {
        i64::from(primitive.0)
    }
}
