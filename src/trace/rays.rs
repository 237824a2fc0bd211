//! A packet of eight, sixteen or thirty-two rays on its way through the tree, and its best hits so far.
//!
//! Each field is a vector in memory, a lane a ray; `set` fills it from [`RayPacket`]s and `gather` from sorted rays.
//! (Packets: Wald, Slusallek, Benthin and Wagner, *Interactive Rendering with Coherent Ray Tracing*, 2001.)

use super::{bits, bundle::corners};
use crate::{
    geometry::{ENTRY_SCALE, EXIT_SCALE, interval},
    lanes::{F32x8, LANES, Vec3x8},
    math::MIN_ABS_DIRECTION,
    ray::{HitPacket, PrimitiveId, RayPacket},
    simd::{EightLanes, LaneMask, Lanes, Memory, Simd, Vec3Lanes},
};

/// A packet and its best hits. A lane whose `t` is 0 or below is done: nothing replaces it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet<M> {
    pub origin: [M; 3],
    pub direction: [M; 3],
    /// `1 / direction`, finite: see [`MIN_ABS_DIRECTION`].
    pub inv_direction: [M; 3],
    /// Nearest hit so far, at first the ray's end. Occlusion: negative once anything is hit.
    pub t: M,
    /// Edge functions of the nearest hit: second corner, third, first. Not divided by their sum; negative means 0.
    weights: [M; 3],
    /// Raw ids as bits of floats, so that they blend like the rest.
    primitive: M,
}

/// The t of a blocked ray in occlusion.
pub(super) const BLOCKED: f32 = -1.0;

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

#[inline(always)]
fn id_bits(id: u32) -> f32 {
    f32::from_bits(id)
}

impl<M: Memory> Packet<M> {
    pub const EMPTY: Self = Self {
        origin: [M::ZERO; 3],
        direction: [M::ZERO; 3],
        inv_direction: [M::ZERO; 3],
        t: M::ZERO,
        weights: [M::ZERO; 3],
        primitive: M::ZERO,
    };

    /// Sets rays in eights of lanes, with their ends and no hits. Origins stay as they were.
    #[inline(always)]
    pub fn set<V: Lanes<Memory = M>>(&mut self, simd: V::Simd, rays: [&RayPacket; 4], t_max: [&F32x8; 4]) {
        let direction = Vec3Lanes::<V>::of_eights(
            simd,
            [
                &rays[0].direction,
                &rays[1].direction,
                &rays[2].direction,
                &rays[3].direction,
            ],
        );
        direction.store(&mut self.direction);
        V::of_eights(simd, t_max).store(&mut self.t);
        self.start::<V>(direction);
    }

    /// Sets the origins in eights of lanes.
    #[inline(always)]
    pub fn start_at<V: Lanes<Memory = M>>(&mut self, simd: V::Simd, origins: [&Vec3x8; 4]) {
        Vec3Lanes::<V>::of_eights(simd, origins).store(&mut self.origin);
    }

    /// Sets single rays, with no hits: `members` are packets times eight plus lane. Lanes beyond them repeat the last
    /// one, with an end of 0. A shared origin stays as it was.
    #[inline(always)]
    pub fn gather<V: Lanes<Memory = M>, const SHARED: bool>(
        &mut self,
        simd: V::Simd,
        rays: &[RayPacket],
        origins: &[Vec3x8],
        members: &[u16],
    ) {
        let last = members.last().copied().unwrap_or(0);
        for i in 0..V::COUNT {
            let member = usize::from(members.get(i).copied().unwrap_or(last));
            let (packet, lane) = (member / LANES, member % LANES);
            let from = &rays[packet];
            let d = &from.direction;
            if !SHARED {
                let o = &origins[packet];
                for (column, values) in self.origin.iter_mut().zip([&o.x, &o.y, &o.z]) {
                    *column.place_mut(i) = values.as_array()[lane];
                }
            }
            for (column, values) in self.direction.iter_mut().zip([&d.x, &d.y, &d.z]) {
                *column.place_mut(i) = values.as_array()[lane];
            }
            *self.t.place_mut(i) = if i < members.len() {
                from.t_max.as_array()[lane]
            } else {
                0.0
            };
        }
        self.start::<V>(Vec3Lanes::load(simd, &self.direction));
    }

