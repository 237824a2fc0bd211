//! Leaf blocks of triangles against the packets of a bundle, for rays with a shared origin (separate origins:
//! [`sheared`](super::sheared)), and the end of the canonical test for both.
//!
//!   two blocks -> edge functions from the origin, once per bundle, a lane per triangle
//!     x bundle frustum, x packet frusta -> pairs of triangle and packet
//!       x rays, a lane per ray -> candidates -> canonical test -> hits
//!
//! Triangles are culled by the maximum of their edge functions over a frustum, as in Dmitriev, Havran and Seidel 2004
//! (*SIMD Shaft Culling*) and Benthin and Wald 2009. Differs: a lane is a triangle, a frustum a box of directions.

use super::{PACKETS, bits, bits64, bundle::Culling, origins::Shared, rays::Packet, spheres::spheres};
use crate::{
    accel::{Bvh, Child, TriangleBlocks},
    geometry::{EdgeFunctions, TriangleTest, meets, padded_boxes, weights},
    lanes::LANES,
    simd::{Column, EightLanes, LaneMask, Lanes, Memory, REGISTER_LANES, TriangleLanes, Vec3Lanes},
};
use glam::Vec3;

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
const SLOTS: usize = REGISTER_LANES;

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
    fn slots(self) -> u32 {
        let [first, second] = self.child;
        first.count_bits() | second.count_bits() << LANES
    }

    /// The slots of those leaves that packet `p` may hit something in.
    #[inline(always)]
    fn slots_of(self, p: usize) -> u32 {
        let [first, second] = self.packets;
        ((first >> p & 1) * 0x00ff) | ((second >> p & 1) * 0xff00)
    }
}

/// Vectors that are broadcast, number by number.
type Columns3 = [Column; 3];

const EMPTY: Column = Column([0.0; REGISTER_LANES]);

/// Slot `i` of `columns`, in all lanes.
#[inline(always)]
fn slot<V: Lanes>(simd: V::Simd, [x, y, z]: &Columns3, i: usize) -> Vec3Lanes<V> {
    let i = i % SLOTS;
    Vec3Lanes {
        x: V::splat(simd, x.0[i]),
        y: V::splat(simd, y.0[i]),
        z: V::splat(simd, z.0[i]),
    }
}

/// Slot `i` of a column, in all lanes.
#[inline(always)]
fn number<V: Lanes>(simd: V::Simd, column: &Column, i: usize) -> V {
    V::splat(simd, column.0[i % SLOTS])
}

/// [`EdgeFunctions`] in memory: a broadcast from there is free.
struct Functions {
    edges: [Columns3; 3],
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
            edges: [[EMPTY; 3]; 3],
            normal: [EMPTY; 3],
            plane: EMPTY,
            tolerance: EMPTY,
            lowest: EMPTY,
            least: EMPTY,
        };
        let ([u, v, w], [to_u, to_v, to_w]) = (edges.functions, &mut functions.edges);
        u.store(to_u);
        v.store(to_v);
        w.store(to_w);
        edges.normal.store(&mut functions.normal);
        edges.plane.store(&mut functions.plane);
        edges.tolerance.store(&mut functions.tolerance);
        (-edges.tolerance).store(&mut functions.lowest);
        (edges.tolerance * -1.5).store(&mut functions.least);
        functions
    }

    /// The edge functions of the triangle in slot `i`, see [`EdgeFunctions::functions`].
    #[inline(always)]
    fn of<V: Lanes>(&self, simd: V::Simd, i: usize) -> [Vec3Lanes<V>; 3] {
        let [u, v, w] = &self.edges;
        [slot(simd, u, i), slot(simd, v, i), slot(simd, w, i)]
    }

    /// The canonical test of the triangle in slot `i`, see [`EdgeFunctions::test`].
    #[inline(always)]
    fn test<V: Lanes>(&self, d: Vec3Lanes<V>, i: usize, interval: (V, V)) -> TriangleTest<V> {
        let simd = d.x.simd();
        TriangleTest::new(
            weights(d, self.of(simd, i)),
            [number(simd, &self.lowest, i), number(simd, &self.tolerance, i)],
            (number(simd, &self.plane, i), d.dot(slot(simd, &self.normal, i))),
            interval,
        )
    }

    /// Whether a ray may have a candidate in slot `i`: no weight is below [`Self::least`].
    #[inline(always)]
    fn may_hit<V: Lanes>(&self, d: &Vec3Lanes<V>, i: usize) -> bool {
        let simd = d.x.simd();
        let [u, v, w] = self.of::<V>(simd, i);
        let smallest = d.dot_about(u).min(d.dot_about(v)).min(d.dot_about(w));
        smallest.ge(number(simd, &self.least, i)).any()
    }
}

