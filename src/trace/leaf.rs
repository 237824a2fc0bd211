//! Leaf blocks against the packets of a bundle.

use super::{PACKETS, bits, bits64, bundle::Culling, rays::Packet};
use crate::{
    accel::{Bvh, Child},
    geometry::{EdgeFunctions, EdgeLines, Edges, SphereBlock, TriangleBlock, pad, passes_through},
    simd::{
        F32x8, LANES, Mask8, Vec3x8, lane,
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
/// for eight triangles at a time; triangles that no ray of the frustum can hit are dropped, and so are packets none of
/// whose rays can hit a triangle. Answers which
/// packets may have taken a hit.
#[inline(always)]
pub(super) fn shared_origin<V: Lanes, const ANY: bool>(
    bvh: &Bvh,
    leaf: Child,
    culling: &Culling<'_, V>,
    packets: u32,
    states: &mut [Packet; PACKETS],
) -> u32 {
    if !leaf.is_triangles() {
        let block = &bvh.sphere_blocks()[leaf.index()];
        return spheres::<V, ANY>(block, leaf.count_bits(), culling, packets, states);
    }
    let block = &bvh.triangle_blocks()[leaf.index()];
    let [x, y, z] = &states[0].origin;
    let origin = Vec3::new(x.0[0], y.0[0], z.0[0]);
    let edges8 = block.edge_functions(Vec3x8::splat(origin));
    let mut triangles = leaf.count_bits();
    if let Some(frustum) = culling.frustum
        && packets.count_ones() > ALL_FIRST
    {
        triangles &= frustum.triangles(&edges8);
    }
    // Which triangles for which packet: a byte a packet. (Both words by their own loop: no choice between them a packet.)
    let mut pairs = [0_u64; PACKETS / 8];
    for (word, pairs) in pairs.iter_mut().enumerate() {
        for p in bits(packets >> (word * 8) & 0xff) {
            let mut triangles = triangles;
            if let Some(frustum) = culling.frustum {
                triangles &= frustum.triangles_of(word * 8 + p, &edges8);
            }
            *pairs |= u64::from(triangles) << (p * 8);
        }
    }
    // Turned here for all: a number that is broadcast from memory costs nothing, one that is turned first does.
    let lowest8 = -edges8.tolerance;
    let mut looks = [0_u8; PACKETS * LANES];
    let mut count = 0;
    for (word, pairs) in pairs.into_iter().enumerate() {
        for pair in bits64(pairs) {
            let (p, i) = (word * 8 + pair / 8, pair % 8);
            let d = Vec3Lanes::<V>::load(&states[p % PACKETS].direction);
            let weights = weights(&d, &edges8, i);
            let look = smallest(weights).ge(V::splat(lane(&lowest8, i)));
            looks[count % (PACKETS * LANES)] = (word * 64 + pair) as u8;
            count += usize::from(look.bits() != 0);
        }
    }
    if count == 0 {
        return 0;
    }
    let (lower, upper) = block.padded_boxes();
    let origin = Vec3x8::splat(origin);
    let (first8, last8) = in_order(lower - origin, upper - origin, culling.down);
    let mut taken = 0;
    for &pair in &looks[..count] {
        let (p, i) = (usize::from(pair) / LANES, usize::from(pair) % LANES);
        let state = &mut states[p % PACKETS];
        let d = Vec3Lanes::<V>::load(&state.direction);
        let weights = weights(&d, &edges8, i);
        let tolerance = [V::splat(lane(&lowest8, i)), V::splat(lane(&edges8.tolerance, i))];
        let determinant = d.dot(vector(&edges8.normal, i));
        let t = V::splat(lane(&edges8.plane, i)) / determinant;
        let bounds = interval::<V>(state, vector(&first8, i), vector(&last8, i), culling);
        let hit = hit::<V, ANY>(state, block, i, tolerance, weights, t, bounds);
        taken |= u32::from(hit) << p;
    }
    taken
}

/// Puts packet `p`'s byte into `pairs`, which had none. (Without an index, so that both words stay in registers.)
#[inline(always)]
fn put(pairs: &mut [u64; PACKETS / 8], p: usize, byte: u32) {
    let (bits, is_high) = (u64::from(byte) << (p % 8 * 8), u64::from(p >= 8).wrapping_neg());
    pairs[0] |= bits & !is_high;
    pairs[1] |= bits & is_high;
}

/// The barycentric weights of triangle `i`, see [`EdgeFunctions::weights`].
#[inline(always)]
fn weights<V: Lanes>(d: &Vec3Lanes<V>, edges8: &EdgeFunctions, i: usize) -> Weights<V> {
    [
        d.dot(vector(&edges8.u, i)),
        d.dot(vector(&edges8.v, i)),
        d.dot(vector(&edges8.w, i)),
    ]
}

/// With more packets than this, triangles are first tested against the frustum of all of them.
const ALL_FIRST: u32 = 2;

/// A block against packets whose rays have their own origins: first as lines, which takes half the operations of the
/// canonical edge functions, then canonically those pairs that are left. (Mirror rays: interior 9.9 to 11.2 Mrays/s, figure
/// 46 to 51, terrain 4.7 to 4.9.)
#[inline(always)]
pub(super) fn separate_origins<V: Lanes, const ANY: bool>(
    bvh: &Bvh,
    leaf: Child,
    culling: &Culling<'_, V>,
    packets: u32,
    moments: &[[Column; 3]; PACKETS],
    states: &mut [Packet; PACKETS],
) -> u32 {
    if !leaf.is_triangles() {
        let block = &bvh.sphere_blocks()[leaf.index()];
        return spheres::<V, ANY>(block, leaf.count_bits(), culling, packets, states);
    }
    let block = &bvh.triangle_blocks()[leaf.index()];
    let edges8: Edges = block.edges();
    let lines8 = block.edge_lines(&edges8, Vec3x8::splat(culling.point), splat(culling.extent));
    let (lowest8, look_lowest8) = (-lines8.tolerance, -lines8.look_tolerance);
    let mut looks = [0_u8; PACKETS * LANES];
    let mut count = 0;
    for p in bits(packets) {
        let state = &states[p % PACKETS];
        let d = Vec3Lanes::<V>::load(&state.direction);
        let m = Vec3Lanes::<V>::load(&moments[p % PACKETS]);
        let live = state.live_bits::<V>();
        for i in 0..leaf.count() {
            let outside = outside(&d, &m, &lines8, &look_lowest8, i);
            looks[count % (PACKETS * LANES)] = (p * LANES + i) as u8;
            count += usize::from(live & !outside.bits() != 0);
        }
    }
    if count == 0 {
        return 0;
    }
    let (lower8, upper8) = block.padded_boxes();
    let (first8, last8) = in_order(lower8, upper8, culling.down);
    let mut taken = 0;
    for &pair in &looks[..count] {
        let (p, i) = (usize::from(pair) / LANES, usize::from(pair) % LANES);
        let state = &mut states[p % PACKETS];
        let o = Vec3Lanes::<V>::load(&state.origin);
        let d = Vec3Lanes::<V>::load(&state.direction);
        let a = vector::<V>(&block.v0, i) - o;
        let b = vector::<V>(&block.v1, i) - o;
        let c = vector::<V>(&block.v2, i) - o;
        let normal = vector::<V>(&edges8.normal, i);
        let plane = normal.dot(a);
        let flip = plane.sign();
        let weights = [
            d.dot(vector::<V>(&edges8.u, i).cross(c + a)).turn(flip),
            d.dot(vector::<V>(&edges8.v, i).cross(a + b)).turn(flip),
            d.dot(vector::<V>(&edges8.w, i).cross(b + c)).turn(flip),
        ];
        let tolerance = [V::splat(lane(&lowest8, i)), V::splat(lane(&lines8.tolerance, i))];
        let bounds = interval::<V>(state, vector(&first8, i) - o, vector(&last8, i) - o, culling);
        // Turned before the product, as elsewhere: the sign of a determinant of 0 depends on it.
        let turned = Vec3Lanes {
            x: normal.x.turn(flip),
            y: normal.y.turn(flip),
            z: normal.z.turn(flip),
        };
        let determinant = d.dot(turned);
        let t = plane.turn(flip) / determinant;
        let hit = hit::<V, ANY>(state, block, i, tolerance, weights, t, bounds);
        taken |= u32::from(hit) << p;
    }
    taken
}

/// Lanes whose rays, taken as lines, clearly pass outside triangle `i`: some edges have them on one side, some on the
/// other.
#[inline(always)]
fn outside<V: Lanes>(
    d: &Vec3Lanes<V>,
    m: &Vec3Lanes<V>,
    lines8: &EdgeLines,
    lowest8: &F32x8,
    i: usize,
) -> V::Mask {
    let u = beside(d, m, vector(&lines8.edges[0], i), vector(&lines8.moments[0], i));
    let v = beside(d, m, vector(&lines8.edges[1], i), vector(&lines8.moments[1], i));
    let w = beside(d, m, vector(&lines8.edges[2], i), vector(&lines8.moments[2], i));
    let highest = V::splat(lane(&lines8.look_tolerance, i));
    u.min(v).min(w).lt(V::splat(lane(lowest8, i))) & u.max(v).max(w).gt(highest)
}

/// The edge function: on which side of the line with `edge` and `moment` rays pass.
#[inline(always)]
fn beside<V: Lanes>(d: &Vec3Lanes<V>, m: &Vec3Lanes<V>, edge: Vec3Lanes<V>, moment: Vec3Lanes<V>) -> V {
    let by_moment = d.x.mul_add(moment.x, d.y.mul_add(moment.y, d.z * moment.z));
    let by_edge = m.x.mul_add(edge.x, m.y.mul_add(edge.y, m.z * edge.z));
    by_moment - by_edge
}

#[inline(always)]
fn smallest<V: Lanes>([u, v, w]: Weights<V>) -> V {
    u.min(v).min(w)
}

/// Eight boxes' corners: those where rays that go one way come in, then those where they leave; lower and upper ones if
/// they do not go one way.
#[inline(always)]
fn in_order(lower8: Vec3x8, upper8: Vec3x8, down: Option<[u8; 3]>) -> (Vec3x8, Vec3x8) {
    let down = down.unwrap_or_default().map(|down| Mask8::all_or_none(down != 0));
    let pick = |a: Vec3x8, b: Vec3x8| {
        Vec3x8::new(
            down[0].select(b.x, a.x),
            down[1].select(b.y, a.y),
            down[2].select(b.z, a.z),
        )
    };
    (pick(lower8, upper8), pick(upper8, lower8))
}

/// The canonical interval of rays in a box, given by what [`in_order`] tells, relative to their origins.
#[inline(always)]
fn interval<V: Lanes>(
    state: &Packet,
    first: Vec3Lanes<V>,
    last: Vec3Lanes<V>,
    culling: &Culling<'_, V>,
) -> (V, V) {
    if culling.down.is_some() {
        state.interval_one_way(first, last)
    } else {
        state.interval(first, last)
    }
}

/// The canonical test of triangle `i`; twin of [`EdgeFunctions::intersect`]. `tolerance`: below 0, then above. `bounds`:
/// where the rays are in its padded box. Answers whether a lane may have taken it.
#[inline(always)]
fn hit<V: Lanes, const ANY: bool>(
    state: &mut Packet,
    block: &TriangleBlock,
    i: usize,
    tolerance: [V; 2],
    weights: Weights<V>,
    t: V,
    (near, far): (V, V),
) -> bool {
    let t = t.max(near).min(far);
    let best = V::load(&state.t);
    // Asking for the nearer here, and not only where hits are taken, made shadow rays 5 to 10 % faster.
    let nearer = if ANY { t.lt(best) } else { t.le(best) };
    let ahead = near.le(far) & t.gt(V::splat(0.0)) & nearer;
    let smallest = smallest(weights);
    let looked = (ahead & smallest.ge(tolerance[0])).bits();
    let hit = ahead & smallest.gt(tolerance[1]);
    if hit.bits() != looked {
        let mut columns = [Column::splat(0.0); 4];
        for (column, value) in columns.iter_mut().zip([weights[0], weights[1], weights[2], t]) {
            value.store(column);
        }
        return unsure::<ANY>(state, block, i, hit.bits(), looked, &columns);
    }
    if looked != 0 {
        state.offer::<V, ANY>(hit, t, block.id[i], weights);
    }
    looked != 0
}

/// The rest of [`hit`], ray by ray, where some of the rays that `looked` are not sure to hit. `columns`: their weights
/// and distances. (Not to come back from here with what rays hit keeps that out of memory everywhere else.)
#[cold]
#[inline(never)]
fn unsure<const ANY: bool>(
    state: &mut Packet,
    block: &TriangleBlock,
    i: usize,
    sure: u32,
    looked: u32,
    [u, v, w, t]: &[Column; 4],
) -> bool {
    let hit = sure | passing(state, looked & !sure, [u, v, w], block, i);
    for ray in bits(hit) {
        let weights = [u, v, w].map(|weights| weights.0[ray & 15]);
        state.offer_lane::<ANY>(ray & 15, t.0[ray & 15], block.id[i], weights);
    }
    hit != 0
}

/// Those of `lanes` whose rays [pass through](passes_through) triangle `i`.
fn passing(state: &Packet, lanes: u32, weights: [&Column; 3], block: &TriangleBlock, i: usize) -> u32 {
    let corners = [&block.v0, &block.v1, &block.v2].map(|corner| corner.lane(i));
    let passes = |&ray: &usize| {
        let vector = |columns: [&Column; 3]| columns.map(|column| column.0[ray & 15]);
        let (origin, direction) = (
            vector(state.origin.each_ref()),
            vector(state.direction.each_ref()),
        );
        passes_through(origin.into(), direction.into(), corners, vector(weights))
    };
    bits(lanes)
        .filter(passes)
        .fold(0, |passing, ray| passing | 1 << ray)
}

/// A block of spheres (`all`: a bit each); twin of [`intersect_spheres`](crate::geometry::intersect_spheres). Spheres
/// whose boxes a packet's frustum does not meet are left out. (Camera rays of a hundred thousand spheres +30 %. The same
/// for triangles: with rays that share their origin -4 to 0 %, with others -6 to +5 %.)
#[inline(always)]
fn spheres<V: Lanes, const ANY: bool>(
    block: &SphereBlock,
    mut all: u32,
    culling: &Culling<'_, V>,
    packets: u32,
    states: &mut [Packet; PACKETS],
) -> u32 {
    let size = Vec3x8::new(block.radius, block.radius, block.radius);
    let (lower8, upper8) = (block.center - size, block.center + size);
    let pad8 = pad(crate::simd::max(lower8.max_abs(), upper8.max_abs()));
    let pad8 = Vec3x8::new(pad8, pad8, pad8);
    let (lower8, upper8) = (lower8 - pad8, upper8 + pad8);
    let zero = V::splat(0.0);
    let mut pairs = [0_u64; PACKETS / 8];
    if let Some(frustum) = culling.frustum {
        let planes = [lower8.x, lower8.y, lower8.z, upper8.x, upper8.y, upper8.z];
        let (met, seen) = frustum.boxes(&planes);
        all &= met;
        for p in bits(packets) {
            put(&mut pairs, p, all & frustum.boxes_of(p, &seen));
        }
    } else {
        for p in bits(packets) {
            put(&mut pairs, p, all);
        }
    }
    let mut meets = [0_u8; PACKETS * LANES];
    let mut met = 0;
    for (word, pairs) in pairs.into_iter().enumerate() {
        for pair in bits64(pairs) {
            let (p, i) = (word * 8 + pair / 8, pair % 8);
            let state = &states[p % PACKETS];
            let (_, discriminant): (V, V) = chord(state, block, i);
            meets[met % (PACKETS * LANES)] = (word * 64 + pair) as u8;
            met += usize::from(discriminant.ge(zero).bits() != 0);
        }
    }
    let mut taken = 0;
    for &pair in &meets[..met] {
        let (p, i) = (usize::from(pair) / LANES, usize::from(pair) % LANES);
        let state = &mut states[p % PACKETS];
        let (nearest, discriminant): (V, V) = chord(state, block, i);
        let o = Vec3Lanes::<V>::load(&state.origin);
        let half_chord = discriminant.max(zero).sqrt();
        let (t0, t1) = (nearest - half_chord, nearest + half_chord);
        let t = V::select(t0.gt(zero), t0, t1);
        let (near, far) = state.interval(vector::<V>(&lower8, i) - o, vector::<V>(&upper8, i) - o);
        let held = t.max(near).min(far);
        let hit = discriminant.ge(zero) & t.gt(zero) & held.gt(zero) & near.le(far);
        if hit.bits() != 0 {
            // Not asked before: camera rays of spheres +7 % (before packets' frusta were asked).
            let hit = hit & held.le(V::load(&state.t));
            state.offer::<V, ANY>(hit, held, block.id[i], [zero, zero, V::splat(1.0)]);
            taken |= 1 << p;
        }
    }
    taken
}

/// How far along the rays sphere `i` is nearest, and the square of half the chord.
#[inline(always)]
fn chord<V: Lanes>(state: &Packet, block: &SphereBlock, i: usize) -> (V, V) {
    let o = Vec3Lanes::<V>::load(&state.origin);
    let d = Vec3Lanes::<V>::load(&state.direction);
    let from_center = o - vector(&block.center, i);
    let radius = V::splat(lane(&block.radius, i));
    let nearest = -from_center.dot(d);
    let aside = Vec3Lanes {
        x: d.x.mul_add(nearest, from_center.x),
        y: d.y.mul_add(nearest, from_center.y),
        z: d.z.mul_add(nearest, from_center.z),
    };
    (nearest, radius * radius - aside.dot(aside))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        ray::{PrimitiveId, RayPacket},
        simd::F32x8,
    };

    /// Rays at corners, at edges and past them, of triangles of all shapes, near and far from their origins.
    #[test]
    fn first_looks_lose_no_ray_that_passes_through() {
        let mut random = fastrand::Rng::with_seed(11);
        let mut unit = move || random.f32() * 2.0 - 1.0;
        let mut vector = |size: f32| Vec3::new(unit(), unit(), unit()) * size;
        let mut passing = 0;
        for round in 0..20_000 {
            let size = [1e-3, 1.0, 1e3, 1e15][round % 4];
            let around = vector([0.0, 1.0, 1e4][round % 3] * size);
            let corners = [(); 3].map(|()| around + vector(size));
            let sliver = [corners[0], corners[1], (corners[0] + corners[1]) * 0.5];
            let corners = if round % 5 == 0 { sliver } else { corners };
            let block = TriangleBlock::new(&[(PrimitiveId(0), corners)]);
            let origins = [(); LANES].map(|()| around + vector(3.0 * size));
            let mut part = vector(1.0);
            let directions = origins.map(|origin| {
                part = Vec3::new(part.y, part.z, (part.x * 7.0).fract());
                let at = corners[0]
                    + (corners[1] - corners[0]) * part.x.abs()
                    + (corners[2] - corners[0]) * [0.0, part.y][round % 2];
                (at - origin).normalize()
            });
            let rays = RayPacket {
                direction: Vec3x8::from_lanes(directions),
                t_max: splat(f32::MAX),
            };
            let point = origins.into_iter().fold(origins[0], Vec3::min);
            let extent = (origins.into_iter().fold(origins[0], Vec3::max) - point).length();
            let mut packet = Packet::EMPTY;
            let origin8 = Vec3x8::from_lanes(origins);
            packet.set::<F32x8>(&rays, &rays);
            packet.start_at::<F32x8>(&origin8, &origin8);
            let lines = block.edge_lines(&block.edges(), Vec3x8::splat(point), splat(extent));
            let d = Vec3Lanes::<F32x8>::load(&packet.direction);
            let m = packet.moments::<F32x8>(point);
            let outside = outside(&d, &m, &lines, &-lines.look_tolerance, 0).bits();
            for (lane, (origin, direction)) in origins.into_iter().zip(directions).enumerate() {
                let edges = block.edge_functions(Vec3x8::splat(origin));
                let weights = edges.weights(&Vec3x8::splat(direction));
                let look = edges.first_look(weights) & 1;
                let passes = passes_through(
                    origin,
                    direction,
                    corners,
                    weights.map(|w| crate::simd::lane(&w, 0)),
                );
                passing += u32::from(passes);
                assert!(
                    !passes || look != 0 && outside >> lane & 1 == 0,
                    "round {round}: {corners:?} {origin} {direction}"
                );
            }
        }
        assert!(
            (40_000..120_000).contains(&passing),
            "{passing} of 160,000 pass through"
        );
    }
}
