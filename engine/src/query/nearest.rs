//! The closest point of the geometry: eight boxes at a time in `f32` to cull, then triangle by triangle in `f64`. Instances
//! are searched by the same code (`query/instanced/nearest.rs`).
//!
//! Regions of a triangle as in Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5. Differs: a point on an
//! edge is computed from its ends in the order of their coordinates, so that two triangles with that edge give the same
//! bits and the lower id wins.

use crate::{
    accel::{Bvh, Child, Node8},
    ray::{InstanceId, PrimitiveId},
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
pub(super) const SLACK: f64 = 1e-6;

/// Bound on the rounding of a corner's distance along the direction, relative to the 1-norm of its offset: one half-ulp for
/// the offset, three for the dot product, and as many to spare.
const AHEAD_ERROR: f32 = 8.0 / (1 << 24) as f32;

/// If the square of twice a triangle's area is a smaller fraction than this of the products in its sum, it may be mostly
/// rounding error.
const LEAST_AREA: f64 = 1e-8;

// Tuned: see docs/lab-notes.md#closest-points
pub(super) type Stack = Vec<(f32, Child)>;

thread_local! {
    /// Kept from point to point.
    static STACK: Cell<Stack> = const { Cell::new(Vec::new()) };
}

/// A primitive; outside of instances the instance is [`InstanceId::NONE`].
pub(super) type Id = (InstanceId, PrimitiveId);

/// A point that a search has found.
#[derive(Clone, Copy)]
pub(super) struct Found {
    pub point: DVec3,
    pub distance: f64,
    pub id: Id,
}

/// The best point so far, if any, and the bounds for culling.
pub(super) struct Search {
    pub point: DVec3,
    best: Found,
    /// Square of the distance beyond which points are not wanted.
    squared: f64,
    /// The point in `f32`, and its distance from there.
    rounded: Vec3,
    rounding: f64,
    /// Boxes whose squared scaled distance is above this hold nothing nearer.
    limit: f32,
    /// Keeps squares of distances within the range of `f32`.
    pub scale: f32,
    /// From the point to the best so far, slightly shorter than 1; 0 before the first.
    direction: Vec3,
}

impl Search {
    /// Begins a search for what is no farther than `near`, a point of the geometry, if one is known.
    fn new(point: DVec3, near: Option<DVec3>, scale: f32) -> Self {
        let rounded = point.as_vec3();
        let mut search = Self {
            point,
            best: Found {
                point: DVec3::NAN,
                distance: f64::INFINITY,
                id: (InstanceId::NONE, PrimitiveId::NONE),
            },
            squared: f64::INFINITY,
            rounded,
            rounding: (point - rounded.as_dvec3()).length(),
            limit: f32::INFINITY,
            scale,
            direction: Vec3::ZERO,
        };
        if let Some(near) = near {
            search.squared = (near - point).length_squared() * (1.0 + SLACK);
            search.cull_beyond(near);
        }
        search
    }

    fn offer(&mut self, at: DVec3, id: Id) {
        let squared = (at - self.point).length_squared();
        if squared < self.squared || squared == self.squared && id < self.best.id {
            self.squared = squared;
            self.best = Found {
                point: at,
                distance: squared.sqrt(),
                id,
            };
            self.cull_beyond(at);
        }
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

    /// Squared scaled distances of the point from a node's boxes.
    #[inline(always)]
    pub fn box_distances<S: Simd>(&self, simd: S, node: &Node8) -> S::V8 {
        box_distances(simd, node, simd.splat3(self.rounded), self.scale)
    }
}

/// A hierarchy as a search visits it.
pub(super) trait Visited {
    /// Lower bounds on the squared scaled distances of a node's children.
    fn distances<S: Simd>(&self, simd: S, node: &Node8, search: &Search) -> S::V8;
    /// Offers what is in a leaf. What is on the stack must stay there.
    fn leaf<S: Simd>(&self, simd: S, leaf: Child, search: &mut Search, stack: &mut Stack);
}

/// How a hierarchy's primitives lie in the space of the search.
pub(super) trait Space {
    fn distances<S: Simd>(&self, simd: S, node: &Node8, search: &Search) -> S::V8;
    /// Corners of triangles, from the search's point.
    fn relative<S: Simd>(&self, simd: S, corner: Eight<S>, search: &Search) -> Eight<S>;
    /// Bounds on their rounding beyond that of a difference in `f32`.
    fn margin(&self) -> Vec3;
    fn corner(&self, corner: Vec3) -> DVec3;
    fn on_sphere(&self, point: DVec3, center: DVec3, radius: f64) -> DVec3;
    fn id(&self, primitive: PrimitiveId) -> Id;
}

type Eight<S> = Vec3Lanes<<S as Simd>::V8>;

/// A hierarchy of primitives in a space.
pub(super) struct In<'a, P> {
    pub bvh: &'a Bvh,
    pub space: P,
}

impl<P: Space> Visited for In<'_, P> {
    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, node: &Node8, search: &Search) -> S::V8 {
        self.space.distances(simd, node, search)
    }
    #[inline(always)]
    fn leaf<S: Simd>(&self, simd: S, leaf: Child, search: &mut Search, _: &mut Stack) {
        if leaf.is_triangles() {
            self.triangles(simd, leaf, search);
        } else {
            let block = &self.bvh.sphere_blocks()[leaf.index()];
            for lane in 0..leaf.count() {
                let center = block.center.lane(lane).as_dvec3();
                let radius = f64::from(block.radius.as_array()[lane]);
                let at = self.space.on_sphere(search.point, center, radius);
                search.offer(at, self.space.id(PrimitiveId(block.id[lane])));
            }
        }
    }
}

