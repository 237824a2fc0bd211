//! Traces rays through the BVH: closest hits and occlusion.
//!
//! ```text
//! rays -> packets of 8, 16 or 32 -> bundles of up to 16 packets, which share one traversal (bundle)
//!                                -> incoherent rays: sorted first (order), or one by one (single)
//!      -> result sink, in the order of the rays (sink)
//! ```
//! All ways find the same hits, bit for bit: they differ only in which boxes they skip, and skipped boxes hold no
//! hit. A [`Tracer`] chooses among them by how coherent the last rays were. Measurements: docs/lab-notes.md.

mod backoff;
mod bits;
mod bundle;
mod directions;
mod dominant;
mod entry;
mod frustum;
mod leaf;
mod order;
mod pairs;
mod rays;
mod room;
mod run;
mod sheared;
mod single;
mod sink;
mod visit;

use crate::{
    accel::{Bvh, LeafBlocks, Node8, TriangleBlocks, prefetch_for_later},
    geometry::TriangleLeaf,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, Origins, RayPacket},
    simd::{Lanes, Level, REGISTER_LANES, Simd, at_level},
};
use backoff::Backoff;
use bits::{bits, bits64, largest_axis, part};
use bundle::Culling;
use dominant::DominantAxis;
use frustum::{BundleFrustum, Frustum};
use glam::Vec3;
use rays::Packet;
use room::{RayLanes, Rooms};
use sheared::ShearedSpace;
use sink::ResultSink;
pub(crate) use visit::{Found, HitSink, visit};

/// Packets of a bundle at most: the lanes of the widest register.
// Tuned: see docs/lab-notes.md#bundle-packets
const PACKETS: usize = REGISTER_LANES;

/// The most [`RayPacket`]s that are traced together. Calls with a multiple of it, of neighbours in space, are
/// fastest.
pub const BUNDLE: usize = 2 * BUNDLE_OF_16;

/// The most [`RayPacket`]s of a bundle whose packets hold sixteen rays.
const BUNDLE_OF_16: usize = PACKETS * REGISTER_LANES / LANES;

/// Selects a traversal method; all give the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Whichever fits the rays: bundles, packets or single rays.
    #[default]
    Adaptive,
    /// Packets on their own, never bundles or single rays.
    Packet,
    /// One ray against eight boxes, eight primitives at a time.
    Single,
}

/// A bundle is incoherent if it makes more than half this many single-ray tasks per ray.
const INCOHERENT_HALVES: usize = 2;

/// How many groups skip sorting after it did not help.
const SKIPPED_SORTS: u32 = 8;

/// Capacity for single-ray tasks: more than a bundle leaves, except in odd scenes.
const BUFFERED_TASKS: usize = 4096;

/// Traces rays through one BVH. Owns the memory of traversal: make one per thread and reuse it.
#[derive(Debug)]
pub struct Tracer<'a> {
    bvh: &'a Bvh,
    method: Method,
    level: Level,
    rooms: Rooms,
    /// The origin of rays that share it.
    origin: Vec3,
    /// Candidates of rays with separate origins.
    candidates: Box<sheared::Candidates>,
    bundle_stack: Vec<bundle::Entry>,
    tasks: Vec<single::SingleRayTask>,
    sorted: order::Sorted,
    /// How many groups still skip sorting.
    skipped_sorts: u32,
    /// For rays with separate origins.
    separate_backoff: Backoff,
    /// For rays with a shared origin: closest hit, then occlusion.
    shared_backoff: [Backoff; 2],
    /// Of the current bundle.
    visits: Visits,
    /// Cost of the last group of shadow rays, whichever light it came from.
    effort: order::Effort,
    slots: Box<[single::Slot; single::SLOTS]>,
}

/// Counts the leaves that bundles visited.
#[derive(Clone, Copy, Debug, Default)]
struct Visits {
    leaves: usize,
    /// Packets that visited them, summed over the leaves.
    packets: usize,
}

