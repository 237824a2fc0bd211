//! Bundle traversal: up to 16 packets descend the BVH together.
//!
//!   bundle (<= 16 packets)
//!      | bundle frustum x 8 child boxes
//!   surviving children
//!      | 1 child box x 16 packet frusta (separate origins: x rays, packet by packet)  -> pairs of child and packet
//!   stack of (child, packets, near)  -> leaves pass a ring of 4 while their memory arrives
//!   leaf block: 8 triangles x packets  -> hits
//!
//! After Boulos et al. 2006 and Overbeck et al. 2008 (*Large Ray Packets*), with a bit mask instead of a first active
//! packet.

use super::{
    PACKETS, Tracer, bits,
    entering::nearest8,
    frustum::BundleFrustum,
    origins::RayOrigins,
    pairs::Pairs,
    scratch::RayLanes,
    sheared::ShearedSpace,
    single::SingleRayTask,
    slabs::in_order,
    stack::{DeferredLeaves, Entry, Limits},
};
use crate::{
    accel::Node8,
    lanes::{F32x8, LANES},
    simd::{EightLanes, LaneMask, Lanes, Memory, REGISTER_LANES, Simd, TriangleLanes, unpack},
};

/// How the rays of a bundle are culled.
pub(super) struct Culling<'a, V: Lanes> {
    pub frustum: Option<&'a BundleFrustum<V>>,
    /// Camera rays: the node to start at instead of the root.
    pub entry: Option<&'a Node8>,
    /// Whether boxes are also tested ray by ray.
    pub exact: bool,
    /// Whether rays become single-ray tasks once few of a packet remain.
    pub regroup: bool,
    /// The direction octant: for each axis 1 if all rays are negative along it, 0 if positive. `None` if they differ.
    pub octant: Option<[u8; 3]>,
    /// For rays with separate origins.
    pub space: ShearedSpace,
}

impl<V: Lanes> Culling<'_, V> {
    /// The limit of packet `p` if none of its lanes takes a hit beyond distance `t`.
    #[inline(always)]
    fn limit(&self, p: usize, t: f32) -> f32 {
        match self.frustum {
            Some(frustum) => frustum.q_limit(p, t),
            None => t,
        }
    }
}

