//! Keeps one of the triangles that a line meets at the same place: at an edge or a vertex that they share. Decided exactly,
//! not by t, so surfaces that are very near each other stay apart.

use super::crossings;
use crate::{math::orientation::Row, ray::PrimitiveId};
use glam::{DVec3, Vec3};

/// Where a line meets the border of a triangle: the ends of an edge in order, or a vertex twice.
type Place = [Vec3; 2];

/// A triangle that a line meets at an edge or a vertex.
pub(super) struct Touch<T> {
    pub found: T,
    pub triangle: PrimitiveId,
    pub t: f32,
    place: Place,
    corners: [Vec3; 3],
    sides: [f64; 3],
}

impl<T> Touch<T> {
    /// `None` if the line passes inside. `sides` are those of the edges from the first corner to the second and so on.
    pub(super) fn new(
        found: T,
        (triangle, t): (PrimitiveId, f32),
        corners: [Vec3; 3],
        sides: [f64; 3],
    ) -> Option<Self> {
        let [a, b, c] = corners;
        let place = match sides.map(|side| side == 0.0) {
            [true, false, false] => ordered([a, b]),
            [false, true, false] => ordered([b, c]),
            [false, false, true] => ordered([c, a]),
            [true, true, false] => [b, b],
            [false, true, true] => [c, c],
            [true, false, true] => [a, a],
            _ => return None,
        };
        Some(Self {
            found,
            triangle,
            t,
            place,
            corners,
            sides,
        })
    }
}

fn bits(p: Vec3) -> [u32; 3] {
    // Not -0, which has other bits than 0.
    (p + 0.0).to_array().map(f32::to_bits)
}

fn ordered([a, b]: Place) -> Place {
    if bits(a) <= bits(b) { [a, b] } else { [b, a] }
}

/// Whether a line that meets both places meets them in one point: they lie on one straight line, or are the same vertex.
fn is_same([a, b]: Place, [c, d]: Place) -> bool {
    let is_on = |p: Vec3, [from, to]: Place| {
        let [p, from, to] = [p, from, to].map(Vec3::as_dvec3);
        (p - from).cross(to - from) == DVec3::ZERO
    };
    match (a == b, c == d) {
        (true, true) => a == c,
        (true, false) => is_on(a, [c, d]),
        (false, _) => is_on(c, [a, b]) && is_on(d, [a, b]),
    }
}

/// Different places farther apart than this fraction of t are not compared. It bounds the work of a ray, and is far above the
/// error of t.
const NEAR: f32 = 1.0 / 1024.0;

/// Triangles at one place.
struct Group<T> {
    members: Vec<Touch<T>>,
    t: f32,
}

/// Calls `keep` with one triangle of each place: that with the lowest id; with as many if the line passes through several
/// whichever way it is moved infinitesimally, as where closed meshes touch.
pub(super) fn once_a_place<T>(
    [origin, direction]: [Row; 2],
    touches: Vec<Touch<T>>,
    mut keep: impl FnMut(T),
) {
    for mut group in groups(touches) {
        group.members.sort_by_key(|touch| touch.triangle);
        let crossed = |way: f64| {
            let line = crossings::Line {
                origin,
                direction,
                way,
            };
            let is_crossed = |touch: &&Touch<T>| line.pierces(touch.corners, touch.sides);
            group.members.iter().filter(is_crossed).count()
        };
        let mut count = 1;
        // A line that is moved one way and the opposite way passes a triangle once at most: two need four.
        if group.members.len() >= 4 {
            count = crossed(1.0).max(1);
        }
        if count > 1 {
            count = crossed(-1.0).clamp(1, count);
        }
        group
            .members
            .into_iter()
            .take(count)
            .for_each(|touch| keep(touch.found));
    }
}

fn groups<T>(mut touches: Vec<Touch<T>>) -> Vec<Group<T>> {
    touches.sort_by_cached_key(|touch| touch.place.map(bits));
    let mut groups: Vec<Group<T>> = Vec::new();
    for touch in touches {
        match groups.last_mut() {
            Some(group) if group.members[0].place == touch.place => {
                group.t = group.t.min(touch.t);
                group.members.push(touch);
            }
            _ => groups.push(Group {
                t: touch.t,
                members: vec![touch],
            }),
        }
    }
    groups.sort_by(|a, b| a.t.total_cmp(&b.t));
    // At a T-junction a vertex of one triangle is on an edge of the other.
    let mut united: Vec<Group<T>> = Vec::new();
    for group in groups {
        let place = group.members[0].place;
        let mut near = united
            .iter_mut()
            .rev()
            .take_while(|earlier| group.t - earlier.t <= group.t * NEAR);
        match near.find(|earlier| is_same(earlier.members[0].place, place)) {
            Some(earlier) => earlier.members.extend(group.members),
            None => united.push(group),
        }
    }
    united
}
