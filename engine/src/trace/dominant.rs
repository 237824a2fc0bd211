//! The dominant axis of rays: a [frustum](super::frustum) holds only rays that share it.
//!
//! Dominant axis and slopes along it are those of Wald, Ize, Kensler, Knoll and Parker, *Ray Tracing Animated Scenes
//! using Coherent Grid Traversal*, 2006. Differs: a bundle with several axes is divided into groups of packets instead of
//! traced ray by ray.

use super::{PACKETS, bits, largest_axis, rays::Packet};
use crate::simd::{EightLanes, LaneMask, Lanes, Vec3Lanes};
use glam::Vec3;

/// Least component of a frustum's rays along its axis, of unit directions; below, its slopes are too far apart to cull
/// anything. Less makes larger groups with wider frusta.
// Tuned: see docs/lab-notes.md#varied-constants
pub(super) const LEAST_ALONG_K: f32 = 0.3;

/// The sum of all lanes, times a factor that depends only on the width.
#[inline(always)]
fn sum_of_lanes<V: Lanes>(v: V) -> f32 {
    // min(a, b) + max(a, b) = a + b, so folding both sums the lanes.
    let sums = v.fold_min_to_16() + v.fold_max_to_16();
    (sums.fold_min() + sums.fold_max()).sum()
}

/// The dominant axis of all rays of a frustum, and its sign.
#[derive(Clone, Copy, Debug)]
pub(super) struct DominantAxis {
    pub axis: usize,
    pub sign: f32,
}

impl DominantAxis {
    /// The axis of the sum of all directions.
    #[inline(always)]
    pub fn of_most<V: Lanes>(simd: V::Simd, states: &[Packet<V::Memory>; PACKETS], packets: u32) -> Self {
        let mut sum = Vec3Lanes::<V>::splat(simd, Vec3::ZERO);
        for p in bits(packets) {
            sum = sum + Vec3Lanes::load(simd, &states[p % PACKETS].direction);
        }
        // Without a closure, which would not be inlined into AVX-512 code.
        let sum = [sum_of_lanes(sum.x), sum_of_lanes(sum.y), sum_of_lanes(sum.z)];
        let axis = largest_axis([sum[0].abs(), sum[1].abs(), sum[2].abs()]);
        let sign = if sum[axis] < 0.0 { -1.0 } else { 1.0 };
        Self { axis, sign }
    }

    /// Those of `packets` all of whose rays have this dominant axis.
    #[inline(always)]
    fn sharing<V: Lanes>(self, simd: V::Simd, states: &[Packet<V::Memory>; PACKETS], packets: u32) -> u32 {
        let (least, sign) = (V::splat(simd, LEAST_ALONG_K), V::splat(simd, self.sign));
        let mut sharing = 0;
        for p in bits(packets) {
            let along = V::load(simd, &states[p % PACKETS].direction[self.axis]) * sign;
            sharing |= u32::from(along.ge(least).bits() == !0 >> (32 - V::COUNT)) << p;
        }
        sharing
    }
}

/// The largest subset of `packets` (a bit each) that shares a dominant axis; `None` if no packet's rays do.
// Tuned: see docs/lab-notes.md#dividing-bundles
#[inline(always)]
pub(super) fn largest_group<V: Lanes>(
    simd: V::Simd,
    states: &[Packet<V::Memory>; PACKETS],
    packets: u32,
) -> Option<(u32, DominantAxis)> {
    let mut most = None;
    let mut count = 0;
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let axis = DominantAxis { axis, sign };
            let sharing = axis.sharing::<V>(simd, states, packets);
            if sharing.count_ones() > count {
                count = sharing.count_ones();
                most = Some((sharing, axis));
            }
        }
    }
    most
}
