//! A packet on its way through the tree: its rays, and what they hit so far.

use crate::{
    geometry::Slabs8,
    ray::{HitPacket, PrimitiveId, RayPacket},
    simd::{F32x8, LANES, Mask8, Vec3x8, eq, gt, lane, lt, max_lane, splat},
};

/// Eight rays and their best hits. A lane whose `t` is 0 or below is done: nothing replaces it.
#[derive(Clone, Copy, Debug)]
pub(super) struct PacketState {
    pub slabs: Slabs8,
    pub direction: Vec3x8,
    /// Nearest hit so far, at first the ray's end. Occlusion: negative once anything is hit.
    pub t: F32x8,
    /// Edge functions of the nearest hit, second and third corner, and the sum of all three; not yet divided.
    weights: [F32x8; 3],
    /// Raw ids as bits of floats, so that they blend like the rest.
    primitive: F32x8,
}

/// What t becomes in occlusion, once a ray is blocked.
const BLOCKED: f32 = -1.0;

fn id_bits(id: u32) -> F32x8 {
    splat(f32::from_bits(id))
}

impl PacketState {
    pub fn new(rays: &RayPacket) -> Self {
        Self {
            slabs: Slabs8::new(rays.origin, rays.direction),
            direction: rays.direction,
            t: rays.t_max,
            weights: [splat(0.0), splat(0.0), splat(1.0)],
            primitive: id_bits(PrimitiveId::NONE.0),
        }
    }

    /// The nearest hits, for closest-hit traversal.
    pub fn hits(&self) -> HitPacket {
        let [u, v, sum] = self.weights;
        HitPacket {
            t: self.t,
            u: u / sum,
            v: v / sum,
            primitive: bytemuck::cast(self.primitive),
        }
    }

    /// Lanes that hit something.
    pub fn hit_bits(&self) -> u32 {
        lt(self.t, splat(0.0)).bits()
    }

    /// Lanes that can still hit something.
    #[inline(always)]
    pub fn live_bits(&self) -> u32 {
        gt(self.t, splat(0.0)).bits()
    }

    /// Beyond this distance no lane takes a hit.
    #[inline(always)]
    pub fn farthest(&self) -> f32 {
        max_lane(self.t)
    }

    /// Offers primitive `id` at `t` to the lanes of `candidate`, with its edge functions (of second and third
    /// corner, and the sum of all).
    #[inline(always)]
    pub fn offer<const ANY: bool>(
        &mut self,
        candidate: Mask8,
        t: F32x8,
        id: u32,
        weights: impl FnOnce() -> [F32x8; 3],
    ) {
        let nearer = candidate & lt(t, self.t);
        if ANY {
            self.t = nearer.select(splat(BLOCKED), self.t);
            return;
        }
        let mut accept = nearer;
        let tie = candidate & eq(t, self.t);
        if tie.any() {
            accept = accept | self.ties_won(tie.bits(), id);
        }
        if accept.any() {
            self.t = accept.select(t, self.t);
            self.primitive = accept.select(id_bits(id), self.primitive);
            for (own, new) in self.weights.iter_mut().zip(weights()) {
                *own = accept.select(new, *own);
            }
        }
    }

    /// The lanes of `tie` whose hit has a higher id. Rare, so lane by lane.
    #[cold]
    fn ties_won(&self, tie: u32, id: u32) -> Mask8 {
        let ids: [u32; LANES] = bytemuck::cast(self.primitive);
        let won = |i: &usize| tie >> i & 1 == 1 && ids[*i] != PrimitiveId::NONE.0 && id < ids[*i];
        Mask8::from_bits((0..LANES).filter(won).fold(0, |bits, i| bits | 1 << i))
    }

    /// Lane `i` on its own: its nearest hit so far.
    pub fn lane_hit(&self, i: usize) -> LaneHit {
        let ids: [u32; LANES] = bytemuck::cast(self.primitive);
        LaneHit {
            t: lane(&self.t, i),
            primitive: ids[i],
            weights: self.weights.map(|w| lane(&w, i)),
        }
    }

    /// Puts the nearest hit of lane `i` back.
    pub fn set_lane_hit(&mut self, i: usize, hit: &LaneHit) {
        self.t.as_mut_array()[i] = hit.t;
        self.primitive.as_mut_array()[i] = f32::from_bits(hit.primitive);
        for (own, new) in self.weights.iter_mut().zip(hit.weights) {
            own.as_mut_array()[i] = new;
        }
    }
}

/// The nearest hit of one ray so far; fields as in [`PacketState`].
#[derive(Clone, Copy, Debug)]
pub(super) struct LaneHit {
    pub t: f32,
    pub primitive: u32,
    pub weights: [f32; 3],
}

impl LaneHit {
    /// Offers a candidate, as [`PacketState::offer`] does.
    #[inline(always)]
    pub fn offer<const ANY: bool>(&mut self, t: f32, id: u32, weights: [f32; 3]) {
        if ANY {
            if t < self.t {
                self.t = BLOCKED;
            }
        } else if t < self.t || (t == self.t && self.primitive != PrimitiveId::NONE.0 && id < self.primitive)
        {
            *self = Self {
                t,
                primitive: id,
                weights,
            };
        }
    }
}
