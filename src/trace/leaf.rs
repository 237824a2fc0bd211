//! Leaf blocks against the packets of a bundle: triangles for rays with a shared origin (separate origins:
//! [`sheared`](super::sheared)), spheres, and the canonical test.
//!
//!   two blocks -> edge functions from the origin, once per bundle, a lane per triangle
//!     x bundle frustum, x packet frusta -> pairs of triangle and packet
//!       x rays, a lane per ray -> candidates -> canonical test -> hits
//!
//! Triangles are culled by the maximum of their edge functions over a frustum, as in Dmitriev, Havran and Seidel 2004
//! (*SIMD Shaft Culling*) and Benthin and Wald 2009. Differs: a lane is a triangle, a frustum a box of directions.

use super::{
    PACKETS, bits, bits64,
    bundle::Culling,
    origins::{RayOrigins, Shared},
    rays::Packet,
};
use crate::{
    accel::{Child, LeafBlocks},
    geometry::{
        EdgeFunctions, SphereBlock, TriangleLeaf, chord, meets, padded_boxes, padded_sphere_boxes,
        sphere_hits,
    },
    lanes::LANES,
    simd::{
        Column, Eight, EightLanes, LaneMask, Lanes, Memory, REGISTER_LANES, Simd, TriangleLanes, Vec3Lanes,
    },
};
use glam::Vec3;

/// Barycentric weights times twice the determinant: second corner, third, first.
type Weights<V> = [V; 3];

/// Lane `i` of eight vectors, in all lanes.
#[inline(always)]
pub(super) fn vector<V: Lanes, E: EightLanes<Simd = V::Simd>>(v: &Vec3Lanes<E>, i: usize) -> Vec3Lanes<V> {
    let simd = v.x.simd();
    Vec3Lanes {
        x: V::splat(simd, v.x.lane(i)),
        y: V::splat(simd, v.y.lane(i)),
        z: V::splat(simd, v.z.lane(i)),
    }
}

/// Slots of [`Leaves`]: the triangles of two leaves.
const PLACES: usize = REGISTER_LANES;

/// A leaf and the packets that may hit something in it; with sixteen [triangle lanes](Lanes::Triangles), a second
/// leaf, so that both blocks are prepared in one register and the loops' overhead is paid once. Without a second one,
/// its packet mask is 0 and `child` repeats the first.
// Tuned: see docs/lab-notes.md#two-leaves
#[derive(Clone, Copy)]
pub(super) struct Leaves {
    pub child: [Child; 2],
    pub packets: [u32; 2],
}

impl Leaves {
    /// The slots with a triangle, a bit each: the second leaf's follow the first one's.
    #[inline(always)]
    fn places(self) -> u32 {
        let [first, second] = self.child;
        first.count_bits() | second.count_bits() << LANES
    }

    /// The slots of those leaves that packet `p` may hit something in.
    #[inline(always)]
    fn places_of(self, p: usize) -> u32 {
        let [first, second] = self.packets;
        ((first >> p & 1) * 0x00ff) | ((second >> p & 1) * 0xff00)
    }
}

/// Vectors that are broadcast, number by number.
type Columns3 = [Column; 3];

const EMPTY: Column = Column([0.0; REGISTER_LANES]);

/// Slot `i` of `columns`, in all lanes.
#[inline(always)]
fn place<V: Lanes>(simd: V::Simd, [x, y, z]: &Columns3, i: usize) -> Vec3Lanes<V> {
    let i = i % PLACES;
    Vec3Lanes {
        x: V::splat(simd, x.0[i]),
        y: V::splat(simd, y.0[i]),
        z: V::splat(simd, z.0[i]),
    }
}

/// Slot `i` of a column, in all lanes.
#[inline(always)]
fn number<V: Lanes>(simd: V::Simd, column: &Column, i: usize) -> V {
    V::splat(simd, column.0[i % PLACES])
}

