//! The differences between rays with a shared origin and rays with separate origins.

use super::{
    PACKETS, Tracer, bits,
    bundle::Culling,
    entering::{Entering, entering, entering_by_packet},
    leaf::{self, Leaves},
    pairs::Pairs,
    policy::{ENTRY_PACKETS, RayKind},
    rays::Packet,
    scratch::{BundleScratch, RayLanes},
    sheared,
    slabs::enter,
    stack::{DeferredLeaves, Entry, Limits},
};
use crate::{
    lanes::{F32x8, LANES},
    simd::{EightLanes, Lanes, Memory, REGISTER_LANES, Simd},
};
use glam::Vec3;

/// Whether rays share their origin.
pub(super) trait RayOrigins {
    const ARE_SHARED: bool;

    /// The kind of rays with these origins.
    #[inline(always)]
    fn kind(is_any: bool) -> RayKind {
        RayKind::of(Self::ARE_SHARED, is_any)
    }

    /// How many packets ahead rays are prefetched, in packets of `lanes`.
    fn prefetch_ahead(kind: RayKind, lanes: usize) -> usize;

    /// A node's planes as packets are tested against them.
    fn seen_planes<S: Simd>(simd: S, planes: [F32x8; 6], origin: Vec3) -> [F32x8; 6];

    /// The children that packets enter, ray by ray: those of `pairs`, or of all `packets` with all `candidates`.
    fn entering<V: RayLanes, const ONE_OCTANT: bool>(
        simd: V::Simd,
        planes: &[F32x8; 6],
        pairs: &Pairs,
        candidates: u32,
        packets: u32,
        scratch: &BundleScratch<V::Memory>,
    ) -> Entering;

    /// A lower bound on where the rays of packet `p` enter child `c`, and the rays that do.
    fn enter<V: RayLanes, const ONE_OCTANT: bool>(
        simd: V::Simd,
        planes: &[F32x8; 6],
        c: usize,
        p: usize,
        scratch: &BundleScratch<V::Memory>,
    ) -> (V, V::Mask);

    /// Tests a leaf, perhaps together with another deferred one. Returns the packets whose ends came nearer, in occlusion
    /// those that are done.
    fn visit_leaf<V: RayLanes, const ANY: bool>(
        tracer: &mut Tracer<'_>,
        simd: V::Simd,
        leaf: Entry,
        others: &mut DeferredLeaves,
        culling: &Culling<'_, V>,
        limits: Limits<V>,
    ) -> u32;
}

/// All rays start at one point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shared;

impl RayOrigins for Shared {
    const ARE_SHARED: bool = true;

    #[inline(always)]
    fn prefetch_ahead(kind: RayKind, lanes: usize) -> usize {
        match kind {
            RayKind::Camera => ENTRY_PACKETS,
            _ if lanes > REGISTER_LANES => super::BUNDLE,
            _ => super::BUNDLE_OF_16,
        }
    }

    /// Relative to the origin.
    #[inline(always)]
    fn seen_planes<S: Simd>(simd: S, mut planes: [F32x8; 6], origin: Vec3) -> [F32x8; 6] {
        for (i, plane) in planes.iter_mut().enumerate() {
            *plane = (simd.load(plane) - simd.splat(origin[i % 3])).to8();
        }
        planes
    }

    #[inline(always)]
    fn entering<V: RayLanes, const ONE_OCTANT: bool>(
        simd: V::Simd,
        planes: &[F32x8; 6],
        pairs: &Pairs,
        _: u32,
        _: u32,
        scratch: &BundleScratch<V::Memory>,
    ) -> Entering {
        entering::<V, ONE_OCTANT>(simd, planes, pairs, &scratch.packets)
    }

    #[inline(always)]
    fn enter<V: RayLanes, const ONE_OCTANT: bool>(
        simd: V::Simd,
        planes: &[F32x8; 6],
        c: usize,
        p: usize,
        scratch: &BundleScratch<V::Memory>,
    ) -> (V, V::Mask) {
        enter::<V, ONE_OCTANT>(simd, planes, c, &scratch.packets[p % super::PACKETS])
    }

