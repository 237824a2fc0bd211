//! Leaf blocks against packets with separate origins: a candidate filter, then the canonical test.
//!
//! The filter treats rays as lines. Space is sheared along the dominant axis k of the frustum until rays run along k; then
//! a point is tested against a triangle's edges in 2D, with 24 operations per triangle:
//!
//!   block -> relative to the space -> sheared per packet -> candidates (above, below) -> canonical test -> hits
//!
//! The shear is that of Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, 2013, which uses it for the
//! canonical test; here it only filters.
// Tuned: see docs/lab-notes.md#sheared-rays

use super::{
    PACKETS, bits,
    bundle::Culling,
    frustum::BundleFrustum,
    leaf::{hit, in_order, interval, vector},
    origins::Separate,
    rays::Packet,
    spheres::spheres,
};
use crate::{
    accel::{Bvh, Child},
    geometry::{CANDIDATE_SLACK, Edges, TriangleTest, edge_functions, padded_boxes, weights},
    lanes::LANES,
    simd::{Eight, EightLanes, LaneMask, Lanes, Memory, Vec3Lanes},
};
use glam::Vec3;

/// A packet and a triangle that passed the filter: the rays whose lines may meet the triangle, by the side of its plane
/// from which they come.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// No edge function is clearly negative: may hit if they start where the canonical test flips nothing.
    above: u16,
    /// No edge function is clearly positive: may hit if they start where it flips all of them.
    below: u16,
    /// The packet times eight plus the triangle.
    pair: u32,
}

impl Candidate {
    const NONE: Self = Self {
        above: 0,
        below: 0,
        pair: 0,
    };

    #[inline(always)]
    fn packet(self) -> usize {
        self.pair as usize / LANES % PACKETS
    }

    #[inline(always)]
    fn triangle(self) -> usize {
        self.pair as usize % LANES
    }

    /// The lanes that may hit, given those that the canonical test flips.
    #[inline(always)]
    fn ahead(self, turned: u32) -> u32 {
        (u32::from(self.above) & !turned) | (u32::from(self.below) & turned)
    }
}

/// Reused memory for the candidates of a block.
#[derive(Debug)]
pub(super) struct Candidates([Candidate; PACKETS * LANES]);

impl Candidates {
    pub const EMPTY: Self = Self([Candidate::NONE; PACKETS * LANES]);
}

