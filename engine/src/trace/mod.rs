//! Traces rays through the BVH: closest hits and occlusion.
//!
//! ```text
//! ray: a lane of a packet -- packet: 8, 16 or 32 rays -- bundle: up to 16 packets, one traversal      (group, policy)
//!   |  incoherent rays: sorted first (order), or single rays, 32 in flight (single)
//!   v
//! node: 8 boxes       x bundle frustum, then x packet frusta or rays -> child, packets, nearest       (bundle, stack)
//!   v
//! leaf block: up to 8 triangles or spheres     x packets -> candidates -> canonical test     (leaf, sheared, spheres)
//!   v
//! result sink: hits or bits, in the order of the rays                                                          (sink)
//! ```
//! All methods find the same hits, bit for bit: they differ only in the boxes that they skip, and skipped boxes hold no
//! hit. A [`Tracer`] chooses by how coherent the last rays were (policy). Measurements: docs/lab-notes.md.

mod bits;
mod bundle;
mod cut_outs;
mod directions;
mod dominant;
mod entering;
mod entry;
mod frustum;
mod group;
mod instances;
mod leaf;
mod nearby;
pub mod order;
mod origins;
mod pairs;
mod planes;
mod policy;
mod rays;
mod run;
mod scratch;
mod sheared;
mod single;
mod sink;
mod slabs;
mod slopes;
mod slots;
mod spheres;
mod stack;
mod visit;

use crate::{
    accel::{Bvh, Node8},
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, Origins, PrimitiveId, RayPacket},
    scene::{Plane, Scene},
    simd::{Level, REGISTER_LANES, Simd, at_level},
};
use bits::{bits, bits64, largest_axis, part};
use frustum::Frustum;
use glam::Vec3;
use instances::Instances;
pub(crate) use instances::{FoundThere, InstanceSink, visit_instances};
use origins::{Separate, Shared};
use policy::CoherencePolicy;
pub use policy::Method;
use scratch::Scratch;
pub(crate) use visit::{Found, HitSink, visit, visit_with};

/// Maximum packets of a bundle: the lanes of the widest register.
// Tuned: see docs/lab-notes.md#bundle-packets
const PACKETS: usize = REGISTER_LANES;

/// The most [`RayPacket`]s that are traced together. Calls with a multiple of it are fastest.
pub const BUNDLE: usize = 2 * BUNDLE_OF_16;

/// The most [`RayPacket`]s of a bundle whose packets hold sixteen rays.
const BUNDLE_OF_16: usize = PACKETS * REGISTER_LANES / LANES;

/// Capacity for single-ray tasks, 48 kB a tracer: more than a bundle leaves, except in odd scenes, where it grows.
// Tuned: see docs/lab-notes.md#slots
const BUFFERED_TASKS: usize = 4096;

/// Traces rays through one BVH. Owns the memory of traversal: make one per thread and reuse it.
#[derive(Debug)]
pub struct Tracer<'a> {
    bvh: &'a Bvh,
    /// The scene, if parts of its surfaces are cut out.
    cut_outs: Option<&'a Scene>,
    /// The scene, if light passes some surfaces in part.
    dimming: Option<&'a Scene>,
    /// See [`Self::stopping_where_dimmed`].
    stops_where_dimmed: bool,
    /// See [`Self::opaque_hit`].
    stops_only_where_opaque: bool,
    /// The scene, if some of its surfaces are one-sided.
    one_sided: Option<&'a Scene>,
    /// See [`Self::visible_hit`].
    passes_backs: bool,
    instances: Option<Box<Instances<'a>>>,
    /// Infinite planes, and the id of the first.
    planes: &'a [Plane],
    first_plane: PrimitiveId,
    policy: CoherencePolicy,
    level: Level,
    scratch: Scratch,
    /// The origin of rays that share it.
    origin: Vec3,
    /// Candidates of rays with separate origins.
    candidates: Box<sheared::Candidates>,
    bundle_stack: Vec<stack::Entry>,
    tasks: Vec<single::SingleRayTask>,
    sorted: order::Sorted,
    slots: Box<[slots::Slot; slots::SLOTS]>,
}

impl<'a> Tracer<'a> {
    /// Creates a tracer that chooses among all methods.
    #[must_use]
    pub fn new(bvh: &'a Bvh) -> Self {
        Self::with_method(bvh, Method::Adaptive)
    }

    /// Creates a tracer that uses only one method, for comparison.
    #[must_use]
    pub fn with_method(bvh: &'a Bvh, method: Method) -> Self {
        let size = bvh.stack_size();
        Self {
            bvh,
            cut_outs: None,
            dimming: None,
            stops_where_dimmed: false,
            stops_only_where_opaque: false,
            one_sided: None,
            passes_backs: false,
            instances: None,
            planes: &[],
            first_plane: PrimitiveId::NONE,
            policy: CoherencePolicy::new(method),
            level: Level::current(),
            scratch: Scratch::new(),
            origin: Vec3::ZERO,
            candidates: Box::new(sheared::Candidates::EMPTY),
            bundle_stack: Vec::with_capacity(size),
            tasks: Vec::with_capacity(BUFFERED_TASKS),
            sorted: order::Sorted::new(),
            slots: Box::new(slots::slots(bvh.stats().depth)),
        }
    }

    /// Checks that the BVH was built from this scene: ids would be those of other primitives.
    fn check(self, scene: &Scene) -> Self {
        assert!(self.bvh.is_of(scene), "this BVH was built from another scene");
        self
    }