/// [`EdgeFunctions`] in memory: a broadcast from there is free.
struct Functions {
    u: Columns3,
    v: Columns3,
    w: Columns3,
    normal: Columns3,
    plane: Column,
    tolerance: Column,
    /// Minus the tolerance.
    lowest: Column,
    /// One and a half times that: a weight with unfused products differs from the fused one by at most six half-ulps, and the
    /// tolerance is twenty.
    least: Column,
}

impl Functions {
    #[inline(always)]
    fn new<V: TriangleLanes>(edges: &EdgeFunctions<V>) -> Self {
        let mut functions = Self {
            u: [EMPTY; 3],
            v: [EMPTY; 3],
            w: [EMPTY; 3],
            normal: [EMPTY; 3],
            plane: EMPTY,
            tolerance: EMPTY,
            lowest: EMPTY,
            least: EMPTY,
        };
        edges.u.store(&mut functions.u);
        edges.v.store(&mut functions.v);
        edges.w.store(&mut functions.w);
        edges.normal.store(&mut functions.normal);
        edges.plane.store(&mut functions.plane);
        edges.tolerance.store(&mut functions.tolerance);
        (-edges.tolerance).store(&mut functions.lowest);
        (edges.tolerance * -1.5).store(&mut functions.least);
        functions
    }

    /// The barycentric weights of the triangle in slot `i`, see [`EdgeFunctions::weights`].
    #[inline(always)]
    fn weights<V: Lanes>(&self, d: &Vec3Lanes<V>, i: usize) -> Weights<V> {
        let simd = d.x.simd();
        [
            d.dot(place(simd, &self.u, i)),
            d.dot(place(simd, &self.v, i)),
            d.dot(place(simd, &self.w, i)),
        ]
    }

    /// Whether a ray may have a candidate in slot `i`: no weight is below [`Self::least`].
    #[inline(always)]
    fn may_hit<V: Lanes>(&self, d: &Vec3Lanes<V>, i: usize) -> bool {
        let simd = d.x.simd();
        let weights = [
            d.dot_about(place(simd, &self.u, i)),
            d.dot_about(place(simd, &self.v, i)),
            d.dot_about(place(simd, &self.w, i)),
        ];
        smallest(weights).ge(number(simd, &self.least, i)).any()
    }
}