    /// Sets what follows from the directions, and no hits.
    #[inline(always)]
    fn start<V: Lanes<Memory = M>>(&mut self, direction: Vec3Lanes<V>) {
        let simd = direction.x.simd();
        let inv_direction = Vec3Lanes {
            x: reciprocal(direction.x),
            y: reciprocal(direction.y),
            z: reciprocal(direction.z),
        };
        inv_direction.store(&mut self.inv_direction);
        V::splat(simd, id_bits(PrimitiveId::NONE.0)).store(&mut self.primitive);
        let [u, v, w] = &mut self.weights;
        V::splat(simd, 0.0).store(u);
        V::splat(simd, 0.0).store(v);
        V::splat(simd, 1.0).store(w);
    }

    /// The nearest hits of eight lanes, for closest-hit traversal.
    #[inline(always)]
    pub fn hits<S: Simd>(&self, simd: S, eight: usize) -> HitPacket {
        let zero = simd.splat(0.0);
        let [u, v, w] = &self.weights;
        let u = simd.load(u.eight(eight)).max(zero);
        let v = simd.load(v.eight(eight)).max(zero);
        let w = simd.load(w.eight(eight)).max(zero);
        let sum = (u + v + w).max(simd.splat(f32::MIN_POSITIVE));
        HitPacket {
            t: *self.t.eight(eight),
            u: (u / sum).to8(),
            v: (v / sum).to8(),
            primitive: bytemuck::cast(*self.primitive.eight(eight)),
        }
    }

    /// Those of eight lanes that hit something, for occlusion.
    #[inline(always)]
    pub fn blocked_bits<S: Simd>(&self, simd: S, eight: usize) -> u32 {
        simd.load(self.t.eight(eight)).lt(simd.splat(0.0)).bits()
    }

    /// Lanes that can still hit something.
    #[inline(always)]
    pub fn live<V: Lanes<Memory = M>>(&self, simd: V::Simd) -> V::Mask {
        V::load(simd, &self.t).gt(V::splat(simd, 0.0))
    }

    /// [`live`](Self::live), a bit a lane.
    #[inline(always)]
    pub fn live_bits<V: Lanes<Memory = M>>(&self, simd: V::Simd) -> u32 {
        self.live::<V>(simd).bits()
    }

    /// Beyond this distance no lane takes a hit.
    #[inline(always)]
    pub fn farthest<V: Lanes<Memory = M>>(&self, simd: V::Simd) -> f32 {
        V::load(simd, &self.t).largest()
    }

    /// Closest hits: offers primitive `id` at `t`, with its edge functions, to the lanes of `candidate`, none of
    /// which has a nearer hit.
    #[inline(always)]
    pub fn offer<V: Lanes<Memory = M>>(&mut self, candidate: V::Mask, t: V, id: u32, weights: [V; 3]) {
        let simd = t.simd();
        let best = V::load(simd, &self.t);
        debug_assert_eq!((candidate & t.gt(best)).bits(), 0, "none is beyond the best hit");
        let mut accept = candidate & t.lt(best);
        let tie = candidate.bits() & !accept.bits();
        if tie != 0 {
            accept = accept | V::mask(simd, self.ties_won(tie, id));
        }
        V::select(accept, t, best).store(&mut self.t);
        let primitive = V::load(simd, &self.primitive);
        V::select(accept, V::splat(simd, id_bits(id)), primitive).store(&mut self.primitive);
        for (new, own) in weights.into_iter().zip(&mut self.weights) {
            V::select(accept, new, V::load(simd, own)).store(own);
        }
    }

