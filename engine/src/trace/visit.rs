//! Visits the leaf blocks that one ray meets, nearest first, and passes all hits in them to a sink: for queries that bundles
//! do not support, and for calls with one ray.

use super::{
    bits::bits,
    single::{SingleRay, sphere_block, triangle_block},
    slabs::{MOST_OFFSET, NODE_PAD, OFFSET_ERROR},
};
use crate::{
    accel::{Bvh, Child, Node8, Places},
    geometry::{SphereBlock, TriangleBlock},
    lanes::LANES,
    math::max,
    ray::{Hit, PrimitiveId, Ray},
    simd::{EightLanes, LaneMask, Lanes, Level, Simd, at_level, unpack},
};
use glam::Vec3;
use std::cell::Cell;

/// A hit by the canonical test, for a [`HitSink`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub t: f32,
    pub primitive: PrimitiveId,
    /// Edge functions of a triangle's second, third and first corner, not yet divided by their sum; negative means 0.
    pub weights: [f32; 3],
}

impl Found {
    /// The hit as packets report it.
    #[inline(always)]
    pub fn hit(&self) -> Hit {
        let [u, v, w] = self.weights.map(|weight| max(weight, 0.0));
        let sum = max(u + v + w, f32::MIN_POSITIVE);
        Hit {
            t: self.t,
            u: u / sum,
            v: v / sum,
            primitive: self.primitive,
        }
    }
}

/// A ray against the boxes of nodes. Planes are taken by the signs of its direction, and [`NODE_PAD`] is part of the factors:
/// twice it, and twice [`OFFSET_ERROR`], since factors and offsets are rounded once more.
// Tuned: see docs/lab-notes.md#one-ray-a-call
struct NodeRay {
    /// Of [`Node8::planes`], for each axis: where the ray enters, and where it leaves.
    first: [usize; 3],
    last: [usize; 3],
    /// Multiplied with the entry and the exit planes.
    first_inv: Vec3,
    last_inv: Vec3,
    /// Added to that.
    first_offset: Vec3,
    last_offset: Vec3,
}

impl NodeRay {
    #[inline(always)]
    fn new(ray: &SingleRay) -> Self {
        let (inv, offset) = (ray.inv, ray.origin * ray.inv);
        let is_tame = offset.abs().cmplt(Vec3::splat(MOST_OFFSET));
        let error = Vec3::select(is_tame, offset.abs() * (2.0 * OFFSET_ERROR), Vec3::INFINITY);
        let offset = Vec3::select(is_tame, offset, Vec3::ZERO);
        let side = |inv: f32| (inv.to_bits() >> 31) as usize;
        let first = [3 * side(inv.x), 3 * side(inv.y) + 1, 3 * side(inv.z) + 2];
        Self {
            first,
            last: [3 - first[0], 5 - first[1], 7 - first[2]],
            first_inv: inv * (1.0 - 2.0 * NODE_PAD),
            last_inv: inv * (1.0 + 2.0 * NODE_PAD),
            first_offset: (-offset - error) * (1.0 - 2.0 * NODE_PAD),
            last_offset: (-offset + error) * (1.0 + 2.0 * NODE_PAD),
        }
    }

    /// As [`SingleRay::enter`].
    #[inline(always)]
    fn enter<S: Simd>(&self, simd: S, node: &Node8, t_max: f32) -> (u32, S::V8) {
        let at = |planes: &[usize; 3], axis: usize, inv: &Vec3, offset: &Vec3| {
            let plane = simd.load(&node.planes[planes[axis] % 6]);
            plane.mul_add_approx(simd.splat(inv[axis]), simd.splat(offset[axis]))
        };
        let near = |axis| at(&self.first, axis, &self.first_inv, &self.first_offset);
        let far = |axis| at(&self.last, axis, &self.last_inv, &self.last_offset);
        let near = near(0).max(near(1)).max(near(2).max(simd.splat(0.0)));
        let far = far(0).min(far(1)).min(far(2).min(simd.splat(t_max)));
        let entered = near.le(far).bits() & node.valid_bits();
        let (at, missed) = (near.min(simd.splat(f32::MAX)), simd.splat(f32::INFINITY));
        (entered, S::V8::select(simd.mask(entered), at, missed))
    }
}

