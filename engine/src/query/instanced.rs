//! Geometries that are placed any number of times, and their ray queries.

mod ellipsoid;
mod nearest;
mod placed;

pub use nearest::InstancedClosestPoint;

use super::{
    AllHits, Geometry, QueryError, Ray, Rays, SurfacePoint, Worker,
    geometry::surface_of,
    sinks::{All, Any, ClosestThere},
    unit::UnitRay,
    worker::{self, Target},
};
use crate::{
    accel::Bvh,
    lanes::LANES,
    ray::{Hit, HitPacket, InstanceId, PrimitiveId},
    scene::{MAX_INSTANCES, MAX_PROTOTYPES, Prototype, PrototypeId, Scene, SceneBuilder, Transform},
    simd::{Level, Simd, at_level},
    trace::{Tracer, visit_instances},
};
use glam::DVec3;
use placed::{Part, Placed, add, check_finite};
use std::{fmt, sync::Arc};

/// A hit in an [`InstancedGeometry`]. The default is a miss.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct InstancedHit {
    /// Distance along the ray, in lengths of its direction; infinite for a miss.
    pub t: f32,
    /// Barycentric weight of a triangle's second corner; 0 on spheres.
    pub u: f32,
    /// Barycentric weight of a triangle's third corner; 0 on spheres.
    pub v: f32,
    /// The primitive, by its id in its geometry; [`PrimitiveId::NONE`] for a miss.
    pub primitive: PrimitiveId,
    /// The instance, by its index in the array that was given; [`InstanceId::NONE`] for a miss.
    pub instance: InstanceId,
}

impl Default for InstancedHit {
    fn default() -> Self {
        Self::new(Hit::default(), InstanceId::NONE)
    }
}

impl InstancedHit {
    pub(super) fn new(Hit { t, u, v, primitive }: Hit, instance: InstanceId) -> Self {
        Self {
            t,
            u,
            v,
            primitive,
            instance,
        }
    }

    /// Returns whether this is a hit, not a miss.
    #[inline(always)]
    #[must_use]
    pub fn is_hit(&self) -> bool {
        self.primitive != PrimitiveId::NONE
    }
}

/// Geometries, each stored once and placed any number of times, ready for ray queries. All methods may be called from many
/// threads at once.
///
/// An instance is a geometry and the affine transform from its world space to that of the scene; it may mirror, stretch and
/// shear, and takes about 100 bytes. Spheres that are stretched are ellipsoids. Queries are those of [`Geometry`]: t counts the
/// length of the direction in the scene, of equally near hits or points the one in the first instance comes first, then the one
/// with the lowest id. One ray or point and many get the same bits, at every level, on any number of threads.
///
/// Coordinates are stored in `f32`, those of geometries as [`Geometry`] has them, and those of instances relative to the centre
/// of the scene on each axis on which it is far from 0. Transforms are multiplied in `f64` and their inverses are rounded to `f32`
/// once. So t is accurate to about 1e-7 of the scene's size and the origin's distance, times the ratio of a transform's
/// largest to its least scale, for rays at right angles to the surface. So is the closest point: that of triangles which are
/// placed in `f64`, by the inverses of the stored matrices. A ray may miss an instance if it starts, in the space
/// of the geometry, farther than 2 * 10^8 times the geometry's size from it.
///
/// ```
/// # use octray_engine as octray;
/// use octray::{Geometry, InstancedGeometry, Ray, glam::DVec3, scene::Transform};
/// # fn main() -> Result<(), octray::QueryError> {
/// let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let triangle = Geometry::from_triangles(&positions, &[[0, 1, 2]])?;
/// let raised = |z: f64| Transform::IDENTITY.then_translate(DVec3::Z * z);
/// let scene = InstancedGeometry::new(&[&triangle], &[(0, raised(0.0)), (0, raised(2.0))])?;
/// let hit = scene.closest_hit(&Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -1.0])).expect("a hit");
/// assert_eq!((hit.t, hit.instance.0, hit.primitive.0), (1.0, 1, 0));
/// # Ok(())
/// # }
/// ```
pub struct InstancedGeometry {
    /// Prototypes and instances, and nothing else.
    scene: Scene,
    bvh: Bvh,
    level: Level,
    /// Coordinates are relative to the sum of this point and the scene's origin.
    offset: DVec3,
    bounds: Option<[DVec3; 2]>,
    /// By prototype.
    parts: Arc<[Part]>,
    count: usize,
    /// The indices of instances that are in the scene, in order, if some are of empty geometries, which are left out.
    kept: Option<Arc<[u32]>>,
}