impl Visits {
    /// Adds one or two leaves, visited by `packets`.
    #[inline(always)]
    fn add(&mut self, leaves: usize, packets: usize) {
        self.leaves += leaves;
        self.packets += packets;
    }
}

/// Whether a bundle of `rays` from one origin was incoherent: more than two leaves per ray, and fewer than two
/// packets per leaf (one and a half for occlusion). Triangles are then far smaller than the gaps between its rays.
// Tuned: see docs/lab-notes.md#incoherent-bundles
fn is_incoherent<const ANY: bool>(rays: usize, visits: Visits) -> bool {
    let least_x2 = if ANY { 3 } else { 4 };
    visits.leaves > 2 * rays && 2 * visits.packets < least_x2 * visits.leaves
}

/// [`RayPacket`]s with a shared origin that share one [`entry`]: four bundles of 256 rays, or eight of 128.
const ENTRY_PACKETS: usize = 128;

/// Prefetches packet `i` of the rays, if there is one. Called for each packet as another is made ready, since a core
/// has few outstanding misses.
// Tuned: see docs/lab-notes.md#prefetch-rays
#[inline(always)]
fn prefetch_rays(rays: &[RayPacket], origins: &[Vec3x8], i: usize) {
    if let Some(rays) = rays.get(i) {
        prefetch_for_later(rays);
    }
    if let Some(origins) = origins.get(i) {
        prefetch_for_later(origins);
    }
}

/// Packets that are traced in one order.
struct Group<'a> {
    /// First packet, and the end.
    start: usize,
    end: usize,
    /// Camera rays: the node to start at instead of the root.
    entry: Option<&'a Node8>,
    /// Single rays in the order in which they are packed, except for camera rays: packet times eight plus lane.
    /// `None`: live packets as they come.
    order: Option<&'a [u16]>,
}

/// Fills packets with rays of the `members` in order, and prefetches those `ahead`.
#[inline(always)]
fn fill<V: RayLanes, const SHARED: bool>(
    simd: V::Simd,
    packets: &mut [Packet<V::Memory>; PACKETS],
    rays: &[RayPacket],
    origins: &[Vec3x8],
    members: &[usize],
    ahead: usize,
) {
    let each = V::COUNT / LANES;
    for (p, packet) in packets.iter_mut().enumerate() {
        let members = part(members, p, each);
        if members.is_empty() {
            break;
        }
        for &i in members {
            prefetch_rays(rays, origins, i + ahead);
        }
        // Lanes without a ray repeat the last ones, with an end of 0; eights beyond the vector's lanes repeat the
        // first.
        let at = |eight: usize| members[(eight % each).min(members.len() - 1)];
        let from = [&rays[at(0)], &rays[at(1)], &rays[at(2)], &rays[at(3)]];
        let [a, b, c, d] = from;
        let mut t_max = [&a.t_max, &b.t_max, &c.t_max, &d.t_max];
        for eight in members.len()..each {
            t_max[eight % 4] = &F32x8::ZERO;
        }
        packet.set::<V>(simd, from, t_max);
        if !SHARED {
            let from = [&origins[at(0)], &origins[at(1)], &origins[at(2)], &origins[at(3)]];
            packet.start_at::<V>(simd, from);
        }
    }
}

impl<'a> Tracer<'a> {
    /// Creates a tracer that chooses its way by itself.
    #[must_use]
    pub fn new(bvh: &'a Bvh) -> Self {
        Self::with_method(bvh, Method::Adaptive)
    }

    /// Creates a tracer that is held to one way, to compare them.
    #[must_use]
    pub fn with_method(bvh: &'a Bvh, method: Method) -> Self {
        let size = bvh.stack_size();
        Self {
            bvh,
            method,
            level: Level::current(),
            rooms: Rooms::new(),
            origin: Vec3::ZERO,
            candidates: Box::new(sheared::Candidates::EMPTY),
            bundle_stack: Vec::with_capacity(size),
            tasks: Vec::with_capacity(BUFFERED_TASKS),
            sorted: order::Sorted::new(),
            skipped_sorts: 0,
            separate_backoff: Backoff::default(),
            shared_backoff: <[Backoff; 2]>::default(),
            visits: Visits::default(),
            effort: order::Effort::default(),
            slots: Box::new(single::slots(bvh.stats().depth)),
        }
    }

