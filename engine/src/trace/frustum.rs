//! Frusta of bundles and packets in slope form, and their tests against boxes.
//!
//!   ray = origin + q * (a, b, ±1) along axes (i, j, k), k the dominant one
//!   q = t |d_k|, a = d_i / |d_k|, b = d_j / |d_k|
//!   frustum = [a0, a1] x [b0, b1] x a box of origins
//!
//! Slopes need no division, no case for a direction of 0, and fewer operations than corner rays (Reshetov, Soupikov
//! and Hurley 2005) or interval arithmetic on reciprocals (Boulos et al. 2006). They are widened so that every hit of the
//! canonical tests is inside: a hit may miss its box by 14 half-ulps of its distance, and the arithmetic here rounds a few
//! more times.

use super::{
    PACKETS,
    directions::Directions,
    dominant::{DominantAxis, LEAST_ALONG_K},
    largest_axis,
    origins::{RayOrigins, is_near, origin_box},
    rays::Packet,
    slopes::{HALF_ERROR, Range, SLACK, Seen, Slopes, outside, slopes_by_packet, slopes_of_all},
};
use crate::{
    accel::Node8,
    geometry::EdgeFunctions,
    lanes::F32x8,
    ray::RayPacket,
    simd::{Column, Eight, EightLanes, LaneMask, Lanes, Simd, Vec3Lanes},
};
use glam::Vec3;

/// The axes k, i and j, the sign of the rays along k, and their origins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub k: usize,
    pub i: usize,
    pub j: usize,
    pub sign: f32,
    origin_lower: [f32; 3],
    origin_upper: [f32; 3],
}

/// A frustum around many rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frustum<V8> {
    frame: Frame,
    slopes: Slopes<V8>,
}

/// The frusta of a bundle: one for all rays and, where they share their origin, one for each packet.
#[derive(Clone, Copy, Debug)]
pub(super) struct BundleFrustum<V: Lanes> {
    all: Frustum<Eight<V>>,
    /// With a shared origin.
    own: Option<PacketFrusta<V::Packets, Eight<V>>>,
    most_along_k: Column,
}

/// The packets' frusta, a lane each, and what else only rays with a shared origin need.
#[derive(Clone, Copy, Debug)]
struct PacketFrusta<P, V8> {
    slopes: Slopes<P>,
    /// The same slopes in memory: least and largest a, least and largest b.
    slope_columns: [Column; 4],
    /// Middle x, y, z, half x, y, z.
    directions: [Column; 6],
    all_directions: Directions<V8>,
}

impl<V: Lanes> BundleFrustum<V> {
    /// The frusta of `members` (a bit each) of the packets, or one for all of them with separate origins; `None` if
    /// not all rays share the dominant axis. Directions are not NaN. Lanes without a ray are included: they hold a neighbour's
    /// direction.
    #[inline(always)]
    pub fn new<O: RayOrigins>(
        simd: V::Simd,
        packets: &[Packet<V::Memory>; PACKETS],
        members: u32,
        dominant: DominantAxis,
    ) -> Option<Self> {
        let DominantAxis { axis: k, sign } = dominant;
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let (origin_lower, origin_upper) = origin_box::<V, O>(simd, packets, members);
        let frame = Frame {
            k,
            i,
            j,
            sign,
            origin_lower,
            origin_upper,
        };

        if !O::ARE_SHARED {
            let (slopes, most_along_k) = slopes_of_all::<V>(simd, packets, members, &frame)?;
            return Some(Self {
                all: Frustum::new(frame, slopes),
                own: None,
                most_along_k: Column::splat(most_along_k),
            });
        }
        let (slope_columns, most_along_k) = slopes_by_packet::<V>(simd, packets, members, &frame)?;
        let [a0, a1, b0, b1] = &slope_columns;
        let (a0, a1) = (V::Packets::load(simd, a0), V::Packets::load(simd, a1));
        let (b0, b1) = (V::Packets::load(simd, b0), V::Packets::load(simd, b1));
        let all_a0 = simd.splat(a0.fold_min().min_lane());
        let all_a1 = simd.splat(a1.fold_max().max_lane());
        let all_b0 = simd.splat(b0.fold_min().min_lane());
        let all_b1 = simd.splat(b1.fold_max().max_lane());
        Some(Self {
            all: Frustum::new(frame, [all_a0, all_a1, all_b0, all_b1]),
            own: Some(PacketFrusta {
                slopes: Slopes {
                    a: Range::new(a0, a1),
                    b: Range::new(b0, b1),
                },
                slope_columns,
                directions: Directions::new(&frame, [a0, a1], [b0, b1]).columns(),
                all_directions: Directions::new(&frame, [all_a0, all_a1], [all_b0, all_b1]),
            }),
            most_along_k,
        })
    }

    /// The axes i, j and k, the first two swapped if rays are negative along k, to keep the handedness along the rays.
    #[inline(always)]
    pub fn axes(&self) -> [usize; 3] {
        let Frame { k, i, j, sign, .. } = self.all.frame;
        if sign < 0.0 { [j, i, k] } else { [i, j, k] }
    }

