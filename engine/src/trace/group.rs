//! Groups of packets, traced bundle by bundle: fills packets with rays, traces them, and writes the results.

use super::{
    BUNDLE, PACKETS, Tracer, bits,
    bundle::Culling,
    dominant::{self, DominantAxis},
    frustum::BundleFrustum,
    order,
    origins::{RayOrigins, is_near, origin_box},
    part,
    policy::{CoherencePolicy, RayKind},
    rays::{self, Packet},
    scratch::RayLanes,
    sheared::ShearedSpace,
    single,
    sink::ResultSink,
};
use crate::{
    accel::{Node8, prefetch_for_later},
    lanes::{F32x8, LANES, Vec3x8},
    ray::RayPacket,
    simd::Simd,
};
use glam::Vec3;

/// Packets that are traced in one order.
pub(super) struct Group<'a> {
    /// First packet, and one past the last.
    pub start: usize,
    pub end: usize,
    /// Camera rays: the node to start at instead of the root.
    pub entry: Option<&'a Node8>,
    /// Single rays in the order in which they are packed, except for camera rays: packet times eight plus lane.
    /// `None`: live packets as they come.
    pub order: Option<&'a [u16]>,
}

/// Prefetches packet `i` of the rays, if it exists. Called for one packet at a time while another is prepared, since a
/// core has few outstanding misses.
// Tuned: see docs/lab-notes.md#prefetch-rays
#[inline(always)]
pub(super) fn prefetch_rays(rays: &[RayPacket], origins: &[Vec3x8], i: usize) {
    if let Some(rays) = rays.get(i) {
        prefetch_for_later(rays);
    }
    if let Some(origins) = origins.get(i) {
        prefetch_for_later(origins);
    }
}

/// Fills `members` with live packets from `next` on, until it is full or there are no more. Returns their number.
#[inline(always)]
fn next_live<S: Simd, A: ResultSink>(
    simd: S,
    rays: &[RayPacket],
    next: &mut usize,
    members: &mut [usize],
    results: &mut A,
) -> usize {
    let mut count = 0;
    while *next < rays.len() && count < members.len() {
        if rays::live(simd, &rays[*next]) {
            members[count] = *next;
            results.prefetch(*next);
            count += 1;
        } else {
            results.put_none(*next, &rays[*next]);
        }
        *next += 1;
    }
    count
}

/// Fills packets with rays of the `members` in order, and prefetches those `ahead`.
#[inline(always)]
fn fill<V: RayLanes, O: RayOrigins>(
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
        // Lanes without a ray repeat the last ray with an end of 0; eights beyond the vector's lanes repeat the first.
        let at = |eight: usize| members[(eight % each).min(members.len() - 1)];
        let from = [&rays[at(0)], &rays[at(1)], &rays[at(2)], &rays[at(3)]];
        let [a, b, c, d] = from;
        let mut t_max = [&a.t_max, &b.t_max, &c.t_max, &d.t_max];
        for eight in members.len()..each {
            t_max[eight % 4] = &F32x8::ZERO;
        }
        packet.set::<V>(simd, from, t_max);
        if !O::ARE_SHARED {
            let from = [&origins[at(0)], &origins[at(1)], &origins[at(2)], &origins[at(3)]];
            packet.start_at::<V>(simd, from);
        }
    }
}