impl fmt::Debug for InstancedGeometry {
    /// Counts: the arrays are large.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InstancedGeometry")
            .field("meshes", &self.parts.len())
            .field("instances", &self.count)
            .field("primitives", &self.scene.primitive_count())
            .finish_non_exhaustive()
    }
}

impl InstancedGeometry {
    /// Places geometries: each instance is an index into `meshes` and a transform. Copies the geometries and builds
    /// hierarchies of the copies, on rayon's threads.
    ///
    /// An instance of an empty geometry keeps its index and is never hit.
    ///
    /// # Errors
    /// [`QueryError::MeshIndex`], [`QueryError::NotFinite`], [`QueryError::Flat`], [`QueryError::Coordinate`] if an instance is
    /// farther than [`MAX_COORDINATE`](crate::scene::MAX_COORDINATE) from the centre of the scene (from 0, unless the scene is
    /// far from it), [`QueryError::TooMany`] (2^16 meshes or 2^24 instances) or [`QueryError::NoMemory`].
    pub fn new(meshes: &[&Geometry], instances: &[(usize, Transform)]) -> Result<Self, QueryError> {
        for (what, count, limit) in [
            ("meshes", meshes.len(), MAX_PROTOTYPES),
            ("instances", instances.len(), MAX_INSTANCES),
        ] {
            if count > limit {
                return Err(QueryError::TooMany { what, limit });
            }
        }
        let of_one = |geometry: &&Geometry| Part {
            bounds: geometry.bounds(),
            middle: geometry.middle(),
        };
        let parts: Arc<[Part]> = meshes.iter().map(of_one).collect();
        let wrong = instances.iter().position(|&(mesh, _)| mesh >= meshes.len());
        if let Some(instance) = wrong {
            return Err(QueryError::MeshIndex {
                instance,
                index: instances[instance].0,
                meshes: meshes.len(),
            });
        }
        check_finite(instances.iter().map(|(_, transform)| transform))?;
        let is_empty = |&(mesh, _): &(usize, Transform)| parts[mesh].bounds.is_none();
        let kept = instances.iter().any(is_empty).then(|| {
            let kept = (0..).zip(instances).filter(|(_, instance)| !is_empty(instance));
            kept.map(|(i, _)| i).collect::<Arc<[u32]>>()
        });
        let mut builder = SceneBuilder::new();
        for geometry in meshes {
            add(&mut builder, geometry)?;
        }
        let empty = builder.finish();
        let given = |i: usize| kept.as_ref().map_or(i, |kept| kept[i] as usize);
        let placed = Placed::new(&empty, &parts, kept.as_deref(), instances.len(), |i| {
            let (mesh, transform) = &instances[given(i)];
            (*mesh, transform)
        })?;
        Ok(Self {
            bvh: Bvh::build(&placed.scene),
            scene: placed.scene,
            level: Level::current(),
            offset: placed.offset,
            bounds: placed.bounds,
            parts,
            count: instances.len(),
            kept,
        })
    }

    /// Sets the instruction set of queries, by default the [current](Level::current) level. All give the same results.
    #[must_use]
    pub fn at_level(mut self, level: Level) -> Self {
        self.level = level;
        self
    }

    /// Moves all instances: a transform for each, in their order. Only the hierarchy over the instances is rebuilt. Results are
    /// those of a new scene, bit for bit.
    ///
    /// # Errors
    /// [`QueryError::Length`] if there are not as many transforms as instances; [`QueryError::NotFinite`],
    /// [`QueryError::Flat`] or [`QueryError::Coordinate`]. Nothing is changed then.
    pub fn move_instances(&mut self, transforms: &[Transform]) -> Result<(), QueryError> {
        let placed = self.placed(transforms)?;
        self.bvh.follow(&placed.scene);
        (self.scene, self.offset, self.bounds) = (placed.scene, placed.offset, placed.bounds);
        Ok(())
    }

    /// Returns a copy with moved instances, which shares the meshes and their hierarchies; other threads may keep using this
    /// one.
    ///
    /// # Errors
    /// As [`InstancedGeometry::move_instances`].
    pub fn moved(&self, transforms: &[Transform]) -> Result<Self, QueryError> {
        let placed = self.placed(transforms)?;
        let mut bvh = self.bvh.clone();
        bvh.follow(&placed.scene);
        Ok(Self {
            bvh,
            scene: placed.scene,
            level: self.level,
            offset: placed.offset,
            bounds: placed.bounds,
            parts: Arc::clone(&self.parts),
            count: self.count,
            kept: self.kept.clone(),
        })
    }

