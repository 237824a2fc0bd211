//! What answers queries in Python: a geometry that calls share, until another one replaces it.

use crate::{
    arrays::{Vectors, room, rows},
    hits::{HitColumns, STEP, id_of, joined},
    rays::AskedRays,
    threads::{PART, Pace, SMALL_PART, Threads, Turns, in_parts, interruptible},
};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1};
use octray::{
    Hit, QueryError,
    glam::DVec3,
    query::{ClosestPoint, Points, Rays, SurfacePoint},
    ray::PrimitiveId,
};
use pyo3::{
    exceptions::{PyMemoryError, PyValueError},
    prelude::*,
};
use rayon::prelude::*;
use std::{
    ops::Range,
    sync::{
        Arc, PoisonError, RwLock,
        atomic::{AtomicBool, Ordering},
    },
};

/// The error for Python.
pub fn raised(error: QueryError) -> PyErr {
    match error {
        QueryError::NoMemory { .. } => PyMemoryError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// The numbers of an array.
pub fn numbers<'a, T: numpy::Element>(array: &'a PyReadonlyArray1<'_, T>) -> PyResult<&'a [T]> {
    let contiguous = |_| PyValueError::new_err("the array is not contiguous");
    array.as_slice().map_err(contiguous)
}

/// The columns of closest hits: t, triangles, weights, and which rays hit.
pub type HitArrays<'py> = (
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<bool>>,
);

/// Positions and normals.
pub type Surfaces<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Closest points, their distances and triangles.
pub type ClosestArrays<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i64>>,
);

/// A geometry and the threads of its calls.
pub struct Shared<G> {
    /// Locked only while the interpreter's lock is held, which a thread that forks holds: no child finds this locked.
    geometry: RwLock<Arc<G>>,
    moves: Turns,
    threads: Arc<Threads>,
}

impl<G: Send + Sync> Shared<G> {
    pub fn of(geometry: G, threads: Arc<Threads>) -> Self {
        Self::sharing(Arc::new(geometry), threads)
    }

    fn sharing(geometry: Arc<G>, threads: Arc<Threads>) -> Self {
        Self {
            geometry: RwLock::new(geometry),
            moves: Turns::default(),
            threads,
        }
    }

    /// One that stays as this one is now, until it is replaced itself.
    pub fn copy(&self, py: Python<'_>) -> Self {
        Self::sharing(self.now(py), Arc::clone(&self.threads))
    }

    pub fn threads(&self) -> &Threads {
        &self.threads
    }

    /// The geometry as it is now.
    pub fn now(&self, _: Python<'_>) -> Arc<G> {
        Arc::clone(&self.geometry.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Replaces the geometry. Calls that run meanwhile query the old one.
    ///
    /// # Errors
    /// `RuntimeError`, which says `what`, if this thread is already replacing it.
    pub fn replace(
        &self,
        py: Python<'_>,
        what: &str,
        moved: impl FnOnce(&G) -> Result<G, QueryError> + Send,
    ) -> PyResult<()> {
        // One at a time, and no lock while the pool works: its thread may start another call meanwhile.
        let _turn = self.moves.take(py, what)?;
        let (old, pool) = (self.now(py), self.threads.pool()?);
        let moved = interruptible(py, &pool, |_| moved(&old))?;
        let moved = Arc::new(moved.map_err(raised)?);
        *self.geometry.write().unwrap_or_else(PoisonError::into_inner) = moved;
        Ok(())
    }

    /// Runs `work` on the threads without the interpreter's lock.
    pub fn run<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&G, &AtomicBool) -> Result<T, QueryError> + Send,
    ) -> PyResult<T> {
        let (geometry, pool) = (self.now(py), self.threads.pool()?);
        interruptible(py, &pool, |cancelled| work(&geometry, cancelled))?.map_err(raised)
    }

    /// One answer per ray.
    pub fn of_rays<T: Clone + Send>(
        &self,
        py: Python<'_>,
        rays: &AskedRays<'_>,
        nothing: T,
        ask: impl Fn(&G, Rays<'_>, &mut [T]) + Sync + Send,
    ) -> PyResult<Vec<T>> {
        self.run(py, |geometry, cancelled| {
            let (mut answers, pace) = (room(rays.len())?, Pace::default());
            answers.resize(rays.len(), nothing);
            in_parts(&mut answers, PART, cancelled, |part, answers| {
                pace.steps(answers, cancelled, |step, answers| {
                    let range = part.start + step.start..part.start + step.end;
                    ask(geometry, rays.part(&range)?, answers);
                    Ok(())
                })
            })
            .map(|()| answers)
        })
    }

    /// One answer per point.
    pub fn of_points<T: Clone + Send>(
        &self,
        py: Python<'_>,
        points: &Vectors<'_>,
        nothing: T,
        ask: impl FnOnce(&G, Points<'_>, &mut [T], &AtomicBool) -> Result<(), QueryError> + Send,
    ) -> PyResult<Vec<T>> {
        let points = points.rows()?;
        self.run(py, |geometry, cancelled| {
            let mut answers = room(points.len())?;
            answers.resize(points.len(), nothing);
            ask(geometry, points, &mut answers, cancelled).map(|()| answers)
        })
    }

    /// The columns of closest points; `of` returns that of an answer. A point without an answer has NaN, NaN and -1.
    pub fn closest_columns<'py, C>(
        &self,
        py: Python<'py>,
        answers: &[Option<C>],
        of: impl Fn(&C) -> ClosestPoint,
    ) -> PyResult<ClosestArrays<'py>> {
        let nothing = ClosestPoint {
            point: DVec3::NAN,
            distance: f64::NAN,
            primitive: PrimitiveId::NONE,
        };
        let mut point = room(answers.len()).map_err(raised)?;
        let mut distance = room(answers.len()).map_err(raised)?;
        let mut triangle = room(answers.len()).map_err(raised)?;
        for answer in answers {
            let found = answer.as_ref().map_or(nothing, &of);
            point.push(found.point.to_array());
            distance.push(found.distance);
            triangle.push(id_of(found.primitive));
        }
        Ok((
            rows(py, point)?,
            distance.into_pyarray(py),
            triangle.into_pyarray(py),
        ))
    }

