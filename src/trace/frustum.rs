//! The frustum of many rays in slope form, against eight boxes, or against one box packet by packet.
//!
//! With k the axis along which the rays mainly go, a ray is `origin + q * (a, b, ±1)`, where q = t |d_k| and the
//! slopes are a = d_i / |d_k|, b = d_j / |d_k|. A set of rays is then a rectangle of slopes, [a0, a1] x [b0, b1],
//! and a box of origins. (Reshetov, Soupikov and Hurley, *Multi-Level Ray Tracing Algorithm*, 2005, intersect
//! corner rays; Boulos et al. 2006 use interval arithmetic on reciprocals. Slopes need no division, no case for
//! a direction of 0 and fewer operations than either.)
//!
//! Slopes are widened so that whatever a ray hits by the canonical tests is inside: those let a ray miss a box
//! by 14 half-ulps of its distance, and the arithmetic here rounds a few more times.

use super::{BUNDLE, state::PacketState};
use crate::{
    accel::Node8,
    simd::{F32x8, Vec3x8, ge, le, lt, max, max_lane, min, min_lane, splat},
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

fn component(v: &Vec3x8, axis: usize) -> F32x8 {
    [v.x, v.y, v.z][axis]
}

impl BundleFrustum {
    /// The frusta of up to eight packets; `None` if some ray goes too little along the common axis. Lanes
    /// without a ray count too: they hold a neighbour's direction.
    pub fn new(states: &[PacketState]) -> Option<Self> {
        let first = states.first()?;
        let mut direction_sum = first.direction;
        let (mut lower, mut upper) = (first.slabs.origin, first.slabs.origin);
        for state in &states[1..] {
            let o = state.slabs.origin;
            direction_sum = direction_sum + state.direction;
            lower = Vec3x8::new(min(lower.x, o.x), min(lower.y, o.y), min(lower.z, o.z));
            upper = Vec3x8::new(max(upper.x, o.x), max(upper.y, o.y), max(upper.z, o.z));
        }
        let sum = [direction_sum.x, direction_sum.y, direction_sum.z].map(F32x8::reduce_add);
        let k = (0..3).max_by(|&p, &q| sum[p].abs().total_cmp(&sum[q].abs()))?;
        let frame = Frame {
            k,
            i: (k + 1) % 3,
            j: (k + 2) % 3,
            sign: if sum[k] < 0.0 { -1.0 } else { 1.0 },
            origin_lower: [lower.x, lower.y, lower.z].map(min_lane),
            origin_upper: [upper.x, upper.y, upper.z].map(max_lane),
        };

        // Rows are packets until the transpose, then lanes are.
        let state = |row: usize| states.get(row).unwrap_or(first);
        let sign8 = splat(frame.sign);
        let along_k: [F32x8; BUNDLE] = std::array::from_fn(|row| component(&state(row).direction, k) * sign8);
        let least = along_k.into_iter().fold(splat(1.0), min);
        if lt(least, splat(LEAST_ALONG_K)).any() {
            return None;
        }
        let slopes = |axis: usize| {
            let of_row = |row: usize| component(&state(row).direction, axis) / along_k[row];
            let columns = F32x8::transpose(std::array::from_fn(of_row));
            let smallest = columns.into_iter().fold(columns[0], min);
            let largest = columns.into_iter().fold(columns[0], max);
            (widen_down(smallest), widen_up(largest))
        };
        let (a0, a1) = slopes(frame.i);
        let (b0, b1) = slopes(frame.j);
        let most_along_k = F32x8::transpose(along_k).into_iter().fold(splat(0.0), max);
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
                node.lower[k] - splat(origin_upper[k]),
                node.upper[k] - splat(origin_lower[k]),
            )
        } else {
            (
                splat(origin_lower[k]) - node.upper[k],
                splat(origin_upper[k]) - node.lower[k],
            )
        };
        Seen8 {
            q_near: max(near, splat(0.0)),
            q_far: far,
            i_lower: node.lower[i] - splat(origin_upper[i]),
            i_upper: node.upper[i] - splat(origin_lower[i]),
            j_lower: node.lower[j] - splat(origin_upper[j]),
            j_upper: node.upper[j] - splat(origin_lower[j]),
        }
    }

    /// The lanes in which `value`, a linear function of the direction that is worst-case `margin` off, may
    /// reach 0 for some ray: `e` holds its coefficients. Used with edge functions, eight triangles at a time.
    #[inline(always)]
    pub fn may_reach_zero(&self, e: &Vec3x8, margin: F32x8) -> u32 {
        let Frame { k, i, j, sign, .. } = self.frame;
        let [ei, ej, ek] = [i, j, k].map(|axis| component(e, axis));
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
