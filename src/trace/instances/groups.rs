//! Rays of one origin: a group of packets descends to the instances together, and those rays that meet the box of one are
//! traced through its prototype as rays that share the image of their origin.

use super::{Instances, Met, Results, Slot};
use crate::{
    accel::Node8,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, InstanceId, Origins, Ray, RayPacket},
    scene::ImageRay,
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes},
    trace::{Method, bits::bits, frustum::Frustum, rays::reciprocal},
};
use glam::Vec3;

/// Packets of a group.
pub(super) const PACKETS: usize = 32;

/// An instance of more than this many primitives for each ray that meets it is traced ray by ray: its triangles are
/// smaller than what is between the rays.
// Tuned: see docs/lab-notes.md#sparse-instances
const SPARSE: usize = 8;

/// A child that some packets, a bit each, have yet to visit, and a lower bound on where they enter it.
#[derive(Clone, Copy, Debug, Default)]
struct Todo {
    near: f32,
    slot: Slot,
    packets: u32,
}

/// The memory of a group.
#[derive(Debug, Default)]
pub(super) struct Group {
    origin: Vec3,
    /// `1 / direction`, finite.
    inv: Vec<Vec3x8>,
    /// The ends of the rays, or their nearest hits; negative for lanes that are done.
    t: Vec<F32x8>,
    /// The largest of each packet's ends.
    farthest: Vec<f32>,
    todo: Vec<Todo>,
    /// The rays that meet an instance, as their images, and what is found.
    images: Vec<RayPacket>,
    met: Vec<Meeting>,
    hits: Vec<HitPacket>,
    blocked: Vec<u8>,
}

/// A ray that meets an instance.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    packet: usize,
    lane: usize,
    met: Met,
}

impl Results<'_> {
    /// How far rays go that may still hit something; negative for others.
    #[inline(always)]
    fn ends<S: Simd>(&self, simd: S, p: usize, rays: &RayPacket) -> S::V8 {
        let end = simd.load(&rays.t_max);
        let live = end.gt(simd.splat(0.0)).bits() & !self.done(p);
        let end = match self {
            Self::Closest(hits, _) => simd.load(&hits[p].t),
            Self::Any(_) => end,
        };
        S::V8::select(simd.mask(live), end, simd.splat(-1.0))
    }
}

impl Group {
    /// Starts with these rays. Returns the packets that may hit something.
    #[inline(always)]
    fn start<S: Simd>(&mut self, simd: S, origin: Vec3, rays: &[RayPacket], results: &Results<'_>) -> u32 {
        self.origin = origin;
        self.inv.clear();
        self.t.clear();
        self.farthest.clear();
        self.todo.clear();
        let mut live = 0;
        for (p, packet) in rays.iter().enumerate() {
            let d = simd.load3(&packet.direction);
            self.inv
                .push(Vec3Lanes::<S::V8>::new(reciprocal(d.x), reciprocal(d.y), reciprocal(d.z)).to8());
            let ends = results.ends(simd, p, packet);
            self.t.push(ends.to8());
            self.farthest.push(ends.max_lane());
            live |= u32::from(self.farthest[p] > 0.0) << p;
        }
        live
    }

    /// Those of `packets` that may hit something at `near` or behind it.
    #[inline(always)]
    fn reaching(&self, packets: u32, near: f32) -> u32 {
        let mut reaching = 0;
        for p in bits(packets) {
            reaching |= u32::from(self.farthest[p] >= near) << p;
        }
        reaching
    }

    /// Where the rays of packet `p` are in a box, relative to their origin, and the lanes that are there before they end.
    #[inline(always)]
    fn enter<S: Simd>(&self, simd: S, p: usize, planes: [Vec3Eight<S>; 2]) -> (S::V8, S::V8, u32) {
        let inv: Vec3Eight<S> = simd.load3(&self.inv[p]);
        let (near, far) = crate::geometry::interval(&inv, planes[0], planes[1]);
        let lanes = near.le(far) & near.le(simd.load(&self.t[p]));
        (near, far, lanes.bits())
    }

    /// The box of a child relative to the origin.
    #[inline(always)]
    fn planes<S: Simd>(&self, simd: S, node: &Node8, lane: usize) -> [Vec3Eight<S>; 2] {
        let (lower, upper) = node.corners(lane);
        let origin: Vec3Eight<S> = simd.splat3(self.origin);
        [simd.splat3(lower) - origin, simd.splat3(upper) - origin]
    }

    /// Puts the children of a node that some packets enter on the stack, the nearest last.
    #[inline(always)]
    fn push_children<S: Simd>(
        &mut self,
        simd: S,
        frustum: &Frustum<S::V8>,
        node: &Node8,
        first: Slot,
        packets: u32,
    ) {
        let (candidates, _) = frustum.children(node);
        let start = self.todo.len();
        for c in bits(candidates & node.valid_bits()) {
            let planes = self.planes(simd, node, c);
            let (mut entering, mut least) = (0, simd.splat(f32::INFINITY));
            for p in bits(packets) {
                let (near, _, lanes) = self.enter(simd, p, planes);
                entering |= u32::from(lanes != 0) << p;
                least = S::V8::select(simd.mask(lanes), near.min(least), least);
            }
            if entering != 0 {
                let todo = Todo {
                    near: least.min_lane(),
                    slot: first + c as Slot,
                    packets: entering,
                };
                let at = self.todo[start..].partition_point(|other| other.near > todo.near);
                self.todo.insert(start + at, todo);
            }
        }
    }
}

