//! Points in Z order (Morton, *A Computer Oriented Geodetic Data Base*, 1966), so that neighbours in the order are mostly
//! neighbours in space.

use glam::DVec3;
use std::cell::Cell;

/// Cells along each axis of the box around the points.
const CELLS: f64 = 1024.0;

thread_local! {
    /// Kept from call to call.
    static ORDER: Cell<Vec<(u32, u32)>> = const { Cell::new(Vec::new()) };
}

/// Calls `visit` with the indices of `count` points, in Z order.
pub(super) fn in_z_order(count: usize, point: impl Fn(usize) -> DVec3, mut visit: impl FnMut(usize)) {
    let mut order = ORDER.take();
    order.clear();
    let finite = |i: usize| Some(point(i)).filter(|point| point.is_finite());
    let (mut lower, mut upper) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for point in (0..count).filter_map(finite) {
        (lower, upper) = (lower.min(point), upper.max(point));
    }
    // Halves, so that differences are finite.
    let size = (upper * 0.5 - lower * 0.5).max_element();
    order.extend((0..count).map(|i| {
        let cell = finite(i).map_or(DVec3::ZERO, |point| {
            (point * 0.5 - lower * 0.5) / size * (CELLS - 1.0)
        });
        // NaN becomes 0.
        let [x, y, z] = cell.to_array().map(|cell| spread(cell as u32));
        (x | y << 1 | z << 2, i as u32)
    }));
    order.sort_unstable();
    for &(_, i) in &order {
        visit(i as usize);
    }
    ORDER.set(order);
}

/// Spreads ten bits, with two zeros above each.
fn spread(bits: u32) -> u32 {
    let mut spread = bits;
    for (shift, mask) in [
        (16, 0x0300_00ff),
        (8, 0x0300_f00f),
        (4, 0x030c_30c3),
        (2, 0x0924_9249),
    ] {
        spread = (spread | spread << shift) & mask;
    }
    spread
}

#[cfg(test)]
mod tests;