    /// The square of the longest distance that a ray goes while it goes 1 along k.
    #[inline(always)]
    pub fn stretch_squared(&self) -> f32 {
        let Slopes { a, b } = &self.all.slopes;
        let steepest_a = a.minus_abs_low.first().min(a.minus_abs_high.first());
        let steepest_b = b.minus_abs_low.first().min(b.minus_abs_high.first());
        1.0 + steepest_a * steepest_a + steepest_b * steepest_b
    }

    /// The direction octant: for each axis 1 if all rays are negative along it, 0 if positive; `None` if they differ, or nearly
    /// do.
    #[inline(always)]
    pub fn octant(&self) -> Option<[u8; 3]> {
        let Frame { k, i, j, sign, .. } = self.all.frame;
        let mut octant = [0; 3];
        for (axis, slopes) in [(i, &self.all.slopes.a), (j, &self.all.slopes.b)] {
            let is_down = slopes.minus_high.first() > 0.0;
            let is_up = slopes.low.first() > 0.0;
            if !is_down && !is_up {
                return None;
            }
            octant[axis] = u8::from(is_down);
        }
        octant[k] = u8::from(sign < 0.0);
        Some(octant)
    }

    /// The q beyond which packet `p` takes no hit if none of its lanes does beyond distance `t`.
    #[inline(always)]
    pub fn q_limit(&self, p: usize, t: f32) -> f32 {
        t * self.most_along_k.0[p & 15] * (1.0 + SLACK)
    }

    /// [`q_limit`](Self::q_limit) of all packets, a lane each.
    #[inline(always)]
    pub fn q_limits(&self, t: V::Packets) -> V::Packets {
        t * V::Packets::load(t.simd(), &self.most_along_k) * (1.0 + SLACK)
    }

    /// See [`Frustum::children`].
    #[inline(always)]
    pub fn children(&self, node: &Node8) -> (u32, Seen<Eight<V>>) {
        self.all.children(node)
    }

    /// The packets that may hit something in box `child` of `seen` before their limits (a lane per packet).
    #[inline(always)]
    pub fn packets_of(&self, seen: &Seen<Eight<V>>, child: usize, q_limit: V::Packets) -> u32 {
        let Some(own) = &self.own else {
            return !0;
        };
        let seen = seen.splat::<V::Packets>(child);
        let inside = outside(&seen, &own.slopes).le(q_limit.all(0.0));
        (inside & seen.q_near.le(q_limit)).bits()
    }

    /// See [`Frustum::boxes`].
    #[inline(always)]
    pub fn boxes(&self, planes: &[Eight<V>; 6]) -> (u32, Seen<Eight<V>>) {
        self.all.boxes(planes)
    }

    /// The boxes (of eight, a lane each) that some ray of packet `p` may hit.
    #[inline(always)]
    pub fn boxes_of(&self, p: usize, seen: &Seen<Eight<V>>) -> u32 {
        let Some(own) = &self.own else {
            return !0;
        };
        let [a0, a1, b0, b1] = &own.slope_columns;
        let all = seen.q_near;
        let slopes = Slopes {
            a: Range::new(all.all(a0.0[p & 15]), all.all(a1.0[p & 15])),
            b: Range::new(all.all(b0.0[p & 15]), all.all(b1.0[p & 15])),
        };
        outside(seen, &slopes).le(all.all(0.0)).bits()
    }

    /// The triangles (a lane each) that some ray may hit: no edge has all of the frustum on its outer side.
    #[inline(always)]
    pub fn triangles(&self, edges: &EdgeFunctions<V::Triangles>) -> u32 {
        let Some(own) = &self.own else {
            return !0;
        };
        let directions = Directions {
            middle: widened(edges.plane.simd(), &own.all_directions.middle),
            half: widened(edges.plane.simd(), &own.all_directions.half),
        };
        directions.triangles(edges)
    }

    /// The triangles (a lane each) that some ray of packet `p` may hit.
    #[inline(always)]
    pub fn triangles_of(&self, p: usize, edges: &EdgeFunctions<V::Triangles>) -> u32 {
        let Some(own) = &self.own else {
            return !0;
        };
        let [x, y, z, half_x, half_y, half_z] = &own.directions;
        let directions = Directions {
            middle: Vec3Lanes {
                x: edges.plane.all(x.0[p & 15]),
                y: edges.plane.all(y.0[p & 15]),
                z: edges.plane.all(z.0[p & 15]),
            },
            half: Vec3Lanes {
                x: edges.plane.all(half_x.0[p & 15]),
                y: edges.plane.all(half_y.0[p & 15]),
                z: edges.plane.all(half_z.0[p & 15]),
            },
        };
        directions.triangles(edges)
    }
}

impl<V8: EightLanes> Frustum<V8> {
    /// From slopes: least and largest a, least and largest b.
    #[inline(always)]
    fn new(frame: Frame, [a0, a1, b0, b1]: [V8; 4]) -> Self {
        Self {
            frame,
            slopes: Slopes {
                a: Range::new(a0, a1),
                b: Range::new(b0, b1),
            },
        }
    }

