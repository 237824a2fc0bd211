//! The geometry and its ray queries.

use super::{
    AllHits, Points, QueryError, Ray, Rays, Worker,
    coordinates::scene_of,
    exact::{AllOfLine, GivenLine, Line},
    sinks::{All, Any, Closest, Crossings},
    unit::UnitRay,
    worker,
};
use crate::{
    accel::{Bvh, Child},
    ray::Hit,
    scene::{BVH_BYTES, Scene, Shape},
    simd::{Level, at_level},
    trace::{visit, visit_with},
};
use glam::{DVec3, Vec3};
use std::{fmt, sync::OnceLock};

/// A sphere of a geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// World space.
    pub center: [f64; 3],
    /// Above 0.
    pub radius: f32,
}

/// Triangles and spheres, ready for queries. All methods may be called from many threads at once.
///
/// Primitive ids count the triangles in their order, then the spheres. Coordinates are stored in `f32`, relative to the
/// centre of the geometry on each axis on which it is far from 0. A triangle without area is never hit, and is never the
/// closest to a point.
///
/// ```
/// # use octray_engine as octray;
/// use octray::{Geometry, Ray};
/// # fn main() -> Result<(), octray::QueryError> {
/// let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let geometry = Geometry::from_triangles(&positions, &[[0, 1, 2]])?;
/// let ray = Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -2.0]);
/// let hit = geometry.closest_hit(&ray).expect("the ray meets the triangle");
/// assert_eq!((hit.t, hit.primitive.0), (1.5, 0)); // in units of the direction's length
/// # Ok(())
/// # }
/// ```
pub struct Geometry {
    pub(super) scene: Scene,
    /// As they were given.
    spheres: Vec<Sphere>,
    bvh: Bvh,
    level: Level,
    /// Coordinates are relative to the sum of this point and the scene's origin.
    pub(super) offset: DVec3,
    pub(super) is_closed: OnceLock<Result<(), QueryError>>,
}

impl fmt::Debug for Geometry {
    /// Counts: the arrays are large.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Geometry")
            .field("vertices", &self.vertex_count())
            .field("triangles", &self.triangle_count())
            .field("spheres", &self.spheres.len())
            .finish_non_exhaustive()
    }
}

/// Where a ray hits, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point that is hit.
    pub position: DVec3,
    /// The geometric unit normal: of a triangle by its winding, of a sphere outwards.
    pub normal: DVec3,
}

/// Where a line meets a shape, at about `t`, and a normal there of any length.
pub(super) fn surface_of(shape: Shape, [origin, direction]: GivenLine, t: f32) -> (DVec3, DVec3) {
    let ahead = origin + direction * f64::from(t);
    match shape {
        Shape::Sphere(center, _) => (ahead, ahead - center.as_dvec3()),
        Shape::Triangle(corners) => {
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a);
            let t = normal.dot(a - origin) / normal.dot(direction);
            let on_plane = if t.is_finite() {
                origin + direction * t
            } else {
                ahead
            };
            let (lower, upper) = (a.min(b).min(c), a.max(b).max(c));
            (on_plane.max(lower).min(upper), normal)
        }
    }
}

