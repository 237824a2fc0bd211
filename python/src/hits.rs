//! All hits of rays, as columns.

use crate::arrays::make_room;
use octray::{Geometry, InstancedGeometry, QueryError, query::Rays, ray::PrimitiveId};

/// Rays, instances (of scenes only), triangles and distances of hits.
#[derive(Clone, Default)]
pub struct HitColumns {
    pub ray: Vec<i64>,
    pub instance: Vec<i64>,
    pub triangle: Vec<i64>,
    pub t: Vec<f32>,
}

impl HitColumns {
    /// Makes room for `count` more hits of a mesh.
    fn make_room(&mut self, count: usize) -> Result<(), QueryError> {
        make_room(&mut self.ray, count)?;
        make_room(&mut self.triangle, count)?;
        make_room(&mut self.t, count)
    }
}

/// Appends the hits of a few rays in a scene, `first` and those after it. They are one task of the library, on this thread.
pub fn append_placed(
    geometry: &InstancedGeometry,
    (rays, limit): (Rays<'_>, Option<usize>),
    first: usize,
    to: &mut HitColumns,
) -> Result<(), QueryError> {
    let all = geometry.all_hits_each(rays, limit);
    to.make_room(all.hits.len())?;
    make_room(&mut to.instance, all.hits.len())?;
    for i in 0..rays.len() {
        for hit in all.of_ray(i) {
            to.ray.push((first + i) as i64);
            to.instance.push(hit.instance.0.into());
            to.triangle.push(hit.primitive.0.into());
            to.t.push(hit.t);
        }
    }
    Ok(())
}

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
        to.make_room(count)?;
        let mut at_start = at_start.into_iter().peekable();
        for i in 0..rays.len() {
            let own = std::iter::from_fn(|| at_start.next_if(|&(ray, _)| ray == i));
            let own: Vec<(PrimitiveId, f32)> = own.map(|(_, triangle)| (triangle, 0.0)).collect();
            let rest = all.of_ray(i).iter().map(|hit| (hit.primitive, hit.t));
            for (triangle, t) in own.into_iter().chain(rest).take(self.limit.unwrap_or(usize::MAX)) {
                to.ray.push((first + i) as i64);
                to.triangle.push(id_of(triangle));
                to.t.push(t);
            }
        }
        Ok(())
    }
}

/// The hits of all parts.
pub fn joined(parts: Vec<HitColumns>) -> Result<HitColumns, QueryError> {
    let mut all = HitColumns::default();
    all.make_room(parts.iter().map(|part| part.t.len()).sum())?;
    make_room(
        &mut all.instance,
        parts.iter().map(|part| part.instance.len()).sum(),
    )?;
    for part in parts {
        all.ray.extend(part.ray);
        all.instance.extend(part.instance);
        all.triangle.extend(part.triangle);
        all.t.extend(part.t);
    }
    Ok(all)
}

pub fn id_of(primitive: PrimitiveId) -> i64 {
    if primitive == PrimitiveId::NONE {
        -1
    } else {
        i64::from(primitive.0)
    }
}
