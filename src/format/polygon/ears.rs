//! Cuts the ears off a large polygon: triangles of a corner and its neighbours that hold no other corner.
//!
//! A corner can only become an ear when a neighbour is cut off, so each corner is tested at most three times on average,
//! against the reflex corners: quadratic time at worst, also for polygons whose sides cross.
//!
//! After O'Rourke, *Computational Geometry in C*, 1998, section 1.4.

use glam::DVec2;
use std::collections::VecDeque;

/// Cuts a polygon of area `winding` > 0 or < 0 into `triangles`, indices of its corners in the polygon's winding. There
/// are two fewer than corners, unless its sides cross.
pub(super) fn cut(corners: &[DVec2], winding: f64, triangles: &mut Vec<u32>) {
    triangles.clear();
    let mut ring = Ring::new(corners, winding);
    let mut queue: VecDeque<usize> = (0..corners.len()).collect();
    let mut left = corners.len();
    while let Some(tip) = queue.pop_front()
        && left > 2
    {
        if ring.is_cut[tip] || !ring.is_ear(tip) {
            continue;
        }
        let (before, after) = (ring.before[tip], ring.after[tip]);
        triangles.extend([before, tip, after].map(|corner| corner as u32));
        ring.cut(tip);
        left -= 1;
        queue.extend([before, after]);
    }
}

/// The corners that are not cut off yet, as a linked list.
struct Ring<'a> {
    corners: &'a [DVec2],
    winding: f64,
    before: Vec<usize>,
    after: Vec<usize>,
    is_cut: Vec<bool>,
    /// The initial reflex corners: some may be convex by now, and cutting makes no new ones.
    reflex: Vec<usize>,
}

impl<'a> Ring<'a> {
    fn new(corners: &'a [DVec2], winding: f64) -> Self {
        let count = corners.len();
        let mut ring = Self {
            corners,
            winding,
            before: (0..count).map(|i| (i + count - 1) % count).collect(),
            after: (0..count).map(|i| (i + 1) % count).collect(),
            is_cut: vec![false; count],
            reflex: Vec::new(),
        };
        ring.reflex = (0..count).filter(|&i| ring.is_reflex(i)).collect();
        ring
    }

    /// Above 0 if `c` lies on the polygon's side of the line from `a` to `b`.
    fn turn(&self, a: DVec2, b: DVec2, c: DVec2) -> f64 {
        (b - a).perp_dot(c - a) * self.winding
    }

    fn triangle(&self, tip: usize) -> [DVec2; 3] {
        [self.before[tip], tip, self.after[tip]].map(|i| self.corners[i])
    }

    fn is_reflex(&self, tip: usize) -> bool {
        let [a, b, c] = self.triangle(tip);
        self.turn(a, b, c) <= 0.0
    }

    fn is_ear(&self, tip: usize) -> bool {
        let [a, b, c] = self.triangle(tip);
        let is_inside = |&corner: &usize| {
            let p = self.corners[corner];
            // A polygon with a hole has corners twice where it is cut open.
            !self.is_cut[corner]
                && p != a
                && p != b
                && p != c
                && self.turn(a, b, p) >= 0.0
                && self.turn(b, c, p) >= 0.0
                && self.turn(c, a, p) >= 0.0
        };
        self.turn(a, b, c) > 0.0 && !self.reflex.iter().any(is_inside)
    }

    fn cut(&mut self, tip: usize) {
        let (before, after) = (self.before[tip], self.after[tip]);
        self.after[before] = after;
        self.before[after] = before;
        self.is_cut[tip] = true;
    }
}