impl Geometry {
    /// Makes a geometry of triangles: three indices into `positions` each. Builds its hierarchy on rayon's threads.
    ///
    /// # Errors
    /// [`QueryError::Coordinate`], [`QueryError::VertexIndex`], [`QueryError::TooMany`] or [`QueryError::NoMemory`].
    pub fn from_triangles<'a>(
        positions: impl Into<Points<'a>>,
        triangles: &[[u32; 3]],
    ) -> Result<Self, QueryError> {
        Self::new(positions, triangles, &[])
    }

    /// Makes a geometry of triangles and spheres.
    ///
    /// # Errors
    /// As [`Geometry::from_triangles`], or [`QueryError::Radius`].
    pub fn new<'a>(
        positions: impl Into<Points<'a>>,
        triangles: &[[u32; 3]],
        spheres: &[Sphere],
    ) -> Result<Self, QueryError> {
        let (scene, offset) = scene_of(positions.into(), triangles, spheres)?;
        let limit = Child::MAX_BLOCKS;
        if scene.primitive_count() > limit {
            return Err(QueryError::TooMany {
                what: "primitives",
                limit,
            });
        }
        check_room(&scene)?;
        Ok(Self {
            bvh: Bvh::build(&scene),
            scene,
            spheres: spheres.to_vec(),
            level: Level::current(),
            offset,
            is_closed: OnceLock::new(),
        })
    }

    /// Sets the instruction set of queries, by default the [current](Level::current) level. All give the same results.
    #[must_use]
    pub fn at_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Moves the vertices to `positions` in world space (those of a mesh that is relative to an offset have to be moved by it)
    /// and refits the BVH, which usually is far faster than building a new one. If neighbours move apart,
    /// queries are slower than with a new geometry; results are the same, bit for bit. The BVH is rebuilt if triangles are
    /// equal, or gain or lose their area, and from four million triangles on.
    ///
    /// # Errors
    /// [`QueryError::Length`] if there are not as many positions as vertices, [`QueryError::Coordinate`] or
    /// [`QueryError::NoMemory`]; nothing is changed then.
    pub fn refit<'a>(&mut self, positions: impl Into<Points<'a>>) -> Result<(), QueryError> {
        let (scene, offset) = self.moved(positions.into())?;
        check_room(&scene)?;
        if !self.bvh.refit(&scene) {
            self.bvh = Bvh::build(&scene);
        }
        (self.scene, self.offset) = (scene, offset);
        self.is_closed = OnceLock::new();
        Ok(())
    }

    /// Returns a copy with moved vertices; other threads may keep using this one.
    ///
    /// # Errors
    /// As [`Geometry::refit`].
    pub fn refitted<'a>(&self, positions: impl Into<Points<'a>>) -> Result<Self, QueryError> {
        let (scene, offset) = self.moved(positions.into())?;
        check_room(&scene)?;
        let kept = self.bvh.may_refit(&scene).then(|| self.bvh.clone());
        let kept = kept.and_then(|mut bvh| bvh.refit(&scene).then_some(bvh));
        Ok(Self {
            bvh: kept.unwrap_or_else(|| Bvh::build(&scene)),
            scene,
            spheres: self.spheres.clone(),
            level: self.level,
            offset,
            is_closed: OnceLock::new(),
        })
    }

    /// The scene with its vertices at other positions.
    fn moved(&self, positions: Points<'_>) -> Result<(Scene, DVec3), QueryError> {
        let expected = self.vertex_count();
        if positions.len() != expected {
            return Err(QueryError::Length {
                what: "positions",
                found: positions.len(),
                expected,
            });
        }
        scene_of(positions, &self.scene.triangles().corners, &self.spheres)
    }

    /// Returns the number of triangles.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.scene.triangles().corners.len()
    }

    /// Returns the triangles: three vertices each.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.scene.triangles().corners
    }

    /// Returns the number of vertices.
    #[must_use]
    pub fn vertex_count(&self) -> usize {
        self.scene.vertices().x.len()
    }

    /// Returns the lower and upper corner of the box around everything, world space; `None` if there is nothing.
    #[must_use]
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        let bounds = self.scene.bounds();
        let (lower, upper) = (bounds.lower.as_dvec3(), bounds.upper.as_dvec3());
        (!bounds.is_empty()).then(|| [lower + self.offset, upper + self.offset])
    }

    /// Returns the stored vertices, which are relative to a point, and that point, world space: as
    /// [`Geometry::from_relative`] takes them.
    #[must_use]
    pub fn vertices(&self) -> (Vec<[f32; 3]>, DVec3) {
        let vertices = self.scene.vertices();
        let count = vertices.x.len() as u32;
        let positions = (0..count).map(|i| vertices.position(i).to_array());
        (positions.collect(), self.middle())
    }

    /// Returns the stored corners of a triangle, world space.
    ///
    /// # Panics
    /// If there is no such triangle.
    #[must_use]
    pub fn triangle(&self, triangle: usize) -> [DVec3; 3] {
        let middle = self.middle();
        self.scene
            .triangle(triangle)
            .map(|corner| corner.as_dvec3() + middle)
    }

    /// Returns the triangles and spheres, relative to their middle.
    #[doc(hidden)]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    pub(super) fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    pub(super) fn level(&self) -> Level {
        self.level
    }

    /// Returns the point that stored coordinates are relative to, world space: 0 on an axis unless the geometry is far from 0
    /// there.
    #[must_use]
    pub fn middle(&self) -> DVec3 {
        self.offset + self.scene.origin().as_dvec3()
    }

    /// Finds the closest hit of a ray; of equally near ones, the one with the lowest id.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<Hit> {
        at_level!(self.level, |simd| {
            let ray = UnitRay::new(ray, self.middle());
            let mut closest = Closest::new(&ray);
            visit_with(simd, &self.bvh, &ray.ray, &mut closest);
            closest.hit()
        })
    }

    /// Finds whether a ray hits anything.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        at_level!(self.level, |simd| {
            let ray = UnitRay::new(ray, self.middle());
            let mut any = Any::new(&ray);
            visit_with(simd, &self.bvh, &ray.ray, &mut any);
            any.is_hit
        })
    }

    /// Finds all hits of a ray, or the nearest `limit` ones, in order of t, then id. At an edge or vertex all triangles that the
    /// ray touches are hit, each once. A sphere is hit where the ray enters it and where it leaves it.
    #[must_use]
    pub fn all_hits(&self, ray: &Ray, limit: Option<usize>) -> Vec<Hit> {
        self.all_into(UnitRay::new(ray, self.middle()), limit, Vec::new())
    }

    fn all_into(&self, ray: UnitRay, limit: Option<usize>, hits: Vec<Hit>) -> Vec<Hit> {
        let first = hits.len();
        let mut all = All::new(ray, limit, self.bvh.repeats(), hits);
        visit(self.level, &self.bvh, &ray.ray, &mut all);
        all.into_hits(first)
    }

    /// Finds the triangles that a ray crosses: of those that meet at an edge or vertex, one on each sheet. So a ray from outside
    /// a closed mesh has an even number of crossings.
    ///
    /// Where rounding could decide, exact signs do, for a line that is moved by infinitesimal amounts, the same for all
    /// triangles. So parity is right for any mesh, unless the ray starts within rounding error of it. A sphere is crossed where
    /// the ray enters it and where it leaves it.
    #[must_use]
    pub fn crossings(&self, ray: &Ray) -> Vec<Hit> {
        self.crossings_of(UnitRay::new(ray, self.middle()))
    }

    fn crossings_of(&self, ray: UnitRay) -> Vec<Hit> {
        let mut crossings = Crossings::new(ray, self.bvh.repeats());
        visit(self.level, &self.bvh, &ray.ray, &mut crossings);
        crossings.into_hits()
    }

    /// Returns position and normal of a hit of the ray from `origin` along `direction`, in `f64`: where that line meets
    /// the plane of the triangle, within the triangle's box.
    ///
    /// # Panics
    /// If the geometry has no such primitive.
    #[must_use]
    pub fn surface(&self, origin: impl Into<DVec3>, direction: impl Into<DVec3>, hit: &Hit) -> SurfacePoint {
        let middle = self.middle();
        let line = [origin.into() - middle, direction.into()];
        let (position, normal) = surface_of(self.scene.shape(hit.primitive), line, hit.t);
        SurfacePoint {
            position: position + middle,
            normal: normal.normalize(),
        }
    }

    /// Makes a worker for many rays, which traces on the calling thread.
    #[must_use]
    pub fn worker(&self) -> Worker<'_> {
        Worker::new(self)
    }

    /// Finds the closest hits of many rays, on the threads of the current rayon pool. A miss is
    /// [`Hit::miss`]`(f32::INFINITY)`.
    ///
    /// # Panics
    /// If rays and hits differ in number.
    pub fn closest_hits<'r>(&self, rays: impl Into<Rays<'r>>, hits: &mut [Hit]) {
        worker::closest_hits(self, rays.into(), hits);
    }

    /// Finds whether each of many rays hits anything, on the threads of the current rayon pool.
    ///
    /// # Panics
    /// If rays and results differ in number.
    pub fn occluded_each<'r>(&self, rays: impl Into<Rays<'r>>, occluded: &mut [bool]) {
        worker::occluded_each(self, rays.into(), occluded);
    }

    /// Finds all hits of many rays, as [`Geometry::all_hits`] does, on the threads of the current rayon pool.
    #[must_use]
    pub fn all_hits_each<'r>(&self, rays: impl Into<Rays<'r>>, limit: Option<usize>) -> AllHits {
        self.each_of(rays.into(), |unit, _, hits| self.all_into(unit, limit, hits))
    }

    /// Finds all hits of many rays in exact arithmetic. Directions are not rounded to `f32`. Nor are origins, except for
    /// triangles that are nearer than a sixth of the origin's distance from the middle of the geometry. At edges, within
    /// rounding error, triangles may differ from those of [`Geometry::all_hits_each`]. With `once`, a ray that meets several
    /// triangles at one edge or vertex hits one of them.
    #[doc(hidden)]
    #[must_use]
    pub fn exact_hits_each<'r>(
        &self,
        rays: impl Into<Rays<'r>>,
        limit: Option<usize>,
        once: bool,
    ) -> AllHits {
        self.each_of(rays.into(), |unit, line, hits| {
            let first = hits.len();
            let all = All::new(unit, limit, self.bvh.repeats(), hits);
            let mut exact = AllOfLine::new(all, Line::new(line, self.middle(), unit.ray.origin), once);
            visit(self.level, &self.bvh, &unit.ray, &mut exact);
            exact.into_all().into_hits(first)
        })
    }

    /// Finds the crossings of many rays, as [`Geometry::crossings`] does, on the threads of the current rayon pool.
    #[must_use]
    pub fn crossings_each<'r>(&self, rays: impl Into<Rays<'r>>) -> AllHits {
        self.each_of(rays.into(), |unit, _, mut hits| {
            hits.extend(self.crossings_of(unit));
            hits
        })
    }

    /// Calls `append` for each ray, as the kernels and as the caller have it, with the hits of those before.
    fn each_of(
        &self,
        rays: Rays<'_>,
        append: impl Fn(UnitRay, GivenLine, Vec<Hit>) -> Vec<Hit> + Sync,
    ) -> AllHits {
        AllHits::of_each(rays, (self.level, self.middle()), append)
    }
}

/// Checks that there is memory for building a BVH, which would end the process otherwise.
fn check_room(scene: &Scene) -> Result<(), QueryError> {
    let bytes = scene.primitive_count() * BVH_BYTES as usize;
    let room = Vec::<u8>::new().try_reserve_exact(bytes);
    room.map_err(|_| QueryError::NoMemory { what: "the BVH" })
}
