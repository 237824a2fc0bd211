//! Hits at t = 0: the triangles on which rays start. Queries leave them out, but engines that the Python package stands in for
//! report them.

use super::{
    Geometry, Rays, exact,
    nearest::box_distances,
    places::{Touch, once_a_place},
    rays::EightRays,
    sinks::repeats_of,
    unit::UnitPacket,
};
use crate::{
    accel::{Bvh, Child},
    geometry::starts_on_planes,
    lanes::LANES,
    math::orientation::{Row, point, sign},
    ray::PrimitiveId,
    scene::Shape,
    simd::{LaneMask, Lanes, Simd, at_level},
};
use glam::{DVec3, Vec3};

impl Geometry {
    /// Calls `trace`, which traces `rays` on this thread: with a worker, or up to 256. Returns its result and the triangles on
    /// which rays start, by the ray's index, then id. Triangles parallel to the ray as the caller has it are left out; with
    /// `once`, one triangle of those at the same edge or vertex is told. After an occlusion query rays that are blocked
    /// elsewhere may be missing.
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
                let (ray, [_, direction]) = (units.ray(lane).ray, eight.line(lane));
                let before = found.len();
                if ray.is_valid() {
                    let mut take = |id, corners| {
                        if starts_on(ray.origin, direction, corners) {
                            found.push((first + lane, id));
                        }
                    };
                    at_level!(self.level(), |simd| each_around(
                        simd,
                        self.bvh(),
                        ray.origin,
                        &mut stack,
                        &mut take
                    ));
                }
                if once {
                    let starts = found.split_off(before);
                    let rows = [point(ray.origin), exact::row(direction)];
                    self.once_a_start(rows, starts.iter().map(|&(_, id)| id), |id| {
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
        rows: [Row; 2],
        starts: impl Iterator<Item = PrimitiveId>,
        mut keep: impl FnMut(PrimitiveId),
    ) {
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

/// Calls `take` with each triangle of the leaves whose boxes `origin` is in.
#[inline(always)]
fn each_around<S: Simd>(
    simd: S,
    bvh: &Bvh,
    origin: Vec3,
    stack: &mut Vec<Child>,
    take: &mut impl FnMut(PrimitiveId, [Vec3; 3]),
) {
    let origin = simd.splat3(origin);
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
            of_leaf(child, bvh, take);
        }
    }
}

fn of_leaf(child: Child, bvh: &Bvh, take: &mut impl FnMut(PrimitiveId, [Vec3; 3])) {
    let blocks = bvh.triangle_blocks();
    for lane in 0..child.count() {
        let triangle = [child.index(), lane];
        let (id, corners) = (PrimitiveId(blocks.id(triangle)), blocks.triangle(triangle));
        take(id, corners);
        for &[_, equal] in repeats_of(bvh.repeats(), id) {
            take(equal, corners);
        }
    }
}

/// Decides exactly whether a ray from `p` starts on a triangle and is not parallel to it.
#[must_use]
pub fn starts_on(p: Vec3, direction: DVec3, corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners;
    let (lower, upper) = (a.min(b).min(c), a.max(b).max(c));
    if !(p.cmpge(lower).all() && p.cmple(upper).all()) {
        return false;
    }
    let [a, b, c, p] = [a, b, c, p].map(point);
    if sign([a, b, c, p]) != 0.0 || sign([a, b, c, exact::row(direction)]) == 0.0 {
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
