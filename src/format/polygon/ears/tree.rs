//! A tree of boxes around points of the plane, from which points are removed.

use glam::DVec2;

/// The most points of a leaf.
const LEAF: usize = 8;
/// The place of a point that is not in the tree.
const NONE: u32 = u32::MAX;

/// Points as indices of an array. The children of node `i`, `2 i + 1` and `2 i + 2`, have half of its points each.
#[derive(Default)]
pub(super) struct Tree {
    points: Vec<u32>,
    /// Where each point of the array is in `points`.
    places: Vec<u32>,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    low: DVec2,
    high: DVec2,
    /// How many points are not removed.
    left: u32,
}

impl Tree {
    pub(super) fn new(all: &[DVec2], points: Vec<u32>) -> Self {
        let none = Node {
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
            left: 0,
        };
        let leaves = points.len().div_ceil(LEAF).next_power_of_two();
        let mut tree = Self {
            points,
            places: vec![NONE; all.len()],
            nodes: vec![none; 2 * leaves],
        };
        divide(all, &mut tree.points, &mut tree.nodes, 0);
        for (place, &point) in tree.points.iter().enumerate() {
            tree.places[point as usize] = place as u32;
        }
        tree
    }

    pub(super) fn remove(&mut self, point: u32) {
        let place = self.places[point as usize] as usize;
        if place >= self.points.len() {
            return;
        }
        let (mut node, mut start, mut end) = (0, 0, self.points.len());
        loop {
            self.nodes[node].left -= 1;
            if end - start <= LEAF {
                return;
            }
            let middle = start.midpoint(end);
            let is_second = place >= middle;
            (start, end) = if is_second { (middle, end) } else { (start, middle) };
            node = 2 * node + 1 + usize::from(is_second);
        }
    }

    /// Whether a point that is not removed is wanted, and how many steps it took to find that out. No box with such a point
    /// may be refused by `meets`, which gets its least and its greatest corner.
    pub(super) fn find(
        &self,
        all: &[DVec2],
        is_removed: &[bool],
        meets: impl Fn(DVec2, DVec2) -> bool,
        is_wanted: impl Fn(DVec2) -> bool,
    ) -> (bool, usize) {
        let mut steps = 0;
        // Deep enough for 2^32 points.
        let mut stack = [(0, 0, 0); 40];
        stack[0] = (0, 0, self.points.len());
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (i, start, end) = stack[depth];
            let node = &self.nodes[i];
            steps += 1;
            if node.left == 0 || !meets(node.low, node.high) {
                continue;
            }
            if end - start <= LEAF {
                steps += end - start;
                let mut points = self.points[start..end].iter().map(|&point| point as usize);
                if points.any(|point| !is_removed[point] && is_wanted(all[point])) {
                    return (true, steps);
                }
            } else {
                let middle = start.midpoint(end);
                stack[depth] = (2 * i + 2, middle, end);
                stack[depth + 1] = (2 * i + 1, start, middle);
                depth += 2;
            }
        }
        (false, steps)
    }
}

/// Sorts points into the halves of node `i` and of those below it.
fn divide(all: &[DVec2], points: &mut [u32], nodes: &mut [Node], i: usize) {
    let node = &mut nodes[i];
    for &point in &*points {
        node.low = node.low.min(all[point as usize]);
        node.high = node.high.max(all[point as usize]);
    }
    node.left = points.len() as u32;
    if points.len() > LEAF {
        let size = node.high - node.low;
        let middle = points.len() / 2;
        let key = |point: u32| {
            let point = all[point as usize];
            if size.x > size.y { point.x } else { point.y }
        };
        points.select_nth_unstable_by(middle, |&a, &b| key(a).total_cmp(&key(b)));
        let (first, second) = points.split_at_mut(middle);
        divide(all, first, nodes, 2 * i + 1);
        divide(all, second, nodes, 2 * i + 2);
    }
}