    /// The columns of closest hits; `of` returns the hit of an answer.
    pub fn columns<'py, H: Sync>(
        &self,
        py: Python<'py>,
        hits: &[H],
        of: impl Fn(&H) -> Hit + Sync + Send + Copy,
    ) -> PyResult<HitArrays<'py>> {
        // On these threads as well: rayon's own would be missing in a forked process.
        let (t, triangle, uv, is_hit) = self.run(py, |_, _| {
            let (hits, count) = (hits.par_iter().map(of), hits.len());
            let (mut t, mut triangle) = (room(count)?, room(count)?);
            let (mut uv, mut is_hit) = (room(count)?, room(count)?);
            let halves = hits.clone().map(|hit| (hit.t, id_of(hit.primitive)));
            halves.unzip_into_vecs(&mut t, &mut triangle);
            let halves = hits.map(|hit| ([hit.u, hit.v], hit.is_hit()));
            halves.unzip_into_vecs(&mut uv, &mut is_hit);
            Ok((t, triangle, uv, is_hit))
        })?;
        Ok((
            t.into_pyarray(py),
            triangle.into_pyarray(py),
            rows(py, uv)?,
            is_hit.into_pyarray(py),
        ))
    }

    /// All hits: `append` adds those of a range of rays.
    pub fn all_hits(
        &self,
        py: Python<'_>,
        rays: &AskedRays<'_>,
        append: impl Fn(&G, Rays<'_>, Range<usize>, &mut HitColumns) -> Result<(), QueryError> + Sync + Send,
    ) -> PyResult<HitColumns> {
        let count = rays.len();
        self.run(py, |geometry, cancelled| {
            let mut parts = room(count.div_ceil(SMALL_PART))?;
            parts.resize(count.div_ceil(SMALL_PART), HitColumns::default());
            in_parts(&mut parts, 1, cancelled, |part, to| {
                let end = count.min(part.end * SMALL_PART);
                for start in (part.start * SMALL_PART..end).step_by(STEP) {
                    if !cancelled.load(Ordering::Relaxed) {
                        let range = start..end.min(start + STEP);
                        append(geometry, rays.part(&range)?, range, &mut to[0])?;
                    }
                }
                Ok(())
            })?;
            joined(parts)
        })
    }

    /// Positions of `count` hits, and normals if `with_normals`. `ray` holds the index of each hit's ray; without it, hits and
    /// rays correspond. `surface` finds those of a hit on its ray; NaN for `None`.
    pub fn surfaces<'py>(
        &self,
        py: Python<'py>,
        (origins, directions): (&Vectors<'_>, &Vectors<'_>),
        (ray, count): (Option<&[i64]>, usize),
        with_normals: bool,
        surface: impl Fn(&G, usize, [DVec3; 2]) -> Option<SurfacePoint> + Sync + Send,
    ) -> PyResult<Surfaces<'py>> {
        let (origins, directions) = (origins.rows()?, directions.rows()?);
        let rays = directions.len();
        if ray.map_or(rays, <[i64]>::len) != count || origins.len() != rays && origins.len() != 1 {
            return Err(PyValueError::new_err("the arrays differ in length"));
        }
        let nothing = ([f64::NAN; 3], [f64::NAN; 3]);
        let of_hit = |geometry: &G, cancelled: &AtomicBool, i: usize| {
            let ray = ray.map_or(i, |ray| ray[i] as usize);
            if cancelled.load(Ordering::Relaxed) || ray >= rays {
                return nothing;
            }
            let origin = origins.get(if origins.len() == 1 { 0 } else { ray });
            let found = surface(geometry, i, [origin, directions.get(ray)]);
            found.map_or(nothing, |found| {
                (found.position.to_array(), found.normal.to_array())
            })
        };
        let (positions, normals) = self.run(py, |geometry, cancelled| {
            let (mut positions, mut normals) = (room(count)?, room(if with_normals { count } else { 0 })?);
            let all = (0..count).into_par_iter().with_min_len(1024);
            let surfaces = all.map(|i| of_hit(geometry, cancelled, i));
            if with_normals {
                surfaces.unzip_into_vecs(&mut positions, &mut normals);
            } else {
                surfaces.map(|surface| surface.0).collect_into_vec(&mut positions);
            }
            Ok((positions, normals))
        })?;
        Ok((rows(py, positions)?, rows(py, normals)?))
    }
}
