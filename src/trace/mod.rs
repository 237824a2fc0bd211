//! Closest hits and occlusion over bundles (sixteen packets of eight or sixteen rays), packets and single rays.
//!
//! All ways give the same hits, bit for bit: they differ only in which boxes they skip, and what they skip has
//! no hit in it. A [`Tracer`] chooses among them by what its rays do: bundles as long as one frustum holds the
//! rays of several packets, packets as long as several lanes enter a box, single rays where coherence is gone.

mod answers;
mod backoff;
mod bundle;
mod entry;
mod frustum;
mod leaf;
mod lines;
mod order;
mod rays;
mod single;
mod way;

use crate::{
    accel::{Bvh, LeafBlocks, Node8, TriangleBlocks, prefetch_for_later},
    geometry::TriangleLeaf,
    ray::{HitPacket, Origins, RayPacket},
    simd::{
        F32x8, LANES, Vec3x8,
        lanes::{Column, Lanes, MOST_LANES},
        pair::{self, F32x8x2},
    },
};
use answers::{AHEAD, Answers, Hits};
use backoff::Backoff;
use bundle::Culling;
use frustum::{BundleFrustum, Frustum};
use glam::Vec3;
use lines::LineSpace;
use rays::{Packet, PacketSlabs};
use way::Way;

/// The most packets of a bundle: as many as the widest vector has lanes. (Sixteen of sixteen against eight: camera rays of
/// the interior +12 %, of the terrain +5 %, mirror rays +5 to +12 %; sixteen of eight against eight: see [`pair`]. Tried:
/// 32 of sixteen, which fill more than half of a core's first cache: shadow rays of small scenes 0 to +17 %, of large ones
/// -3 to +5 %, camera rays of triangles -9 to +9 %, of spheres +15 %; without AVX-512 -1 to +8 %.)
const PACKETS: usize = MOST_LANES;

/// The most [`RayPacket`]s that are traced together. Calls with a multiple of it, of neighbours in space, are fastest.
pub const BUNDLE: usize = PACKETS * MOST_LANES / LANES;

/// Which way of tracing to use; all give the same hits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// What fits the rays: bundles, packets or single rays.
    #[default]
    Adaptive,
    /// Packets of eight on their own, never bundles or single rays.
    Packet,
    /// One ray against eight boxes, eight primitives at a time.
    Single,
    /// As `Adaptive`, with the instructions that the build was compiled for even where the CPU has AVX-512.
    AdaptiveBaseline,
}

/// Where a bundle's rays have gone on one by one in this many halves of a subtree each, they are scattered: the bundle
/// was of no use, nor would the next ones be.
const SCATTERED: usize = 2;

/// Where sorting has led to scattered rays all the same it is left out so many times.
const UNSORTED: u32 = 8;

/// Room for rays that go on one by one: more than a bundle leaves, but in odd scenes.
const ITEMS: usize = 4096;

/// Traces rays through one BVH. Holds the memory of traversal: one for each thread, reused for all its rays.
#[derive(Debug)]
pub struct Tracer<'a> {
    bvh: &'a Bvh,
    method: Method,
    packets: Box<[Packet; PACKETS]>,
    /// Where all of them start, as bits, if that is one point: rays of the next call often start there, too.
    shared: Option<[u32; 3]>,
    /// The rays as lines, only while rays with their own origins are traced in bundles. (Three columns more as a part
    /// of the packets cost camera rays of small scenes 4 %.)
    lines: Box<[lines::PacketLines; PACKETS]>,
    /// As the lines.
    slabs: Box<[PacketSlabs; PACKETS]>,
    /// As the lines.
    looks: Box<lines::Looks>,
    bundle_stack: Vec<bundle::Entry>,
    items: Vec<single::Item>,
    sorted: order::Sorted,
    /// How many times sorting is still left out.
    unsorted: u32,
    /// Whether nodes [wait](bundle), too: the tree is larger than caches near the core are.
    nodes_wait: bool,
    /// Rays that share their origin go in packets of eight, too.
    eight_lanes: bool,
    /// Of rays with their own origins.
    scattered: Backoff,
    /// Of rays with a shared origin whose closest hit is asked for. A bundle that visits more than two leaves for each
    /// of its rays is of no use: triangles are far smaller than what is between its rays. (Camera rays of ten million
    /// triangles: 9.6 to 13.8 Mrays/s. With one leaf a ray 14.5, but a million then lose 6 %.)
    crowded: Backoff,
    /// Leaves that the bundle in hand has visited.
    leaves: usize,
    slots: Box<[single::Slot; single::SLOTS]>,
}