    /// Occlusion: blocks the lanes of `hit`, none of which is done. Returns whether all lanes are done.
    #[inline(always)]
    pub fn block<V: Lanes<Memory = M>>(&mut self, simd: V::Simd, hit: V::Mask) -> bool {
        debug_assert_eq!(hit.bits() & !self.live_bits::<V>(simd), 0, "none is done");
        let t = V::select(hit, V::splat(simd, BLOCKED), V::load(simd, &self.t));
        t.store(&mut self.t);
        !t.gt(V::splat(simd, 0.0)).any()
    }

    /// The lanes of `tie` whose hit has a higher id. Rare, so lane by lane.
    #[cold]
    #[inline(never)]
    fn ties_won(&self, tie: u32, id: u32) -> u32 {
        let won = |i: &usize| {
            let own = self.primitive.place(*i).to_bits();
            own != PrimitiveId::NONE.0 && id < own
        };
        bits(tie).filter(won).fold(0, |won, i| won | 1 << i)
    }

    /// Offers a candidate to one lane, as [`offer`](Self::offer) does; in occlusion it blocks the lane.
    #[inline(always)]
    pub fn offer_lane<const ANY: bool>(&mut self, i: usize, t: f32, id: u32, weights: [f32; 3]) {
        let best = self.t.place(i);
        let own = self.primitive.place(i).to_bits();
        if ANY {
            if t < best {
                *self.t.place_mut(i) = BLOCKED;
            }
        } else if t < best || (t == best && own != PrimitiveId::NONE.0 && id < own) {
            *self.t.place_mut(i) = t;
            *self.primitive.place_mut(i) = id_bits(id);
            for (own, new) in self.weights.iter_mut().zip(weights) {
                *own.place_mut(i) = new;
            }
        }
    }

    /// The rays' [`interval`] in boxes given relative to their origins.
    #[inline(always)]
    pub fn interval<V: Lanes<Memory = M>>(&self, lower: Vec3Lanes<V>, upper: Vec3Lanes<V>) -> (V, V) {
        let inv = Vec3Lanes::load(lower.x.simd(), &self.inv_direction);
        interval(&inv, lower, upper)
    }

    /// [`interval`](Self::interval) of rays in one direction octant, given the planes where they enter and leave: the
    /// same bits, for boxes that are not inside out.
    #[inline(always)]
    pub fn interval_in_octant<V: Lanes<Memory = M>>(
        &self,
        first: Vec3Lanes<V>,
        last: Vec3Lanes<V>,
    ) -> (V, V) {
        let inv = Vec3Lanes::<V>::load(first.x.simd(), &self.inv_direction);
        let near = (first.x * inv.x).max(first.y * inv.y);
        let near = near.max((first.z * inv.z).max(near.all(0.0)));
        let far = (last.x * inv.x).min(last.y * inv.y).min(last.z * inv.z);
        (near * ENTRY_SCALE, far * EXIT_SCALE)
    }
}

/// What a packet with separate origins needs to be tested against a node's boxes with one multiply-add a plane.
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
            // What overflows is not culled.
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
        let (x0, x1) = (lower.x.mul_add_about(inv.x, x0), upper.x.mul_add_about(inv.x, x1));
        let (y0, y1) = (lower.y.mul_add_about(inv.y, y0), upper.y.mul_add_about(inv.y, y1));
        let (z0, z1) = (lower.z.mul_add_about(inv.z, z0), upper.z.mul_add_about(inv.z, z1));
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

/// `1 / d`, finite.
// Tuned: see docs/lab-notes.md#reciprocals
#[inline(always)]
fn reciprocal<V: Lanes>(d: V) -> V {
    let least = d.all(MIN_ABS_DIRECTION);
    d.all(1.0) / V::select(d.abs().lt(least), least.turn(d.sign()), d)
}

