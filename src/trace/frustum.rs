//! The frustum of many rays in slope form, against eight boxes, or against one box packet by packet.
//!
//! With k the axis along which the rays mainly go, a ray is `origin + q * (a, b, ±1)`, where q = t |d_k| and the
//! slopes are a = d_i / |d_k|, b = d_j / |d_k|. A set of rays is then a rectangle of slopes, [a0, a1] x [b0, b1],
//! and a box of origins. (Reshetov, Soupikov and Hurley, *Multi-Level Ray Tracing Algorithm*, 2005, intersect
//! corner rays; Boulos et al. 2006 use interval arithmetic on reciprocals. Slopes need no division, no case for
//! a direction of 0 and fewer operations than either.)
//!
//! Slopes are widened so that whatever a ray hits by the canonical tests is inside: those let a ray miss a box
//! by 14 half-ulps of its distance, and the arithmetic here rounds a few more times (slopes are products with a
//! reciprocal).

use super::{PACKETS, rays::Packet};
use crate::{
    accel::Node8,
    simd::{
        F32x8, Vec3x8, ge,
        lanes::{LaneMask, Lanes, Vec3Lanes},
        le, max, max_lane, min, min_lane, splat,
    },
};

/// Slopes are widened by this times (1 + |slope|), and distances along k by this share.
const SLACK: f32 = 2e-6;

/// A frustum needs all its rays to go at least this much along k, else its slopes are too far apart to be of
/// use.
const LEAST_ALONG_K: f32 = 0.3;

/// Which axes stand for k, i and j, which way the rays go along k, and where they start.
#[derive(Clone, Copy, Debug)]
struct Frame {
    k: usize,
    i: usize,
    j: usize,
    sign: f32,
    origin_lower: [f32; 3],
    origin_upper: [f32; 3],
}

/// The rays of a tile or packet: one rectangle of slopes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frustum {
    frame: Frame,
    a0: F32x8,
    a1: F32x8,
    b0: F32x8,
    b1: F32x8,
}

/// The rays of a bundle: a frustum for all, and one for each packet (a lane a packet).
#[derive(Clone, Copy, Debug)]
pub(super) struct BundleFrustum {
    pub all: Frustum,
    a0: F32x8,
    a1: F32x8,
    b0: F32x8,
    b1: F32x8,
    most_along_k: F32x8,
}

/// Where eight boxes lie as seen from the origins: distances along k, and offsets along i and j.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen8 {
    /// Nearest distance along k, not below 0: a bound on q for whatever is in the box.
    pub q_near: F32x8,
    q_far: F32x8,
    i_lower: F32x8,
    i_upper: F32x8,
    j_lower: F32x8,
    j_upper: F32x8,
}

/// Above 0 where a box lies outside the slopes, or behind.
#[inline(always)]
fn outside(seen: &Seen8, a0: F32x8, a1: F32x8, b0: F32x8, b1: F32x8) -> F32x8 {
    let (near, far) = (seen.q_near, seen.q_far);
    let i = max(
        seen.i_lower - max(a1 * near, a1 * far),
        min(a0 * near, a0 * far) - seen.i_upper,
    );
    let j = max(
        seen.j_lower - max(b1 * near, b1 * far),
        min(b0 * near, b0 * far) - seen.j_upper,
    );
    max(max(i, j), -far)
}

fn widen_down(slope: F32x8) -> F32x8 {
    slope - splat(SLACK) * (splat(1.0) + slope.abs())
}

fn widen_up(slope: F32x8) -> F32x8 {
    slope + splat(SLACK) * (splat(1.0) + slope.abs())
}