impl<P: Space> In<'_, P> {
    #[inline(always)]
    fn triangles<S: Simd>(&self, simd: S, leaf: Child, search: &mut Search) {
        let mut room = None;
        let block = self.bvh.triangle_blocks().whole(simd, leaf.index(), &mut room);
        let [a, b, c] = block.load(simd);
        // Not `map`, which is not inlined here.
        let a = self.space.relative(simd, a, search);
        let b = self.space.relative(simd, b, search);
        let c = self.space.relative(simd, c, search);
        let margin = self.space.margin();
        let (lower, upper) = (a.min(b).min(c), a.max(b).max(c));
        let squared = squared_distances(lower, upper, simd.splat3(margin), search.scale);
        let ahead = least_ahead([a, b, c], simd.splat3(search.direction), margin.element_sum());
        let ahead = ahead * search.scale;
        let squared = squared.max(ahead * ahead);
        let near = squared.le(simd.splat(search.limit)).bits() & leaf.count_bits();
        let (entries, count) = squared.min(simd.splat(f32::MAX)).nearest_last(near);
        for &entry in entries.iter().take(count).rev() {
            let (squared, lane) = unpack(entry);
            if squared <= search.limit {
                let [a, b, c] = block.triangle(lane);
                let corners = [self.space.corner(a), self.space.corner(b), self.space.corner(c)];
                let id = self.space.id(PrimitiveId(block.id[lane]));
                search.offer(on_triangle(search.point, corners), id);
            }
        }
    }
}

/// The space of the search itself.
struct Own;

impl Space for Own {
    #[inline(always)]
    fn distances<S: Simd>(&self, simd: S, node: &Node8, search: &Search) -> S::V8 {
        search.box_distances(simd, node)
    }
    #[inline(always)]
    fn relative<S: Simd>(&self, simd: S, corner: Eight<S>, search: &Search) -> Eight<S> {
        corner - simd.splat3(search.rounded)
    }
    #[inline(always)]
    fn margin(&self) -> Vec3 {
        Vec3::ZERO
    }
    #[inline(always)]
    fn corner(&self, corner: Vec3) -> DVec3 {
        corner.as_dvec3()
    }
    #[inline(always)]
    fn on_sphere(&self, point: DVec3, center: DVec3, radius: f64) -> DVec3 {
        let away = (point - center).try_normalize().unwrap_or(DVec3::X);
        center + away * radius
    }
    #[inline(always)]
    fn id(&self, primitive: PrimitiveId) -> Id {
        (InstanceId::NONE, primitive)
    }
}

/// Returns the closest point to `point`, both relative to the scene's origin; `None` if the hierarchy is empty or the
/// point is not finite in `f32`. A point `near` of the geometry changes the time, not the answer.
pub(super) fn closest(level: Level, bvh: &Bvh, point: DVec3, near: Option<DVec3>) -> Option<ClosestPoint> {
    let within = In { bvh, space: Own };
    let largest = point.abs().max_element().max(1.0);
    let found = found(level, (bvh.nodes(), bvh.root()), &within, (point, near), largest)?;
    Some(ClosestPoint {
        point: found.point,
        distance: found.distance,
        primitive: found.id.1,
    })
}

/// As [`closest`], in a hierarchy of these nodes. Coordinates are up to about `largest`.
pub(super) fn found(
    level: Level,
    (nodes, root): (&[Node8], Child),
    visited: &impl Visited,
    (point, near): (DVec3, Option<DVec3>),
    largest: f64,
) -> Option<Found> {
    if !point.as_vec3().is_finite() {
        return None;
    }
    let huge = (1_u64 << 63) as f32;
    let scale = match largest {
        1e15.. => 1.0 / huge,
        1e-15.. => 1.0,
        _ => huge,
    };
    let search = |near| {
        let (mut stack, mut search) = (STACK.take(), Search::new(point, near, scale));
        stack.clear();
        at_level!(level, |simd| walk(
            simd,
            (nodes, root),
            visited,
            &mut search,
            &mut stack
        ));
        STACK.set(stack);
        (search.best.id.1 != PrimitiveId::NONE).then_some(search.best)
    };
    // Rounding may have moved `near` off the geometry.
    search(near).or_else(|| near.and_then(|_| search(None)))
}

