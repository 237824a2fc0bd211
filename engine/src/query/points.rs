//! Point queries: closest point, inside or outside, signed distance.

use super::{ClosestPoint, Geometry, Points, QueryError, inside, nearest, z_order::in_z_order};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Points per task.
// Tuned: see docs/lab-notes.md#varied-constants
const POINTS: usize = 256;

/// Among fewer points per task neighbours are too far from each other for an order to pay.
// Tuned: see docs/lab-notes.md#closest-points
const FEWEST_ORDERED: usize = 1024;

/// Points that are ordered together, at most: in more points neighbours are nearer, but they need more memory.
// Tuned: see docs/lab-notes.md#closest-points
const MOST_ORDERED: usize = 65_536;

/// The flag of calls that nobody cancels.
pub(super) static NEVER: AtomicBool = AtomicBool::new(false);

impl Geometry {
    /// Finds the closest point of the geometry; of equally near primitives, the one with the lowest id. `None` if there
    /// is nothing, or the point is not finite in `f32`.
    #[must_use]
    pub fn closest_point(&self, point: impl Into<DVec3>) -> Option<ClosestPoint> {
        self.closest_near(point.into(), &mut None)
    }

    /// Begins with what is known of a point nearby, and leaves what is known of this one.
    fn closest_near(&self, point: DVec3, near: &mut Option<DVec3>) -> Option<ClosestPoint> {
        let middle = self.middle();
        let found = nearest::closest(self.level(), self.bvh(), point - middle, *near)?;
        *near = Some(found.point);
        Some(ClosestPoint {
            point: found.point + middle,
            ..found
        })
    }

    /// Finds the closest points to many points, on the threads of the current rayon pool.
    ///
    /// # Panics
    /// If points and answers differ in number.
    pub fn closest_points<'p>(&self, points: impl Into<Points<'p>>, closest: &mut [Option<ClosestPoint>]) {
        self.closest_points_until(points.into(), closest, &NEVER);
    }

    /// Finds closest points until the call is cancelled.
    #[doc(hidden)]
    pub fn closest_points_until(
        &self,
        points: Points<'_>,
        closest: &mut [Option<ClosestPoint>],
        cancelled: &AtomicBool,
    ) {
        for_neighbours(points, closest, cancelled, |point, near| {
            self.closest_near(point, near)
        });
    }

    /// Checks that the triangles enclose a volume: every edge belongs to an even number of them, where vertices at the same
    /// position are one. The result is cached.
    ///
    /// # Errors
    /// [`QueryError::NotClosed`] with an open edge, or [`QueryError::HasSpheres`].
    pub fn check_closed(&self) -> Result<(), QueryError> {
        if let Some(known) = self.is_closed.get() {
            return known.clone();
        }
        // Not while the lock is held: the check may run a task of the same pool that waits for this lock.
        let found = inside::check_closed(&self.scene);
        self.is_closed.get_or_init(|| found).clone()
    }

    /// Returns whether a point is inside the closed mesh: whether rays from it cross the mesh an odd number of times. For a
    /// point on the surface it may be either.
    ///
    /// # Errors
    /// As [`Geometry::check_closed`].
    pub fn contains(&self, point: impl Into<DVec3>) -> Result<bool, QueryError> {
        self.check_closed()?;
        Ok(self.is_inside(point.into()))
    }

    fn is_inside(&self, point: DVec3) -> bool {
        inside::contains(self.level(), self.bvh(), point - self.middle())
    }

    /// Finds which of many points are inside, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// As [`Geometry::check_closed`].
    ///
    /// # Panics
    /// If points and answers differ in number.
    pub fn contains_each<'p>(
        &self,
        points: impl Into<Points<'p>>,
        inside: &mut [bool],
    ) -> Result<(), QueryError> {
        self.contains_each_until(points.into(), inside, &NEVER)
    }

    /// Tests points until the call is cancelled.
    #[doc(hidden)]
    pub fn contains_each_until(
        &self,
        points: Points<'_>,
        inside: &mut [bool],
        cancelled: &AtomicBool,
    ) -> Result<(), QueryError> {
        self.check_closed()?;
        for_points(points, inside, cancelled, |point| self.is_inside(point));
        Ok(())
    }

    /// Returns the distance of a point from the closed mesh, positive inside, negative outside; -infinity if there is no
    /// triangle, NaN if the point is not finite in `f32`.
    ///
    /// # Errors
    /// As [`Geometry::check_closed`].
    pub fn signed_distance(&self, point: impl Into<DVec3>) -> Result<f64, QueryError> {
        self.check_closed()?;
        Ok(self.signed(point.into(), &mut None))
    }

    fn signed(&self, point: DVec3, near: &mut Option<DVec3>) -> f64 {
        match self.closest_near(point, near) {
            Some(closest) if closest.distance == 0.0 || self.is_inside(point) => closest.distance,
            Some(closest) => -closest.distance,
            None if (point - self.middle()).as_vec3().is_finite() => f64::NEG_INFINITY,
            None => f64::NAN,
        }
    }

    /// Returns the signed distances of many points, on the threads of the current rayon pool.
    ///
    /// # Errors
    /// As [`Geometry::check_closed`].
    ///
    /// # Panics
    /// If points and answers differ in number.
    pub fn signed_distances<'p>(
        &self,
        points: impl Into<Points<'p>>,
        distances: &mut [f64],
    ) -> Result<(), QueryError> {
        self.signed_distances_until(points.into(), distances, &NEVER)
    }

    /// Finds signed distances until the call is cancelled.
    #[doc(hidden)]
    pub fn signed_distances_until(
        &self,
        points: Points<'_>,
        distances: &mut [f64],
        cancelled: &AtomicBool,
    ) -> Result<(), QueryError> {
        self.check_closed()?;
        for_neighbours(points, distances, cancelled, |point, near| {
            self.signed(point, near)
        });
        Ok(())
    }
}

/// Calls `answer` for each point until the call is cancelled: the answers of the others stay as they are.
fn for_points<T: Send>(
    points: Points<'_>,
    answers: &mut [T],
    cancelled: &AtomicBool,
    answer: impl Fn(DVec3) -> T + Sync,
) {
    assert_eq!(points.len(), answers.len(), "an answer for each point");
    let pieces = answers.par_chunks_mut(POINTS).enumerate();
    pieces.for_each(|(piece, answers)| {
        for (i, to) in answers.iter_mut().enumerate() {
            if cancelled.load(Ordering::Relaxed) {
                return;
            }
            *to = answer(points.get(piece * POINTS + i));
        }
    });
}

/// The same, with the closest point to the one before: neighbours follow each other.
pub(super) fn for_neighbours<T: Send>(
    points: Points<'_>,
    answers: &mut [T],
    cancelled: &AtomicBool,
    answer: impl Fn(DVec3, &mut Option<DVec3>) -> T + Sync,
) {
    assert_eq!(points.len(), answers.len(), "an answer for each point");
    let even = points.len().div_ceil(4 * rayon::current_num_threads());
    if even < FEWEST_ORDERED {
        return for_points(points, answers, cancelled, |point| answer(point, &mut None));
    }
    let size = even.min(MOST_ORDERED);
    let pieces = answers.par_chunks_mut(size).enumerate();
    pieces.for_each(|(piece, answers)| {
        let point = |i: usize| points.get(piece * size + i);
        let mut near = None;
        in_z_order(answers.len(), point, |i| {
            if !cancelled.load(Ordering::Relaxed) {
                answers[i] = answer(point(i), &mut near);
            }
        });
    });
}