    /// Holds the tracer to a level; else it uses the [current](Level::current) one. All give the same hits.
    #[must_use]
    pub fn at_level(mut self, level: Level) -> Self {
        self.hold_to(level);
        self
    }

    /// Does what [`at_level`](Self::at_level) does.
    pub(crate) fn hold_to(&mut self, level: Level) {
        self.level = level;
    }

    /// Returns the level that the tracer uses.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// Finds the closest hit of each ray; of equally near ones, the one with the lowest id. Neighbours in `rays`
    /// should be neighbours in space: [`BUNDLE`] of them are traced together.
    ///
    /// # Panics
    /// If `rays` and `hits`, or separate origins, differ in length.
    pub fn closest_hit(&mut self, origins: Origins<'_>, rays: &[RayPacket], hits: &mut [HitPacket]) {
        assert_eq!(rays.len(), hits.len(), "a hit packet for each ray packet");
        match self.start_at(origins, rays) {
            None => self.dispatch::<_, false, true>(rays, &[], hits),
            Some(origins) => self.dispatch::<_, false, false>(rays, origins, hits),
        }
    }

    /// Finds whether anything is hit before each ray's end: a bit a lane.
    ///
    /// # Panics
    /// If `rays` and `occluded`, or separate origins, differ in length.
    pub fn occluded(&mut self, origins: Origins<'_>, rays: &[RayPacket], occluded: &mut [u8]) {
        assert_eq!(rays.len(), occluded.len(), "eight bits for each ray packet");
        match self.start_at(origins, rays) {
            None => self.dispatch::<_, true, true>(rays, &[], occluded),
            Some(origins) => self.dispatch::<_, true, false>(rays, origins, occluded),
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

    /// `origins` is empty where they are shared.
    fn dispatch<A: ResultSink, const ANY: bool, const SHARED: bool>(
        &mut self,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        results: A,
    ) {
        let bvh = self.bvh;
        let spheres = bvh.sphere_blocks();
        match bvh.triangle_blocks() {
            TriangleBlocks::Whole(triangles) => {
                let blocks = LeafBlocks { triangles, spheres };
                self.dispatch_to::<_, _, ANY, SHARED>(blocks, rays, origins, results);
            }
            TriangleBlocks::Indexed(triangles) => {
                let blocks = LeafBlocks { triangles, spheres };
                self.dispatch_to::<_, _, ANY, SHARED>(blocks, rays, origins, results);
            }
        }
    }

    /// Returns whether any ray from `origin` may hit something in the cone spanned by `corners` (sums of them with
    /// weights of 0 or more). May return true if nothing is hit.
    #[must_use]
    pub fn may_hit(&self, origin: Vec3, corners: [Vec3; 4]) -> bool {
        // Frusta drop NaN.
        if !corners.iter().all(|corner| corner.is_finite()) {
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
        entry::entry_node(self.bvh, &frustum).is_none_or(|entry| entry.count != 0)
    }

    /// Where camera rays start instead of the root, if that is known.
    #[inline(always)]
    fn entry<S: Simd>(&self, simd: S, rays: &[RayPacket]) -> Option<Node8> {
        if rays.len() <= BUNDLE_OF_16 {
            return None;
        }
        let frustum = Frustum::<S::V8>::around(simd, self.origin, rays)?;
        entry::entry_node(self.bvh, &frustum)
    }

    /// Traces a group, a bundle at a time. It calls [`trace`](Self::trace) once, since all of traversal is inlined
    /// there.
    // Tuned: see docs/lab-notes.md#one-traversal
    #[inline(always)]
    fn trace_group<B: TriangleLeaf, V: RayLanes, A: ResultSink, const ANY: bool, const SHARED: bool>(
        &mut self,
        simd: V::Simd,
        blocks: LeafBlocks<'_, B>,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        group: &Group<'_>,
        results: &mut A,
    ) {
        let &Group { start, end, .. } = group;
        let eights = V::COUNT / LANES;
        let most = if self.method == Method::Packet {
            1
        } else {
            PACKETS * eights
        };
        // Never set for camera rays: said here so that none of it is compiled for those.
        let order = if SHARED && !ANY { None } else { group.order };
        let origins_of_group = if SHARED { &[] } else { &origins[start..end] };
        if order.is_some() {
            for i in start..end {
                results.put_none(i, &rays[i]);
            }
        }
        let mut members = [0; BUNDLE];
        let (mut next, mut first) = (start, 0);
        let mut later = end;
        let asked_each = match order {
            Some(order) => order::PACKETS.div_ceil(order.len().div_ceil(V::COUNT).max(1)),
            None => 0,
        };
        loop {
            let (packets, mut count) = (&mut self.rooms.of_mut::<V>().packets, 0);
            let mut bundle: &[u16] = &[];
            if let Some(order) = order {
                bundle = &order[first..order.len().min(first + V::COUNT * PACKETS)];
                first += bundle.len();
                for (p, packet) in packets.iter_mut().enumerate() {
                    let members = part(bundle, p, V::COUNT);
                    if members.is_empty() {
                        break;
                    }
                    let upto = (later + asked_each).min(end + order::PACKETS);
                    for i in later..upto {
                        prefetch_rays(rays, origins, i);
                    }
                    later = upto;
                    packet.gather::<V, SHARED>(simd, &rays[start..end], origins_of_group, members);
                }
            } else {
                while next < end && count < most {
                    if rays::live(simd, &rays[next]) {
                        members[count % BUNDLE] = next;
                        results.prefetch(next);
                        count += 1;
                    } else {
                        results.put_none(next, &rays[next]);
                    }
                    next += 1;
                }
                let ahead = match (SHARED, ANY) {
                    (true, false) => ENTRY_PACKETS,
                    (false, _) => order::PACKETS,
                    _ if V::COUNT > REGISTER_LANES => BUNDLE,
                    _ => BUNDLE_OF_16,
                };
                fill::<V, SHARED>(simd, packets, rays, origins, &members[..count], ahead);
            }
            let filled = bundle.len().div_ceil(V::COUNT) + count.div_ceil(eights);
            if filled == 0 {
                break;
            }
            self.trace::<B, V, ANY, SHARED>(simd, blocks, filled, group.entry);
            let packets = &self.rooms.of::<V>().packets;
            for (p, packet) in packets.iter().enumerate() {
                results.scatter(simd, start, packet, part(bundle, p, V::COUNT));
            }
            for (member, &i) in members[..count].iter().enumerate() {
                results.put(simd, i, &packets[member / eights % PACKETS], member % eights);
            }
        }
    }

    /// Traces the first `count` packets.
    #[inline(always)]
    fn trace<B: TriangleLeaf, V: RayLanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        simd: V::Simd,
        blocks: LeafBlocks<'_, B>,
        count: usize,
        entry: Option<&Node8>,
    ) {
        if count == 0 {
            return;
        }
        const { assert!(<V::Packets as Lanes>::COUNT == PACKETS, "a lane for each packet") }
        let all = (1_u32 << count) - 1;
        let (lower, upper) = frustum::origins::<V, SHARED>(simd, &self.rooms.of::<V>().packets[..], all);
        let is_near = frustum::is_near(lower, upper);
        let point = Vec3::from(lower);
        let extent = (Vec3::from(upper) - point).length();
        let regroup = self.method != Method::Packet;
        let backoff = if SHARED {
            &self.shared_backoff[usize::from(ANY)]
        } else {
            &self.separate_backoff
        };
        let single = self.method == Method::Single || regroup && backoff.is_on();
        self.visits = Visits::default();
        let mut left = all;
        while left != 0 {
            let (packets, frustum) = if single || !is_near {
                (left, None)
            } else {
                self.next_group::<V, SHARED>(simd, left)
            };
            left &= !packets;
            if frustum.is_none() && regroup {
                self.go_alone::<V>(simd, packets);
                continue;
            }
            let culling = Culling {
                frustum: frustum.as_ref(),
                entry,
                exact: ANY || !SHARED || !regroup,
                regroup,
                space: ShearedSpace::new(frustum.as_ref(), point, extent),
                octant: frustum.as_ref().and_then(BundleFrustum::octant),
            };
            if !SHARED {
                let room = self.rooms.of_mut::<V>();
                for p in bits(packets) {
                    room.slabs[p % PACKETS].set::<V>(
                        simd,
                        &room.packets[p % PACKETS],
                        culling.octant.is_some(),
                    );
                    room.sheared[p % PACKETS].set::<V>(simd, &room.packets[p % PACKETS], &culling.space);
                }
            }
            self.traverse_bundle::<B, V, ANY, SHARED>(simd, blocks, packets, &culling);
        }
        let rays = count * V::COUNT;
        let backoff = if SHARED {
            &mut self.shared_backoff[usize::from(ANY)]
        } else {
            &mut self.separate_backoff
        };
        if single {
            backoff.one_less();
        } else if !SHARED {
            backoff.tried(self.tasks.len() > rays * INCOHERENT_HALVES / 2);
        } else if count >= PACKETS / 2 {
            // Small bundles at a picture's edge say nothing about others.
            backoff.tried(is_incoherent::<ANY>(rays, self.visits));
        }
        if SHARED && ANY {
            self.effort.add(rays, self.visits.packets, self.tasks.len());
        }
        // A call of its own: without optimisation all that is inlined into one function takes megabytes of its stack.
        simd.call(
            #[inline(always)]
            || self.trace_tasks::<B, V, ANY>(simd, blocks),
        );
    }

    /// Those of `packets` that are traced together next, with their frustum: all of them if one frustum holds them,
    /// else the most with one dominant axis, else all without a frustum.
    #[inline(always)]
    fn next_group<V: RayLanes, const SHARED: bool>(
        &self,
        simd: V::Simd,
        packets: u32,
    ) -> (u32, Option<BundleFrustum<V>>) {
        let states = &self.rooms.of::<V>().packets;
        let mut group = (packets, DominantAxis::of_most::<V>(simd, states, packets));
        loop {
            let frustum = BundleFrustum::new::<SHARED>(simd, states, group.0, group.1);
            if frustum.is_some() {
                return (group.0, frustum);
            }
            match dominant::largest_group::<V>(simd, states, packets) {
                Some(most) => group = most,
                None => return (packets, None),
            }
        }
    }

    /// Makes a single-ray task of each ray of `packets`.
    #[inline(always)]
    fn go_alone<V: RayLanes>(&mut self, simd: V::Simd, packets: u32) {
        let room = self.rooms.of::<V>();
        for p in bits(packets) {
            for i in bits(room.packets[p % PACKETS].live_bits::<V>(simd)) {
                self.tasks.push(single::SingleRayTask {
                    ray: (p * V::COUNT + i) as u32,
                    child: self.bvh.root(),
                    near: 0.0,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Visits, is_incoherent};

    #[test]
    fn bundles_are_given_up_where_triangles_are_smaller_than_what_is_between_rays() {
        // About as measured: pipes, twenty million triangles in blobs, and most other scenes.
        let visits = |leaves, packets| Visits { leaves, packets };
        assert!(!is_incoherent::<false>(512, visits(2000, 18_000)));
        assert!(is_incoherent::<false>(256, visits(700, 850)));
        assert!(!is_incoherent::<false>(256, visits(60, 70)));
        // Small triangles anywhere, and hair.
        assert!(is_incoherent::<true>(512, visits(2300, 3200)));
        assert!(!is_incoherent::<true>(512, visits(3700, 6500)));
    }
}