/// Tests a block against packets with separate origins: first the filter, which takes less than half the operations of the
/// canonical edge functions, then the canonical test of the candidates.
///
/// A line extends behind the ray, so each mirror ray's line meets the triangle that it starts on. The canonical test
/// therefore ends early if no ray starts on the side of the plane from which its line would hit.
#[inline(always)]
pub(super) fn separate_origins<V: Lanes, const ANY: bool>(
    simd: V::Simd,
    bvh: &Bvh,
    (leaf, packets): (Child, u32),
    culling: &Culling<'_, V>,
    sheared: &[ShearedPacket<V::Memory>; PACKETS],
    candidates: &mut Candidates,
    states: &mut [Packet<V::Memory>; PACKETS],
) -> u32 {
    debug_assert!(V::COUNT <= 16, "a `Candidate` has no room for more lanes");
    if !leaf.is_triangles() {
        let block = &bvh.sphere_blocks()[leaf.index()];
        return spheres::<V, Separate, ANY>(simd, block, leaf.count_bits(), culling, packets, states);
    }
    let mut unpacked = None;
    let stored = bvh.triangle_blocks();
    let block = stored.whole(simd, leaf.index(), &mut unpacked);
    let corners = block.load(simd);
    let edges = Edges::new(&corners);
    let seen = SeenTriangles::new(&corners, &edges, &culling.space);
    let Candidates(candidates) = candidates;
    let count = filter::<V>(simd, &seen, (leaf.count(), packets), sheared, states, candidates);
    if count == 0 {
        return 0;
    }
    let lowest = -seen.tolerance;
    let (lower, upper) = padded_boxes(&corners);
    let (first, last) = in_order(lower, upper, culling.octant);
    let mut taken = 0;
    for &candidate in &candidates[..count] {
        let (p, i) = (candidate.packet(), candidate.triangle());
        let state = &mut states[p];
        let o = Vec3Lanes::<V>::load(simd, &state.origin);
        let d = Vec3Lanes::<V>::load(simd, &state.direction);
        let a = Vec3Lanes::<V>::splat(simd, block.v0.lane(i)) - o;
        let normal = vector::<V, _>(&edges.normal, i);
        let plane = normal.dot(a);
        // Whichever side it is, where that is not known.
        let unknown = Edges::unknown_side(vector(&edges.permanent, i), plane, a);
        let both = u32::from(candidate.above | candidate.below) & unknown.bits();
        if candidate.ahead(plane.sign_bits()) | both == 0 {
            continue;
        }
        let b = Vec3Lanes::<V>::splat(simd, block.v1.lane(i)) - o;
        let c = Vec3Lanes::<V>::splat(simd, block.v2.lane(i)) - o;
        let flip = plane.sign();
        let [u, v, w] = [&edges.u, &edges.v, &edges.w];
        let functions = edge_functions([vector(u, i), vector(v, i), vector(w, i)], [a, b, c]);
        let [u, v, w] = weights(d, functions);
        let infinite = V::splat(simd, f32::INFINITY);
        let tolerance = [
            V::select(unknown, -infinite, V::splat(simd, lowest.lane(i))),
            V::select(unknown, infinite, V::splat(simd, seen.tolerance.lane(i))),
        ];
        let bounds = interval::<V>(state, vector(&first, i) - o, vector(&last, i) - o, culling);
        // Flipped before the product, as elsewhere: the sign of a determinant of 0 depends on it.
        let determinant = d.dot(normal.flip_signs(flip));
        let test = TriangleTest::new(
            [u.flip_signs(flip), v.flip_signs(flip), w.flip_signs(flip)],
            tolerance,
            (plane.flip_signs(flip), determinant),
            bounds,
        );
        let hit = hit::<V, ANY>(state, stored, [leaf.index(), i], &test);
        taken |= u32::from(hit) << p;
    }
    taken
}

/// Collects the candidates among the first `triangles` of a block, and returns their number.
#[inline(always)]
fn filter<V: Lanes>(
    simd: V::Simd,
    seen: &SeenTriangles<Eight<V>>,
    (triangles, packets): (usize, u32),
    sheared: &[ShearedPacket<V::Memory>; PACKETS],
    states: &[Packet<V::Memory>; PACKETS],
    candidates: &mut [Candidate; PACKETS * LANES],
) -> usize {
    let mut count = 0;
    for p in bits(packets) {
        let live = states[p % PACKETS].live::<V>(simd);
        let rays = sheared[p % PACKETS].load::<V>(simd);
        for i in 0..triangles {
            let [above, below] = rays.sides(seen, i, live);
            candidates[count % (PACKETS * LANES)] = Candidate {
                above: above.bits() as u16,
                below: below.bits() as u16,
                pair: (p * LANES + i) as u32,
            };
            count += usize::from((above | below).any());
        }
    }
    count
}

/// The space in which rays are sheared.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedSpace {
    /// The [axes](BundleFrustum::axes) i, j and k.
    axes: [usize; 3],
    /// Everything is relative to this point: the lower corner of the origins' box.
    point: Vec3,
    /// The greatest distance of an origin from it.
    extent: f32,
    /// [Slack](SHEARED_SLACK) of the filter on the wrong side of an edge, as a fraction of [`Edges::size`].
    slack: f32,
}