/// Tests blocks against packets with a shared origin. What depends only on the origin is computed once for all packets;
/// triangles outside the frustum and packets that miss a triangle are dropped. Returns the packets that may have taken a
/// hit, in occlusion those that are done.
#[inline(always)]
pub(super) fn shared_origin<V: Lanes, const ANY: bool>(
    simd: V::Simd,
    bvh: &Bvh,
    leaves: Leaves,
    culling: &Culling<'_, V>,
    states: &mut [Packet<V::Memory>; PACKETS],
) -> u32 {
    let Leaves { child, packets } = leaves;
    if !child[0].is_triangles() {
        let block = &bvh.sphere_blocks()[child[0].index()];
        return spheres::<V, Shared, ANY>(simd, block, child[0].count_bits(), culling, packets[0], states);
    }
    let (at, blocks) = (child.map(Child::index), bvh.triangle_blocks());
    let [x, y, z] = &states[0].origin;
    let origin = Vec3Lanes::splat(simd, Vec3::new(x.place(0), y.place(0), z.place(0)));
    let corners = blocks.corners::<V::Triangles>(simd, at);
    let edges = EdgeFunctions::new(&corners, origin);
    let packets = packets[0] | packets[1];
    let mut triangles = leaves.slots();
    if let Some(frustum) = culling.frustum
        && packets.count_ones() > ALL_FIRST
    {
        triangles &= frustum.triangles(&edges);
    }
    let slots = V::Triangles::COUNT;
    let packets_a_word = 64 / slots;
    let pairs = pairs(leaves, packets, triangles, culling, &edges);
    let functions = Functions::new(&edges);
    let mut candidates = [0_u8; PACKETS * SLOTS];
    let mut count = 0;
    for (word, pairs) in pairs.into_iter().enumerate() {
        // Two words hold eight packets; with eight slots all of them are in the first.
        let first = (word / 2 * 8 + word % 2 * packets_a_word) * slots;
        for pair in bits64(pairs) {
            let (p, i) = ((first + pair) / slots, pair % slots);
            let d = Vec3Lanes::<V>::load(simd, &states[p % PACKETS].direction);
            candidates[count % (PACKETS * SLOTS)] = (first + pair) as u8;
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
        let (p, i) = (usize::from(pair) / slots, usize::from(pair) % slots);
        let state = &mut states[p % PACKETS];
        let d = Vec3Lanes::<V>::load(simd, &state.direction);
        let interval = interval::<V>(state, slot(simd, &first, i), slot(simd, &last, i), culling);
        let test = functions.test(d, i, interval);
        let hit = hit::<V, ANY>(state, blocks, [at[i / LANES % 2], i % LANES], &test);
        taken |= u32::from(hit) << p;
    }
    taken
}

/// The triangles of each of `packets` that its frusta leave, a bit per slot. Each word has its own loop and no index, so
/// that it stays in a register.
#[inline(always)]
fn pairs<V: Lanes>(
    leaves: Leaves,
    packets: u32,
    triangles: u32,
    culling: &Culling<'_, V>,
    edges: &EdgeFunctions<V::Triangles>,
) -> [u64; PACKETS / 4] {
    let mut pairs = [0_u64; PACKETS / 4];
    for (half, pairs) in pairs.as_chunks_mut::<2>().0.iter_mut().enumerate() {
        for p in bits(packets >> (half * 8) & 0xff) {
            let own = half * 8 + p;
            let mut triangles = triangles & leaves.slots_of(own);
            if let Some(frustum) = culling.frustum {
                triangles &= frustum.triangles_of(own, edges);
            }
            put(pairs, p, 64 / V::Triangles::COUNT, triangles);
        }
    }
    pairs
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
pub(super) fn put(pairs: &mut [u64; 2], p: usize, each: usize, bits: u32) {
    let is_high = u64::from(p >= each).wrapping_neg();
    let bits = u64::from(bits) << (p % each * (64 / each));
    pairs[0] |= bits & !is_high;
    pairs[1] |= bits & is_high;
}

/// With more packets than this, triangles are first tested against the frustum of all of them: one test more against
/// those of packets that it saves.
// Tuned: see docs/lab-notes.md#two-leaves
const ALL_FIRST: u32 = 2;

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

/// Completes the canonical test of a triangle: a block's index and a lane. Returns whether a lane may have taken a hit, in
/// occlusion whether all lanes are done.
// Tuned: see docs/lab-notes.md#occlusion-without-branches
#[inline(always)]
pub(super) fn hit<V: Lanes, const ANY: bool>(
    state: &mut Packet<V::Memory>,
    blocks: &TriangleBlocks,
    triangle: [usize; 2],
    test: &TriangleTest<V>,
) -> bool {
    let (t, simd) = (test.t, test.t.simd());
    let best = V::load(simd, &state.t);
    // Tuned: see docs/lab-notes.md#nearer-first
    let ahead = test.ahead(if ANY { t.lt(best) } else { t.le(best) });
    let candidates = (ahead & test.candidates()).bits();
    let hit = ahead & test.sure();
    if hit.bits() != candidates {
        let mut columns = [V::Memory::ZERO; 6];
        let ([u, v, w], (near, far)) = (test.weights, test.interval);
        for (column, value) in columns.iter_mut().zip([u, v, w, t, near, far]) {
            value.store(column);
        }
        let taken = unsure::<V::Memory, ANY>(state, (blocks, triangle), hit.bits(), candidates, &columns);
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
        state.offer::<V>(hit, t, blocks.id(triangle), test.weights);
    }
    candidates != 0
}

/// The rest of [`hit`], ray by ray, where some candidates are not certain. `columns`: their weights,
/// distances, and the interval of the triangle's box.
/// Not returning from here into the loop keeps the rays' hits in registers.
#[cold]
#[inline(never)]
fn unsure<M: Memory, const ANY: bool>(
    state: &mut Packet<M>,
    (blocks, triangle): (&TriangleBlocks, [usize; 2]),
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
            let found = meets(
                origin,
                direction,
                blocks.triangle(triangle),
                [u, v, w, t],
                interval,
            );
            if !found.0 {
                continue;
            }
            [u, v, w, t] = found.1;
        }
        state.offer_lane::<ANY>(ray, t, blocks.id(triangle), [u, v, w]);
        taken = true;
    }
    taken
}