    #[inline(always)]
    fn visit_leaf<V: RayLanes, const ANY: bool>(
        tracer: &mut Tracer<'_>,
        simd: V::Simd,
        leaf: Entry,
        others: &mut DeferredLeaves,
        culling: &Culling<'_, V>,
        limits: Limits<V>,
    ) -> u32 {
        let mut second = (leaf.child, 0);
        if V::Triangles::COUNT > LANES
            && leaf.child.is_triangles()
            && let Some(next) = others.oldest()
            && next.child.is_triangles()
        {
            others.pop();
            let packets = limits.reached(next);
            if packets != 0 {
                second = (next.child, packets);
            }
        }
        let leaves = Leaves {
            child: [leaf.child, second.0],
            packets: [leaf.packets, second.1],
        };
        let count = 1 + usize::from(second.1 != 0);
        let met = (leaf.packets.count_ones() + second.1.count_ones()) as usize;
        tracer.policy.visited(count, met);
        let packets = &mut tracer.scratch.of_mut::<V>().packets;
        simd.call(
            #[inline(always)]
            || leaf::shared_origin::<V, ANY>(simd, tracer.bvh, leaves, culling, packets),
        )
    }
}

/// Each ray has its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Separate;

impl RayOrigins for Separate {
    const ARE_SHARED: bool = false;

    #[inline(always)]
    fn prefetch_ahead(_: RayKind, _: usize) -> usize {
        super::order::PACKETS
    }

    #[inline(always)]
    fn seen_planes<S: Simd>(_: S, planes: [F32x8; 6], _: Vec3) -> [F32x8; 6] {
        planes
    }

    #[inline(always)]
    fn entering<V: RayLanes, const ONE_OCTANT: bool>(
        simd: V::Simd,
        planes: &[F32x8; 6],
        _: &Pairs,
        candidates: u32,
        packets: u32,
        scratch: &BundleScratch<V::Memory>,
    ) -> Entering {
        entering_by_packet::<V, ONE_OCTANT>(
            simd,
            planes,
            candidates,
            packets,
            &scratch.packets,
            &scratch.slabs,
        )
    }

    #[inline(always)]
    fn enter<V: RayLanes, const ONE_OCTANT: bool>(
        simd: V::Simd,
        planes: &[F32x8; 6],
        c: usize,
        p: usize,
        scratch: &BundleScratch<V::Memory>,
    ) -> (V, V::Mask) {
        let p = p % super::PACKETS;
        scratch.slabs[p]
            .load::<V>(simd, &scratch.packets[p])
            .enter::<ONE_OCTANT>(planes, c)
    }

    #[inline(always)]
    fn visit_leaf<V: RayLanes, const ANY: bool>(
        tracer: &mut Tracer<'_>,
        simd: V::Simd,
        leaf: Entry,
        _: &mut DeferredLeaves,
        culling: &Culling<'_, V>,
        _: Limits<V>,
    ) -> u32 {
        let (scratch, candidates) = (tracer.scratch.of_mut::<V>(), &mut tracer.candidates);
        let (rays, states) = (&scratch.sheared, &mut scratch.packets);
        let leaf = (leaf.child, leaf.packets);
        simd.call(
            #[inline(always)]
            || sheared::separate_origins::<V, ANY>(simd, tracer.bvh, leaf, culling, rays, candidates, states),
        )
    }
}

/// Rays from farther away have no frustum: products with their origins might overflow, and 0 times infinity is NaN.
const FARTHEST_ORIGIN: f32 = 1e18;

/// Whether a box of origins is near enough for a frustum.
#[inline(always)]
pub(super) fn is_near(lower: [f32; 3], upper: [f32; 3]) -> bool {
    let mut is_near = true;
    for axis in 0..3 {
        is_near &= lower[axis] >= -FARTHEST_ORIGIN && upper[axis] <= FARTHEST_ORIGIN;
    }
    is_near
}

/// The box of the packets' origins: lower and upper corner.
#[inline(always)]
pub(super) fn origin_box<V: Lanes, O: RayOrigins>(
    simd: V::Simd,
    packets: &[Packet<V::Memory>],
    members: u32,
) -> ([f32; 3], [f32; 3]) {
    let first = &packets[members.trailing_zeros() as usize % packets.len()];
    if O::ARE_SHARED {
        let [x, y, z] = &first.origin;
        let origin = [x.place(0), y.place(0), z.place(0)];
        return (origin, origin);
    }
    let (mut origin_lower, mut origin_upper) = ([0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        let (mut lower, mut upper) = (
            V::load(simd, &first.origin[axis]),
            V::load(simd, &first.origin[axis]),
        );
        for p in bits(members) {
            let o = V::load(simd, &packets[p % PACKETS].origin[axis]);
            (lower, upper) = (lower.min(o), upper.max(o));
        }
        (origin_lower[axis], origin_upper[axis]) = (lower.fold_min().min_lane(), upper.fold_max().max_lane());
    }
    (origin_lower, origin_upper)
}