impl ShearedSpace {
    /// Without a frustum nothing is filtered out.
    #[inline(always)]
    pub fn new<V: Lanes>(frustum: Option<&BundleFrustum<V>>, point: Vec3, extent: f32) -> Self {
        let (axes, stretch_squared) = match frustum {
            Some(frustum) => (frustum.axes(), frustum.stretch_squared()),
            None => ([0, 1, 2], f32::INFINITY),
        };
        Self {
            axes,
            point,
            extent,
            slack: SHEARED_SLACK * stretch_squared,
        }
    }
}

/// The filter's slack in half-ulps, times the square of N, the distance that rays go while they go 1 along k: a
/// fraction of [`Edges::size`], which is at least 2 E (E + L), with E the longest edge and L more than the distances
/// of the point and the origins from the first corner, and from each other.
///
/// The shear makes vectors at most N times as long. Errors of a sheared edge: its own rounding, the slope's (2) and
/// the multiply-add's: 4 N E. Of the sheared first corner: its and the origin's rounding relative to the point, the
/// slope's (2), p and q, the difference and the multiply-add: 6 N L. With the rounding of two products, u and v are
/// wrong by up to 12 N^2 E L, their sum with w by 10 N^2 E^2; w then by 27 N^2 E (E + L), half of that as a fraction
/// of the size, at most 15 N^2. Without fused multiply-add, 15.5 N^2.
///
/// The canonical edge functions are these times twice what rays go along k, at least 2 / N; they are rejected below
/// -20 half-ulps ([`CANDIDATE_SLACK`]) and wrong by up to 11.5, which here is 15.75 N. Together up to 31.25 N^2, as N
/// is at least 1.
const SHEARED_SLACK: f32 = 32.0 / (1 << 24) as f32;

/// A packet's rays as lines in slope form, relative to a [`ShearedSpace`]: (p + a x_k, q + b x_k, x_k) for all x_k.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedPacket<M> {
    minus_a: M,
    minus_b: M,
    p: M,
    q: M,
}

impl<M: Memory> ShearedPacket<M> {
    pub const EMPTY: Self = Self {
        minus_a: M::ZERO,
        minus_b: M::ZERO,
        p: M::ZERO,
        q: M::ZERO,
    };

    /// Sets the lines of a packet within the space's frustum. (Without a frustum they may be anything; nothing is filtered
    /// out.)
    #[inline(always)]
    pub fn set<V: Lanes<Memory = M>>(&mut self, simd: V::Simd, packet: &Packet<M>, space: &ShearedSpace) {
        let [i, j, k] = space.axes;
        let o_i = V::load(simd, &packet.origin[i]) - V::splat(simd, space.point[i]);
        let o_j = V::load(simd, &packet.origin[j]) - V::splat(simd, space.point[j]);
        let o_k = V::load(simd, &packet.origin[k]) - V::splat(simd, space.point[k]);
        let minus_inv = -V::load(simd, &packet.inv_direction[k]);
        let minus_a = V::load(simd, &packet.direction[i]) * minus_inv;
        let minus_b = V::load(simd, &packet.direction[j]) * minus_inv;
        minus_a.store(&mut self.minus_a);
        minus_b.store(&mut self.minus_b);
        minus_a.mul_add_approx(o_k, o_i).store(&mut self.p);
        minus_b.mul_add_approx(o_k, o_j).store(&mut self.q);
    }

    /// In registers.
    #[inline(always)]
    fn load<V: Lanes<Memory = M>>(&self, simd: V::Simd) -> ShearedRays<V> {
        ShearedRays {
            minus_a: V::load(simd, &self.minus_a),
            minus_b: V::load(simd, &self.minus_b),
            p: V::load(simd, &self.p),
            q: V::load(simd, &self.q),
        }
    }
}

/// [`ShearedPacket`] in registers.
#[derive(Clone, Copy)]
struct ShearedRays<V> {
    minus_a: V,
    minus_b: V,
    p: V,
    q: V,
}

