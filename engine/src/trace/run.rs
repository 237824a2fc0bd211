//! Chooses the kernel (lanes, leaf layout) and the groups for the rays of a call.

use super::{
    Tracer,
    group::{Group, prefetch_rays},
    origins::RayOrigins,
    policy::{ENTRY_PACKETS, RayKind},
    scratch::{RayLanes, Widths},
    sink::{AHEAD, ResultSink},
};
use crate::{
    lanes::Vec3x8,
    ray::RayPacket,
    simd::{LaneMask, Lanes, Simd, Vec3Lanes, at_level},
};
use glam::Vec3;

/// Rays to trace, and where their results go.
struct Work<'a, A> {
    rays: &'a [RayPacket],
    /// Empty if they are shared.
    origins: &'a [Vec3x8],
    results: A,
    /// The next packet to trace.
    next: usize,
}

/// Copies rays and their origins, without the invalid ones. With a shared origin, `origins` is empty.
#[cold]
fn without_invalid(
    rays: &[RayPacket],
    origins: &[Vec3x8],
    shared: &mut Vec3,
) -> (Vec<RayPacket>, Vec<Vec3x8>) {
    let (mut rays, mut origins) = (rays.to_vec(), origins.to_vec());
    for (i, packet) in rays.iter_mut().enumerate() {
        match origins.get_mut(i) {
            Some(origin) => packet.make_valid(origin),
            None => packet.make_valid(&mut Vec3x8::splat(*shared)),
        }
    }
    if !shared.is_finite() {
        *shared = Vec3::ZERO;
    }
    (rays, origins)
}

impl Tracer<'_> {
    /// Traces all rays. `origins` is empty where they are shared.
    pub(super) fn dispatch<A: ResultSink, O: RayOrigins, const ANY: bool>(
        &mut self,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        results: A,
    ) {
        let work = Work {
            rays,
            origins,
            results,
            next: 0,
        };
        let work = self.trace_valid::<A, O, ANY>(work);
        if work.next == rays.len() {
            return;
        }
        let (rays, origins) = without_invalid(rays, origins, &mut self.origin);
        let work = Work {
            rays: &rays,
            origins: &origins,
            ..work
        };
        self.trace_valid::<A, O, ANY>(work);
    }

    /// Traces up to the first group that holds an invalid ray.
    fn trace_valid<'w, A: ResultSink, O: RayOrigins, const ANY: bool>(
        &mut self,
        work: Work<'w, A>,
    ) -> Work<'w, A> {
        at_level!(self.level, |simd| self.trace_at::<_, A, O, ANY>(simd, work))
    }

    /// [`run`](Self::run) with the lanes that fit the rays.
    #[inline(always)]
    fn trace_at<'w, S: Widths, A: ResultSink, O: RayOrigins, const ANY: bool>(
        &mut self,
        simd: S,
        work: Work<'w, A>,
    ) -> Work<'w, A> {
        match O::kind(ANY) {
            RayKind::Shadow => self.run::<S::SharedAny, A, O, ANY>(simd, work),
            RayKind::Camera => self.run::<S::Shared, A, O, ANY>(simd, work),
            RayKind::Separate => self.run::<S::Separate, A, O, ANY>(simd, work),
        }
    }

    /// Traces packets in order, or sorted by direction. Returns early if one of the next rays is invalid.
    #[inline(always)]
    fn run<'w, V: RayLanes, A: ResultSink, O: RayOrigins, const ANY: bool>(
        &mut self,
        simd: V::Simd,
        work: Work<'w, A>,
    ) -> Work<'w, A> {
        let Work {
            rays,
            origins,
            mut results,
            mut next,
        } = work;
        if O::ARE_SHARED {
            let origin = self.origin;
            self.scratch.of_mut::<V>().start_at::<V>(simd, origin);
        } else {
            self.scratch.of_mut::<V>().start_apart();
        }
        let kind = O::kind(ANY);
        let mut sorted = std::mem::take(&mut self.sorted);
        let at_a_time = self.policy.group(kind, rays.len());
        for start in (next..rays.len()).step_by(at_a_time) {
            let end = rays.len().min(start + at_a_time);
            let origins_of_group = if O::ARE_SHARED { &[] } else { &origins[start..end] };
            if !self.are_valid(simd, &rays[start..end], origins_of_group) {
                break;
            }
            next = end;
            let of_group = &rays[start..end];
            let mut entry = None;
            if self.policy.shares_entry(kind) {
                entry = simd.call(
                    #[inline(always)]
                    || self.entry(simd, of_group),
                );
                if entry.as_ref().is_some_and(|entry| entry.count == 0) {
                    for i in start..end {
                        results.prefetch((i + AHEAD).min(rays.len() - 1));
                        prefetch_rays(rays, &[], i + ENTRY_PACKETS);
                        results.put_none(i, &rays[i]);
                    }
                    continue;
                }
            }
            let is_sorted = kind != RayKind::Camera
                && self.policy.wants_sorting(kind)
                && simd.call(
                    #[inline(always)]
                    || {
                        if O::ARE_SHARED {
                            sorted.by_place(simd, of_group)
                        } else {
                            sorted.by_direction(simd, of_group)
                        }
                    },
                );
            let group = Group {
                start,
                end,
                entry: entry.as_ref(),
                order: is_sorted.then(|| sorted.rays()),
            };
            self.trace_group::<V, A, O, ANY>(simd, rays, origins, &group, &mut results);
            if is_sorted {
                self.policy.traced_sorted(kind);
            }
        }
        self.sorted = sorted;
        Work {
            rays,
            origins,
            results,
            next,
        }
    }

    /// Whether all rays are [valid](crate::ray::Ray::is_valid): with NaN, minima and maxima depend on the order.
    #[inline(always)]
    fn are_valid<S: Simd>(&self, simd: S, rays: &[RayPacket], origins: &[Vec3x8]) -> bool {
        let mut any = simd.mask(0);
        for packet in rays {
            any = any | invalid(simd, packet);
        }
        for points in origins {
            any = any | !times_zero(simd.load3(points)).eq(simd.splat(0.0));
        }
        self.origin.is_finite() && !any.any()
    }
}

/// The lanes whose direction or end is not that of a [valid](crate::ray::Ray::is_valid) ray.
#[inline(always)]
pub(super) fn invalid<S: Simd>(simd: S, rays: &RayPacket) -> <S::V8 as Lanes>::Mask {
    let d = simd.load3(&rays.direction);
    let zero = simd.splat(0.0);
    let is_zero = d.x.eq(zero) & d.y.eq(zero) & d.z.eq(zero);
    let end = simd.load(&rays.t_max) * zero;
    is_zero | !(times_zero(d) + end).eq(zero)
}

/// NaN for vectors that are not finite, else 0.
#[inline(always)]
fn times_zero<V: Lanes>(v: Vec3Lanes<V>) -> V {
    v.x * 0.0 + v.y * 0.0 + v.z * 0.0
}