/// Whether any of eight rays can hit something.
#[inline(always)]
pub(super) fn live<S: Simd>(simd: S, rays: &RayPacket) -> bool {
    simd.load(&rays.t_max).gt(simd.splat(0.0)).any()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Portable, Simd};
    type V8 = <Portable as Simd>::V8;
    use crate::{
        accel::{Child, Node8},
        math::Aabb,
        trace::{
            bundle::{corners, enter, in_order},
            single::SingleRay,
        },
    };
    use glam::Vec3;

    /// Directions, one of them along an axis or in a plane of two; half of the time all in one direction octant, see
    /// [`BundleFrustum::octant`](super::super::frustum::BundleFrustum::octant).
    fn directions(
        round: usize,
        vector: &mut impl FnMut(f32) -> Vec3,
        ways: &mut fastrand::Rng,
    ) -> ([Vec3; LANES], Option<[u8; 3]>) {
        let mut directions = [(); LANES].map(|()| vector(1.0).normalize());
        directions[0] = [Vec3::X, Vec3::NEG_Y, Vec3::new(-0.0, 0.6, 0.8)][round % 3];
        let octant = ways.bool().then(|| [(); 3].map(|()| ways.u8(..2)));
        if let Some(octant) = octant {
            let signs = Vec3::from(octant.map(|down| 1.0 - 2.0 * f32::from(down)));
            directions = directions.map(|d| (d.abs() + 1e-5) * signs);
        }
        (directions, octant)
    }

    /// Boxes around points on rays, of all sizes and near and far from where rays start, some of these along an axis;
    /// half of the rays are in one direction octant.
    #[test]
    fn slabs_hold_what_the_canonical_interval_holds() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut ways = random.fork();
        let mut unit = move || random.f32() * 2.0 - 1.0;
        let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
        let mut met = 0;
        for round in 0..20_000 {
            let size = [1e-6, 1.0, 1e6, 1e9][round % 4];
            let far = [1.0, 1e3, 1e12, 1e30][round / 4 % 4];
            let origins = [(); LANES].map(|()| vector(size * far));
            let (directions, octant) = directions(round, &mut vector, &mut ways);
            let ray = round % LANES;
            let at = (origins[ray] + directions[ray] * size).clamp(Vec3::splat(-2e9), Vec3::splat(2e9));
            let half = vector(size).abs() * [0.0, 1e-6, 1.0][round / 16 % 3];
            let bounds = Aabb {
                lower: at - half,
                upper: at + half,
            };
            let rays = RayPacket {
                direction: Vec3x8::from_lanes(directions),
                t_max: F32x8::splat(f32::MAX),
            };
            let mut packet = Packet::EMPTY;
            packet.set::<V8>(Portable, [&rays; 4], [&rays.t_max; 4]);
            let origin8 = Vec3x8::from_lanes(origins);
            packet.start_at::<V8>(Portable, [&origin8; 4]);
            let mut slabs = PacketSlabs::EMPTY;
            slabs.set::<V8>(Portable, &packet, octant.is_some());
            let node = Node8::new(&[(Child::inner(0), bounds)]);
            let planes = in_order(&node, octant);
            let rays = slabs.load::<V8>(Portable, &packet);
            let (near, entering) = if octant.is_some() {
                rays.enter::<true>(&planes, 0)
            } else {
                rays.enter::<false>(&planes, 0)
            };
            let o = Vec3Lanes::<V8>::load(Portable, &packet.origin);
            let (lower, upper) = (
                Vec3Lanes::splat(Portable, bounds.lower),
                Vec3Lanes::splat(Portable, bounds.upper),
            );
            let (canonical_near, canonical_far) = packet.interval(lower - o, upper - o);
            if octant.is_some() {
                let (first, last) = corners(Portable, &planes, 0);
                let same = packet.interval_in_octant(first - o, last - o);
                let bits = |t: V8| t.to8().to_array().map(f32::to_bits);
                assert_eq!(bits(same.0), bits(canonical_near), "{round}");
                assert_eq!(bits(same.1), bits(canonical_far), "{round}");
            }
            for i in 0..LANES {
                let near = near.lane(i);
                let [least, most] = [canonical_near, canonical_far].map(|t| t.lane(i));
                if least <= most {
                    met += 1;
                    let (enters, near8) = SingleRay::new(&packet, 0, i).enter(Portable, &node, f32::MAX);
                    let near8 = near8.to8();
                    assert!(
                        enters && near8.as_array()[0] <= least.min(f32::MAX),
                        "{round}: alone"
                    );
                    let empty = (1..LANES).all(|c| near8.as_array()[c] == f32::INFINITY);
                    assert!(empty, "{round}: {near8:?}");
                    let enters = entering.bits() >> i & 1 != 0;
                    assert!(enters && near <= least, "{round}: {enters} {near} {least}");
                }
            }
        }
        assert!(met > 5_000, "{met}");
    }

    /// The same where rays share their origin, for rays that end at the box as well; the origin is sometimes in it.
    #[test]
    fn planes_as_seen_from_one_origin_hold_what_the_canonical_interval_holds() {
        let mut random = fastrand::Rng::with_seed(4);
        let mut ways = random.fork();
        let mut unit = move || random.f32() * 2.0 - 1.0;
        let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
        let mut met = 0;
        for round in 0..50_000 {
            let size = [1e-6, 1.0, 1e6, 1e9][round % 4];
            let origin =
                vector(size * [0.0, 1.0, 1e3][round / 4 % 3]).clamp(Vec3::splat(-2e9), Vec3::splat(2e9));
            let (directions, octant) = directions(round, &mut vector, &mut ways);
            let at = origin + directions[round % LANES] * size;
            let half = vector(size).abs() * [0.0, 1e-6, 1.0, 3.0][round / 16 % 4];
            let bounds = Aabb {
                lower: at - half,
                upper: at + half,
            };
            let rays = RayPacket {
                direction: Vec3x8::from_lanes(directions),
                t_max: F32x8::splat(f32::MAX),
            };
            let mut packet = Packet::EMPTY;
            packet.set::<V8>(Portable, [&rays; 4], [&rays.t_max; 4]);
            let origin8 = Vec3x8::splat(origin);
            packet.start_at::<V8>(Portable, [&origin8; 4]);
            let o = Vec3Lanes::<V8>::load(Portable, &packet.origin);
            let (lower, upper) = (
                Vec3Lanes::splat(Portable, bounds.lower),
                Vec3Lanes::splat(Portable, bounds.upper),
            );
            let (canonical_near, canonical_far) = packet.interval(lower - o, upper - o);
            if ways.bool() {
                // As soon as they are in the box.
                canonical_near
                    .max(Portable.splat(f32::MIN_POSITIVE))
                    .store(&mut packet.t);
            }
            let mut planes = in_order(&Node8::new(&[(Child::inner(0), bounds)]), octant);
            for (i, plane) in planes.iter_mut().enumerate() {
                *plane = (Portable.load(plane) - Portable.splat(origin[i % 3])).to8();
            }
            let (near, entering) = if octant.is_some() {
                enter::<V8, true>(Portable, &planes, 0, &packet)
            } else {
                enter::<V8, false>(Portable, &planes, 0, &packet)
            };
            for i in 0..LANES {
                let [least, most] = [canonical_near, canonical_far].map(|t| t.lane(i));
                if least <= most && most > 0.0 {
                    met += 1;
                    let (enters, near) = (entering.bits() >> i & 1 != 0, near.lane(i));
                    assert!(enters && near <= least, "{round}: {enters} {near} {least}");
                }
            }
        }
        assert!(met > 20_000, "{met}");
    }
}
