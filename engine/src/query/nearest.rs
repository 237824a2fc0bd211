//! The closest point of the geometry: eight boxes at a time in `f32` to cull, then triangle by triangle in `f64`.
//!
//! Regions of a triangle as in Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5. Differs: a point on an
//! edge is computed from its ends in the order of their coordinates, so that two triangles with that edge give the same
//! bits and the lower id wins.

use crate::{
    accel::{Bvh, Child, Node8},
    geometry::TriangleBlock,
    ray::PrimitiveId,
    simd::{EightLanes, LaneMask, Lanes, Level, Simd, Vec3Lanes, at_level, unpack},
};
use glam::{DVec3, Vec3};
use std::cell::Cell;

/// The closest point of a geometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// The point, world space.
    pub point: DVec3,
    /// Its distance, at least 0.
    pub distance: f64,
    /// The triangle or sphere that it is on.
    pub primitive: PrimitiveId,
}

/// More than the rounding of a distance in `f32`, as a fraction of it.
const SLACK: f64 = 1e-6;

/// Bound on the rounding of a corner's distance along the direction, relative to the 1-norm of its offset: one half-ulp for
/// the offset, three for the dot product, and as many to spare.
const AHEAD_ERROR: f32 = 8.0 / (1 << 24) as f32;

/// If the square of twice a triangle's area is a smaller fraction than this of the products in its sum, it may be mostly
/// rounding error.
const LEAST_AREA: f64 = 1e-8;

// Tuned: see docs/lab-notes.md#closest-points
type Stack = Vec<(f32, Child)>;

thread_local! {
    /// Kept from point to point.
    static STACK: Cell<Stack> = const { Cell::new(Vec::new()) };
}

/// The best point so far, if any, and the bounds for culling.
struct Search {
    point: DVec3,
    best: ClosestPoint,
    /// Square of the distance beyond which points are not wanted.
    squared: f64,
    /// Distance between the point and its rounding to `f32`.
    rounding: f64,
    /// Boxes whose squared scaled distance is above this hold nothing nearer.
    limit: f32,
    /// Keeps squares of large distances finite.
    scale: f32,
    /// From the point to the best so far, slightly shorter than 1; 0 before the first.
    direction: Vec3,
}

impl Search {
    /// Begins a search for what is no farther than `near`, a point of the geometry, if one is known.
    fn new(point: DVec3, near: Option<DVec3>) -> Self {
        let rounded = point.as_vec3();
        let mut search = Self {
            point,
            best: ClosestPoint {
                point: DVec3::NAN,
                distance: f64::INFINITY,
                primitive: PrimitiveId::NONE,
            },
            squared: f64::INFINITY,
            rounding: (point - rounded.as_dvec3()).length(),
            limit: f32::INFINITY,
            scale: if rounded.abs().max_element() > 1e15 {
                1.0 / (1_u64 << 63) as f32
            } else {
                1.0
            },
            direction: Vec3::ZERO,
        };
        if let Some(near) = near {
            search.squared = (near - point).length_squared() * (1.0 + SLACK);
            search.cull_beyond(near);
        }
        search
    }

    fn offer(&mut self, at: DVec3, primitive: PrimitiveId) {
        let squared = (at - self.point).length_squared();
        if squared > self.squared || squared == self.squared && primitive > self.best.primitive {
            return;
        }
        self.squared = squared;
        self.best = ClosestPoint {
            point: at,
            distance: squared.sqrt(),
            primitive,
        };
        self.cull_beyond(at);
    }

    /// Sets the bounds for culling: the best so far is at `at`.
    fn cull_beyond(&mut self, at: DVec3) {
        let distance = self.squared.sqrt();
        let reach = (distance + self.rounding) * (1.0 + SLACK) * f64::from(self.scale);
        self.limit = ((reach * reach) as f32).next_up();
        let towards = (at - self.point) * ((1.0 - SLACK) / distance);
        self.direction = if distance > 0.0 {
            towards.as_vec3()
        } else {
            Vec3::ZERO
        };
    }
}

/// Returns the closest point to `point`, both relative to the scene's origin; `None` if the hierarchy is empty or the
/// point is not finite in `f32`. A point `near` of the geometry changes the time, not the answer.
pub(super) fn closest(level: Level, bvh: &Bvh, point: DVec3, near: Option<DVec3>) -> Option<ClosestPoint> {
    if !point.as_vec3().is_finite() {
        return None;
    }
    let found = search(level, bvh, Search::new(point, near));
    // Rounding may have moved `near` off the geometry.
    found.or_else(|| near.and_then(|_| search(level, bvh, Search::new(point, None))))
}

fn search(level: Level, bvh: &Bvh, mut search: Search) -> Option<ClosestPoint> {
    let mut stack = STACK.take();
    stack.clear();
    at_level!(level, |simd| walk(simd, bvh, &mut search, &mut stack));
    STACK.set(stack);
    (search.best.primitive != PrimitiveId::NONE).then_some(search.best)
}

#[inline(always)]
fn walk<S: Simd>(simd: S, bvh: &Bvh, search: &mut Search, stack: &mut Stack) {
    let point = simd.splat3(search.point.as_vec3());
    let mut child = bvh.root();
    loop {
        if child.is_inner() {
            let node = &bvh.nodes()[child.index()];
            let squared = box_distances(simd, node, point, search.scale);
            let near = squared.le(simd.splat(search.limit)).bits() & node.valid_bits();
            let (entries, count) = squared.min(simd.splat(f32::MAX)).nearest_last(near);
            for &entry in entries.iter().take(count) {
                let (squared, lane) = unpack(entry);
                stack.push((squared, node.child[lane]));
            }
        } else if child.is_triangles() {
            let mut room = None;
            let block = bvh.triangle_blocks().whole(simd, child.index(), &mut room);
            triangles(simd, block, child, point, search);
        } else {
            let block = &bvh.sphere_blocks()[child.index()];
            for lane in 0..child.count() {
                let center = block.center.lane(lane).as_dvec3();
                let radius = f64::from(block.radius.as_array()[lane]);
                search.offer(
                    on_sphere(search.point, center, radius),
                    PrimitiveId(block.id[lane]),
                );
            }
        }
        loop {
            let Some((squared, next)) = stack.pop() else {
                return;
            };
            if squared <= search.limit {
                child = next;
                break;
            }
        }
    }
}

