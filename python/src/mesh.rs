//! `octray._octray.Mesh`: a geometry and its threads.

use crate::{
    arrays::{RayEnds, Vectors, room},
    hits::{AllWanted, HitColumns, id_of},
    rays::asked,
    shared::{ClosestArrays, HitArrays, Shared, Surfaces, numbers, raised},
    whole,
};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use octray::{Geometry, Hit, glam::DVec3, query::Rays, ray::PrimitiveId};
use pyo3::{exceptions::PyValueError, prelude::*};
use std::ops::Range;

/// A triangle mesh that answers queries; see `octray.Mesh`.
#[pyclass(frozen, module = "octray._octray")]
pub struct Mesh(pub Shared<Geometry>);

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
        Self(self.0.copy(py))
    }

    #[getter]
    fn bounds(&self, py: Python<'_>) -> Option<[[f64; 3]; 2]> {
        self.0
            .now(py)
            .bounds()
            .map(|bounds| bounds.map(|corner| corner.to_array()))
    }

    #[getter]
    fn counts(&self, py: Python<'_>) -> (usize, usize) {
        let geometry = self.0.now(py);
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
        let hits = self.0.of_rays(py, &rays, miss, |geometry, rays, to| {
            geometry.closest_hits(rays, to)
        })?;
        self.0.columns(py, &hits, |hit| *hit)
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
        let found = self.0.of_rays(py, &rays, -1, |geometry, rays, to| {
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
        let found = self.0.of_rays(py, &rays, false, |geometry, rays, to| {
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
        let found = self.0.of_rays(py, &rays, false, |geometry, rays, to| {
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
        let append = |geometry: &Geometry, rays: Rays<'_>, range: Range<usize>, to: &mut HitColumns| {
            wanted.append(geometry, rays, range.start, to)
        };
        let HitColumns { ray, triangle, t, .. } = self.0.all_hits(py, &rays, append)?;
        Ok((
            ray.into_pyarray(py),
            triangle.into_pyarray(py),
            t.into_pyarray(py),
        ))
    }

    /// Positions of hits, and normals if `with_normals`. A hit has the index of its ray (without `ray`, hits and rays
    /// correspond), its triangle, -1 for none, and t.
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
    ) -> PyResult<Surfaces<'py>> {
        let (triangle, t) = (numbers(&triangle)?, numbers(&t)?);
        let ray = ray.as_ref().map(numbers).transpose()?;
        if triangle.len() != t.len() {
            return Err(PyValueError::new_err("the arrays differ in length"));
        }
        let of_hit = |geometry: &Geometry, i: usize, [origin, direction]: [DVec3; 2]| {
            let hit = Hit {
                primitive: PrimitiveId(triangle[i] as u32),
                ..Hit::miss(t[i])
            };
            let is_there = (triangle[i] as usize) < geometry.triangle_count();
            is_there.then(|| geometry.surface(origin, direction, &hit))
        };
        let lines = (&origins, &directions);
        self.0.surfaces(py, lines, (ray, t.len()), with_normals, of_hit)
    }

    fn closest_point<'py>(&self, py: Python<'py>, points: Vectors<'_>) -> PyResult<ClosestArrays<'py>> {
        let found = self
            .0
            .of_points(py, &points, None, |geometry, points, closest, cancelled| {
                geometry.closest_points_until(points, closest, cancelled);
                Ok(())
            })?;
        self.0.closest_columns(py, &found, |found| *found)
    }

    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        points: Vectors<'_>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self
            .0
            .of_points(py, &points, 0.0, |geometry, points, distances, cancelled| {
                geometry.signed_distances_until(points, distances, cancelled)
            })?;
        Ok(found.into_pyarray(py))
    }

    fn contains<'py>(&self, py: Python<'py>, points: Vectors<'_>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let found = self
            .0
            .of_points(py, &points, false, |geometry, points, inside, cancelled| {
                geometry.contains_each_until(points, inside, cancelled)
            })?;
        Ok(found.into_pyarray(py))
    }

    fn refit(&self, py: Python<'_>, vertices: Vectors<'_>) -> PyResult<()> {
        let positions = vertices.rows()?;
        let what = "refit: this thread is already moving the vertices of this mesh";
        self.0.replace(py, what, |old| old.refitted(positions))
    }
}