/// Visits a hierarchy, the nearest children first.
#[inline(always)]
pub(super) fn walk<S: Simd>(
    simd: S,
    (nodes, mut child): (&[Node8], Child),
    visited: &impl Visited,
    search: &mut Search,
    stack: &mut Stack,
) {
    let below = stack.len();
    loop {
        if child.is_inner() {
            let node = &nodes[child.index()];
            let squared = visited.distances(simd, node, search);
            let near = squared.le(simd.splat(search.limit)).bits() & node.valid_bits();
            let (entries, count) = squared.min(simd.splat(f32::MAX)).nearest_last(near);
            for &entry in entries.iter().take(count) {
                let (squared, lane) = unpack(entry);
                stack.push((squared, node.child[lane]));
            }
        } else {
            visited.leaf(simd, child, search, stack);
        }
        loop {
            if stack.len() == below {
                return;
            }
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

/// Squared scaled distances of 0 from boxes whose coordinates are wrong by up to a margin, at least.
#[inline(always)]
pub(super) fn squared_distances<V: Lanes>(
    lower: Vec3Lanes<V>,
    upper: Vec3Lanes<V>,
    margin: Vec3Lanes<V>,
    scale: f32,
) -> V {
    let outside = lower.max(-upper) - margin;
    let zero = outside.x.all(0.0);
    let x = outside.x.max(zero) * scale;
    let y = outside.y.max(zero) * scale;
    let z = outside.z.max(zero) * scale;
    x * x + y * y + z * z
}

/// A node's boxes: their lower and upper corners.
#[inline(always)]
pub(super) fn boxes<S: Simd>(simd: S, node: &Node8) -> [Eight<S>; 2] {
    let [lx, ly, lz, ux, uy, uz] = &node.planes;
    [
        Vec3Lanes::new(simd.load(lx), simd.load(ly), simd.load(lz)),
        Vec3Lanes::new(simd.load(ux), simd.load(uy), simd.load(uz)),
    ]
}

/// Squared scaled distances of a point from a node's boxes.
#[inline(always)]
pub(super) fn box_distances<S: Simd>(simd: S, node: &Node8, point: Eight<S>, scale: f32) -> S::V8 {
    let [lower, upper] = boxes(simd, node);
    squared_distances(lower - point, upper - point, simd.splat3(Vec3::ZERO), scale)
}

/// Lower bounds on the distance of triangles, at least 0: how far ahead they begin along a direction of at most unit length.
/// `margin` is the sum of further bounds on their coordinates' rounding.
#[inline(always)]
fn least_ahead<V: Lanes>(corners: [Vec3Lanes<V>; 3], direction: Vec3Lanes<V>, margin: f32) -> V {
    // Not `map`, which is not inlined here.
    let [a, b, c] = corners;
    let ahead = a
        .dot_about(direction)
        .min(b.dot_about(direction))
        .min(c.dot_about(direction));
    let size = one_norm(a).max(one_norm(b)).max(one_norm(c));
    (ahead - size * AHEAD_ERROR - ahead.all(margin)).max(ahead.all(0.0))
}

#[inline(always)]
fn one_norm<V: Lanes>(v: Vec3Lanes<V>) -> V {
    v.x.abs() + v.y.abs() + v.z.abs()
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
    // NaN if the ends are one point.
    if part >= 1.0 {
        b
    } else if part > 0.0 {
        a + edge * part
    } else {
        a
    }
}

/// The point of a triangle nearest to `point`.
#[doc(hidden)]
pub fn on_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
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
    if normal == DVec3::ZERO {
        // Two corners may be one point, whose edge says nothing.
        return nearest_of(point, edges_of(point, [a, b, c]).into_iter());
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
    let inside = (v >= 0.0 && w >= 0.0 && v + w <= 1.0).then(|| a + ab * v + ac * w);
    nearest_of(point, edges_of(point, [a, b, c]).into_iter().chain(inside))
}

/// The nearest points of a triangle's edges.
fn edges_of(point: DVec3, [a, b, c]: [DVec3; 3]) -> [DVec3; 3] {
    [on_edge(point, a, b), on_edge(point, a, c), on_edge(point, b, c)]
}

/// The nearest of some points, the first of equally near ones.
fn nearest_of(point: DVec3, points: impl Iterator<Item = DVec3>) -> DVec3 {
    let nearer = |a: DVec3, b: DVec3| {
        let is_nearer = (b - point).length_squared() < (a - point).length_squared();
        if is_nearer { b } else { a }
    };
    points.reduce(nearer).unwrap_or(point)
}
