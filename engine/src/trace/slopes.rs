//! Slopes of rays relative to a dominant axis: see [`frustum`](super::frustum).

use super::{PACKETS, bits, dominant::LEAST_ALONG_K, frustum::Frame, rays::Packet};
use crate::simd::{Column, Eight, EightLanes, LaneMask, Lanes, REGISTER_LANES, Simd, TriangleLanes};

/// Slopes are widened by this times (1 + |slope|), and distances along k by this fraction.
pub(super) const SLACK: f32 = 2e-6;

/// Rectangles of slopes, [a0, a1] x [b0, b1], as the box test reads them; one per lane, or the same in all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes<V> {
    pub a: Range<V>,
    pub b: Range<V>,
}

/// From `low` to `high`, as they are summed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range<V> {
    pub low: V,
    pub minus_abs_low: V,
    pub minus_high: V,
    pub minus_abs_high: V,
}

/// Boxes relative to the origins: distances along k, and offsets along i and j. Eight boxes, or one in all lanes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<V> {
    /// Nearest distance along k, at least 0: a lower bound on q for anything in the box.
    pub q_near: V,
    /// Midpoint of nearest and farthest distance along k.
    pub q_middle: V,
    /// Half of their difference, padded for rounding.
    pub q_half: V,
    pub i_lower: V,
    pub i_upper: V,
    pub j_lower: V,
    pub j_upper: V,
}

/// Rounding of `q_middle`, `q_half` and the test made of them, as a fraction of the farthest distance.
pub(super) const HALF_ERROR: f32 = 8.0 / (1 << 24) as f32;

impl<V: Lanes> Range<V> {
    #[inline(always)]
    pub fn new(low: V, high: V) -> Self {
        Self {
            low,
            minus_abs_low: -low.abs(),
            minus_high: -high,
            minus_abs_high: -high.abs(),
        }
    }

    /// The widened slopes of directions from `low` to `high` that go from `least` to `most` along k.
    #[inline(always)]
    pub fn within(simd: V::Simd, low: f32, high: f32, [least, most]: [f32; 2]) -> Self {
        let lowest = low / if low < 0.0 { least } else { most };
        let highest = high / if high > 0.0 { least } else { most };
        Self::new(
            widen_down(V::splat(simd, lowest)),
            widen_up(V::splat(simd, highest)),
        )
    }

    /// Positive where [lower, upper] is outside q times the range, for all q. The maximum of q times `high` is at the
    /// near or far end by its sign, so it is `high * q_middle + |high| * q_half`.
    #[inline(always)]
    fn outside(&self, seen: &Seen<V>, lower: V, upper: V) -> V {
        let (middle, half) = (seen.q_middle, seen.q_half);
        let above = self
            .minus_high
            .mul_add_approx(middle, self.minus_abs_high.mul_add_approx(half, lower));
        let below = self
            .low
            .mul_add_approx(middle, self.minus_abs_low.mul_sub_approx(half, upper));
        above.max(below)
    }
}

/// Positive where a box lies outside the slopes.
#[inline(always)]
pub(super) fn outside<V: Lanes>(seen: &Seen<V>, slopes: &Slopes<V>) -> V {
    let a = slopes.a.outside(seen, seen.i_lower, seen.i_upper);
    let b = slopes.b.outside(seen, seen.j_lower, seen.j_upper);
    a.max(b)
}

#[inline(always)]
fn widen_down<V: Lanes>(slope: V) -> V {
    slope - (slope.all(1.0) + slope.abs()) * SLACK
}

#[inline(always)]
fn widen_up<V: Lanes>(slope: V) -> V {
    slope + (slope.all(1.0) + slope.abs()) * SLACK
}

