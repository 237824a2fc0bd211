//! Hits at t = 0: the triangles on which rays start. Queries leave them out, but engines that the Python package stands in for
//! report them.

use super::{
    Geometry, Rays,
    crossings::direction,
    nearest::box_distances,
    places::{Touch, once_a_place},
    rays::EightRays,
    sinks::repeats_of,
    unit::UnitPacket,
};
use crate::{
    accel::{Bvh, Child, TriangleBlocks},
    geometry::{TriangleLeaf, starts_on_planes},
    lanes::LANES,
    math::orientation::{Row, point, sign},
    ray::{PrimitiveId, Ray},
    scene::Shape,
    simd::{LaneMask, Lanes, Simd, at_level},
};
use glam::Vec3;

impl Geometry {
    /// Calls `trace`, which traces `rays` on this thread: with a worker, or up to 256. Returns its result and the triangles on
    /// which rays start, by the ray's index, then id, without those parallel to the ray; with `once`, one triangle of those at
    /// the same edge or vertex. After an occlusion query rays that are blocked elsewhere may be missing.
    ///
    /// Costs next to nothing unless a ray starts on the plane of a triangle, which the canonical test notices.
    #[doc(hidden)]
    pub fn with_starts<T>(
        &self,
        rays: Rays<'_>,
        once: bool,
        trace: impl FnOnce() -> T,
    ) -> (T, Vec<(usize, PrimitiveId)>) {
        let before = starts_on_planes();
        let traced = trace();
        let starts = if starts_on_planes() == before {
            Vec::new()
        } else {
            self.starts(rays, once)
        };
        (traced, starts)
    }

    fn starts(&self, rays: Rays<'_>, once: bool) -> Vec<(usize, PrimitiveId)> {
        let (mut found, mut stack, mut eight) = (Vec::new(), Vec::new(), EightRays::ZERO);
        for first in (0..rays.len()).step_by(LANES) {
            at_level!(self.level(), |simd| rays.eight(simd, first, &mut eight));
            let units = UnitPacket::new(&eight, self.middle());
            for lane in 0..LANES.min(rays.len() - first) {
                let ray = units.ray(lane).ray;
                let before = found.len();
                if ray.is_valid() {
                    let mut take = |id| found.push((first + lane, id));
                    at_level!(self.level(), |simd| each_start(
                        simd,
                        self.bvh(),
                        &ray,
                        &mut stack,
                        &mut take
                    ));
                }
                if once {
                    let starts = found.split_off(before);
                    self.once_a_start(&ray, starts.iter().map(|&(_, id)| id), |id| {
                        found.push((first + lane, id));
                    });
                }
                found[before..].sort_unstable();
            }
        }
        found
    }

    /// Calls `keep` with one triangle of each place, of those on which a ray starts.
    fn once_a_start(
        &self,
        ray: &Ray,
        starts: impl Iterator<Item = PrimitiveId>,
        mut keep: impl FnMut(PrimitiveId),
    ) {
        let rows = [point(ray.origin), direction(ray.direction)];
        let mut touches = Vec::new();
        for id in starts {
            let Shape::Triangle(corners) = self.scene().shape(id) else {
                continue;
            };
            let [a, b, c] = corners.map(point);
            let sides = [[a, b], [b, c], [c, a]].map(|[from, to]| sign([rows[0], rows[1], from, to]));
            match Touch::new(id, (id, 0.0), corners, sides) {
                Some(touch) => touches.push(touch),
                None => keep(id),
            }
        }
        once_a_place(rows, touches, keep);
    }
}

/// Calls `take` with each triangle on which a ray starts.
#[inline(always)]
fn each_start<S: Simd>(
    simd: S,
    bvh: &Bvh,
    ray: &Ray,
    stack: &mut Vec<Child>,
    take: &mut impl FnMut(PrimitiveId),
) {
    let origin = simd.splat3(ray.origin);
    stack.clear();
    stack.push(bvh.root());
    while let Some(child) = stack.pop() {
        if child.is_inner() {
            let node = &bvh.nodes()[child.index()];
            let within = box_distances(simd, node, origin, 1.0).le(simd.splat(0.0));
            let within = within.bits() & node.valid_bits();
            stack.extend(
                (0..LANES)
                    .filter(|lane| within >> lane & 1 != 0)
                    .map(|lane| node.child[lane]),
            );
        } else if child.is_triangles() {
            match bvh.triangle_blocks() {
                TriangleBlocks::Whole(blocks) => of_leaf(&blocks[child.index()], child, ray, bvh, take),
                TriangleBlocks::Indexed(blocks) => of_leaf(&blocks[child.index()], child, ray, bvh, take),
            }
        }
    }
}

fn of_leaf<B: TriangleLeaf>(
    block: &B,
    child: Child,
    ray: &Ray,
    bvh: &Bvh,
    take: &mut impl FnMut(PrimitiveId),
) {
    for lane in 0..child.count() {
        if starts_on(ray, block.triangle(lane)) {
            let id = PrimitiveId(block.id(lane));
            take(id);
            for &[_, equal] in repeats_of(bvh.repeats(), id) {
                take(equal);
            }
        }
    }
}

/// Decides exactly whether a ray starts on a triangle and is not parallel to it.
#[must_use]
pub fn starts_on(ray: &Ray, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners;
    let (lower, upper, p) = (a.min(b).min(c), a.max(b).max(c), ray.origin);
    if !(p.cmpge(lower).all() && p.cmple(upper).all()) {
        return false;
    }
    let ([a, b, c, p], d) = ([a, b, c, p].map(point), ray.direction.as_dvec3());
    if sign([a, b, c, p]) != 0.0 || sign([a, b, c, [d.x, d.y, d.z, 0.0]]) == 0.0 {
        return false;
    }
    // Seen along an axis along which it is not a line: on no other side of an edge than the triangle.
    let axes: [Row; 3] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    axes.into_iter().any(|axis| {
        let side = sign([a, b, c, axis]);
        let is_inside = |[from, to]: [Row; 2]| {
            let at = sign([from, to, p, axis]);
            at == 0.0 || (at > 0.0) == (side > 0.0)
        };
        side != 0.0 && [[a, b], [b, c], [c, a]].into_iter().all(is_inside)
    })
}
