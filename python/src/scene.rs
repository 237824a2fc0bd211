//! `octray._octray.Scene`: meshes that are placed, and their threads.

use crate::{
    arrays::{RayEnds, Vectors, room, rows},
    hits::{HitColumns, append_placed},
    mesh::Mesh,
    rays::asked,
    shared::{HitArrays, Shared, Surfaces, numbers, raised},
    threads::{Threads, interruptible},
};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use octray::{
    Geometry, Hit, InstanceId, InstancedGeometry, InstancedHit, QueryError,
    glam::DVec3,
    query::{ClosestPoint, Rays},
    ray::PrimitiveId,
    scene::Transform,
};
use pyo3::{exceptions::PyValueError, prelude::*};
use rayon::prelude::*;
use std::{ops::Range, sync::Arc};

/// Instances, and the matrices that they were placed by: 3x4, row by row.
pub struct Placed {
    pub geometry: InstancedGeometry,
    pub matrices: Vec<[f64; 12]>,
}

/// Placed meshes that answer queries; see `octray.Scene`.
#[pyclass(frozen, module = "octray._octray")]
pub struct Scene(pub Shared<Placed>);

/// The rows of matrices.
fn matrices(array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<[f64; 12]>> {
    let wrong = |_| PyValueError::new_err("the array is not contiguous");
    let matrices = array.as_slice().map_err(wrong)?.as_chunks().0;
    let mut copied = room(matrices.len()).map_err(raised)?;
    copied.extend_from_slice(matrices);
    Ok(copied)
}

pub fn transform(matrix: &[f64; 12]) -> Transform {
    let row = |i: usize| [matrix[i], matrix[i + 1], matrix[i + 2], matrix[i + 3]];
    Transform::from_rows([row(0), row(4), row(8)])
}

#[pymethods]
impl Scene {
    /// For each instance, `matrices` has a row of 12 numbers, and `indices` a valid index into `meshes`.
    #[new]
    fn new(
        py: Python<'_>,
        meshes: Vec<PyRef<'_, Mesh>>,
        matrices: PyReadonlyArray2<'_, f64>,
        indices: PyReadonlyArray1<'_, i64>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let geometries: Vec<Arc<Geometry>> = meshes.iter().map(|mesh| mesh.0.now(py)).collect();
        let (matrices, indices) = (self::matrices(&matrices)?, numbers(&indices)?);
        if matrices.len() != indices.len() {
            return Err(PyValueError::new_err("the arrays differ in length"));
        }
        let threads = Threads::new(threads)?;
        let pool = threads.pool()?;
        let placed = interruptible(py, &pool, |_| {
            let mut instances = room(matrices.len())?;
            let all = indices.iter().zip(&matrices);
            instances.extend(all.map(|(&mesh, matrix)| (mesh as usize, transform(matrix))));
            let meshes: Vec<&Geometry> = geometries.iter().map(|geometry| &**geometry).collect();
            let geometry = InstancedGeometry::new(&meshes, &instances)?;
            Ok(Placed { geometry, matrices })
        })?;
        Ok(Self(Shared::of(placed.map_err(raised)?, Arc::new(threads))))
    }

    /// A scene that stays as this one is now, until it is moved itself.
    fn copy(&self, py: Python<'_>) -> Self {
        Self(self.0.copy(py))
    }

    #[getter]
    fn bounds(&self, py: Python<'_>) -> Option<[[f64; 3]; 2]> {
        let bounds = self.0.now(py).geometry.bounds();
        bounds.map(|bounds| bounds.map(|corner| corner.to_array()))
    }

    /// The matrices, a row of 12 numbers each.
    #[getter]
    fn matrices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.0.now(py).matrices.clone())
    }

    #[getter]
    fn threads(&self) -> Option<usize> {
        self.0.threads().own
    }

    fn closest_hit<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
        t_min: RayEnds<'_>,
        t_max: RayEnds<'_>,
    ) -> PyResult<(HitArrays<'py>, Bound<'py, PyArray1<i64>>)> {
        let rays = asked(&origins, &directions, &t_min, &t_max)?;
        let miss = InstancedHit::default();
        let hits = self.0.of_rays(py, &rays, miss, |placed, rays, to| {
            placed.geometry.closest_hits(rays, to);
        })?;
        let columns = self.0.columns(py, &hits, |hit| Hit {
            t: hit.t,
            u: hit.u,
            v: hit.v,
            primitive: hit.primitive,
        })?;
        let instance = self.0.run(py, |_, _| {
            let mut instance: Vec<i64> = room(hits.len())?;
            let ids = hits
                .par_iter()
                .map(|hit| if hit.is_hit() { hit.instance.0.into() } else { -1 });
            ids.collect_into_vec(&mut instance);
            Ok(instance)
        })?;
        Ok((columns, instance.into_pyarray(py)))
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
        let found = self.0.of_rays(py, &rays, false, |placed, rays, to| {
            placed.geometry.occluded_each(rays, to);
        })?;
        Ok(found.into_pyarray(py))
    }

    #[expect(clippy::type_complexity, reason = "a tuple of arrays")]
    fn all_hits<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
        t_min: RayEnds<'_>,
        t_max: RayEnds<'_>,
        max_hits: Option<usize>,
    ) -> PyResult<(
        Bound<'py, PyArray1<i64>>,
        Bound<'py, PyArray1<i64>>,
        Bound<'py, PyArray1<i64>>,
        Bound<'py, PyArray1<f32>>,
    )> {
        let rays = asked(&origins, &directions, &t_min, &t_max)?;
        let append = |placed: &Placed, rays: Rays<'_>, range: Range<usize>, to: &mut HitColumns| {
            append_placed(&placed.geometry, (rays, max_hits), range.start, to)
        };
        let hits = self.0.all_hits(py, &rays, append)?;
        Ok((
            hits.ray.into_pyarray(py),
            hits.instance.into_pyarray(py),
            hits.triangle.into_pyarray(py),
            hits.t.into_pyarray(py),
        ))
    }

    /// Positions and normals of hits, one for each ray; NaN where the triangle is -1.
    fn surface<'py>(
        &self,
        py: Python<'py>,
        origins: Vectors<'_>,
        directions: Vectors<'_>,
        instance: PyReadonlyArray1<'_, i64>,
        triangle: PyReadonlyArray1<'_, i64>,
        t: PyReadonlyArray1<'_, f32>,
    ) -> PyResult<Surfaces<'py>> {
        let (instance, triangle, t) = (numbers(&instance)?, numbers(&triangle)?, numbers(&t)?);
        if instance.len() != t.len() || triangle.len() != t.len() {
            return Err(PyValueError::new_err("the arrays differ in length"));
        }
        let of_hit = |placed: &Placed, i: usize, [origin, direction]: [DVec3; 2]| {
            let hit = InstancedHit {
                t: t[i],
                primitive: PrimitiveId(triangle[i] as u32),
                instance: InstanceId(instance[i] as u32),
                ..InstancedHit::default()
            };
            let is_hit = triangle[i] >= 0;
            is_hit.then(|| placed.geometry.surface(origin, direction, &hit))
        };
        let lines = (&origins, &directions);
        self.0.surfaces(py, lines, (None, t.len()), true, of_hit)
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
        Bound<'py, PyArray1<i64>>,
    )> {
        let found = self
            .0
            .of_points(py, &points, None, |placed, points, closest, cancelled| {
                placed.geometry.closest_points_until(points, closest, cancelled);
                Ok(())
            })?;
        let (point, distance, triangle) = self.0.closest_columns(py, &found, |found| ClosestPoint {
            point: found.point,
            distance: found.distance,
            primitive: found.primitive,
        })?;
        let mut instance: Vec<i64> = room(found.len()).map_err(raised)?;
        instance.extend(
            found
                .iter()
                .map(|found| found.map_or(-1, |found| found.instance.0.into())),
        );
        Ok((point, distance, instance.into_pyarray(py), triangle))
    }

    #[pyo3(name = "move")]
    fn move_to(&self, py: Python<'_>, matrices: PyReadonlyArray2<'_, f64>) -> PyResult<()> {
        let matrices = self::matrices(&matrices)?;
        let what = "move: this thread is already moving the instances of this scene";
        self.0.replace(py, what, |old| {
            let mut transforms = room(matrices.len())?;
            transforms.extend(matrices.iter().map(transform));
            let geometry = old.geometry.moved(&transforms)?;
            Ok::<_, QueryError>(Placed { geometry, matrices })
        })
    }
}
