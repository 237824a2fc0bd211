//! `octray._octray.Mesh`: a geometry and its threads.

use crate::{
    arrays::{RayEnds, Vectors, room, rows},
    hits::{AllWanted, HitColumns, STEP, id_of, joined},
    rays::{AskedRays, asked},
    threads::{PART, Pace, SMALL_PART, Threads, Turns, in_parts, interruptible},
    whole,
};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use octray::{
    Geometry, Hit, QueryError,
    glam::DVec3,
    query::{ClosestPoint, Points, Rays},
    ray::PrimitiveId,
};
use pyo3::{
    exceptions::{PyMemoryError, PyValueError},
    prelude::*,
};
use rayon::prelude::*;
use std::sync::{
    Arc, PoisonError, RwLock,
    atomic::{AtomicBool, Ordering},
};

/// The error for Python.
pub fn raised(error: QueryError) -> PyErr {
    match error {
        QueryError::NoMemory { .. } => PyMemoryError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// A triangle mesh that answers queries; see `octray.Mesh`.
#[pyclass(frozen, module = "octray._octray")]
pub struct Mesh {
    /// Locked only while the interpreter's lock is held, which a thread that forks holds: no child finds this locked.
    geometry: RwLock<Arc<Geometry>>,
    refits: Turns,
    threads: Arc<Threads>,
}

impl Mesh {
    pub fn of(geometry: Geometry, threads: Arc<Threads>) -> Self {
        Self::sharing(Arc::new(geometry), threads)
    }

    fn sharing(geometry: Arc<Geometry>, threads: Arc<Threads>) -> Self {
        Self {
            geometry: RwLock::new(geometry),
            refits: Turns::default(),
            threads,
        }
    }

    /// The threads that its calls use.
    pub fn threads(&self) -> &Threads {
        &self.threads
    }

    /// The number of threads of its own.
    pub fn own_threads(&self) -> Option<usize> {
        self.threads.own
    }

    /// The geometry as it is now.
    pub fn geometry(&self, _: Python<'_>) -> Arc<Geometry> {
        Arc::clone(&self.geometry.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Runs `work` on the mesh's threads without the interpreter's lock.
    fn run<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Geometry, &AtomicBool) -> Result<T, QueryError> + Send,
    ) -> PyResult<T> {
        let (geometry, pool) = (self.geometry(py), self.threads.pool()?);
        interruptible(py, &pool, |cancelled| work(&geometry, cancelled))?.map_err(raised)
    }

    /// One answer per ray.
    fn of_rays<T: Clone + Send>(
        &self,
        py: Python<'_>,
        rays: &AskedRays<'_>,
        nothing: T,
        ask: impl Fn(&Geometry, Rays<'_>, &mut [T]) + Sync + Send,
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
    fn of_points<T: Clone + Send>(
        &self,
        py: Python<'_>,
        points: &Vectors<'_>,
        nothing: T,
        ask: impl FnOnce(&Geometry, Points<'_>, &mut [T], &AtomicBool) -> Result<(), QueryError> + Send,
    ) -> PyResult<Vec<T>> {
        let points = points.rows()?;
        self.run(py, |geometry, cancelled| {
            let mut answers = room(points.len())?;
            answers.resize(points.len(), nothing);
            ask(geometry, points, &mut answers, cancelled).map(|()| answers)
        })
    }
}

type HitArrays<'py> = (
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray2<f32>>,
    Bound<'py, PyArray1<bool>>,
);

#[pymethods]
impl Mesh {
    #[new]
    fn new(
        py: Python<'_>,
        vertices: Vectors<'_>,
        faces: PyReadonlyArray2<'_, i64>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let positions = vertices.rows()?;
        let faces = faces
            .as_slice()
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        let mut triangles = room(faces.len() / 3).map_err(raised)?;
        for (i, face) in faces.as_chunks::<3>().0.iter().enumerate() {
            for &index in face {
                if index < 0 || index >= positions.len() as i64 {
                    return Err(PyValueError::new_err(format!(
                        "face {i} has vertex index {index}, but there are only {} vertices",
                        positions.len()
                    )));
                }
            }
            triangles.push(face.map(|index| index as u32));
        }
        whole::built(py, threads, || {
            Ok(Geometry::from_triangles(positions, &triangles))
        })
    }

    /// A mesh that stays as this one is now, until it is moved itself.
    fn copy(&self, py: Python<'_>) -> Self {
        Self::sharing(self.geometry(py), Arc::clone(&self.threads))
    }

    #[getter]
    fn bounds(&self, py: Python<'_>) -> Option<[[f64; 3]; 2]> {
        self.geometry(py)
            .bounds()
            .map(|bounds| bounds.map(|corner| corner.to_array()))
    }

    #[getter]
    fn counts(&self, py: Python<'_>) -> (usize, usize) {
        let geometry = self.geometry(py);
        (geometry.vertex_count(), geometry.triangle_count())
    }

    fn closest_hit<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
        t_min: RayEnds<'_>,
        t_max: RayEnds<'_>,
    ) -> PyResult<HitArrays<'py>> {
        let rays = asked(&origins, &directions, &t_min, &t_max)?;
        let miss = Hit::miss(f32::INFINITY);
        let hits = self.of_rays(py, &rays, miss, |geometry, rays, to| {
            geometry.closest_hits(rays, to)
        })?;
        // On the mesh's threads as well: rayon's own would be missing in a forked process.
        let (t, triangle, uv, is_hit) = self.run(py, |_, _| {
            let (hits, count) = (hits.par_iter(), hits.len());
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

    /// Only the triangles, -1 for a miss, in 32 bits as in trimesh; those on which rays start, too.
    fn first<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
    ) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let (t_min, t_max) = (RayEnds::All(0.0), RayEnds::All(f32::INFINITY));
        let rays = asked(&origins, &directions, &t_min, &t_max)?;
        let found = self.of_rays(py, &rays, -1, |geometry, rays, to| {
            let mut hits = vec![Hit::miss(f32::INFINITY); rays.len()];
            let trace = || geometry.worker().closest_hits(rays, &mut hits);
            let ((), starts) = geometry.with_starts(rays, false, trace);
            for (to, hit) in to.iter_mut().zip(hits) {
                *to = id_of(hit.primitive) as i32;
            }
            // In reverse order, so that the lowest of a ray's triangles stays.
            for (ray, triangle) in starts.into_iter().rev() {
                to[ray] = id_of(triangle) as i32;
            }
        })?;
        Ok(found.into_pyarray(py))
    }

    fn occluded<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
        t_min: RayEnds<'_>,
        t_max: RayEnds<'_>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let rays = asked(&origins, &directions, &t_min, &t_max)?;
        let found = self.of_rays(py, &rays, false, |geometry, rays, to| {
            geometry.occluded_each(rays, to);
        })?;
        Ok(found.into_pyarray(py))
    }

    /// Whether rays hit anything, those that start on a triangle, too.
    fn any<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let (t_min, t_max) = (RayEnds::All(0.0), RayEnds::All(f32::INFINITY));
        let rays = asked(&origins, &directions, &t_min, &t_max)?;
        let found = self.of_rays(py, &rays, false, |geometry, rays, to| {
            let trace = || geometry.worker().occluded_each(rays, to);
            let ((), starts) = geometry.with_starts(rays, false, trace);
            for (ray, _) in starts {
                to[ray] = true;
            }
        })?;
        Ok(found.into_pyarray(py))
    }

    /// With `starts` as trimesh's engines: also the triangles on which rays start, at t = 0, which must not be before `t_min`
    /// then, and hits are those of the rays as they are given, not rounded to `f32`. With `once` as well, one triangle of
    /// those that a ray meets at the same edge or vertex, before `max_hits` counts.
    #[expect(clippy::type_complexity, reason = "a tuple of arrays")]
    #[expect(
        clippy::too_many_arguments,
        reason = "those of the Python method, and two more"
    )]
    fn all_hits<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
        t_min: RayEnds<'_>,
        t_max: RayEnds<'_>,
        max_hits: Option<usize>,
        crossings: bool,
        starts: bool,
        once: bool,
    ) -> PyResult<(
        Bound<'py, PyArray1<i64>>,
        Bound<'py, PyArray1<i64>>,
        Bound<'py, PyArray1<f32>>,
    )> {
        let rays = asked(&origins, &directions, &t_min, &t_max)?;
        let wanted = AllWanted {
            limit: max_hits,
            crossings,
            starts,
            once,
        };
        let count = rays.len();
        let (ray, triangle, t) = self.run(py, |geometry, cancelled| {
            let mut parts = room(count.div_ceil(SMALL_PART))?;
            parts.resize(count.div_ceil(SMALL_PART), HitColumns::default());
            in_parts(&mut parts, 1, cancelled, |part, to| {
                let end = count.min(part.end * SMALL_PART);
                for start in (part.start * SMALL_PART..end).step_by(STEP) {
                    if !cancelled.load(Ordering::Relaxed) {
                        let range = start..end.min(start + STEP);
                        wanted.append(geometry, rays.part(&range)?, start, &mut to[0])?;
                    }
                }
                Ok(())
            })?;
            joined(parts)
        })?;
        Ok((
            ray.into_pyarray(py),
            triangle.into_pyarray(py),
            t.into_pyarray(py),
        ))
    }

    /// Positions of hits, and normals if `with_normals`. A hit has the index of its ray (without `ray`, hits and rays
    /// correspond), its triangle, -1 for none, and t.
    #[expect(clippy::type_complexity, reason = "a tuple of arrays")]
    #[expect(clippy::too_many_arguments, reason = "arrays")]
    fn surface<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
        ray: Option<PyReadonlyArray1<'_, i64>>,
        triangle: PyReadonlyArray1<'_, i64>,
        t: PyReadonlyArray1<'_, f32>,
        with_normals: bool,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let (origins, directions) = (origins.rows()?, directions.rows()?);
        let wrong = |_| PyValueError::new_err("the array is not contiguous");
        let (triangle, t) = (triangle.as_slice().map_err(wrong)?, t.as_slice().map_err(wrong)?);
        let ray = ray
            .as_ref()
            .map(|ray| ray.as_slice().map_err(wrong))
            .transpose()?;
        let (count, rays) = (t.len(), directions.len());
        let fits = triangle.len() == count
            && ray.map_or(rays, <[i64]>::len) == count
            && (origins.len() == rays || origins.len() == 1);
        if !fits {
            return Err(PyValueError::new_err("the arrays differ in length"));
        }
        let surface = |geometry: &Geometry, cancelled: &AtomicBool, i: usize| {
            let (ray, id) = (ray.map_or(i, |ray| ray[i] as usize), triangle[i] as usize);
            if cancelled.load(Ordering::Relaxed) || ray >= rays || id >= geometry.triangle_count() {
                return ([f64::NAN; 3], [f64::NAN; 3]);
            }
            let hit = Hit {
                primitive: PrimitiveId(id as u32),
                ..Hit::miss(t[i])
            };
            let origin = origins.get(if origins.len() == 1 { 0 } else { ray });
            let found = geometry.surface(origin, directions.get(ray), &hit);
            (found.position.to_array(), found.normal.to_array())
        };
        let (positions, normals) = self.run(py, |geometry, cancelled| {
            let (mut positions, mut normals) = (room(count)?, room(if with_normals { count } else { 0 })?);
            let all = (0..count).into_par_iter().with_min_len(1024);
            let surfaces = all.map(|i| surface(geometry, cancelled, i));
            if with_normals {
                surfaces.unzip_into_vecs(&mut positions, &mut normals);
            } else {
                surfaces.map(|surface| surface.0).collect_into_vec(&mut positions);
            }
            Ok((positions, normals))
        })?;
        Ok((rows(py, positions)?, rows(py, normals)?))
    }

    #[expect(clippy::type_complexity, reason = "a tuple of arrays")]
    fn closest_point<'py>(
        &self,
        py: Python<'py>,
        points: Vectors<'_>,
    ) -> PyResult<(
        Bound<'py, PyArray2<f64>>,
        Bound<'py, PyArray1<f64>>,
        Bound<'py, PyArray1<i64>>,
    )> {
        let found = self.of_points(py, &points, None, |geometry, points, closest, cancelled| {
            geometry.closest_points_until(points, closest, cancelled);
            Ok(())
        })?;
        let nothing = ClosestPoint {
            point: DVec3::NAN,
            distance: f64::NAN,
            primitive: PrimitiveId::NONE,
        };
        let mut point = room(found.len()).map_err(raised)?;
        let mut distance = room(found.len()).map_err(raised)?;
        let mut triangle = room(found.len()).map_err(raised)?;
        for found in found {
            let found = found.unwrap_or(nothing);
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

    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        points: Vectors<'_>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.of_points(py, &points, 0.0, |geometry, points, distances, cancelled| {
            geometry.signed_distances_until(points, distances, cancelled)
        })?;
        Ok(found.into_pyarray(py))
    }

    fn contains<'py>(&self, py: Python<'py>, points: Vectors<'_>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let found = self.of_points(py, &points, false, |geometry, points, inside, cancelled| {
            geometry.contains_each_until(points, inside, cancelled)
        })?;
        Ok(found.into_pyarray(py))
    }

    /// Calls that run meanwhile query the old geometry.
    fn refit(&self, py: Python<'_>, vertices: Vectors<'_>) -> PyResult<()> {
        let positions = vertices.rows()?;
        // One refit at a time, and no lock while the pool works: its thread may start another call meanwhile.
        let _turn = self.refits.take(py)?;
        let (old, pool) = (self.geometry(py), self.threads.pool()?);
        let moved = interruptible(py, &pool, |_| old.refitted(positions))?;
        let moved = Arc::new(moved.map_err(raised)?);
        *self.geometry.write().unwrap_or_else(PoisonError::into_inner) = moved;
        Ok(())
    }
}