impl Tracer<'_> {
    /// Traces a group bundle by bundle. Has only one call of [`trace`](Self::trace), which inlines all of traversal.
    // Tuned: see docs/lab-notes.md#one-traversal
    #[inline(always)]
    pub(super) fn trace_group<V: RayLanes, A: ResultSink, O: RayOrigins, const ANY: bool>(
        &mut self,
        simd: V::Simd,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        group: &Group<'_>,
        results: &mut A,
    ) {
        let &Group { start, end, .. } = group;
        let eights = V::COUNT / LANES;
        let most = if self.policy.is_bundled() {
            PACKETS * eights
        } else {
            1
        };
        let kind = O::kind(ANY);
        // Never set for camera rays; the test removes that code for them.
        let order = if kind == RayKind::Camera {
            None
        } else {
            group.order
        };
        let origins_of_group = if O::ARE_SHARED { &[] } else { &origins[start..end] };
        if order.is_some() {
            for i in start..end {
                results.put_none(i, &rays[i]);
            }
        }
        let mut members = [0; BUNDLE];
        let (mut next, mut first) = (start, 0);
        // Rays of the next group up to here are prefetched, the same number with each packet.
        let mut prefetched = end;
        let prefetched_each = match order {
            Some(order) => order::PACKETS.div_ceil(order.len().div_ceil(V::COUNT).max(1)),
            None => 0,
        };
        loop {
            let (packets, mut count) = (&mut self.scratch.of_mut::<V>().packets, 0);
            let mut bundle: &[u16] = &[];
            if let Some(order) = order {
                bundle = &order[first..order.len().min(first + V::COUNT * PACKETS)];
                first += bundle.len();
                for (p, packet) in packets.iter_mut().enumerate() {
                    let members = part(bundle, p, V::COUNT);
                    if members.is_empty() {
                        break;
                    }
                    let upto = (prefetched + prefetched_each).min(end + order::PACKETS);
                    for i in prefetched..upto {
                        prefetch_rays(rays, origins, i);
                    }
                    prefetched = upto;
                    packet.gather::<V, O>(simd, &rays[start..end], origins_of_group, members);
                }
            } else {
                count = next_live(simd, &rays[..end], &mut next, &mut members[..most], results);
                let ahead = O::prefetch_ahead(kind, V::COUNT);
                simd.call(
                    #[inline(always)]
                    || fill::<V, O>(simd, packets, rays, origins, &members[..count], ahead),
                );
            }
            let filled = bundle.len().div_ceil(V::COUNT) + count.div_ceil(eights);
            if filled == 0 {
                break;
            }
            self.trace::<V, O, ANY>(simd, filled, group.entry);
            let packets = &self.scratch.of::<V>().packets;
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
    fn trace<V: RayLanes, O: RayOrigins, const ANY: bool>(
        &mut self,
        simd: V::Simd,
        count: usize,
        entry: Option<&Node8>,
    ) {
        let all = (1_u32 << count) - 1;
        let (lower, upper) = origin_box::<V, O>(simd, &self.scratch.of::<V>().packets[..], all);
        let is_near = is_near(lower, upper);
        let point = Vec3::from(lower);
        let extent = (Vec3::from(upper) - point).length();
        let kind = O::kind(ANY);
        let regroup = self.policy.is_bundled();
        let is_single = self.policy.begin_bundle(kind);
        let mut left = all;
        while left != 0 {
            let (packets, frustum) = if is_single || !is_near {
                (left, None)
            } else {
                // Separate calls: without optimisation, one function with all inlined code takes megabytes of stack.
                simd.call(
                    #[inline(always)]
                    || self.next_group::<V, O>(simd, left),
                )
            };
            left &= !packets;
            if frustum.is_none() && regroup {
                self.go_alone::<V>(simd, packets);
                continue;
            }
            let culling = Culling {
                frustum: frustum.as_ref(),
                entry,
                exact: ANY || !O::ARE_SHARED || !regroup,
                regroup,
                space: ShearedSpace::new(frustum.as_ref(), point, extent),
                octant: frustum.as_ref().and_then(BundleFrustum::octant),
            };
            if !O::ARE_SHARED {
                let scratch = self.scratch.of_mut::<V>();
                simd.call(
                    #[inline(always)]
                    || scratch.see_apart(simd, packets, &culling),
                );
            }
            self.traverse_bundle::<V, O, ANY>(simd, packets, &culling);
        }
        let is_small = CoherencePolicy::is_small(count);
        self.policy
            .end_bundle(kind, count * V::COUNT, self.tasks.len(), is_single, is_small);
        simd.call(
            #[inline(always)]
            || self.trace_tasks::<V, ANY>(simd),
        );
    }

    /// Those of `packets` that are traced together next, with their frustum: all of them if one frustum holds them,
    /// else the most with one dominant axis, else all without a frustum.
    #[inline(always)]
    fn next_group<V: RayLanes, O: RayOrigins>(
        &self,
        simd: V::Simd,
        packets: u32,
    ) -> (u32, Option<BundleFrustum<V>>) {
        let states = &self.scratch.of::<V>().packets;
        let mut group = (packets, DominantAxis::of_most::<V>(simd, states, packets));
        loop {
            let frustum = BundleFrustum::new::<O>(simd, states, group.0, group.1);
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
        let scratch = self.scratch.of::<V>();
        for p in bits(packets) {
            for i in bits(scratch.packets[p % PACKETS].live_bits::<V>(simd)) {
                self.tasks.push(single::SingleRayTask {
                    ray: (p * V::COUNT + i) as u32,
                    child: self.bvh.root(),
                    near: 0.0,
                });
            }
        }
    }
}