/// The box of the packets' origins: lower and upper corner.
#[inline(always)]
pub(super) fn origins<V: Lanes, const SHARED: bool>(packets: &[Packet]) -> ([f32; 3], [f32; 3]) {
    let first = &packets[0];
    if SHARED {
        let [x, y, z] = &first.origin;
        let origin = [x.0[0], y.0[0], z.0[0]];
        return (origin, origin);
    }
    let (mut origin_lower, mut origin_upper) = ([0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        let (mut lower, mut upper) = (V::load(&first.origin[axis]), V::load(&first.origin[axis]));
        for packet in &packets[1..] {
            let o = V::load(&packet.origin[axis]);
            (lower, upper) = (lower.min(o), upper.max(o));
        }
        (origin_lower[axis], origin_upper[axis]) = (min_lane(lower.fold_min()), max_lane(upper.fold_max()));
    }
    (origin_lower, origin_upper)
}

fn component(v: &Vec3x8, axis: usize) -> F32x8 {
    [v.x, v.y, v.z][axis]
}

impl BundleFrustum {
    /// The frusta of up to eight packets; `None` if some ray goes too little along the common axis. Lanes
    /// without a ray count too: they hold a neighbour's direction.
    #[inline(always)]
    pub fn new<V: Lanes, const SHARED: bool>(packets: &[Packet]) -> Option<Self> {
        let first = packets.first()?;
        let mut sum = Vec3Lanes::<V>::load(&first.direction);
        for packet in &packets[1..] {
            sum = sum + Vec3Lanes::load(&packet.direction);
        }
        let sum = [
            (sum.x.fold_max() + sum.x.fold_min()).reduce_add(),
            (sum.y.fold_max() + sum.y.fold_min()).reduce_add(),
            (sum.z.fold_max() + sum.z.fold_min()).reduce_add(),
        ];
        let k = (0..3).max_by(|&p, &q| sum[p].abs().total_cmp(&sum[q].abs()))?;
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (origin_lower, origin_upper) = origins::<V, SHARED>(packets);
        let frame = Frame {
            k,
            i,
            j,
            sign: if sum[k] < 0.0 { -1.0 } else { 1.0 },
            origin_lower,
            origin_upper,
        };

        // Rows are packets until the transpose, then lanes are.
        let sign = V::splat(frame.sign);
        let mut least = V::splat(1.0);
        let mut along = [splat(0.0); PACKETS];
        let [mut a_low, mut a_high, mut b_low, mut b_high] = [[splat(0.0); PACKETS]; 4];
        for row in 0..PACKETS {
            let packet = packets.get(row).unwrap_or(first);
            let d_i = V::load(&packet.direction[i]);
            let d_j = V::load(&packet.direction[j]);
            let d_k = V::load(&packet.direction[k]);
            let along_k = d_k * sign;
            least = least.min(along_k);
            along[row] = along_k.fold_max();
            let inv = V::load(&packet.inv_direction[k]).abs();
            let (a, b) = (d_i * inv, d_j * inv);
            (a_low[row], a_high[row]) = (a.fold_min(), a.fold_max());
            (b_low[row], b_high[row]) = (b.fold_min(), b.fold_max());
        }
        if least.lt(V::splat(LEAST_ALONG_K)).bits() != 0 {
            return None;
        }
        let smallest = |rows| widen_down(F32x8::transpose(rows).into_iter().reduce(min).unwrap_or_default());
        let largest = |rows| widen_up(F32x8::transpose(rows).into_iter().reduce(max).unwrap_or_default());
        let (a0, a1, b0, b1) = (smallest(a_low), largest(a_high), smallest(b_low), largest(b_high));
        let most_along_k = F32x8::transpose(along).into_iter().fold(splat(0.0), max);
        let all = Frustum {
            frame,
            a0: splat(min_lane(a0)),
            a1: splat(max_lane(a1)),
            b0: splat(min_lane(b0)),
            b1: splat(max_lane(b1)),
        };
        Some(Self {
            all,
            a0,
            a1,
            b0,
            b1,
            most_along_k,
        })
    }

    /// The frustum of packet `p` alone.
    pub fn packet(&self, p: usize) -> Frustum {
        let of = |slopes: &F32x8| splat(slopes.as_array()[p]);
        Frustum {
            frame: self.all.frame,
            a0: of(&self.a0),
            a1: of(&self.a1),
            b0: of(&self.b0),
            b1: of(&self.b1),
        }
    }

    /// The q beyond which packet `p` takes no hit, when no lane of it does beyond distance `t`.
    #[inline(always)]
    pub fn q_limit(&self, p: usize, t: f32) -> f32 {
        t * self.most_along_k.as_array()[p] * (1.0 + SLACK)
    }

    /// The packets that may hit something in box `child` of `seen` before their limits (a lane a packet).
    #[inline(always)]
    pub fn packets_of(&self, seen: &Seen8, child: usize, q_limit8: F32x8) -> u32 {
        let seen = seen.splat(child);
        let outside = outside(&seen, self.a0, self.a1, self.b0, self.b1);
        le(max(outside, seen.q_near - q_limit8), splat(0.0)).bits()
    }
}

impl Frustum {
    /// The children of `node` that a ray may hit, and where they lie.
    #[inline(always)]
    pub fn children(&self, node: &Node8) -> (u32, Seen8) {
        let seen = self.see(node);
        let outside = outside(&seen, self.a0, self.a1, self.b0, self.b1);
        (le(outside, splat(0.0)).bits(), seen)
    }

    #[inline(always)]
    fn see(&self, node: &Node8) -> Seen8 {
        let Frame {
            k,
            i,
            j,
            sign,
            origin_lower,
            origin_upper,
        } = &self.frame;
        let (&k, &i, &j) = (k, i, j);
        let (near, far) = if *sign > 0.0 {
            (
                node.planes[k] - splat(origin_upper[k]),
                node.planes[k + 3] - splat(origin_lower[k]),
            )
        } else {
            (
                splat(origin_lower[k]) - node.planes[k + 3],
                splat(origin_upper[k]) - node.planes[k],
            )
        };
        Seen8 {
            q_near: max(near, splat(0.0)),
            q_far: far,
            i_lower: node.planes[i] - splat(origin_upper[i]),
            i_upper: node.planes[i + 3] - splat(origin_lower[i]),
            j_lower: node.planes[j] - splat(origin_upper[j]),
            j_upper: node.planes[j + 3] - splat(origin_lower[j]),
        }
    }

    /// The lanes in which `value`, a linear function of the direction that is worst-case `margin` off, may
    /// reach 0 for some ray: `e` holds its coefficients. Used with edge functions, eight triangles at a time.
    #[inline(always)]
    pub fn may_reach_zero(&self, e: &Vec3x8, margin: F32x8) -> u32 {
        let Frame { k, i, j, sign, .. } = self.frame;
        let (ei, ej, ek) = (component(e, i), component(e, j), component(e, k));
        let largest = max(self.a0 * ei, self.a1 * ei) + max(self.b0 * ej, self.b1 * ej) + ek * splat(sign);
        ge(largest, -margin).bits()
    }
}

impl Seen8 {
    #[inline(always)]
    fn splat(&self, child: usize) -> Self {
        let of = |v: &F32x8| splat(v.as_array()[child]);
        Self {
            q_near: of(&self.q_near),
            q_far: of(&self.q_far),
            i_lower: of(&self.i_lower),
            i_upper: of(&self.i_upper),
            j_lower: of(&self.j_lower),
            j_upper: of(&self.j_upper),
        }
    }
}
