//! Culls triangles by boxes of directions.

use super::frustum::Frame;
use crate::{
    geometry::EdgeFunctions,
    simd::{Column, LaneMask, Lanes, Vec3Lanes},
};

/// Boxes of directions whose component along k is 1 or -1. An edge function's maximum over one takes six
/// multiply-adds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Directions<V> {
    pub middle: Vec3Lanes<V>,
    pub half: Vec3Lanes<V>,
}

/// The kernel's tolerance over |d_k|, which is above 0.3, and twice it for the rounding here.
const TRIANGLE_MARGIN: f32 = 6.0;

impl<V: Lanes<Memory = Column>> Directions<V> {
    /// In memory: middle x, y, z, half x, y, z.
    #[inline(always)]
    pub fn columns(self) -> [Column; 6] {
        let mut columns = [Column::splat(0.0); 6];
        let [x, y, z, half_x, half_y, half_z] = &mut columns;
        self.middle.x.store(x);
        self.middle.y.store(y);
        self.middle.z.store(z);
        self.half.x.store(half_x);
        self.half.y.store(half_y);
        self.half.z.store(half_z);
        columns
    }
}

impl<V: Lanes> Directions<V> {
    /// The triangles without an edge that has all directions on its outer side.
    #[inline(always)]
    pub fn triangles(&self, edges: &EdgeFunctions<V>) -> u32 {
        let [u, v, w] = edges.functions;
        let (u, v, w) = (self.largest(u), self.largest(v), self.largest(w));
        u.min(v).min(w).ge(edges.tolerance * -TRIANGLE_MARGIN).bits()
    }

    /// From rectangles of slopes along i and j.
    #[inline(always)]
    pub fn new(frame: &Frame, [a0, a1]: [V; 2], [b0, b1]: [V; 2]) -> Self {
        let mut middle = [a0.all(frame.sign); 3];
        let mut half = [a0.all(0.0); 3];
        for (axis, low, high) in [(frame.i, a0, a1), (frame.j, b0, b1)] {
            middle[axis] = (low + high) * 0.5;
            half[axis] = (high - low) * 0.5;
        }
        let ([x, y, z], [half_x, half_y, half_z]) = (middle, half);
        Self {
            middle: Vec3Lanes { x, y, z },
            half: Vec3Lanes {
                x: half_x,
                y: half_y,
                z: half_z,
            },
        }
    }

    /// The largest dot product of `e` with a direction.
    #[inline(always)]
    fn largest(&self, e: Vec3Lanes<V>) -> V {
        let x = self.half.x.mul_add_approx(e.x.abs(), self.middle.x * e.x);
        let y = self
            .half
            .y
            .mul_add_approx(e.y.abs(), self.middle.y.mul_add_approx(e.y, x));
        self.half
            .z
            .mul_add_approx(e.z.abs(), self.middle.z.mul_add_approx(e.z, y))
    }
}