    /// A frustum around rays from `origin`; `None` if they do not share the dominant axis. Uses the slopes of the box
    /// of directions: no division per ray, and hardly wider for neighbouring pixels.
    #[inline(always)]
    pub fn around(simd: V8::Simd, origin: Vec3, rays: &[RayPacket]) -> Option<Self> {
        let mut low = Vec3Lanes::splat(simd, Vec3::MAX);
        let mut high = Vec3Lanes::splat(simd, Vec3::MIN);
        for packet in rays {
            // min and max return the second operand if either is NaN, so NaN lanes drop out.
            let d = Vec3Lanes::<V8>::load8(simd, &packet.direction);
            (low, high) = (d.min(low), d.max(high));
        }
        let low = [low.x.min_lane(), low.y.min_lane(), low.z.min_lane()];
        let high = [high.x.max_lane(), high.y.max_lane(), high.z.max_lane()];
        let least = [low[0].max(-high[0]), low[1].max(-high[1]), low[2].max(-high[2])];
        let k = largest_axis(least);
        let along = least[k];
        // Some rays have the other sign, or no ray is live.
        if !(LEAST_ALONG_K..=1.5).contains(&along) {
            return None;
        }
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let most = low[k].abs().max(high[k].abs());
        let origin = origin.to_array();
        if !is_near(origin, origin) {
            return None;
        }
        Some(Self {
            frame: Frame {
                k,
                i,
                j,
                sign: if low[k] < 0.0 { -1.0 } else { 1.0 },
                origin_lower: origin,
                origin_upper: origin,
            },
            slopes: Slopes {
                a: Range::within(simd, low[i], high[i], [along, most]),
                b: Range::within(simd, low[j], high[j], [along, most]),
            },
        })
    }

    /// The children of `node` that a ray may hit, and where they are.
    #[inline(always)]
    pub fn children(&self, node: &Node8) -> (u32, Seen<V8>) {
        self.boxes(&loaded(self.slopes.a.low.simd(), &node.planes))
    }

    /// The boxes (of eight) that a ray may hit, and where they are; `planes` as a [node](Node8::planes) has them.
    #[inline(always)]
    pub fn boxes(&self, planes: &[V8; 6]) -> (u32, Seen<V8>) {
        let simd = self.slopes.a.low.simd();
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
                planes[k] - V8::splat(simd, origin_upper[k]),
                planes[k + 3] - V8::splat(simd, origin_lower[k]),
            )
        } else {
            (
                V8::splat(simd, origin_lower[k]) - planes[k + 3],
                V8::splat(simd, origin_upper[k]) - planes[k],
            )
        };
        let near = near.max(V8::splat(simd, 0.0));
        let seen = Seen {
            q_near: near,
            q_middle: (near + far) * 0.5,
            q_half: far.mul_add_approx(V8::splat(simd, HALF_ERROR), (far - near) * 0.5),
            i_lower: planes[i] - V8::splat(simd, origin_upper[i]),
            i_upper: planes[i + 3] - V8::splat(simd, origin_lower[i]),
            j_lower: planes[j] - V8::splat(simd, origin_upper[j]),
            j_upper: planes[j + 3] - V8::splat(simd, origin_lower[j]),
        };
        let outside = outside(&seen, &self.slopes).max(-far);
        (outside.le(V8::splat(simd, 0.0)).bits(), seen)
    }
}

/// A node's planes in registers.
#[inline(always)]
pub(super) fn loaded<V8: EightLanes>(simd: V8::Simd, [a, b, c, d, e, f]: &[F32x8; 6]) -> [V8; 6] {
    [
        V8::load8(simd, a),
        V8::load8(simd, b),
        V8::load8(simd, c),
        V8::load8(simd, d),
        V8::load8(simd, e),
        V8::load8(simd, f),
    ]
}

/// A vector with equal lanes, widened to the lanes of `V`.
#[inline(always)]
fn widened<V: Lanes>(simd: V::Simd, v: &Vec3Lanes<Eight<V>>) -> Vec3Lanes<V> {
    Vec3Lanes::splat(simd, Vec3::new(v.x.first(), v.y.first(), v.z.first()))
}

impl<V8: EightLanes> Seen<V8> {
    /// Box `child` in all lanes.
    #[inline(always)]
    fn splat<V: Lanes<Simd = V8::Simd>>(&self, child: usize) -> Seen<V> {
        let simd = self.q_near.simd();
        Seen {
            q_near: V::splat(simd, self.q_near.lane(child)),
            q_middle: V::splat(simd, self.q_middle.lane(child)),
            q_half: V::splat(simd, self.q_half.lane(child)),
            i_lower: V::splat(simd, self.i_lower.lane(child)),
            i_upper: V::splat(simd, self.i_upper.lane(child)),
            j_lower: V::splat(simd, self.j_lower.lane(child)),
            j_upper: V::splat(simd, self.j_upper.lane(child)),
        }
    }
}