/// Tests blocks against packets with a shared origin. What depends only on the origin is computed once for all packets;
/// triangles outside the frustum and packets that miss a triangle are dropped. Returns the packets that may have taken a
/// hit, in occlusion those that are done.
#[inline(always)]
pub(super) fn shared_origin<B: TriangleLeaf, V: Lanes, const ANY: bool>(
    simd: V::Simd,
    blocks: LeafBlocks<'_, B>,
    leaves: Leaves,
    culling: &Culling<'_, V>,
    states: &mut [Packet<V::Memory>; PACKETS],
) -> u32 {
    let Leaves { child, packets } = leaves;
    if !child[0].is_triangles() {
        let block = &blocks.spheres[child[0].index()];
        return spheres::<V, Shared, ANY>(simd, block, child[0].count_bits(), culling, packets[0], states);
    }
    let blocks = [
        &blocks.triangles[child[0].index()],
        &blocks.triangles[child[1].index()],
    ];
    let [x, y, z] = &states[0].origin;
    let origin = Vec3Lanes::splat(simd, Vec3::new(x.place(0), y.place(0), z.place(0)));
    let corners = B::corners::<V::Triangles>(simd, blocks);
    let edges = EdgeFunctions::new(&corners, origin);
    let packets = packets[0] | packets[1];
    let mut triangles = leaves.places();
    if let Some(frustum) = culling.frustum
        && packets.count_ones() > ALL_FIRST
    {
        triangles &= frustum.triangles(&edges);
    }
    // The triangles of each packet, a bit per slot. Each word has its own loop and no index, so that it stays in a
    // register.
    let places = V::Triangles::COUNT;
    let packets_a_word = 64 / places;
    let mut pairs = [0_u64; PACKETS / 4];
    for (half, pairs) in pairs.as_chunks_mut::<2>().0.iter_mut().enumerate() {
        for p in bits(packets >> (half * 8) & 0xff) {
            let own = half * 8 + p;
            let mut triangles = triangles & leaves.places_of(own);
            if let Some(frustum) = culling.frustum {
                triangles &= frustum.triangles_of(own, &edges);
            }
            put(pairs, p, packets_a_word, triangles);
        }
    }
    let functions = Functions::new(&edges);
    let mut candidates = [0_u8; PACKETS * PLACES];
    let mut count = 0;
    for (word, pairs) in pairs.into_iter().enumerate() {
        // Two words hold eight packets; with eight slots all of them are in the first.
        let first = (word / 2 * 8 + word % 2 * packets_a_word) * places;
        for pair in bits64(pairs) {
            let (p, i) = ((first + pair) / places, pair % places);
            let d = Vec3Lanes::<V>::load(simd, &states[p % PACKETS].direction);
            candidates[count % (PACKETS * PLACES)] = (first + pair) as u8;
            count += usize::from(functions.may_hit(&d, i));
        }
    }
    if count == 0 {
        return 0;
    }
    let (lower, upper) = padded_boxes(&corners);
    let (first, last) = in_order(lower - origin, upper - origin, culling.octant);
    let (first, last) = (stored(first), stored(last));
    let mut taken = 0;
    for &pair in &candidates[..count] {
        let (p, i) = (usize::from(pair) / places, usize::from(pair) % places);
        let state = &mut states[p % PACKETS];
        let d = Vec3Lanes::<V>::load(simd, &state.direction);
        let weights = functions.weights(&d, i);
        let tolerance = [
            number(simd, &functions.lowest, i),
            number(simd, &functions.tolerance, i),
        ];
        let determinant = d.dot(place(simd, &functions.normal, i));
        let t = number::<V>(simd, &functions.plane, i) / determinant;
        let bounds = interval::<V>(state, place(simd, &first, i), place(simd, &last, i), culling);
        let hit = hit::<B, V, ANY>(
            state,
            blocks[i / LANES % 2],
            i % LANES,
            tolerance,
            weights,
            t,
            bounds,
        );
        taken |= u32::from(hit) << p;
    }
    taken
}

/// Vectors in memory.
#[inline(always)]
fn stored<V: TriangleLanes>(v: Vec3Lanes<V>) -> Columns3 {
    let mut columns = [EMPTY; 3];
    v.store(&mut columns);
    columns
}

/// Sets the bits of packet `p` in `pairs`, with `each` packets per word. Without an index, so that both words stay in
/// registers.
#[inline(always)]
fn put(pairs: &mut [u64; 2], p: usize, each: usize, bits: u32) {
    let is_high = u64::from(p >= each).wrapping_neg();
    let bits = u64::from(bits) << (p % each * (64 / each));
    pairs[0] |= bits & !is_high;
    pairs[1] |= bits & is_high;
}

/// With more packets than this, triangles are first tested against the frustum of all of them.
const ALL_FIRST: u32 = 2;

#[inline(always)]
fn smallest<V: Lanes>([u, v, w]: Weights<V>) -> V {
    u.min(v).min(w)
}

/// The boxes' corners ordered for the direction octant: where rays enter, then where they leave; lower and upper
/// without an octant.
#[inline(always)]
pub(super) fn in_order<V: Lanes>(
    lower: Vec3Lanes<V>,
    upper: Vec3Lanes<V>,
    octant: Option<[u8; 3]>,
) -> (Vec3Lanes<V>, Vec3Lanes<V>) {
    let [x, y, z] = octant.unwrap_or([0; 3]);
    let (first_x, last_x) = exchanged_if(x, lower.x, upper.x);
    let (first_y, last_y) = exchanged_if(y, lower.y, upper.y);
    let (first_z, last_z) = exchanged_if(z, lower.z, upper.z);
    let (first, last) = ([first_x, first_y, first_z], [last_x, last_y, last_z]);
    (first.into(), last.into())
}