/// Says which hits count.
pub(crate) trait HitSink {
    /// Whether the sink decides in cases where an edge is nearer to the ray than `f32` resolves.
    const WANTS_UNSURE: bool = false;
    /// Whether one hit ends the visit, so that it does not matter which is found.
    const ANY: bool = false;
    /// The ray's end: hits beyond it are ignored.
    fn end(&self) -> f32;
    /// Whether nearer leaves are visited first, since a hit shortens the ray.
    fn in_order(&self) -> bool {
        true
    }
    /// Takes a hit.
    fn take(&mut self, found: Found);
    /// Takes a triangle, hit or not, that the line passes within its padded box, with an edge nearer than `f32` resolves. Its
    /// t may be 0 if its plane is ill-conditioned.
    fn take_unsure(&mut self, _: Found, _: [Vec3; 3]) {}
}

/// What is yet to visit: a lower bound on where the ray enters it, and a node or leaf.
type Stack = Vec<(f32, Child)>;

/// Nodes and leaves that [`visit_all`] prefetches at a time: time for memory to arrive against lines that leave the cache.
// Tuned: see docs/lab-notes.md#all-hits
const QUEUE: usize = 64;

thread_local! {
    /// Kept from ray to ray.
    static STACK: Cell<Stack> = const { Cell::new(Vec::new()) };
}

/// Passes all hits of a ray before the sink's end to the sink, in no particular order. An [invalid](Ray::is_valid) ray has
/// none.
pub(crate) fn visit<K: HitSink>(level: Level, bvh: &Bvh, ray: &Ray, sink: &mut K) {
    at_level!(level, |simd| visit_with(simd, bvh, ray, sink));
}

/// [`visit`] for callers that are at a level already.
#[inline(always)]
pub(crate) fn visit_with<S: Simd, K: HitSink>(simd: S, bvh: &Bvh, ray: &Ray, sink: &mut K) {
    if !ray.is_valid() {
        return;
    }
    let mut stack = STACK.take();
    stack.clear();
    visit_at(simd, bvh, ray, sink, &mut stack);
    STACK.set(stack);
}

#[inline(always)]
fn visit_at<S: Simd, K: HitSink>(simd: S, bvh: &Bvh, ray: &Ray, sink: &mut K, stack: &mut Stack) {
    let single = SingleRay::of(ray);
    let boxes = NodeRay::new(&single);
    let places = bvh.places();
    let mut child = bvh.root();
    if !sink.in_order() {
        return visit_all(simd, bvh, &places, (&single, &boxes), sink, stack);
    }
    loop {
        if child.is_inner() {
            let node = &bvh.nodes()[child.index()];
            let next = enter_nearest::<_, K>(simd, &boxes, (node, &places), sink.end(), stack);
            if let Some(next) = next {
                child = next;
                continue;
            }
        } else {
            leaf(simd, bvh, &single, child, sink);
        }
        child = loop {
            let Some((near, next)) = stack.pop() else { return };
            if near <= sink.end() {
                break next;
            }
        };
    }
}

/// Visits level by level, with a queue, so that nodes arrive from memory while others are visited. What the queue cannot
/// hold goes on the stack.
// Tuned: see docs/lab-notes.md#all-hits
#[inline(always)]
fn visit_all<S: Simd, K: HitSink>(
    simd: S,
    bvh: &Bvh,
    places: &Places,
    (ray, boxes): (&SingleRay, &NodeRay),
    sink: &mut K,
    stack: &mut Stack,
) {
    let mut queue = [bvh.root(); QUEUE];
    let (mut first, mut end) = (0_usize, 1_usize);
    loop {
        let child = if first < end {
            first += 1;
            queue[(first - 1) % QUEUE]
        } else if let Some((_, child)) = stack.pop() {
            child
        } else {
            return;
        };
        if !child.is_inner() {
            leaf(simd, bvh, ray, child, sink);
            continue;
        }
        let node = &bvh.nodes()[child.index()];
        let (entered, _) = boxes.enter(simd, node, sink.end());
        for lane in bits(entered) {
            let child = node.child[lane % LANES];
            places.prefetch(child);
            if end - first < QUEUE {
                queue[end % QUEUE] = child;
                end += 1;
            } else {
                stack.push((0.0, child));
            }
        }
    }
}

