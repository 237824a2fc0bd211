//! All hits of lines in `f64`. The kernels' rays are rounded to `f32`; what they find within rounding error of an edge is
//! decided here for the line as the caller has it, by exact signs.

use super::{
    places::{Touch, once_a_place},
    sinks::All,
};
use crate::{
    math::orientation::{Row, point, sign},
    trace::{Found, HitSink},
};
use glam::{DVec3, Vec3};

/// Origin and direction of a ray, as the caller has them.
pub(super) type GivenLine = [DVec3; 2];

/// A ray in exact arithmetic, relative to the scene's origin.
#[doc(hidden)]
pub struct Line {
    origin: Row,
    direction: Row,
    /// The origin of the kernels' ray. It decides which planes are ahead, so that rays that start on a triangle are the same
    /// for all queries.
    start: Row,
}

impl Line {
    #[doc(hidden)]
    pub fn new([origin, direction]: GivenLine, middle: DVec3, start: Vec3) -> Self {
        let o = origin - middle;
        Self {
            origin: [o.x, o.y, o.z, 1.0],
            direction: row(direction),
            start: point(start),
        }
    }

    /// Whether the ray meets a triangle, edges included, and is not parallel to it.
    #[doc(hidden)]
    pub fn meets(&self, corners: [Vec3; 3]) -> bool {
        self.met(corners).is_some()
    }

    /// The sides of the edges if the ray meets the triangle: numbers with the signs of exact determinants.
    fn met(&self, corners: [Vec3; 3]) -> Option<[f64; 3]> {
        let [a, b, c] = corners.map(point);
        let sides = [[a, b], [b, c], [c, a]].map(|[from, to]| sign([self.origin, self.direction, from, to]));
        let passes = sides.iter().all(|&side| side >= 0.0) || sides.iter().all(|&side| side <= 0.0);
        if !passes {
            return None;
        }
        let (start, along) = (sign([a, b, c, self.start]), sign([a, b, c, self.direction]));
        ((start > 0.0 && along < 0.0) || (start < 0.0 && along > 0.0)).then_some(sides)
    }
}

/// A direction as a row, times a power of two, so that products neither underflow nor overflow.
pub(super) fn row(direction: DVec3) -> Row {
    let exponent = direction.abs().max_element().to_bits() >> 52;
    let d = direction * f64::from_bits((2046 - exponent.min(2045)) << 52);
    [d.x, d.y, d.z, 0.0]
}

/// All hits of a line, or one of those at each place.
pub(super) struct AllOfLine<'a> {
    all: All<'a>,
    line: Line,
    /// Hits at edges and vertices, if one at each place is wanted: they wait until all are known.
    touches: Option<Vec<Touch<Found>>>,
}

impl<'a> AllOfLine<'a> {
    pub(super) fn new(all: All<'a>, line: Line, once: bool) -> Self {
        let touches = once.then(Vec::new);
        Self { all, line, touches }
    }

    pub(super) fn into_all(mut self) -> All<'a> {
        if let Some(touches) = self.touches
            && !touches.is_empty()
        {
            let rows = [self.line.origin, self.line.direction];
            once_a_place(rows, touches, |found| self.all.take(found));
        }
        self.all
    }
}

impl HitSink for AllOfLine<'_> {
    const WANTS_UNSURE: bool = true;

    #[inline(always)]
    fn end(&self) -> f32 {
        self.all.end()
    }
    #[inline(always)]
    fn in_order(&self) -> bool {
        self.all.in_order()
    }
    #[inline(always)]
    fn take(&mut self, found: Found) {
        self.all.take(found);
    }
    fn take_unsure(&mut self, mut found: Found, corners: [Vec3; 3]) {
        let Some(sides) = self.line.met(corners) else {
            return;
        };
        // It is ahead, so not at 0.
        found.t = found.t.max(f32::MIN_POSITIVE);
        if let Some(touches) = &mut self.touches {
            let at = (found.primitive, found.t);
            if let Some(touch) = Touch::new(found, at, corners, sides) {
                touches.push(touch);
                return;
            }
        }
        self.all.take(found);
    }
}