impl Instances<'_> {
    /// Traces rays of one origin, all of them valid. Returns false, with nothing done, if they go too many ways.
    #[inline(always)]
    pub(super) fn trace_group<S: Simd>(
        &mut self,
        simd: S,
        origin: Vec3,
        rays: &[RayPacket],
        results: &mut Results<'_>,
    ) -> bool {
        debug_assert!(rays.len() <= PACKETS);
        let Some(frustum) = Frustum::<S::V8>::around(simd, origin, rays) else {
            return false;
        };
        let mut group = std::mem::take(&mut self.group);
        let live = group.start(simd, origin, rays, results);
        let instanced = self.instanced;
        group.push_children(simd, &frustum, &instanced.nodes()[0], 0, live);
        while let Some(Todo { near, slot, packets }) = group.todo.pop() {
            let packets = group.reaching(packets, near);
            if packets == 0 {
                continue;
            }
            let (node_i, lane) = (slot as usize / LANES, slot as usize % LANES);
            let node = &instanced.nodes()[node_i];
            let child = node.child[lane];
            if child.is_inner() {
                let first = (child.index() * LANES) as Slot;
                group.push_children(simd, &frustum, &instanced.nodes()[child.index()], first, packets);
            } else {
                let planes = group.planes(simd, node, lane);
                let id = InstanceId(child.index() as u32);
                self.meet(simd, &mut group, id, planes, rays, packets);
                self.trace_met(&mut group, id, results);
            }
        }
        self.group = group;
        true
    }

    /// Collects the rays that meet an instance, `planes` its box.
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        group: &mut Group,
        id: InstanceId,
        planes: [Vec3Eight<S>; 2],
        rays: &[RayPacket],
        packets: u32,
    ) {
        group.met.clear();
        let instance = &self.scene.instances()[id.0 as usize];
        let Some(origin) = instance.image_of_origin(group.origin) else {
            return;
        };
        for p in bits(packets) {
            let (near, far, lanes) = group.enter(simd, p, planes);
            if lanes == 0 {
                continue;
            }
            let (near, far) = (near.to8(), far.to8());
            let ([x, y, z], lengths) = instance.images_of_directions(&rays[p].direction);
            for lane in bits(lanes) {
                let ray = Ray::new(origin, Vec3::new(x[lane], y[lane], z[lane]));
                let Some(image) = ImageRay::new(ray, lengths[lane]) else {
                    continue;
                };
                group.met.push(Meeting {
                    packet: p,
                    lane,
                    met: Met {
                        id,
                        image,
                        near: near.as_array()[lane],
                        far: far.as_array()[lane],
                    },
                });
            }
        }
    }

    /// Traces the rays that meet an instance through its prototype.
    fn trace_met(&mut self, group: &mut Group, id: InstanceId, results: &mut Results<'_>) {
        self.trace_images(group, id, results);
        for i in 0..group.met.len() {
            let Meeting { packet, lane, met } = group.met[i];
            let (before, at) = (group.t[packet].as_array()[lane], (packet, lane));
            let mut end = before;
            match results {
                Results::Closest(..) => {
                    let hit = group.hits[i / LANES].hit(i % LANES);
                    results.offer(at, &met, &hit, &mut end);
                }
                Results::Any(_) => {
                    if group.blocked[i / LANES] >> (i % LANES) & 1 == 1 {
                        results.block(at, &mut end);
                    }
                }
            }
            if end != before {
                group.end(packet, lane, end);
            }
        }
    }

    /// Traces the images of all rays that meet an instance.
    fn trace_images(&mut self, group: &mut Group, id: InstanceId, results: &Results<'_>) {
        let is_any = matches!(results, Results::Any(_));
        group.fill_images(is_any);
        let Some(first) = group.met.first() else { return };
        let (origins, count) = (Origins::Shared(first.met.image.ray.origin), group.images.len());
        let bvh = self.prototype_of(id);
        let are_sparse = group.met.len() * SPARSE < bvh.stats().primitives();
        self.nested.policy.hold_to(match self.method {
            Method::Adaptive if are_sparse => Method::Single,
            method => method,
        });
        self.nested.through(bvh);
        if is_any {
            group.blocked.resize(count, 0);
            self.nested.occluded(origins, &group.images, &mut group.blocked);
        } else {
            group.hits.resize(count, HitPacket::miss(F32x8::ZERO));
            self.nested.closest_hit(origins, &group.images, &mut group.hits);
        }
    }
}

impl Group {
    /// Packs the images, eight a packet.
    fn fill_images(&mut self, is_any: bool) {
        let Self { met, images, t, .. } = self;
        images.clear();
        for eight in met.chunks(LANES) {
            let mut packet = RayPacket {
                direction: Vec3x8::ZERO,
                t_max: F32x8::ZERO,
            };
            for lane in 0..LANES {
                let meeting = &eight[lane.min(eight.len() - 1)];
                packet.direction.set(lane, meeting.met.image.ray.direction);
            }
            for (
                lane,
                Meeting {
                    packet: p,
                    lane: from,
                    met,
                },
            ) in eight.iter().enumerate()
            {
                let end = t[*p].as_array()[*from];
                packet.t_max.as_mut_array()[lane] = if is_any { met.end(end) } else { met.beyond(end) };
            }
            images.push(packet);
        }
    }

    /// A ray now ends at `t`.
    fn end(&mut self, packet: usize, lane: usize, t: f32) {
        let ends = self.t[packet].as_mut_array();
        ends[lane] = t;
        self.farthest[packet] = ends
            .iter()
            .fold(-1.0, |farthest, &t| if t > farthest { t } else { farthest });
    }
}
