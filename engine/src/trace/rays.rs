//! A packet of eight, sixteen or thirty-two rays during traversal, with its best hits so far.
//!
//! Each field is a vector in memory, a lane per ray; `set` fills it from [`RayPacket`]s and `gather` from sorted rays.
//! (Packets: Wald, Slusallek, Benthin and Wagner, *Interactive Rendering with Coherent Ray Tracing*, 2001.)

use super::{bits, origins::RayOrigins};
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
    pub fn gather<V: Lanes<Memory = M>, O: RayOrigins>(
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
            if !O::ARE_SHARED {
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

    /// [`live`](Self::live), a bit per lane.
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

    /// Occlusion: blocks the lanes of `hit`; none of them may be done. Returns whether all lanes are done.
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

/// `1 / d`, finite.
// Tuned: see docs/lab-notes.md#reciprocals
#[inline(always)]
pub(super) fn reciprocal<V: Lanes>(d: V) -> V {
    let least = d.all(MIN_ABS_DIRECTION);
    d.all(1.0) / V::select(d.abs().lt(least), least.flip_signs(d.sign()), d)
}

/// Whether any of eight rays can hit something.
#[inline(always)]
pub(super) fn live<S: Simd>(simd: S, rays: &RayPacket) -> bool {
    simd.load(&rays.t_max).gt(simd.splat(0.0)).any()
}