    /// Sets the instruction set, by default the [current](Level::current) level. All give the same hits.
    #[must_use]
    pub fn at_level(mut self, level: Level) -> Self {
        self.hold_to(level);
        self
    }

    /// As [`at_level`](Self::at_level), in place.
    pub(crate) fn hold_to(&mut self, level: Level) {
        self.level = level;
        if let Some(instances) = &mut self.instances {
            instances.hold_to(level);
        }
    }

    /// Returns the level that the tracer uses.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Whether rays were sorted so far.
    #[must_use]
    pub fn has_sorted(&self) -> bool {
        !self.sorted.rays().is_empty()
    }

    /// Finds the closest hit of each ray; of equally near ones, the one with the lowest id. Neighbours in `rays`
    /// should be neighbours in space: [`BUNDLE`] of them are traced together.
    ///
    /// # Panics
    /// If `rays` and `hits`, or separate origins, differ in length.
    pub fn closest_hit(&mut self, origins: Origins<'_>, rays: &[RayPacket], hits: &mut [HitPacket]) {
        assert_eq!(rays.len(), hits.len(), "a hit packet for each ray packet");
        if self.stops_only_where_opaque || self.passes_backs {
            self.visit_all(origins, rays, hits);
        } else {
            match self.start_at(origins, rays) {
                None => self.dispatch::<_, Shared, false>(rays, &[], &mut *hits),
                Some(origins) => self.dispatch::<_, Separate, false>(rays, origins, &mut *hits),
            }
            if self.cut_outs.is_some_and(Scene::has_holes) {
                self.pass_closest(origins, rays, hits);
            }
        }
        let level = self.level;
        if let Some(instances) = &mut self.instances {
            at_level!(level, |simd| instances.closest(simd, origins, rays, hits));
        }
        if !self.planes.is_empty() {
            at_level!(self.level, |simd| self.planes_closest(simd, origins, rays, hits));
        }
    }

    /// Finds whether anything is hit before each ray's end: a bit per lane.
    ///
    /// # Panics
    /// If `rays` and `occluded`, or separate origins, differ in length.
    pub fn occluded(&mut self, origins: Origins<'_>, rays: &[RayPacket], occluded: &mut [u8]) {
        assert_eq!(rays.len(), occluded.len(), "eight bits for each ray packet");
        match self.start_at(origins, rays) {
            None => self.dispatch::<_, Shared, true>(rays, &[], &mut *occluded),
            Some(origins) => self.dispatch::<_, Separate, true>(rays, origins, &mut *occluded),
        }
        if let Some(scene) = self
            .cut_outs
            .filter(|scene| !self.stops_where_dimmed || scene.has_holes())
        {
            self.pass_occluded(scene, origins, rays, occluded);
        }
        let level = self.level;
        if let Some(instances) = &mut self.instances {
            at_level!(level, |simd| instances.occluded(simd, origins, rays, occluded));
        }
        if !self.planes.is_empty() {
            at_level!(self.level, |simd| self
                .planes_occluded(simd, origins, rays, occluded));
        }
    }

    /// Keeps the shared origin, or returns the separate ones.
    fn start_at<'o>(&mut self, origins: Origins<'o>, rays: &[RayPacket]) -> Option<&'o [Vec3x8]> {
        match origins {
            Origins::Shared(origin) => {
                self.origin = origin;
                None
            }
            Origins::Separate(origins) => {
                assert_eq!(rays.len(), origins.len(), "an origin for each ray");
                self.origin = Vec3::ZERO;
                Some(origins)
            }
        }
    }

    /// Returns whether any ray from `origin` may hit something in the cone spanned by `corners` (sums of them with
    /// weights of 0 or more). May return true if nothing is hit.
    #[must_use]
    pub fn may_hit(&self, origin: Vec3, corners: [Vec3; 4]) -> bool {
        // Frusta drop NaN.
        if !corners.iter().all(|corner| corner.is_finite()) || self.may_hit_planes(origin, corners) {
            return true;
        }
        let packet = RayPacket {
            direction: Vec3x8::from_lanes(std::array::from_fn(|lane| corners[lane % 4])),
            t_max: F32x8::ZERO,
        };
        at_level!(self.level, |simd| self.may_enter(simd, origin, &packet))
    }

    /// Whether the frustum around these rays meets anything, or there is no such frustum.
    #[inline(always)]
    fn may_enter<S: Simd>(&self, simd: S, origin: Vec3, rays: &RayPacket) -> bool {
        let Some(frustum) = Frustum::<S::V8>::around(simd, origin, std::slice::from_ref(rays)) else {
            return true;
        };
        let is_met = |nodes| entry::entry_node(nodes, &frustum).count != 0;
        is_met(self.bvh.nodes())
            || self.instances.is_some()
                && self
                    .bvh
                    .instanced()
                    .is_some_and(|instanced| is_met(instanced.nodes()))
    }

    /// The entry node of camera rays, if there is one.
    #[inline(always)]
    fn entry<S: Simd>(&self, simd: S, rays: &[RayPacket]) -> Option<Node8> {
        if rays.len() <= BUNDLE_OF_16 {
            return None;
        }
        let frustum = Frustum::<S::V8>::around(simd, self.origin, rays)?;
        Some(entry::entry_node(self.bvh.nodes(), &frustum))
    }
}