/// Squared scaled distances of a point from boxes.
#[inline(always)]
fn squared_distances<V: Lanes>(
    point: Vec3Lanes<V>,
    lower: Vec3Lanes<V>,
    upper: Vec3Lanes<V>,
    scale: f32,
) -> V {
    let (below, above) = (lower - point, point - upper);
    let zero = point.x.all(0.0);
    let x = below.x.max(above.x).max(zero) * scale;
    let y = below.y.max(above.y).max(zero) * scale;
    let z = below.z.max(above.z).max(zero) * scale;
    x * x + y * y + z * z
}

/// Squared scaled distances of a point from a node's boxes.
#[inline(always)]
pub(super) fn box_distances<S: Simd>(simd: S, node: &Node8, point: Vec3Lanes<S::V8>, scale: f32) -> S::V8 {
    let [lx, ly, lz, ux, uy, uz] = &node.planes;
    let lower = Vec3Lanes::new(simd.load(lx), simd.load(ly), simd.load(lz));
    let upper = Vec3Lanes::new(simd.load(ux), simd.load(uy), simd.load(uz));
    squared_distances(point, lower, upper, scale)
}

#[inline(always)]
fn triangles<S: Simd>(
    simd: S,
    block: &TriangleBlock,
    child: Child,
    point: Vec3Lanes<S::V8>,
    search: &mut Search,
) {
    let [a, b, c] = block.load(simd);
    let squared = squared_distances(point, a.min(b).min(c), a.max(b).max(c), search.scale);
    let ahead = least_ahead([a - point, b - point, c - point], simd.splat3(search.direction)) * search.scale;
    let squared = squared.max(ahead * ahead);
    let near = squared.le(simd.splat(search.limit)).bits() & child.count_bits();
    let (entries, count) = squared.min(simd.splat(f32::MAX)).nearest_last(near);
    for &entry in entries.iter().take(count).rev() {
        let (squared, lane) = unpack(entry);
        if squared <= search.limit {
            let at = on_triangle(search.point, block.triangle(lane));
            search.offer(at, PrimitiveId(block.id[lane]));
        }
    }
}

/// Lower bounds on the distance of triangles: how far ahead they begin along a direction of at most unit length, at least 0.
#[inline(always)]
fn least_ahead<V: Lanes>(corners: [Vec3Lanes<V>; 3], direction: Vec3Lanes<V>) -> V {
    // Not `map`, which is not inlined here.
    let [a, b, c] = corners;
    let ahead = a
        .dot_about(direction)
        .min(b.dot_about(direction))
        .min(c.dot_about(direction));
    let size = one_norm(a).max(one_norm(b)).max(one_norm(c));
    (ahead - size * AHEAD_ERROR).max(ahead.all(0.0))
}

#[inline(always)]
fn one_norm<V: Lanes>(v: Vec3Lanes<V>) -> V {
    v.x.abs() + v.y.abs() + v.z.abs()
}

fn on_sphere(point: DVec3, center: DVec3, radius: f64) -> DVec3 {
    let away = (point - center).try_normalize().unwrap_or(DVec3::X);
    center + away * radius
}

/// The point of an edge nearest to `point`, the same whichever end comes first.
fn on_edge(point: DVec3, a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = if a.to_array() <= b.to_array() {
        (a, b)
    } else {
        (b, a)
    };
    let edge = b - a;
    let part = (point - a).dot(edge) / edge.length_squared();
    if part <= 0.0 {
        a
    } else if part >= 1.0 {
        b
    } else {
        a + edge * part
    }
}

/// The point of a triangle nearest to `point`.
#[doc(hidden)]
pub fn on_triangle(point: DVec3, corners: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let (from_a, from_b, from_c) = (point - a, point - b, point - c);
    let (d1, d2) = (ab.dot(from_a), ac.dot(from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let (d3, d4) = (ab.dot(from_b), ac.dot(from_b));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let (d5, d6) = (ab.dot(from_c), ac.dot(from_c));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    // Areas by the normal: as differences of these products they would be mostly rounding in needles.
    let vc = normal.dot(ab.cross(from_a));
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return on_edge(point, a, b);
    }
    let vb = normal.dot(from_a.cross(ac));
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return on_edge(point, a, c);
    }
    let va = normal.dot((c - b).cross(from_b));
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return on_edge(point, b, c);
    }
    let sum = va + vb + vc;
    let (v, w) = (vb / sum, vc / sum);
    let largest = d1
        .abs()
        .max(d2.abs())
        .max(d3.abs())
        .max(d4.abs())
        .max(d5.abs())
        .max(d6.abs());
    if sum > largest * largest * LEAST_AREA {
        return a + ab * v + ac * w;
    }
    // In a thinner needle they are, too, so any of its features may be the nearest.
    let edges = [on_edge(point, a, b), on_edge(point, a, c), on_edge(point, b, c)];
    let mut nearest = edges[0];
    let inside = (v >= 0.0 && w >= 0.0 && v + w <= 1.0).then(|| a + ab * v + ac * w);
    for at in edges.into_iter().chain(inside) {
        if (at - point).length_squared() < (nearest - point).length_squared() {
            nearest = at;
        }
    }
    nearest
}
