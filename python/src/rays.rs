//! The rays of a call.

use crate::{
    arrays::{RayEnds, Vectors, part, part_of_all, part_of_ends},
    shared::raised,
};
use octray::{
    QueryError,
    query::{Ends, Points, Rays},
};
use pyo3::prelude::*;
use std::ops::Range;

/// Rays and their ends.
pub struct AskedRays<'a> {
    origins: Points<'a>,
    directions: Points<'a>,
    t_min: Ends<'a>,
    t_max: Ends<'a>,
}

impl AskedRays<'_> {
    pub fn len(&self) -> usize {
        self.directions.len()
    }

    pub fn part(&self, range: &Range<usize>) -> Result<Rays<'_>, QueryError> {
        Rays::from_arrays(part(self.origins, range), part_of_all(self.directions, range))?
            .within(part_of_ends(self.t_min, range), part_of_ends(self.t_max, range))
    }
}

/// The rays of a call.
pub fn asked<'a>(
    origins: &'a Vectors<'_>,
    directions: &'a Vectors<'_>,
    t_min: &'a RayEnds<'_>,
    t_max: &'a RayEnds<'_>,
) -> PyResult<AskedRays<'a>> {
    let rays = AskedRays {
        origins: origins.rows()?,
        directions: directions.rows()?,
        t_min: t_min.ends()?,
        t_max: t_max.ends()?,
    };
    // All lengths fit, or the error says which does not.
    let (origins, directions) = (rays.origins, rays.directions);
    Rays::from_arrays(origins, directions)
        .and_then(|all| all.within(rays.t_min, rays.t_max))
        .map_err(raised)?;
    Ok(rays)
}
