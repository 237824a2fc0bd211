//! All hits of many rays.

use super::{
    Rays,
    exact::GivenLine,
    rays::EightRays,
    unit::{UnitPacket, UnitRay},
};
use crate::{
    lanes::LANES,
    ray::Hit,
    simd::{Level, at_level},
};
use glam::DVec3;
use rayon::prelude::*;

/// Rays per task when all hits are found.
const RAYS: usize = 256;

/// All hits of many rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AllHits<H = Hit> {
    /// The hits, ray by ray, each in order of t, then instance, if there are any, then primitive.
    pub hits: Vec<H>,
    /// Where the hits of each ray begin, and finally where the last ones end: one entry more than rays.
    pub starts: Vec<usize>,
}

impl<H> AllHits<H> {
    /// Returns the hits of ray `i`.
    ///
    /// # Panics
    /// If there is no such ray.
    #[must_use]
    pub fn of_ray(&self, i: usize) -> &[H] {
        &self.hits[self.starts[i]..self.starts[i + 1]]
    }
}

impl<H: Send> AllHits<H> {
    /// Calls `append` for each ray, as the kernels and as the caller have it, with the hits of those before.
    pub(super) fn of_each(
        rays: Rays<'_>,
        (level, middle): (Level, DVec3),
        append: impl Fn(UnitRay, GivenLine, Vec<H>) -> Vec<H> + Sync,
    ) -> Self {
        let pieces: Vec<usize> = (0..rays.len()).step_by(RAYS).collect();
        let found: Vec<(Vec<H>, Vec<usize>)> = pieces
            .into_par_iter()
            .map(|start| {
                let end = rays.len().min(start + RAYS);
                let (mut hits, mut ends) = (Vec::new(), Vec::with_capacity(end - start));
                let mut eight = EightRays::ZERO;
                for i in (start..end).step_by(LANES) {
                    at_level!(level, |simd| rays.eight(simd, i, &mut eight));
                    let units = UnitPacket::new(&eight, middle);
                    for lane in 0..LANES.min(end - i) {
                        hits = append(units.ray(lane), eight.line(lane), hits);
                        ends.push(hits.len());
                    }
                }
                (hits, ends)
            })
            .collect();
        let mut all = Self {
            hits: Vec::with_capacity(found.iter().map(|(hits, _)| hits.len()).sum()),
            starts: Vec::with_capacity(rays.len() + 1),
        };
        all.starts.push(0);
        for (hits, ends) in found {
            let before = all.hits.len();
            all.hits.extend(hits);
            all.starts.extend(ends.into_iter().map(|end| before + end));
        }
        all
    }
}