/// Nodes of a large tree, bytes. (Its whole blocks of triangles are eight times as much, indexed ones five times.)
const LARGE: usize = 1 << 20;

/// The set bits of a mask, lowest first.
#[inline(always)]
fn bits(mask: u32) -> Bits {
    Bits(u64::from(mask))
}

/// As [`bits`].
#[inline(always)]
fn bits64(mask: u64) -> Bits {
    Bits(mask)
}

/// See [`bits`]. (An iterator and not a function that takes a closure: closures do not inherit the instruction set of
/// the kernel that they are written in, and are not always inlined.)
struct Bits(u64);

impl Iterator for Bits {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let lowest = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(lowest)
    }
}

/// So many [`RayPacket`]s that start at one point share an [`entry`]: four bundles of 256 rays, or eight of 128.
const ENTRY_PACKETS: usize = 128;

/// Asks for the memory of packet `i` of the rays, where there is one: rays further on come from memory while others are
/// traced, each as another is made ready, for a core waits for few lines at a time. (To ask once a bundle, for the next
/// bundle's rays, left the frustum of an [`entry`] to wait for all of its own: on a Xeon, whose memory answers in 160
/// ns, camera rays -4 to -10 % in small scenes, 0 to -4 % in large ones. Sorted mirror rays without this: 0 to -4 %.)
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
    /// From which packet on, and up to which.
    start: usize,
    end: usize,
    /// What to visit in place of the root, for camera rays.
    entry: Option<&'a Node8>,
    /// For rays with their own origins: single ones, to be put together in this order: each is a packet, from the first
    /// on, times eight plus lane. `None`: packets that hold a ray, as they come.
    order: Option<&'a [u16]>,
}

/// Fills packets with rays as they come, those that `members` tells, and asks for those `ahead`.
#[inline(always)]
fn fill<V: Lanes, const SHARED: bool>(
    packets: &mut [Packet; PACKETS],
    rays: &[RayPacket],
    origins: &[Vec3x8],
    members: &[usize],
    ahead: usize,
) {
    for (packet, pair) in packets.iter_mut().zip(members.chunks(V::COUNT / LANES)) {
        for &i in pair {
            prefetch_rays(rays, origins, i + ahead);
        }
        let low = &rays[pair[0]];
        match pair.get(1) {
            Some(&high) => packet.set::<V>(low, &rays[high]),
            None => packet.set::<V>(
                low,
                &RayPacket {
                    t_max: F32x8::ZERO,
                    ..*low
                },
            ),
        }
        if !SHARED {
            let high = pair.get(1).unwrap_or(&pair[0]);
            packet.start_at::<V>(&origins[pair[0]], &origins[*high]);
        }
    }
}

impl<'a> Tracer<'a> {
    /// A tracer that chooses its way by itself.
    #[must_use]
    pub fn new(bvh: &'a Bvh) -> Self {
        Self::with_method(bvh, Method::Adaptive)
    }

    /// A tracer that is held to one way, to compare them.
    #[must_use]
    pub fn with_method(bvh: &'a Bvh, method: Method) -> Self {
        let size = bvh.stack_size();
        Self {
            bvh,
            method,
            packets: Box::new([Packet::EMPTY; PACKETS]),
            shared: None,
            lines: Box::new([lines::PacketLines::EMPTY; PACKETS]),
            slabs: Box::new([PacketSlabs::EMPTY; PACKETS]),
            looks: Box::new(lines::Looks::EMPTY),
            bundle_stack: Vec::with_capacity(size),
            items: Vec::with_capacity(ITEMS),
            sorted: order::Sorted::new(),
            unsorted: 0,
            nodes_wait: size_of_val(bvh.nodes()) > LARGE,
            eight_lanes: false,
            scattered: Backoff::default(),
            crowded: Backoff::default(),
            leaves: 0,
            slots: Box::new(single::slots(bvh.stats().depth)),
        }
    }

    /// Whether nodes [wait](bundle) in occlusion, which else the size of the tree decides: to verify that in small trees,
    /// too.
    pub(crate) fn let_nodes_wait(&mut self, wait: bool) {
        self.nodes_wait = wait;
    }