/// The widened slopes of packets, a lane each: least and largest a, least and largest b; and the largest component of
/// their rays along k. `None` if not all of them have that dominant axis.
#[inline(always)]
pub(super) fn slopes_by_packet<V: Lanes>(
    simd: V::Simd,
    packets: &[Packet<V::Memory>; PACKETS],
    members: u32,
    frame: &Frame,
) -> Option<([Column; 4], Column)> {
    let first = members.trailing_zeros() as usize % PACKETS;
    let (i, j, k) = (frame.i, frame.j, frame.k);
    let sign = V::splat(simd, frame.sign);
    let mut least = V::splat(simd, 1.0);
    let is_folded = V::COUNT > REGISTER_LANES;
    // Folded row by row: two vectors of 32 lanes would spill.
    let [mut a0, mut a1, mut b0, mut b1, mut along] = [[V::Triangles::splat(simd, 0.0); REGISTER_LANES]; 5];
    for row in 0..PACKETS {
        // Rows beyond the packets repeat the first one.
        let p = if members >> row & 1 == 0 { first } else { row };
        let packet = &packets[p % PACKETS];
        let along_k = V::load(simd, &packet.direction[k]) * sign;
        least = least.min(along_k);
        along[row] = along_k.fold_max_to_16();
        let inv = V::load(simd, &packet.inv_direction[k]) * sign;
        let a = V::load(simd, &packet.direction[i]) * inv;
        let b = V::load(simd, &packet.direction[j]) * inv;
        (a0[row], b0[row]) = (a.fold_min_to_16(), b.fold_min_to_16());
        if is_folded {
            (a1[row], b1[row]) = (a.fold_max_to_16(), b.fold_max_to_16());
        }
    }
    if least.lt(V::splat(simd, LEAST_ALONG_K)).bits() != 0 {
        return None;
    }
    let mut columns = [Column::splat(0.0); 5];
    // Else both are the same rows.
    let (a1, b1) = if is_folded { (&a1, &b1) } else { (&a0, &b0) };
    let [least_a, most_a, least_b, most_b, most_along_k] = &mut columns;
    widen_down(V::Triangles::least_of_each(&a0)).store(least_a);
    widen_up(V::Triangles::largest_of_each(a1)).store(most_a);
    widen_down(V::Triangles::least_of_each(&b0)).store(least_b);
    widen_up(V::Triangles::largest_of_each(b1)).store(most_b);
    V::Triangles::largest_of_each(&along).store(most_along_k);
    let [a0, a1, b0, b1, most_along_k] = columns;
    Some(([a0, a1, b0, b1], most_along_k))
}

/// Like [`slopes_by_packet`], but for all rays together: with separate origins a packet's frustum is nearly as large as
/// the bundle's.
// Tuned: see docs/lab-notes.md#frustum-separate-origins
#[inline(always)]
pub(super) fn slopes_of_all<V: Lanes>(
    simd: V::Simd,
    packets: &[Packet<V::Memory>; PACKETS],
    members: u32,
    frame: &Frame,
) -> Option<([Eight<V>; 4], f32)> {
    let sign = V::splat(simd, frame.sign);
    let (mut least, mut most) = (V::splat(simd, 1.0), V::splat(simd, 0.0));
    let [mut a_low, mut b_low] = [V::splat(simd, f32::MAX); 2];
    let [mut a_high, mut b_high] = [V::splat(simd, -f32::MAX); 2];
    for p in bits(members) {
        let packet = &packets[p % PACKETS];
        let along_k = V::load(simd, &packet.direction[frame.k]) * sign;
        (least, most) = (least.min(along_k), most.max(along_k));
        let inv = V::load(simd, &packet.inv_direction[frame.k]).abs();
        let a = V::load(simd, &packet.direction[frame.i]) * inv;
        let b = V::load(simd, &packet.direction[frame.j]) * inv;
        (a_low, a_high) = (a_low.min(a), a_high.max(a));
        (b_low, b_high) = (b_low.min(b), b_high.max(b));
    }
    if least.lt(V::splat(simd, LEAST_ALONG_K)).bits() != 0 {
        return None;
    }
    let slopes = [
        widen_down(simd.splat(a_low.fold_min().min_lane())),
        widen_up(simd.splat(a_high.fold_max().max_lane())),
        widen_down(simd.splat(b_low.fold_min().min_lane())),
        widen_up(simd.splat(b_high.fold_max().max_lane())),
    ];
    Some((slopes, most.fold_max().max_lane()))
}
