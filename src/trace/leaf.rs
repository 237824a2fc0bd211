//! Leaf blocks against the packets of a bundle.

use super::{bits, frustum::Frustum, rays::Packet};
use crate::{
    accel::{Bvh, Child},
    geometry::{EdgeFunctions, Edges, SphereBlock, TriangleBlock, near_vertex, pad},
    simd::{
        Vec3x8, lane,
        lanes::{Column, LaneMask, Lanes, Vec3Lanes},
        splat,
    },
};
use glam::Vec3;

/// Barycentric weights times twice the determinant: second corner, third, first.
type Weights<V> = [V; 3];

/// Triangle `i` of the eight in `v`, in all lanes.
#[inline(always)]
fn vector<V: Lanes>(v: &Vec3x8, i: usize) -> Vec3Lanes<V> {
    Vec3Lanes::splat(v.lane(i))
}

/// A block against the packets of `packets` that share their origin. What depends on the origin alone is taken once,
/// for eight triangles at a time, and triangles that no ray of the frustum can hit are dropped. `reach`: see
/// [`first_look_reach`](crate::geometry::first_look_reach).
#[inline(always)]
pub(super) fn shared_origin<V: Lanes, const ANY: bool>(
    bvh: &Bvh,
    leaf: Child,
    frustum: Option<&Frustum>,
    reach: f32,
    packets: u32,
    states: &mut [Packet; 8],
) {
    if !leaf.is_triangles() {
        spheres::<V, ANY>(&bvh.sphere_blocks()[leaf.index()], leaf.count(), packets, states);
        return;
    }
    let block = &bvh.triangle_blocks()[leaf.index()];
    let [x, y, z] = &states[0].origin;
    let origin = Vec3::new(x.0[0], y.0[0], z.0[0]);
    let edges8 = block.edge_functions(Vec3x8::splat(origin), splat(reach));
    let mut boxes: Option<(Vec3x8, Vec3x8)> = None;
    for i in bits(reachable(leaf, &edges8, frustum)) {
        let eu = vector::<V>(&edges8.u, i);
        let ev = vector::<V>(&edges8.v, i);
        let ew = vector::<V>(&edges8.w, i);
        let least = V::splat(-lane(&edges8.tolerance, i));
        for p in bits(packets) {
            let state = &mut states[p & 7];
            let d = Vec3Lanes::<V>::load(&state.direction);
            let weights = [d.dot(eu), d.dot(ev), d.dot(ew)];
            let look = smallest(weights).ge(least);
            if look.bits() != 0 {
                if boxes.is_none() {
                    let (lower, upper) = block.padded_boxes();
                    let origin = Vec3x8::splat(origin);
                    boxes = Some((lower - origin, upper - origin));
                }
                let Some((lower, upper)) = &boxes else { continue };
                let determinant = d.dot(vector(&edges8.normal, i));
                let plane = V::splat(lane(&edges8.plane, i));
                let bounds = (vector::<V>(lower, i), vector::<V>(upper, i));
                hit::<V, ANY>(state, block, i, look, weights, plane / determinant, bounds);
            }
        }
    }
}

/// A block against packets whose rays have their own origins.
#[inline(always)]
pub(super) fn separate_origins<V: Lanes, const ANY: bool>(
    bvh: &Bvh,
    leaf: Child,
    reach: f32,
    packets: u32,
    states: &mut [Packet; 8],
) {
    if !leaf.is_triangles() {
        spheres::<V, ANY>(&bvh.sphere_blocks()[leaf.index()], leaf.count(), packets, states);
        return;
    }
    let block = &bvh.triangle_blocks()[leaf.index()];
    let edges8: Edges = block.edges();
    let least8 = edges8.longest() * splat(-reach);
    for i in 0..leaf.count() {
        let v0 = vector::<V>(&block.v0, i);
        let v1 = vector::<V>(&block.v1, i);
        let v2 = vector::<V>(&block.v2, i);
        let eu = vector::<V>(&edges8.u, i);
        let ev = vector::<V>(&edges8.v, i);
        let ew = vector::<V>(&edges8.w, i);
        let normal = vector::<V>(&edges8.normal, i);
        for p in bits(packets) {
            let state = &mut states[p & 7];
            let o = Vec3Lanes::<V>::load(&state.origin);
            let d = Vec3Lanes::<V>::load(&state.direction);
            let (a, b, c) = (v0 - o, v1 - o, v2 - o);
            let plane = normal.dot(a);
            let flip = plane.sign();
            let weights = [
                d.dot(eu.cross(c + a)).turn(flip),
                d.dot(ev.cross(a + b)).turn(flip),
                d.dot(ew.cross(b + c)).turn(flip),
            ];
            let look = smallest(weights).ge(V::splat(lane(&least8, i)));
            if look.bits() != 0 {
                let (lower, upper) = block.padded_boxes();
                let bounds = (vector::<V>(&lower, i) - o, vector::<V>(&upper, i) - o);
                // Turned before the product, as elsewhere: the sign of a determinant of 0 depends on it.
                let turned = Vec3Lanes {
                    x: normal.x.turn(flip),
                    y: normal.y.turn(flip),
                    z: normal.z.turn(flip),
                };
                let determinant = d.dot(turned);
                hit::<V, ANY>(
                    state,
                    block,
                    i,
                    look,
                    weights,
                    plane.turn(flip) / determinant,
                    bounds,
                );
            }
        }
    }
}