impl<V: Lanes> ShearedRays<V> {
    /// Edge `n` of eight, sheared: its components along i and j.
    #[inline(always)]
    fn sheared<E: EightLanes>(&self, [i, j, k]: &[E; 3], n: usize) -> [V; 2] {
        let along = self.p.all(k.lane(n));
        [
            self.minus_a.mul_add_approx(along, self.p.all(i.lane(n))),
            self.minus_b.mul_add_approx(along, self.p.all(j.lane(n))),
        ]
    }

    /// Those of `lanes` that may hit triangle `n`: as [`Candidate::above`], and as [`Candidate::below`].
    #[inline(always)]
    fn sides<E: EightLanes>(&self, seen: &SeenTriangles<E>, n: usize, lanes: V::Mask) -> [V::Mask; 2] {
        let [e1_i, e1_j] = self.sheared(&seen.e1, n);
        let [e2_i, e2_j] = self.sheared(&seen.e2, n);
        let [i, j, k] = &seen.v0;
        let along = self.p.all(k.lane(n));
        let v0_i = self.minus_a.mul_add_approx(along, along.all(i.lane(n)) - self.p);
        let v0_j = self.minus_b.mul_add_approx(along, along.all(j.lane(n)) - self.q);
        let u = e2_i.mul_sub_approx(v0_j, e2_j * v0_i);
        let v = v0_i.mul_sub_approx(e1_j, v0_j * e1_i);
        let w = e1_i.mul_sub_approx(e2_j, e1_j * e2_i) - u - v;
        let lowest = along.all(seen.lowest.lane(n));
        let highest = along.all(seen.highest.lane(n));
        [
            u.min(v).min(w).not_lt(lowest, lanes),
            u.max(v).max(w).not_gt(highest, lanes),
        ]
    }
}

/// A block's triangles in a [`ShearedSpace`]: columns along i, j and k.
#[derive(Clone, Copy, Debug)]
struct SeenTriangles<E> {
    /// First corners.
    v0: [E; 3],
    /// Edges from there to the second corners.
    e1: [E; 3],
    /// Edges from there to the third corners.
    e2: [E; 3],
    /// The filter's slack on the wrong side of 0, and minus that.
    highest: E,
    lowest: E,
    /// As [`EdgeFunctions::tolerance`](crate::geometry::EdgeFunctions::tolerance), for all origins.
    tolerance: E,
}

impl<E: EightLanes> SeenTriangles<E> {
    #[inline(always)]
    fn new([v0, v1, v2]: &[Vec3Lanes<E>; 3], edges: &Edges<E>, space: &ShearedSpace) -> Self {
        let point = Vec3Lanes::splat(v0.x.simd(), space.point);
        let a = columns(*v0 - point, space);
        let extent = v0.x.all(space.extent);
        // (x + y)^2 is at most 2 (x^2 + y^2).
        let distance_squared = a[2].mul_add_approx(a[2], extent * extent);
        let distance_squared = a[1].mul_add_approx(a[1], distance_squared);
        let distance_squared = a[0].mul_add_approx(a[0], distance_squared);
        let size = edges.size(distance_squared + distance_squared);
        let highest = size * space.slack;
        Self {
            v0: a,
            e1: columns(*v1 - *v0, space),
            e2: columns(*v2 - *v0, space),
            highest,
            lowest: -highest,
            tolerance: size * CANDIDATE_SLACK,
        }
    }
}

/// The columns of eight vectors along i, j and k.
#[inline(always)]
fn columns<E: EightLanes>(v: Vec3Lanes<E>, space: &ShearedSpace) -> [E; 3] {
    let [i, j, k] = space.axes;
    [column(&v, i), column(&v, j), column(&v, k)]
}

#[inline(always)]
fn column<E: EightLanes>(v: &Vec3Lanes<E>, axis: usize) -> E {
    match axis {
        0 => v.x,
        1 => v.y,
        _ => v.z,
    }
}

#[cfg(test)]
mod tests;
