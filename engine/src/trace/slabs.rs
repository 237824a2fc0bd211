//! Packets against the boxes of a node, ray by ray.
//!
//! Boxes only cull and must never lose a hit, so entry distances are padded by more than the rounding of both this
//! arithmetic and the [canonical interval](Packet::interval).

use super::rays::Packet;
use crate::{
    accel::Node8,
    lanes::{F32x8, LANES},
    simd::{Lanes, Memory, Vec3Lanes},
};
use glam::Vec3;

/// Bound on the rounding of `plane * inv - origin * inv` beyond that of its result, as a fraction of `origin * inv`:
/// a half-ulp for that product, one for the sum with this bound, one for the other product without fused
/// multiply-add, and one to spare.
pub(super) const OFFSET_ERROR: f32 = 4.0 / (1 << 24) as f32;

/// Where multiply-adds replace the canonical interval, entry distances shrink and exit distances grow by this
/// fraction: its own margin of 4 half-ulps, 3 roundings, and the multiply-add's. (Packets apply all of it to the
/// entry: see [`Slabs::enter`]. With a shared origin there are no multiply-adds, and one pad on the entry is enough:
/// twice that margin and 3 roundings are 11 half-ulps.)
pub(super) const NODE_PAD: f32 = 12.0 / (1 << 24) as f32;

/// Origins times `1 / direction` above this might overflow.
pub(super) const MOST_OFFSET: f32 = 1e37;

/// A lower bound on where a packet's rays enter child `c`, and the rays that do; `planes` as for [`entering`].
///
/// Includes every ray with a [canonical interval](Packet::interval), up to its end, in something in the box. Only the
/// entry is scaled, by [`NODE_PAD`]: one half-ulp more than both canonical scales and the roundings. Distances may be
/// negative: boxes behind the origin and finished rays may pass; frusta drop the former, and neither takes a hit.
// Tuned: see docs/lab-notes.md#node-slabs
#[inline(always)]
pub(super) fn enter<V: Lanes, const ONE_OCTANT: bool>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    c: usize,
    state: &Packet<V::Memory>,
) -> (V, V::Mask) {
    let inv = Vec3Lanes::<V>::load(simd, &state.inv_direction);
    let (first, last) = corners::<V>(simd, planes, c);
    let (x0, x1) = (first.x * inv.x, last.x * inv.x);
    let (y0, y1) = (first.y * inv.y, last.y * inv.y);
    let (z0, z1) = (first.z * inv.z, last.z * inv.z);
    let t = V::load(simd, &state.t);
    let (near, far) = if ONE_OCTANT {
        (x0.max(y0).max(z0), x1.min(y1).min(z1.min(t)))
    } else {
        let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1));
        (near, x0.max(x1).min(y0.max(y1)).min(z0.max(z1).min(t)))
    };
    let near = near * (1.0 - NODE_PAD);
    (near, near.le(far))
}

/// The node's planes ordered for the direction octant: entry planes, then exit planes; without an octant, lower then
/// upper.
#[inline(always)]
pub(super) fn in_order(node: &Node8, octant: Option<[u8; 3]>) -> [F32x8; 6] {
    let Some(octant) = octant else { return node.planes };
    let sides: &[[F32x8; 3]; 2] = bytemuck::cast_ref(&node.planes);
    let side = |turned: u8, axis: usize| sides[usize::from(octant[axis] ^ turned) & 1][axis];
    [
        side(0, 0),
        side(0, 1),
        side(0, 2),
        side(1, 0),
        side(1, 1),
        side(1, 2),
    ]
}

/// The box of child `c` in all lanes: lower and upper corner.
#[inline(always)]
pub(super) fn corners<V: Lanes>(
    simd: V::Simd,
    planes: &[F32x8; 6],
    c: usize,
) -> (Vec3Lanes<V>, Vec3Lanes<V>) {
    let plane = |i: usize| planes[i].as_array()[c % LANES];
    let lower = Vec3::new(plane(0), plane(1), plane(2));
    let upper = Vec3::new(plane(3), plane(4), plane(5));
    (Vec3Lanes::splat(simd, lower), Vec3Lanes::splat(simd, upper))
}