/// `b` and `a` if `which` is 1, `a` and `b` if it is 0, without a branch.
#[inline(always)]
fn exchanged_if<V: Lanes>(which: u8, a: V, b: V) -> (V, V) {
    let all = V::mask(a.simd(), u32::from(which).wrapping_neg());
    (V::select(all, b, a), V::select(all, a, b))
}

/// The canonical interval of rays in a box, given in the order of [`in_order`], relative to their origins.
#[inline(always)]
pub(super) fn interval<V: Lanes>(
    state: &Packet<V::Memory>,
    first: Vec3Lanes<V>,
    last: Vec3Lanes<V>,
    culling: &Culling<'_, V>,
) -> (V, V) {
    if culling.octant.is_some() {
        state.interval_in_octant(first, last)
    } else {
        state.interval(first, last)
    }
}

/// The canonical test of triangle `i` of a block, like [`EdgeFunctions::intersect`]. `tolerance`: negative, then
/// positive. `bounds`: the rays' interval in its padded box. Returns whether a lane may have taken it, in occlusion
/// whether all lanes are done.
// Tuned: see docs/lab-notes.md#occlusion-without-branches
#[inline(always)]
pub(super) fn hit<B: TriangleLeaf, V: Lanes, const ANY: bool>(
    state: &mut Packet<V::Memory>,
    block: &B,
    i: usize,
    tolerance: [V; 2],
    weights: Weights<V>,
    t: V,
    (near, far): (V, V),
) -> bool {
    let simd = t.simd();
    let t = t.max(near).min(far);
    let best = V::load(simd, &state.t);
    // Tuned: see docs/lab-notes.md#nearer-first
    let nearer = if ANY { t.lt(best) } else { t.le(best) };
    let unknown = tolerance[1].eq(V::splat(simd, f32::INFINITY));
    let ahead = near.le(far) & ((t.gt(V::splat(simd, 0.0)) & nearer) | unknown);
    let smallest = smallest(weights);
    let candidates = (ahead & smallest.ge(tolerance[0])).bits();
    let hit = ahead & smallest.gt(tolerance[1]);
    if hit.bits() != candidates {
        let mut columns = [V::Memory::ZERO; 6];
        let [u, v, w] = weights;
        for (column, value) in columns.iter_mut().zip([u, v, w, t, near, far]) {
            value.store(column);
        }
        let taken = unsure::<B, V::Memory, ANY>(state, block, i, hit.bits(), candidates, &columns);
        return if ANY {
            state.live_bits::<V>(simd) == 0
        } else {
            taken
        };
    }
    if ANY {
        return state.block::<V>(simd, hit);
    }
    if candidates != 0 {
        state.offer::<V>(hit, t, block.id(i), weights);
    }
    candidates != 0
}

/// The rest of [`hit`], ray by ray, where some candidates are not certain. `columns`: their weights,
/// distances, and the interval of the triangle's box.
/// Not returning from here into the loop keeps the rays' hits in registers.
#[cold]
#[inline(never)]
fn unsure<B: TriangleLeaf, M: Memory, const ANY: bool>(
    state: &mut Packet<M>,
    block: &B,
    i: usize,
    sure: u32,
    candidates: u32,
    columns: &[M; 6],
) -> bool {
    let mut taken = sure != 0;
    for ray in bits(candidates) {
        let [u, v, w, t, near, far] = columns;
        let interval = [near.place(ray), far.place(ray)];
        let [mut u, mut v, mut w, mut t] = [u.place(ray), v.place(ray), w.place(ray), t.place(ray)];
        if sure >> ray & 1 == 0 {
            let vector = |[x, y, z]: &[M; 3]| Vec3::new(x.place(ray), y.place(ray), z.place(ray));
            let (origin, direction) = (vector(&state.origin), vector(&state.direction));
            let found = meets(origin, direction, block.triangle(i), [u, v, w, t], interval);
            if !found.0 {
                continue;
            }
            [u, v, w, t] = found.1;
        }
        state.offer_lane::<ANY>(ray, t, block.id(i), [u, v, w]);
        taken = true;
    }
    taken
}

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
