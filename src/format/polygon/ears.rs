//! Cuts the ears off a large polygon: triangles of a corner and its neighbours that hold no other corner.
//!
//! A corner can only become an ear when a neighbour is cut off, so each corner is tested at most three times on average,
//! against the reflex corners. They are in a [`tree`], so a test takes few steps in all but hostile polygons, which are given
//! up after a number of steps.
//!
//! After O'Rourke, *Computational Geometry in C*, 1998, section 1.4.

mod tree;

use glam::DVec2;
use std::collections::VecDeque;
use tree::Tree;

/// How many steps a polygon may take: these for each corner, and more. A test of a box or a corner is one.
// Tuned: see docs/lab-notes.md#polygon-corners
const STEPS: usize = 1 << 9;
const MORE_STEPS: usize = 1 << 20;

/// Cuts a polygon of area `winding` > 0 or < 0 into `triangles`, indices of its corners in the polygon's winding. There
/// are two fewer than corners, unless its sides cross. Returns whether it took no more steps than it may.
pub(super) fn cut(corners: &[DVec2], winding: f64, triangles: &mut Vec<u32>) -> bool {
    triangles.clear();
    let mut ring = Ring::new(corners, winding);
    let mut queue: VecDeque<u32> = (0..corners.len() as u32).collect();
    let mut left = corners.len();
    while let Some(tip) = queue.pop_front()
        && left > 2
    {
        if ring.steps > STEPS * corners.len() + MORE_STEPS {
            return false;
        }
        if ring.is_cut[tip as usize] || !ring.is_ear(tip) {
            continue;
        }
        let [before, after] = ring.beside[tip as usize];
        triangles.extend([before, tip, after]);
        ring.cut(tip);
        left -= 1;
        queue.extend([before, after]);
    }
    true
}

/// The corners that are not cut off yet, as a linked list.
struct Ring<'a> {
    corners: &'a [DVec2],
    winding: f64,
    /// The corners before and after each.
    beside: Vec<[u32; 2]>,
    is_cut: Vec<bool>,
    /// The initial reflex corners: some may be convex by now, and cutting makes no new ones.
    reflex: Tree,
    steps: usize,
}

impl<'a> Ring<'a> {
    fn new(corners: &'a [DVec2], winding: f64) -> Self {
        let count = corners.len();
        let beside = |i| [(i + count - 1) % count, (i + 1) % count].map(|i| i as u32);
        let mut ring = Self {
            corners,
            winding,
            beside: (0..count).map(beside).collect(),
            is_cut: vec![false; count],
            reflex: Tree::default(),
            steps: 0,
        };
        let reflex = (0..count as u32).filter(|&i| ring.is_reflex(i)).collect();
        ring.reflex = Tree::new(corners, reflex);
        ring
    }

    /// Above 0 if `c` lies on the polygon's side of the line from `a` to `b`.
    fn turn(&self, a: DVec2, b: DVec2, c: DVec2) -> f64 {
        (b - a).perp_dot(c - a) * self.winding
    }

    fn triangle(&self, tip: u32) -> [DVec2; 3] {
        let [before, after] = self.beside[tip as usize];
        [before, tip, after].map(|i| self.corners[i as usize])
    }

    fn is_reflex(&self, tip: u32) -> bool {
        let [a, b, c] = self.triangle(tip);
        self.turn(a, b, c) <= 0.0
    }

    fn is_ear(&mut self, tip: u32) -> bool {
        let triangle @ [a, b, c] = self.triangle(tip);
        if self.turn(a, b, c) <= 0.0 {
            return false;
        }
        // A polygon with a hole has corners twice where it is cut open.
        let is_inside = |p: DVec2| {
            triangle.iter().all(|&corner| p != corner)
                && self.turn(a, b, p) >= 0.0
                && self.turn(b, c, p) >= 0.0
                && self.turn(c, a, p) >= 0.0
        };
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        let sides = [(a, b), (b, c), (c, a)];
        let meets = |box_low: DVec2, box_high: DVec2| {
            // The corner of the box that is farthest on the polygon's side.
            let reaches = |&(from, to): &(DVec2, DVec2)| {
                let side = (to - from) * self.winding;
                let x = if side.y > 0.0 { box_low.x } else { box_high.x };
                let y = if side.x > 0.0 { box_high.y } else { box_low.y };
                self.turn(from, to, DVec2::new(x, y)) >= 0.0
            };
            box_low.cmple(high).all() && box_high.cmpge(low).all() && sides.iter().all(reaches)
        };
        let (found, steps) = self.reflex.find(self.corners, &self.is_cut, meets, is_inside);
        self.steps += steps;
        !found
    }

    fn cut(&mut self, tip: u32) {
        let [before, after] = self.beside[tip as usize];
        self.beside[before as usize][1] = after;
        self.beside[after as usize][0] = before;
        self.is_cut[tip as usize] = true;
        self.reflex.remove(tip);
    }
}
