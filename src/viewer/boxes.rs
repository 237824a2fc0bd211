//! Boxes of the BVH, drawn over the picture.

use super::{
    pose::{Pose, half_height},
    request::Boxes,
    screen::Canvas,
};
use crate::{accel::Bvh, math::Aabb, scene};
use glam::DVec3;

/// Their colour, 0RGB: none of the classic materials has it.
pub const COLOR: u32 = 0x0000_90ff;
/// The most boxes that are drawn while the camera moves.
pub const MOST_MOVING: usize = 5000;

/// The near plane of a perspective view, as a share of the distance to the target.
const NEAR: f64 = 1e-3;

/// Returns the boxes to draw. A level leaves out leaves that are less deep.
#[must_use]
pub fn select(bvh: &Bvh, which: Boxes) -> Vec<Aabb> {
    let mut found = Vec::new();
    match which {
        Boxes::Hidden => {}
        Boxes::Level(0) => found.extend((!bvh.nodes().is_empty()).then(|| bvh.bounds())),
        Boxes::Level(level) => walk(bvh, level, &mut |depth, bounds, _| {
            if depth == level {
                found.push(bounds);
            }
        }),
        Boxes::Leaves => walk(bvh, usize::MAX, &mut |_, bounds, is_inner| {
            if !is_inner {
                found.push(bounds);
            }
        }),
    }
    found
}

/// Visits the boxes of all children down to a depth; the root's children are at depth 1.
fn walk(bvh: &Bvh, deepest: usize, visit: &mut impl FnMut(usize, Aabb, bool)) {
    if bvh.nodes().is_empty() {
        return;
    }
    let mut stack = vec![(bvh.root(), 1)];
    while let Some((node, depth)) = stack.pop() {
        let node = &bvh.nodes()[node.index()];
        for (i, &child) in node.child.iter().enumerate().take(node.count as usize) {
            let (lower, upper) = node.corners(i);
            visit(depth, Aabb { lower, upper }, child.is_inner());
            if child.is_inner() && depth < deepest {
                stack.push((child, depth + 1));
            }
        }
    }
}

/// Draws the edges of boxes relative to `origin`.
pub fn draw(
    canvas: &mut Canvas<'_>,
    pose: &Pose,
    origin: DVec3,
    boxes: impl Iterator<Item = Aabb>,
    color: u32,
) {
    let view = Projection::new(pose, origin, canvas.width, canvas.height);
    for Aabb { lower, upper } in boxes {
        let (lower, upper) = (lower.as_dvec3(), upper.as_dvec3());
        let corners: [DVec3; 8] = std::array::from_fn(|i| {
            let pick = |bit: usize, axis: usize| {
                if i >> bit & 1 == 0 {
                    lower[axis]
                } else {
                    upper[axis]
                }
            };
            view.to_view(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
        });
        for i in 0..8_usize {
            for bit in [1, 2, 4] {
                if i & bit == 0
                    && let Some([a, b]) = view.edge(corners[i], corners[i | bit])
                {
                    line(canvas, a, b, color);
                }
            }
        }
    }
}

/// From the scene to pixels.
struct Projection {
    eye: DVec3,
    frame: [DVec3; 3],
    /// Pixels of a unit: at distance 1, or everywhere if rays are parallel.
    scale: f64,
    is_parallel: bool,
    center: [f64; 2],
    near: f64,
}

impl Projection {
    fn new(pose: &Pose, origin: DVec3, width: u32, height: u32) -> Self {
        let (half_height, is_parallel) = match pose.projection {
            scene::Projection::Perspective { fov_degrees } => (half_height(fov_degrees), false),
            scene::Projection::Orthographic { height } => (height / 2.0, true),
        };
        // Parallel rays leave the plane through the eye.
        let near = if is_parallel { 0.0 } else { pose.distance() * NEAR };
        Self {
            eye: pose.eye - origin,
            frame: pose.frame(),
            scale: f64::from(height) / 2.0 / half_height,
            is_parallel,
            center: [f64::from(width) / 2.0, f64::from(height) / 2.0],
            near,
        }
    }

    /// Returns how far a point is to the right, upwards and forwards.
    fn to_view(&self, point: DVec3) -> DVec3 {
        let v = point - self.eye;
        DVec3::from_array(self.frame.map(|axis| axis.dot(v)))
    }

    /// Returns the ends of the part of an edge beyond the near plane, pixels.
    fn edge(&self, a: DVec3, b: DVec3) -> Option<[[f64; 2]; 2]> {
        let clip = |from: DVec3, to: DVec3| {
            if from.z >= self.near {
                from
            } else {
                from + (to - from) * ((self.near - from.z) / (to.z - from.z))
            }
        };
        if a.z < self.near && b.z < self.near {
            return None;
        }
        let pixel = |v: DVec3| {
            let depth = if self.is_parallel { 1.0 } else { v.z };
            let [x, y] = [v.x, -v.y].map(|c| c / depth * self.scale);
            [self.center[0] + x, self.center[1] + y]
        };
        Some([pixel(clip(a, b)), pixel(clip(b, a))])
    }
}

/// Draws a line, a pixel for each step along its longer side.
fn line(canvas: &mut Canvas<'_>, a: [f64; 2], b: [f64; 2], color: u32) {
    let size = [f64::from(canvas.width), f64::from(canvas.height)];
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    // The box of a single point may lie in the eye.
    if !(dx.is_finite() && dy.is_finite()) {
        return;
    }
    // The part of the line that is in the picture, from 0 to 1 (Liang and Barsky 1984).
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let (from, step) = (a[axis], [dx, dy][axis]);
        if step == 0.0 {
            if from < 0.0 || from >= size[axis] {
                return;
            }
            continue;
        }
        let (t0, t1) = ((0.0 - from) / step, (size[axis] - from) / step);
        first = first.max(t0.min(t1));
        last = last.min(t0.max(t1));
    }
    if first > last {
        return;
    }
    // Ends far outside are rounded coarsely: at most as many steps as the picture has pixels.
    let most = f64::from(canvas.width.max(canvas.height));
    let steps = (dx.abs().max(dy.abs()) * (last - first)).ceil().min(most) as u32 + 1;
    for i in 0..=steps {
        let t = first + (last - first) * f64::from(i) / f64::from(steps);
        let (x, y) = ((a[0] + dx * t) as usize, (a[1] + dy * t) as usize);
        if x < canvas.width as usize && y < canvas.height as usize {
            canvas.pixels[y * canvas.width as usize + x] = color;
        }
    }
}

#[cfg(test)]
mod tests;