    fn placed(&self, transforms: &[Transform]) -> Result<Placed, QueryError> {
        if transforms.len() != self.count {
            return Err(QueryError::Length {
                what: "transforms",
                found: transforms.len(),
                expected: self.count,
            });
        }
        check_finite(transforms.iter())?;
        Placed::new(&self.scene, &self.parts, self.kept.as_deref(), self.count, |i| {
            let mesh = self.scene.instances()[i].prototype().0 as usize;
            (mesh, &transforms[self.given_index(i)])
        })
    }

    /// The index that the caller knows an instance of the scene by.
    fn given_index(&self, i: usize) -> usize {
        self.kept.as_ref().map_or(i, |kept| kept[i] as usize)
    }

    /// Returns the number of instances.
    #[must_use]
    pub fn instance_count(&self) -> usize {
        self.count
    }

    /// Returns the lower and upper corner of the box around the placed boxes of the geometries, world space; `None` if there is
    /// nothing. If instances are turned, it may be larger than the box around their primitives.
    #[must_use]
    pub fn bounds(&self) -> Option<[DVec3; 2]> {
        self.bounds
    }

    /// Returns the point that stored coordinates are relative to, world space: 0 on an axis unless the scene is far from 0
    /// there.
    #[must_use]
    pub fn middle(&self) -> DVec3 {
        self.offset + self.scene.origin().as_dvec3()
    }

    /// Returns prototypes and instances, relative to their middle, with ids of their own.
    #[doc(hidden)]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Finds the closest hit of a ray.
    #[must_use]
    pub fn closest_hit(&self, ray: &Ray) -> Option<InstancedHit> {
        self.closest(&UnitRay::new(ray, self.middle()))
    }

    /// Finds whether a ray hits anything.
    #[must_use]
    pub fn occluded(&self, ray: &Ray) -> bool {
        self.blocks(&UnitRay::new(ray, self.middle()))
    }

    /// Finds all hits of a ray, or the nearest `limit` ones, in order of t, then instance, then primitive; as
    /// [`Geometry::all_hits`].
    #[must_use]
    pub fn all_hits(&self, ray: &Ray, limit: Option<usize>) -> Vec<InstancedHit> {
        self.all_into(UnitRay::new(ray, self.middle()), limit, Vec::new())
    }

    fn all_into(&self, ray: UnitRay, limit: Option<usize>, hits: Vec<InstancedHit>) -> Vec<InstancedHit> {
        let first = hits.len();
        let mut all = All::new(ray, limit, &[], hits);
        let over = (&self.scene, &self.bvh);
        at_level!(self.level, |simd| visit_instances(simd, over, &ray.ray, &mut all));
        let mut hits = all.into_hits(first);
        for hit in &mut hits[first..] {
            *hit = self.given(hit);
        }
        hits
    }