/// Hands the hits in a leaf block to the sink.
#[inline(always)]
fn leaf<S: Simd, K: HitSink>(simd: S, bvh: &Bvh, ray: &SingleRay, child: Child, sink: &mut K) {
    if child.is_triangles() {
        let mut unpacked = None;
        let block = bvh.triangle_blocks().whole(simd, child.index(), &mut unpacked);
        triangles(simd, ray, block, child, sink);
    } else {
        spheres(simd, ray, &bvh.sphere_blocks()[child.index()], child, sink);
    }
}

/// Returns the nearest child that the ray enters; the others go on the stack, the nearest last. Usually there are one or
/// two, so sorting all eight would be wasteful. If any hit will do, they come in no order.
// Tuned: see docs/lab-notes.md#one-ray-a-call
#[inline(always)]
fn enter_nearest<S: Simd, K: HitSink>(
    simd: S,
    ray: &NodeRay,
    (node, places): (&Node8, &Places),
    end: f32,
    stack: &mut Stack,
) -> Option<Child> {
    let (entered, near) = ray.enter(simd, node, end);
    let first = entered.trailing_zeros() as usize % LANES;
    let others = entered & entered.wrapping_sub(1);
    if others == 0 {
        return (entered != 0).then(|| node.child[first]);
    }
    if K::ANY {
        for lane in bits(others) {
            let child = node.child[lane % LANES];
            places.prefetch(child);
            stack.push((0.0, child));
        }
        return Some(node.child[first]);
    }
    if others & others.wrapping_sub(1) == 0 {
        let second = others.trailing_zeros() as usize % LANES;
        let near = near.to8().to_array();
        let (nearer, farther) = if near[first] <= near[second] {
            (first, second)
        } else {
            (second, first)
        };
        places.prefetch(node.child[farther]);
        stack.push((near[farther], node.child[farther]));
        return Some(node.child[nearer]);
    }
    let (entries, count) = near.nearest_last(entered);
    for &entry in entries.iter().take(count - 1) {
        let (near, lane) = unpack(entry);
        places.prefetch(node.child[lane]);
        stack.push((near, node.child[lane]));
    }
    Some(node.child[unpack(entries[count - 1]).1])
}

/// Hands the hits in a block of spheres to the sink, where the ray enters and where it leaves.
#[inline(always)]
fn spheres<S: Simd, K: HitSink>(simd: S, ray: &SingleRay, block: &SphereBlock, child: Child, sink: &mut K) {
    let (hit, enters, leaves) = sphere_block(simd, ray, block, child);
    for lane in bits(hit) {
        let found = Found {
            t: enters.lane(lane),
            primitive: PrimitiveId(block.id[lane]),
            weights: [0.0, 0.0, 1.0],
        };
        sink.take(found);
        let t = leaves.lane(lane);
        if t > found.t {
            sink.take(Found { t, ..found });
        }
    }
}

#[inline(always)]
fn triangles<S: Simd, K: HitSink>(
    simd: S,
    ray: &SingleRay,
    block: &TriangleBlock,
    child: Child,
    sink: &mut K,
) {
    let found = triangle_block(simd, ray, block, child);
    let unsure = if K::WANTS_UNSURE { found.unsure } else { 0 };
    let wanted = found.hit | unsure;
    if wanted == 0 {
        return;
    }
    let (t, [u, v, w]) = (found.t.to8(), found.weights);
    let (u, v, w) = (u.to8(), v.to8(), w.to8());
    for lane in bits(wanted) {
        let found = Found {
            t: t.as_array()[lane],
            primitive: PrimitiveId(block.id[lane]),
            weights: [u.as_array()[lane], v.as_array()[lane], w.as_array()[lane]],
        };
        if unsure >> lane & 1 == 0 {
            sink.take(found);
        } else {
            sink.take_unsure(found, block.triangle(lane));
        }
    }
}