#[inline(always)]
fn smallest<V: Lanes>([u, v, w]: Weights<V>) -> V {
    u.min(v).min(w)
}

/// The canonical test of triangle `i`, for the lanes that survived the first look; twin of
/// [`EdgeFunctions::intersect`]. `bounds`: its padded box, relative to the origins.
#[inline(always)]
fn hit<V: Lanes, const ANY: bool>(
    state: &mut Packet,
    block: &TriangleBlock,
    i: usize,
    look: V::Mask,
    weights: Weights<V>,
    t: V,
    bounds: (Vec3Lanes<V>, Vec3Lanes<V>),
) {
    let zero = V::splat(0.0);
    let mut inside = look & smallest(weights).ge(zero);
    if inside.bits() != look.bits() {
        let mut columns = [Column::splat(0.0); 3];
        for (column, weight) in columns.iter_mut().zip(weights) {
            weight.store(column);
        }
        let near = near_a_vertex(&columns, block, i, &state.origin);
        inside = inside | look & V::Mask::from_bits(near);
    }
    let (near, far) = state.interval(bounds.0, bounds.1);
    let t = t.max(near).min(far);
    let hit = inside & near.le(far) & t.gt(zero);
    if hit.bits() != 0 {
        let [u, v, w] = weights;
        let (u, v, w) = (u.max(zero), v.max(zero), w.max(zero));
        let sum = (u + v + w).max(V::splat(f32::MIN_POSITIVE));
        state.offer::<V, ANY>(hit, t, block.id[i], [u, v, sum]);
    }
}

/// [`near_vertex`] for both halves of a packet.
#[cold]
#[inline(never)]
fn near_a_vertex(weights: &[Column; 3], block: &TriangleBlock, i: usize, origin: &[Column; 3]) -> u32 {
    let corners = [&block.v0, &block.v1, &block.v2].map(|v| Vec3x8::splat(v.lane(i)));
    let half = |half: usize| {
        let weights = [0, 1, 2].map(|w: usize| weights[w].halves()[half]);
        let [x, y, z] = [0, 1, 2].map(|axis: usize| origin[axis].halves()[half]);
        near_vertex(weights, corners, Vec3x8::new(x, y, z)).bits()
    };
    half(0) | half(1) << 8
}

/// The triangles of a block that some ray of the frustum may hit: those none of whose edges is wholly outside.
#[inline(always)]
fn reachable(leaf: Child, edges8: &EdgeFunctions, frustum: Option<&Frustum>) -> u32 {
    let count_bits = (1_u32 << leaf.count()) - 1;
    let Some(frustum) = frustum else { return count_bits };
    // The kernel's tolerance over |d_k|, which is above 0.3, and twice it for the rounding here.
    let margin = edges8.tolerance * splat(6.0);
    count_bits
        & frustum.may_reach_zero(&edges8.u, margin)
        & frustum.may_reach_zero(&edges8.v, margin)
        & frustum.may_reach_zero(&edges8.w, margin)
}

/// A block of spheres; twin of [`intersect_spheres`](crate::geometry::intersect_spheres).
#[inline(always)]
fn spheres<V: Lanes, const ANY: bool>(
    block: &SphereBlock,
    count: usize,
    packets: u32,
    states: &mut [Packet; 8],
) {
    let size = Vec3x8::new(block.radius, block.radius, block.radius);
    let (lower8, upper8) = (block.center - size, block.center + size);
    let pad8 = pad(crate::simd::max(lower8.max_abs(), upper8.max_abs()));
    let pad8 = Vec3x8::new(pad8, pad8, pad8);
    let (lower8, upper8) = (lower8 - pad8, upper8 + pad8);
    let zero = V::splat(0.0);
    for i in 0..count {
        let center = vector::<V>(&block.center, i);
        let radius = V::splat(lane(&block.radius, i));
        for p in bits(packets) {
            let state = &mut states[p & 7];
            let o = Vec3Lanes::<V>::load(&state.origin);
            let d = Vec3Lanes::<V>::load(&state.direction);
            let from_center = o - center;
            let nearest = -from_center.dot(d);
            let aside = Vec3Lanes {
                x: d.x.mul_add(nearest, from_center.x),
                y: d.y.mul_add(nearest, from_center.y),
                z: d.z.mul_add(nearest, from_center.z),
            };
            let discriminant = radius * radius - aside.dot(aside);
            let meets = discriminant.ge(zero);
            if meets.bits() == 0 {
                continue;
            }
            let half_chord = discriminant.max(zero).sqrt();
            let (t0, t1) = (nearest - half_chord, nearest + half_chord);
            let t = V::select(t0.gt(zero), t0, t1);
            let (near, far) = state.interval(vector::<V>(&lower8, i) - o, vector::<V>(&upper8, i) - o);
            let held = t.max(near).min(far);
            let hit = meets & t.gt(zero) & held.gt(zero) & near.le(far);
            if hit.bits() != 0 {
                state.offer::<V, ANY>(hit, held, block.id[i], [zero, zero, V::splat(1.0)]);
            }
        }
    }
}
