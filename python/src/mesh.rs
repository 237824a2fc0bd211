//! `octray._octray.Mesh`: a geometry and its threads.

use crate::{
    arrays::{RayEnds, Vectors, part_of_all, rows},
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

/// The most rays or points of a call without a thread that watches for Ctrl-C.
const FEW: usize = 1 << 8;

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
        count: usize,
        work: impl FnOnce(&Geometry, &AtomicBool) -> T + Send,
    ) -> PyResult<T> {
        let (geometry, pool) = (self.geometry(py), self.threads.pool()?);
        if count <= FEW {
            return Ok(py.detach(|| pool.install(|| work(&geometry, &AtomicBool::new(false)))));
        }
        interruptible(py, |cancelled| pool.install(|| work(&geometry, cancelled)))
    }

    /// One answer per ray.
    fn of_rays<T: Clone + Send>(
        &self,
        py: Python<'_>,
        rays: &AskedRays<'_>,
        nothing: T,
        ask: impl Fn(&Geometry, Rays<'_>, &mut [T]) + Sync + Send,
    ) -> PyResult<Vec<T>> {
        let found = self.run(py, rays.len(), |geometry, cancelled| {
            let (mut answers, pace) = (vec![nothing; rays.len()], Pace::default());
            in_parts(&mut answers, PART, cancelled, |part, answers| {
                pace.steps(answers, cancelled, |step, answers| {
                    let range = part.start + step.start..part.start + step.end;
                    ask(geometry, rays.part(&range)?, answers);
                    Ok(())
                })
            })
            .map(|()| answers)
        })?;
        found.map_err(raised)
    }

    /// One answer per point.
    fn of_points<T: Clone + Send>(
        &self,
        py: Python<'_>,
        points: &Vectors<'_>,
        nothing: T,
        ask: impl Fn(&Geometry, Points<'_>, &mut [T]) -> Result<(), QueryError> + Sync + Send,
    ) -> PyResult<Vec<T>> {
        let points = points.rows()?;
        let count = points.len();
        let found = self.run(py, count, |geometry, cancelled| {
            let mut answers = vec![nothing; count];
            // Without points as well, so that an unsuitable mesh is rejected.
            ask(geometry, part_of_all(points, &(0..0)), &mut [])?;
            // All threads work on one step, since the library answers neighbours together.
            Pace::default()
                .steps(&mut answers, cancelled, |range, answers| {
                    ask(geometry, part_of_all(points, &range), answers)
                })
                .map(|()| answers)
        })?;
        found.map_err(raised)
    }
}

/// Rays, triangles and distances of hits.
type HitColumns = (Vec<i64>, Vec<i64>, Vec<f32>);

/// Rays of which all hits are found between two checks for Ctrl-C: where thousands of triangles overlap, each takes
/// milliseconds.
const STEP: usize = 1 << 5;

/// Which hits a call wants.
struct AllWanted {
    limit: Option<usize>,
    crossings: bool,
    starts: bool,
    /// One triangle of those at the same edge or vertex.
    once: bool,
}

impl AllWanted {
    /// Appends the hits of a few rays, `first` and those after it. They are one task of the library, on this thread.
    fn append(&self, geometry: &Geometry, rays: Rays<'_>, first: usize, to: &mut HitColumns) {
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
    }
}

fn id_of(primitive: PrimitiveId) -> i64 {
    if primitive == PrimitiveId::NONE {
        -1
    } else {
        i64::from(primitive.0)
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
        let mut triangles = Vec::with_capacity(faces.len() / 3);
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
        let ((t, triangle), (uv, hit)) = self.run(py, 0, |_, _| {
            let parts = hits.par_iter();
            let distances: (Vec<f32>, Vec<i64>) =
                parts.clone().map(|hit| (hit.t, id_of(hit.primitive))).unzip();
            let rest: (Vec<[f32; 2]>, Vec<bool>) = parts.map(|hit| ([hit.u, hit.v], hit.is_hit())).unzip();
            (distances, rest)
        })?;
        Ok((
            t.into_pyarray(py),
            triangle.into_pyarray(py),
            rows(py, uv)?,
            hit.into_pyarray(py),
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
        let found = self.run(py, count, |geometry, cancelled| {
            let mut parts = vec![HitColumns::default(); count.div_ceil(SMALL_PART)];
            in_parts(&mut parts, 1, cancelled, |part, to| {
                let end = count.min(part.end * SMALL_PART);
                for start in (part.start * SMALL_PART..end).step_by(STEP) {
                    if !cancelled.load(Ordering::Relaxed) {
                        let range = start..end.min(start + STEP);
                        wanted.append(geometry, rays.part(&range)?, start, &mut to[0]);
                    }
                }
                Ok(())
            })
            .map(|()| parts)
        })?;
        let mut found = found.map_err(raised)?.into_iter();
        let (mut ray, mut triangle, mut t) = found.next().unwrap_or_default();
        for part in found {
            ray.extend(part.0);
            triangle.extend(part.1);
            t.extend(part.2);
        }
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
        let (positions, normals) = self.run(py, count, |geometry, cancelled| {
            let all = (0..count).into_par_iter().with_min_len(1024);
            let surfaces = all.map(|i| surface(geometry, cancelled, i));
            if with_normals {
                surfaces.unzip()
            } else {
                (surfaces.map(|surface| surface.0).collect(), Vec::new())
            }
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
        let found = self.of_points(py, &points, None, |geometry, points, closest| {
            geometry.closest_points(points, closest);
            Ok(())
        })?;
        let nothing = ClosestPoint {
            point: DVec3::NAN,
            distance: f64::NAN,
            primitive: PrimitiveId::NONE,
        };
        let found: Vec<ClosestPoint> = found.into_iter().map(|found| found.unwrap_or(nothing)).collect();
        let distance: Vec<f64> = found.iter().map(|found| found.distance).collect();
        let triangle: Vec<i64> = found.iter().map(|found| id_of(found.primitive)).collect();
        let point = rows(py, found.iter().map(|found| found.point.to_array()).collect())?;
        Ok((point, distance.into_pyarray(py), triangle.into_pyarray(py)))
    }

    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        points: Vectors<'_>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.of_points(py, &points, 0.0, |geometry, points, distances| {
            geometry.signed_distances(points, distances)
        })?;
        Ok(found.into_pyarray(py))
    }

    fn contains<'py>(&self, py: Python<'py>, points: Vectors<'_>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let found = self.of_points(py, &points, false, |geometry, points, inside| {
            geometry.contains_each(points, inside)
        })?;
        Ok(found.into_pyarray(py))
    }

    /// Calls that run meanwhile query the old geometry.
    fn refit(&self, py: Python<'_>, vertices: Vectors<'_>) -> PyResult<()> {
        let positions = vertices.rows()?;
        // One refit at a time, and no lock while the pool works: its thread may start another call meanwhile.
        let _turn = self.refits.take(py)?;
        let (old, pool) = (self.geometry(py), self.threads.pool()?);
        let moved = interruptible(py, |_| pool.install(|| old.refitted(positions)))?;
        let moved = Arc::new(moved.map_err(raised)?);
        *self.geometry.write().unwrap_or_else(PoisonError::into_inner) = moved;
        Ok(())
    }
}