impl Tracer<'_> {
    /// Traces `packets` through the whole tree; rays that diverge from the others become single-ray `tasks`.
    #[inline(always)]
    pub(super) fn traverse_bundle<V: RayLanes, O: RayOrigins, const ANY: bool>(
        &mut self,
        simd: V::Simd,
        packets: u32,
        culling: &Culling<'_, V>,
    ) {
        let (packets, mut limits) = self.start_limits(simd, packets, culling);
        self.bundle_stack.clear();
        match culling.entry {
            Some(entry) if O::ARE_SHARED && !ANY => {
                // A separate call, as in `trace`.
                simd.call(
                    #[inline(always)]
                    || self.push_children::<V, O>(simd, entry, culling, packets, limits),
                );
            }
            _ => self.bundle_stack.push(Entry {
                child: self.bvh.root(),
                packets,
                q_near: 0.0,
            }),
        }
        let mut deferred = DeferredLeaves::EMPTY;
        while let Some(leaf) = self.next_leaf::<V, O>(simd, culling, &mut deferred, limits) {
            let taken = O::visit_leaf::<V, ANY>(self, simd, leaf, &mut deferred, culling, limits);
            if ANY {
                // No branch per packet.
                limits.end(taken);
                continue;
            }
            for p in bits(taken) {
                let t = self.scratch.of::<V>().packets[p % PACKETS].farthest::<V>(simd);
                limits.set(p, culling.limit(p, t));
            }
        }
    }

    /// Those of `packets` that can hit anything, and how far.
    #[inline(always)]
    fn start_limits<V: RayLanes>(
        &self,
        simd: V::Simd,
        packets: u32,
        culling: &Culling<'_, V>,
    ) -> (u32, Limits<V>) {
        // One row of `t` per packet, reduced to one lane per packet.
        let mut ends = [V::Triangles::splat(simd, 0.0); REGISTER_LANES];
        let scratch = self.scratch.of::<V>();
        for p in bits(packets) {
            ends[p % REGISTER_LANES] = V::load(simd, &scratch.packets[p % PACKETS].t).fold_max_to_16();
        }
        let farthest = V::Triangles::largest_of_each(&ends);
        let can_hit = farthest.gt(V::Packets::splat(simd, 0.0));
        let limits = match culling.frustum {
            Some(frustum) => frustum.q_limits(farthest),
            None => farthest,
        };
        (can_hit.bits(), Limits::new(can_hit, limits))
    }

    /// Descends to the next leaf that some packets reach.
    #[inline(always)]
    fn next_leaf<V: RayLanes, O: RayOrigins>(
        &mut self,
        simd: V::Simd,
        culling: &Culling<'_, V>,
        deferred: &mut DeferredLeaves,
        limits: Limits<V>,
    ) -> Option<Entry> {
        loop {
            let due = match self.bundle_stack.pop() {
                None => Some(deferred.pop()?),
                Some(entry) => {
                    let packets = limits.reached(entry);
                    let entry = Entry { packets, ..entry };
                    if packets == 0 {
                        continue;
                    }
                    if entry.child.is_inner() {
                        let node = &self.bvh.nodes()[entry.child.index()];
                        self.push_children::<V, O>(simd, node, culling, packets, limits);
                        deferred.pop()
                    } else if !O::ARE_SHARED {
                        return Some(entry);
                    } else {
                        deferred.push(entry);
                        if deferred.is_full() { deferred.pop() } else { None }
                    }
                }
            };
            if let Some(leaf) = due {
                // Packets may have finished while it waited.
                let packets = limits.reached(leaf);
                if packets != 0 {
                    return Some(Entry { packets, ..leaf });
                }
            }
        }
    }

    /// Pushes the children that some of `packets` may hit, nearest last.
    #[inline(always)]
    fn push_children<V: RayLanes, O: RayOrigins>(
        &mut self,
        simd: V::Simd,
        node: &Node8,
        culling: &Culling<'_, V>,
        packets: u32,
        limits: Limits<V>,
    ) {
        let (candidates, seen) = match culling.frustum {
            Some(frustum) => {
                let (candidates, seen) = frustum.children(node);
                (candidates, Some(seen))
            }
            None => (node.valid_bits(), None),
        };
        let mut pairs = Pairs::default();
        debug_assert!(O::ARE_SHARED || culling.exact, "pairs come from ray by ray");
        match (culling.frustum, &seen) {
            // All of them are tested ray by ray.
            _ if !O::ARE_SHARED => {}
            // A single packet fills the bundle's frustum.
            (Some(frustum), Some(seen)) if culling.regroup => {
                for c in bits(candidates) {
                    pairs.put(c, packets & frustum.packets_of(seen, c, limits.lanes()));
                }
            }
            _ => {
                for c in bits(candidates) {
                    pairs.put(c, packets);
                }
            }
        }
        let mut near8 = match seen {
            Some(seen) => seen.q_near,
            None => simd.splat(0.0),
        };
        let mut chosen = pairs.children();
        if culling.exact {
            let few = if culling.octant.is_some() {
                self.enter_children::<V, O, true>(simd, node, culling, candidates, packets, &mut pairs)
            } else {
                self.enter_children::<V, O, false>(simd, node, culling, candidates, packets, &mut pairs)
            };
            chosen = pairs.children() & !few;
            if culling.frustum.is_none() {
                near8 = nearest8::<V>(simd, node, &pairs, &self.scratch.of::<V>().packets);
            }
        }
        let places = self.bvh.places();
        let (order, count) = near8.nearest_last(chosen);
        for &entry in order.iter().take(count) {
            let (q_near, c) = unpack(entry);
            let child = node.child[c];
            places.prefetch(child);
            self.bundle_stack.push(Entry {
                child,
                packets: pairs.packets(c),
                q_near,
            });
        }
    }

    /// Narrows `pairs` to those with a ray that enters. Returns the children that so few rays enter that they continue
    /// alone.
    #[inline(always)]
    fn enter_children<V: RayLanes, O: RayOrigins, const ONE_OCTANT: bool>(
        &mut self,
        simd: V::Simd,
        node: &Node8,
        culling: &Culling<'_, V>,
        candidates: u32,
        packets: u32,
        pairs: &mut Pairs,
    ) -> u32 {
        let planes = O::seen_planes(simd, in_order(node, culling.octant), self.origin);
        let scratch = self.scratch.of::<V>();
        let entering = O::entering::<V, ONE_OCTANT>(simd, &planes, pairs, candidates, packets, scratch);
        *pairs = entering.pairs;
        if !culling.regroup {
            return 0;
        }
        let few = pairs.children() & !entering.more;
        if few != 0 {
            simd.call(
                #[inline(always)]
                || self.go_on_alone::<V, O, ONE_OCTANT>(simd, node, &planes, few, pairs),
            );
        }
        few
    }

    /// Makes single-ray tasks of the rays that enter the children `few`. They are few, so finding them again is
    /// cheaper than keeping all entering rays.
    #[inline(always)]
    fn go_on_alone<V: RayLanes, O: RayOrigins, const ONE_OCTANT: bool>(
        &mut self,
        simd: V::Simd,
        node: &Node8,
        planes: &[F32x8; 6],
        few: u32,
        pairs: &Pairs,
    ) {
        let scratch = self.scratch.of::<V>();
        for c in bits(few) {
            for p in bits(pairs.packets(c)) {
                let live = scratch.packets[p % PACKETS].live_bits::<V>(simd);
                let (near, lanes) = O::enter::<V, ONE_OCTANT>(simd, planes, c, p, scratch);
                let mut nears = V::Memory::ZERO;
                near.store(&mut nears);
                for i in bits(lanes.bits() & live) {
                    self.tasks.push(SingleRayTask {
                        ray: (p * V::COUNT + i) as u32,
                        child: node.child[c % LANES],
                        near: nears.place(i),
                    });
                }
            }
        }
    }
}