/// Tests a packet with separate origins against a node's boxes with one multiply-add per plane.
// Tuned: see docs/lab-notes.md#node-slabs
#[derive(Clone, Copy, Debug)]
pub(super) struct PacketSlabs<M> {
    /// Added to each of a node's [planes](crate::accel::Node8::planes) times `1 / direction`, in the order that
    /// [`set`](Self::set) was given: minus the origin times that, moved outwards by its error.
    offset: [M; 6],
}

impl<M: Memory> PacketSlabs<M> {
    pub const EMPTY: Self = Self { offset: [M::ZERO; 6] };

    /// `is_one_octant`: all rays are in one direction octant, and planes come in that order.
    #[inline(always)]
    pub fn set<V: Lanes<Memory = M>>(&mut self, simd: V::Simd, packet: &Packet<M>, is_one_octant: bool) {
        for axis in 0..3 {
            let inv = V::load(simd, &packet.inv_direction[axis]);
            let offset = V::load(simd, &packet.origin[axis]) * inv;
            // An overflow must not cull.
            let is_tame = offset.abs().lt(V::splat(simd, MOST_OFFSET));
            let error = V::select(
                is_tame,
                offset.abs() * OFFSET_ERROR,
                V::splat(simd, f32::INFINITY),
            );
            let offset = V::select(is_tame, -offset, V::splat(simd, 0.0));
            let (before, behind) = (offset - error, offset + error);
            if is_one_octant {
                before.store(&mut self.offset[axis]);
                behind.store(&mut self.offset[axis + 3]);
            } else {
                let down = inv.lt(V::splat(simd, 0.0));
                V::select(down, behind, before).store(&mut self.offset[axis]);
                V::select(down, before, behind).store(&mut self.offset[axis + 3]);
            }
        }
    }

    /// In registers.
    #[inline(always)]
    pub fn load<V: Lanes<Memory = M>>(&self, simd: V::Simd, packet: &Packet<M>) -> Slabs<V> {
        let [x0, y0, z0, x1, y1, z1] = &self.offset;
        Slabs {
            inv: Vec3Lanes::load(simd, &packet.inv_direction),
            offset: [
                V::load(simd, x0),
                V::load(simd, y0),
                V::load(simd, z0),
                V::load(simd, x1),
                V::load(simd, y1),
                V::load(simd, z1),
            ],
            t: V::load(simd, &packet.t),
        }
    }
}

/// [`PacketSlabs`] in registers.
#[derive(Clone, Copy)]
pub(super) struct Slabs<V> {
    inv: Vec3Lanes<V>,
    offset: [V; 6],
    t: V,
}

impl<V: Lanes> Slabs<V> {
    /// A lower bound on where the rays enter child `c`, and the rays that do; `planes` are a node's, in the order
    /// that [`PacketSlabs::set`] was given.
    #[inline(always)]
    pub fn enter<const ONE_OCTANT: bool>(&self, planes: &[F32x8; 6], c: usize) -> (V, V::Mask) {
        let Self { inv, offset, t } = self;
        let (lower, upper) = corners::<V>(t.simd(), planes, c);
        let [x0, y0, z0, x1, y1, z1] = *offset;
        let (x0, x1) = (
            lower.x.mul_add_approx(inv.x, x0),
            upper.x.mul_add_approx(inv.x, x1),
        );
        let (y0, y1) = (
            lower.y.mul_add_approx(inv.y, y0),
            upper.y.mul_add_approx(inv.y, y1),
        );
        let (z0, z1) = (
            lower.z.mul_add_approx(inv.z, z0),
            upper.z.mul_add_approx(inv.z, z1),
        );
        let zero = t.all(0.0);
        let (near, far) = if ONE_OCTANT {
            (x0.max(y0).max(z0.max(zero)), x1.min(y1).min(z1.min(*t)))
        } else {
            let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1).max(zero));
            (near, x0.max(x1).min(y0.max(y1)).min(z0.max(z1).min(*t)))
        };
        // One product less: n (1 - p) <= f (1 + p) follows from n (1 - 2p) <= f, as f is not negative where there is
        // a hit, and one p is far more than the product's rounding.
        let near = near * (1.0 - 3.0 * NODE_PAD);
        (near, near.le(far))
    }
}

#[cfg(test)]
mod tests;