    /// Never a [pair] of vectors, as in builds for which it does not pay: to verify those in others, too.
    pub(crate) fn hold_to_eight_lanes(&mut self) {
        self.eight_lanes = true;
    }

    /// The nearest hits of all rays; of several equally near, the one with the lowest id. Neighbours in `rays` should
    /// be neighbours in space: [`BUNDLE`] of them are traced together. More than 4 MB of hits are written past the
    /// caches.
    ///
    /// # Panics
    /// If `rays` and `hits`, or separate origins, differ in length.
    pub fn closest_hit(&mut self, origins: Origins<'_>, rays: &[RayPacket], hits: &mut [HitPacket]) {
        assert_eq!(rays.len(), hits.len(), "a hit packet for each ray packet");
        match self.start_at(origins, rays) {
            None => self.dispatch::<_, false, true>(rays, &[], Hits::new(hits)),
            Some(origins) => self.dispatch::<_, false, false>(rays, origins, Hits::new(hits)),
        }
    }

    /// Whether anything is hit before the rays' ends: a bit a lane.
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

    /// Gives all packets their shared origin, or answers those that are separate.
    fn start_at<'o>(&mut self, origins: Origins<'o>, rays: &[RayPacket]) -> Option<&'o [Vec3x8]> {
        match origins {
            Origins::Shared(origin) => {
                // By bits: 0 and -0 are equal, and make edge functions of different signs.
                let bits = origin.to_array().map(f32::to_bits);
                if self.shared != Some(bits) {
                    let columns = origin.to_array().map(Column::splat);
                    for packet in self.packets.iter_mut() {
                        packet.origin = columns;
                    }
                    self.shared = Some(bits);
                }
                None
            }
            Origins::Separate(origins) => {
                assert_eq!(rays.len(), origins.len(), "an origin for each ray");
                self.shared = None;
                Some(origins)
            }
        }
    }

    /// `origins` is empty where they are shared.
    fn dispatch<A: Answers, const ANY: bool, const SHARED: bool>(
        &mut self,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        answers: A,
    ) {
        let bvh = self.bvh;
        let spheres = bvh.sphere_blocks();
        match bvh.triangle_blocks() {
            TriangleBlocks::Whole(triangles) => {
                let blocks = LeafBlocks { triangles, spheres };
                self.dispatch_to::<_, _, ANY, SHARED>(blocks, rays, origins, answers);
            }
            TriangleBlocks::Indexed(triangles) => {
                let blocks = LeafBlocks { triangles, spheres };
                self.dispatch_to::<_, _, ANY, SHARED>(blocks, rays, origins, answers);
            }
        }
    }

    /// [`dispatch`](Self::dispatch) for blocks of one layout: to kernels of sixteen lanes where the CPU has AVX-512, or
    /// where rays share their origin and it [pays](pair); else of eight.
    fn dispatch_to<B: TriangleLeaf, A: Answers, const ANY: bool, const SHARED: bool>(
        &mut self,
        blocks: LeafBlocks<'_, B>,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        answers: A,
    ) {
        #[cfg(target_arch = "x86_64")]
        if self.method != Method::Packet
            && self.method != Method::AdaptiveBaseline
            && crate::simd::avx512::is_available()
        {
            // SAFETY: the CPU has these instructions.
            return unsafe { self.run_avx512::<B, A, ANY, SHARED>(blocks, rays, origins, answers) };
        }
        if pair::IS_FAST && SHARED && self.method != Method::Packet && !self.eight_lanes {
            return self.run::<B, F32x8x2, A, ANY, SHARED>(blocks, rays, origins, answers);
        }
        self.run::<B, F32x8, A, ANY, SHARED>(blocks, rays, origins, answers);
    }

    /// [`run`](Self::run) with sixteen lanes.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    fn run_avx512<B: TriangleLeaf, A: Answers, const ANY: bool, const SHARED: bool>(
        &mut self,
        blocks: LeafBlocks<'_, B>,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        answers: A,
    ) {
        self.run::<B, crate::simd::avx512::F32x16, A, ANY, SHARED>(blocks, rays, origins, answers);
    }

    /// Traces in the order that fits: as the packets come, or ray by ray in order of directions.
    #[inline(always)]
    fn run<B: TriangleLeaf, V: Lanes, A: Answers, const ANY: bool, const SHARED: bool>(
        &mut self,
        blocks: LeafBlocks<'_, B>,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        mut answers: A,
    ) {
        let is_adaptive = self.method == Method::Adaptive || self.method == Method::AdaptiveBaseline;
        let at_a_time = match (SHARED, ANY) {
            (true, false) if is_adaptive => ENTRY_PACKETS,
            (false, _) if is_adaptive => order::PACKETS,
            _ => rays.len().max(1),
        };
        let mut sorted = std::mem::take(&mut self.sorted);
        for start in (0..rays.len()).step_by(at_a_time) {
            let end = rays.len().min(start + at_a_time);
            let (mut entry, mut order) = (None, None);
            if SHARED && !ANY && is_adaptive {
                entry = self.entry(&rays[start..end]);
                if entry.as_ref().is_some_and(|entry| entry.count == 0) {
                    for (i, packet) in rays.iter().enumerate().take(end).skip(start) {
                        answers.prefetch((i + AHEAD).min(rays.len() - 1));
                        prefetch_rays(rays, &[], i + ENTRY_PACKETS);
                        answers.put_none::<V>(i, packet);
                    }
                    continue;
                }
            } else if !SHARED && is_adaptive {
                if self.unsorted == 0 && sorted.by_direction(&rays[start..end]) {
                    order = Some(sorted.rays());
                }
                self.unsorted = self.unsorted.saturating_sub(1);
            }
            let group = Group {
                start,
                end,
                entry: entry.as_ref(),
                order,
            };
            self.trace_group::<B, V, A, ANY, SHARED>(blocks, rays, origins, &group, &mut answers);
            if order.is_some() && self.scattered.is_on() {
                self.unsorted = UNSORTED;
            }
        }
        self.sorted = sorted;
    }

    /// Where camera rays begin in place of the root, if that is known.
    #[inline(always)]
    fn entry(&self, rays: &[RayPacket]) -> Option<Node8> {
        if rays.len() <= BUNDLE {
            return None;
        }
        let [x, y, z] = &self.packets[0].origin;
        let frustum = Frustum::around(Vec3::new(x.0[0], y.0[0], z.0[0]), rays)?;
        entry::entry_node(self.bvh, &frustum)
    }

    /// Traces a group, a bundle at a time. (One call of [`trace`](Self::trace) for both orders, for all of traversal is
    /// compiled into it: mirror rays of cow, figure and interior +2 to +4 %, and a third less code.)
    #[inline(always)]
    fn trace_group<B: TriangleLeaf, V: Lanes, A: Answers, const ANY: bool, const SHARED: bool>(
        &mut self,
        blocks: LeafBlocks<'_, B>,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        group: &Group<'_>,
        answers: &mut A,
    ) {
        let &Group { start, end, .. } = group;
        let halves = V::COUNT / LANES;
        let most = if self.method == Method::Packet {
            1
        } else {
            PACKETS * halves
        };
        // Never there where origins are shared: said so that none of it is compiled for those.
        let order = if SHARED { None } else { group.order };
        if order.is_some() {
            for (i, rays) in rays.iter().enumerate().take(end).skip(start) {
                answers.clear(i, rays);
            }
        }
        let mut members = [0; BUNDLE];
        let (mut next, mut first) = (start, 0);
        let mut later = end..end + order::PACKETS;
        let asked_each = match order {
            Some(order) => order::PACKETS.div_ceil(order.len().div_ceil(V::COUNT).max(1)),
            None => 0,
        };
        loop {
            let (packets, mut count) = (&mut self.packets, 0);
            let mut bundle: &[u16] = &[];
            if let Some(order) = order {
                bundle = &order[first..order.len().min(first + V::COUNT * PACKETS)];
                first += bundle.len();
                for (packet, members) in packets.iter_mut().zip(bundle.chunks(V::COUNT)) {
                    for i in later.by_ref().take(asked_each) {
                        prefetch_rays(rays, origins, i);
                    }
                    packet.gather::<V>(&rays[start..end], &origins[start..end], members);
                }
            } else {
                while next < end && count < most {
                    if rays::live(&rays[next]) {
                        members[count % BUNDLE] = next;
                        answers.prefetch(next);
                        count += 1;
                    } else {
                        answers.put_none::<V>(next, &rays[next]);
                    }
                    next += 1;
                }
                let ahead = if SHARED && !ANY { ENTRY_PACKETS } else { BUNDLE };
                fill::<V, SHARED>(packets, rays, origins, &members[..count], ahead);
            }
            let filled = bundle.len().div_ceil(V::COUNT) + count.div_ceil(halves);
            if filled == 0 {
                break;
            }
            self.trace::<B, V, ANY, SHARED>(blocks, filled, group.entry);
            for (packet, members) in self.packets.iter().zip(bundle.chunks(V::COUNT)) {
                answers.scatter(start, packet, members);
            }
            for (member, &i) in members[..count].iter().enumerate() {
                answers.put::<V>(i, &self.packets[member / halves], member % halves);
            }
        }
    }

    /// Traces the first `count` packets.
    #[inline(always)]
    fn trace<B: TriangleLeaf, V: Lanes, const ANY: bool, const SHARED: bool>(
        &mut self,
        blocks: LeafBlocks<'_, B>,
        count: usize,
        entry: Option<&Node8>,
    ) {
        if count == 0 {
            return;
        }
        const { assert!(<V::Packets as Lanes>::COUNT == PACKETS, "a lane for each packet") }
        let all = (1_u32 << count) - 1;
        let (lower, upper) = frustum::origins::<V, SHARED>(&self.packets[..], all);
        let point = Vec3::from(lower);
        let extent = (Vec3::from(upper) - point).length();
        let regroup = self.method != Method::Packet;
        let is_scattered = !SHARED && self.scattered.is_on() || SHARED && !ANY && self.crowded.is_on();
        let single = self.method == Method::Single || regroup && is_scattered;
        self.leaves = 0;
        let mut left = all;
        while left != 0 {
            let (packets, frustum) = if single {
                (left, None)
            } else {
                self.next_group::<V, SHARED>(left)
            };
            left &= !packets;
            if frustum.is_none() && regroup {
                self.go_alone::<V>(packets);
                continue;
            }
            let culling = Culling {
                frustum: frustum.as_ref(),
                entry,
                exact: ANY || !SHARED || !regroup,
                regroup,
                space: LineSpace::new(frustum.as_ref(), point, extent),
                down: frustum.as_ref().and_then(BundleFrustum::down),
            };
            if !SHARED {
                for p in bits(packets) {
                    self.slabs[p % PACKETS].set::<V>(&self.packets[p % PACKETS], culling.down.is_some());
                    self.lines[p % PACKETS].set::<V>(&self.packets[p % PACKETS], &culling.space);
                }
            }
            self.traverse_bundle::<B, V, ANY, SHARED>(blocks, packets, &culling);
        }
        let rays = count * V::COUNT;
        if !SHARED && single {
            self.scattered.one_less();
        } else if !SHARED {
            self.scattered.tried(self.items.len() > rays * SCATTERED / 2);
        } else if !ANY && single {
            self.crowded.one_less();
        } else if !ANY {
            self.crowded.tried(self.leaves > 2 * rays);
        }
        self.trace_items::<B, V, ANY>(blocks);
    }

    /// Those of `packets` that are traced together next, and their frustum: all of them if one holds them, else many
    /// that go one way. Without a frustum, there are none that do.
    #[inline(always)]
    fn next_group<V: Lanes, const SHARED: bool>(&self, packets: u32) -> (u32, Option<BundleFrustum<V>>) {
        let mut group = (packets, Way::of_most::<V>(&self.packets, packets));
        loop {
            let frustum = BundleFrustum::new::<SHARED>(&self.packets, group.0, group.1);
            if frustum.is_some() {
                return (group.0, frustum);
            }
            match way::most_going_one_way::<V>(&self.packets, packets) {
                Some(most) => group = most,
                None => return (packets, None),
            }
        }
    }

    /// Puts all rays of `packets` into `items`.
    #[inline(always)]
    fn go_alone<V: Lanes>(&mut self, packets: u32) {
        for p in bits(packets) {
            for i in bits(self.packets[p % PACKETS].live_bits::<V>()) {
                self.items.push(single::Item {
                    ray: (p * V::COUNT + i) as u32,
                    child: self.bvh.root(),
                    near: 0.0,
                });
            }
        }
    }
}
