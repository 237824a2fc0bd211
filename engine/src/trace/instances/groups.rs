//! Rays with a shared origin: a group of packets descends to the instances together. The rays that meet an instance are
//! traced through its prototype, where they share the image of the origin.

use super::{
    Instances, Met, Results, Slot,
    images::{Images, Meeting},
};
use crate::{
    accel::Node8,
    lanes::{F32x8, LANES, Vec3x8},
    ray::{InstanceId, Ray, RayPacket},
    scene::ImageRay,
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes},
    trace::{bits::bits, frustum::Frustum, rays::reciprocal},
};
use glam::Vec3;

/// Packets of a group, a bit each: more share a descent, and spread further.
// Tuned: see docs/lab-notes.md#sparse-instances
pub(super) const PACKETS: usize = 32;

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
    /// Traces valid rays with a shared origin. Returns false, with nothing done, if they diverge too much.
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
        let (mut group, mut images) = (std::mem::take(&mut self.group), std::mem::take(&mut self.images));
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
                images.met.clear();
                self.meet(simd, &group, id, planes, (rays, packets), &mut images);
                self.trace_images(&mut images, true, results);
                for meeting in &images.met {
                    group.end(meeting.at, meeting.end);
                }
            }
        }
        (self.group, self.images) = (group, images);
        true
    }

    /// Collects the rays that meet an instance, `planes` its box.
    #[inline(always)]
    fn meet<S: Simd>(
        &self,
        simd: S,
        group: &Group,
        id: InstanceId,
        planes: [Vec3Eight<S>; 2],
        (rays, packets): (&[RayPacket], u32),
        images: &mut Images,
    ) {
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
                images.met.push(Meeting {
                    at: (p, lane),
                    met: Met {
                        id,
                        image,
                        near: near.as_array()[lane],
                        far: far.as_array()[lane],
                    },
                    end: group.t[p].as_array()[lane],
                    walk: 0,
                });
            }
        }
    }
}

impl Group {
    /// A ray now ends at `t`.
    fn end(&mut self, (packet, lane): (usize, usize), t: f32) {
        let ends = self.t[packet].as_mut_array();
        if ends[lane] == t {
            return;
        }
        ends[lane] = t;
        self.farthest[packet] = ends
            .iter()
            .fold(-1.0, |farthest, &t| if t > farthest { t } else { farthest });
    }
}