    /// Makes a worker for many rays, which traces on the calling thread.
    #[must_use]
    pub fn worker(&self) -> Worker<'_, Self> {
        Worker::new(self)
    }

    /// Finds the closest hits of many rays, on the threads of the current rayon pool.
    ///
    /// # Panics
    /// If rays and hits differ in number.
    pub fn closest_hits<'r>(&self, rays: impl Into<Rays<'r>>, hits: &mut [InstancedHit]) {
        worker::closest_hits(self, rays.into(), hits);
    }

    /// Finds whether each of many rays hits anything, on the threads of the current rayon pool.
    ///
    /// # Panics
    /// If rays and results differ in number.
    pub fn occluded_each<'r>(&self, rays: impl Into<Rays<'r>>, occluded: &mut [bool]) {
        worker::occluded_each(self, rays.into(), occluded);
    }

    /// Finds all hits of many rays, as [`InstancedGeometry::all_hits`] does, on the threads of the current rayon pool.
    #[must_use]
    pub fn all_hits_each<'r>(
        &self,
        rays: impl Into<Rays<'r>>,
        limit: Option<usize>,
    ) -> AllHits<InstancedHit> {
        AllHits::of_each(rays.into(), (self.level, self.middle()), |unit, _, hits| {
            self.all_into(unit, limit, hits)
        })
    }

    /// Returns position and normal of a hit of the ray from `origin` along `direction`, in `f64`: where that line meets the
    /// placed triangle.
    ///
    /// The normal is that of the geometry, where the winding of a triangle decides, turned so that it stays at right angles
    /// (by the inverse transpose): what is outside of a geometry stays outside, of mirrored instances too.
    ///
    /// # Panics
    /// If there is no such instance that is not empty, or its geometry has no such primitive.
    #[must_use]
    pub fn surface(
        &self,
        origin: impl Into<DVec3>,
        direction: impl Into<DVec3>,
        hit: &InstancedHit,
    ) -> SurfacePoint {
        let i = match &self.kept {
            None => hit.instance.0 as usize,
            Some(kept) => kept
                .binary_search(&hit.instance.0)
                .expect("an instance that is hit"),
        };
        let (instance, middle) = (&self.scene.instances()[i], self.middle());
        let (prototype, first_sphere) = self.prototype(instance.prototype());
        let (local, triangles) = (hit.primitive.0, prototype.triangles.len() as u32);
        let id = if local < triangles {
            prototype.triangles.start + local
        } else {
            let sphere = local - triangles;
            assert!(sphere < prototype.spheres.len() as u32, "a primitive of the mesh");
            first_sphere + sphere
        };
        let placement = instance.placement();
        let line = placement.image_of_line([origin.into() - middle, direction.into()]);
        let (position, normal) = surface_of(self.scene.shape(PrimitiveId(id)), line, hit.t);
        SurfacePoint {
            position: placement.point_in_f64(position) + middle,
            normal: placement.normal_in_f64(normal).normalize(),
        }
    }

    /// A prototype, and the scene's id of its first sphere.
    #[inline]
    fn prototype(&self, id: PrototypeId) -> (&Prototype, u32) {
        let prototype = &self.scene.prototypes()[id.0 as usize];
        let triangles = self.scene.triangles().corners.len() as u32;
        (prototype, triangles + prototype.spheres.start)
    }

    /// A hit with the scene's ids, with those that the caller knows.
    fn given(&self, hit: &InstancedHit) -> InstancedHit {
        let i = hit.instance.0 as usize;
        let (prototype, first_sphere) = self.prototype(self.scene.instances()[i].prototype());
        let id = hit.primitive.0;
        let local = if id < first_sphere {
            id - prototype.triangles.start
        } else {
            id - first_sphere + prototype.triangles.len() as u32
        };
        InstancedHit {
            primitive: PrimitiveId(local),
            instance: InstanceId(self.given_index(i) as u32),
            ..*hit
        }
    }
}

impl Target for InstancedGeometry {
    type Hit = InstancedHit;

    fn middle(&self) -> DVec3 {
        self.middle()
    }

    fn tracer(&self) -> Tracer<'_> {
        let tracer = Tracer::new(&self.bvh).at_level(self.level);
        tracer.with_instances(&self.scene)
    }

    fn closest(&self, ray: &UnitRay) -> Option<InstancedHit> {
        let (mut closest, over) = (ClosestThere::new(ray), (&self.scene, &self.bvh));
        at_level!(self.level, |simd| visit_instances(
            simd,
            over,
            &ray.ray,
            &mut closest
        ));
        closest.hit().map(|hit| self.given(&hit))
    }

    fn blocks(&self, ray: &UnitRay) -> bool {
        let (mut any, over) = (Any::new(ray), (&self.scene, &self.bvh));
        at_level!(self.level, |simd| visit_instances(simd, over, &ray.ray, &mut any));
        any.is_hit
    }

    #[inline(always)]
    fn put<S: Simd>(
        &self,
        simd: S,
        (found, instances): (&HitPacket, &[u32]),
        lengths: &[f64; LANES],
        hits: &mut [InstancedHit],
    ) {
        let mut eight = [Hit::default(); LANES];
        worker::put(simd, found, lengths, &mut eight);
        for (lane, (to, hit)) in hits.iter_mut().zip(eight).enumerate() {
            *to = match instances.get(lane) {
                Some(&instance) if hit.is_hit() => self.given(&InstancedHit::new(hit, InstanceId(instance))),
                _ => InstancedHit::default(),
            };
        }
    }

    fn closest_of_piece(worker: &mut Worker<'_, Self>, rays: Rays<'_>, hits: &mut [InstancedHit]) {
        worker.closest_of_piece(rays, hits);
    }

    fn occluded_of_piece(worker: &mut Worker<'_, Self>, rays: Rays<'_>, occluded: &mut [bool]) {
        worker.occluded_of_piece(rays, occluded);
    }
}
