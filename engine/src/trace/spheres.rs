//! Leaf blocks of spheres against the packets of a bundle, with shared or separate origins.

use super::{
    PACKETS, bits, bits64,
    bundle::Culling,
    leaf::{put, vector},
    origins::RayOrigins,
    rays::Packet,
};
use crate::{
    geometry::{SphereBlock, chord, padded_sphere_boxes, sphere_hits},
    lanes::LANES,
    simd::{Eight, LaneMask, Lanes, Simd, Vec3Lanes},
};

/// Tests a block of spheres (`all`: a bit each). Skips spheres whose boxes miss the packet's frustum (with separate
/// origins, the bundle's).
// Tuned: see docs/lab-notes.md#sphere-boxes
#[inline(always)]
pub(super) fn spheres<V: Lanes, O: RayOrigins, const ANY: bool>(
    simd: V::Simd,
    block: &SphereBlock,
    mut all: u32,
    culling: &Culling<'_, V>,
    packets: u32,
    states: &mut [Packet<V::Memory>; PACKETS],
) -> u32 {
    let (lower, upper): (Vec3Lanes<Eight<V>>, _) =
        padded_sphere_boxes(simd.load3(&block.center), simd.load(&block.radius));
    let mut pairs = [0_u64; PACKETS / 8];
    if let Some(frustum) = culling.frustum {
        let planes = [lower.x, lower.y, lower.z, upper.x, upper.y, upper.z];
        let (met, seen) = frustum.boxes(&planes);
        all &= met;
        for p in bits(packets) {
            let own = if O::ARE_SHARED {
                frustum.boxes_of(p, &seen)
            } else {
                all
            };
            put(&mut pairs, p, 8, all & own);
        }
    } else {
        for p in bits(packets) {
            put(&mut pairs, p, 8, all);
        }
    }
    let zero = V::splat(simd, 0.0);
    let mut meets = [0_u8; PACKETS * LANES];
    let mut met = 0;
    for (word, pairs) in pairs.into_iter().enumerate() {
        for pair in bits64(pairs) {
            let (p, i) = (word * 8 + pair / 8, pair % 8);
            let (_, discriminant) = chord_of::<V>(simd, &states[p % PACKETS], block, i);
            meets[met % (PACKETS * LANES)] = (word * 64 + pair) as u8;
            met += usize::from(discriminant.ge(zero).any());
        }
    }
    let mut taken = 0;
    for &pair in &meets[..met] {
        let (p, i) = (usize::from(pair) / LANES, usize::from(pair) % LANES);
        let state = &mut states[p % PACKETS];
        let chord = chord_of::<V>(simd, state, block, i);
        let o = Vec3Lanes::<V>::load(simd, &state.origin);
        let interval = state.interval(vector(&lower, i) - o, vector(&upper, i) - o);
        let (hit, t) = sphere_hits(chord, interval);
        if ANY {
            let hit = hit & t.lt(V::load(simd, &state.t));
            taken |= u32::from(state.block::<V>(simd, hit)) << p;
            continue;
        }
        if hit.any() {
            // Tuned: see docs/lab-notes.md#nearer-first
            let hit = hit & t.le(V::load(simd, &state.t));
            state.offer::<V>(hit, t, block.id[i], [zero, zero, V::splat(simd, 1.0)]);
            taken |= 1 << p;
        }
    }
    taken
}

/// The [`chord`] of sphere `i`.
#[inline(always)]
fn chord_of<V: Lanes>(simd: V::Simd, state: &Packet<V::Memory>, block: &SphereBlock, i: usize) -> (V, V) {
    let center = Vec3Lanes::splat(simd, block.center.lane(i));
    let from_center = Vec3Lanes::load(simd, &state.origin) - center;
    let radius = V::splat(simd, block.radius.as_array()[i]);
    chord(from_center, Vec3Lanes::load(simd, &state.direction), radius)
}
