//! Sorts rays by direction, so that bundles hold rays of similar directions.
//!
//!   512 packets -> a key per ray -> counting sort -> packets of sorted rays -> results scattered back
//!     mirror rays: 24 squares of a cube map (`by_direction`)
//!     shadow rays: 32 x 32 cells of an octahedron around the light, in Z order (`by_place`)
//!
//! After Boulos et al., *Adaptive Ray Packet Reordering*, 2008. Differs: one sort of a few thousand rays, only if packets
//! diverge and earlier rays were expensive.
// Tuned: see docs/lab-notes.md#sorted-mirror-rays and #sorted-shadow-rays

use super::{
    largest_axis,
    policy::{CoherencePolicy, SPREAD},
};
use crate::{
    lanes::LANES,
    ray::RayPacket,
    simd::{EightLanes, LaneMask, Lanes, Simd, Vec3Eight, Vec3Lanes},
};

/// Packets that are sorted together: more make more coherent bundles, and take more cache.
#[doc(hidden)]
pub const PACKETS: usize = 512;
const RAYS: usize = PACKETS * LANES;

/// The faces of a cube map, with 2 x 2 squares each.
const SQUARES: usize = 6 * 4;

/// One in this many packets is sampled for the policy's decisions: time against certainty.
// Tuned: see docs/lab-notes.md#varied-constants
const SAMPLED: usize = 8;

/// Cells along either side of the square in which rays with a shared origin are sorted: a group has four rays a cell.
// Tuned: see docs/lab-notes.md#varied-constants
const CELLS: usize = 32;

/// Memory for sorting.
#[derive(Debug, Default)]
pub(super) struct Sorted {
    /// The key of each ray.
    keys: Box<[[u16; LANES]]>,
    order: Box<[u16]>,
    count: usize,
}

/// Maps directions to a square by unfolding an octahedron, with one of its corners in the middle (Cigolle et al., *A
/// Survey of Efficient Representations for Independent Unit Vectors*, 2014).
#[derive(Clone, Copy, Debug)]
struct Octahedron {
    axis: usize,
    sign: f32,
}

impl Octahedron {
    /// With the corner nearest to `direction` in the middle.
    #[inline(always)]
    fn toward(direction: [f32; 3]) -> Self {
        let axis = largest_axis([direction[0].abs(), direction[1].abs(), direction[2].abs()]);
        let sign = 1.0_f32.copysign(direction[axis]);
        Self { axis, sign }
    }

    /// Eight places, coordinates from -1 to 1.
    #[inline(always)]
    fn places<S: Simd>(self, simd: S, rays: &RayPacket) -> [S::V8; 2] {
        let Vec3Lanes { x, y, z } = simd.load3(&rays.direction);
        let (along, a, b) = match self.axis {
            0 => (x, y, z),
            1 => (y, z, x),
            _ => (z, x, y),
        };
        let along = along * self.sign;
        let one = simd.splat(1.0);
        let scale = one / (a.abs() + b.abs() + along.abs());
        let (a, b) = (a * scale, b * scale);
        let is_behind = along.lt(simd.splat(0.0));
        [
            S::V8::select(is_behind, signed(one - b.abs(), a), a),
            S::V8::select(is_behind, signed(one - a.abs(), b), b),
        ]
    }
}

/// `size`, negative where `of` is.
#[inline(always)]
fn signed<V: Lanes>(size: V, of: V) -> V {
    V::select(of.lt(of.all(0.0)), -size, size)
}

/// Spreads the bits of a number below [`CELLS`], a 0 above each.
const fn apart(mut number: usize) -> u16 {
    let (mut bits, mut place) = (0, 0);
    while number != 0 {
        bits |= ((number & 1) << place) as u16;
        number >>= 1;
        place += 2;
    }
    bits
}

/// [`apart`] as a table.
const APART: [u16; CELLS] = {
    let mut all = [0; CELLS];
    let mut i = 0;
    while i < CELLS {
        all[i] = apart(i);
        i += 1;
    }
    all
};

impl Sorted {
    pub fn new() -> Self {
        Self {
            keys: Box::new([[0; LANES]; PACKETS]),
            order: Box::new([0; RAYS]),
            count: 0,
        }
    }

    /// Sorts up to [`PACKETS`] packets with separate origins by the square of the cube map that each ray passes;
    /// returns `false` if that would not pay.
    #[inline(always)]
    pub fn by_direction<S: Simd>(&mut self, simd: S, rays: &[RayPacket]) -> bool {
        let sampled = rays.iter().step_by(SAMPLED);
        let mut mixed = 0;
        for rays in sampled.clone() {
            mixed += usize::from(is_mixed(simd, rays));
        }
        if !CoherencePolicy::sorts_mixed(mixed, sampled.len()) {
            return false;
        }
        for (p, rays) in rays.iter().enumerate() {
            let keys = &mut self.keys[p];
            let live = simd.load(&rays.t_max).gt(simd.splat(0.0));
            let squares = S::V8::select(live, squares(simd, rays), simd.splat(SQUARES as f32));
            let squares = squares.trunc();
            for (i, key) in keys.iter_mut().enumerate() {
                *key = squares[i] as u16;
            }
        }
        self.sort::<{ SQUARES + 2 }>(rays.len());
        true
    }

    /// Sorts up to [`PACKETS`] packets with a shared origin by cell, cells in Z order (Morton 1966); returns `false`
    /// if that would not pay. The cells cover the square around most of the targets; rays outside belong to the cells
    /// at its sides.
    #[inline(always)]
    pub fn by_place<S: Simd>(&mut self, simd: S, rays: &[RayPacket]) -> bool {
        let octahedron = Octahedron::toward(sum_of_live(simd, rays.iter().step_by(SAMPLED)));
        let (mut lower, mut upper) = ([1.0_f32; 2], [-1.0_f32; 2]);
        let mut sizes = [0.0_f32; PACKETS / SAMPLED];
        for (size, rays) in sizes.iter_mut().zip(rays.iter().step_by(SAMPLED)) {
            let live = simd.load(&rays.t_max).gt(simd.splat(0.0));
            let places = octahedron.places(simd, rays);
            for i in 0..2 {
                let least = S::V8::select(live, places[i], simd.splat(1.0)).min_lane();
                let most = S::V8::select(live, places[i], simd.splat(-1.0)).max_lane();
                (lower[i], upper[i]) = (lower[i].min(least), upper[i].max(most));
                *size = size.max(most - least);
            }
        }
        let size = (upper[0] - lower[0])
            .max(upper[1] - lower[1])
            .max(f32::MIN_POSITIVE);
        let share = SPREAD / rays.len() as f32 * size * size;
        let spread = sizes.iter().filter(|&&of| of * of > share).count();
        if !CoherencePolicy::sorts_spread(spread, rays.len().div_ceil(SAMPLED)) {
            return false;
        }
        for (p, rays) in rays.iter().enumerate() {
            let keys = &mut self.keys[p];
            let live = simd.load(&rays.t_max).gt(simd.splat(0.0)).bits();
            let [a, b] = octahedron.places(simd, rays);
            let scale = CELLS as f32 / size;
            let (a, b) = (cells::<S>(a, lower[0], scale), cells::<S>(b, lower[1], scale));
            for (i, key) in keys.iter_mut().enumerate() {
                let cell = APART[a[i] as usize % CELLS] | APART[b[i] as usize % CELLS] << 1;
                *key = if live >> i & 1 != 0 {
                    cell
                } else {
                    (CELLS * CELLS) as u16
                };
            }
        }
        self.sort::<{ CELLS * CELLS + 2 }>(rays.len());
        true
    }

    /// A counting sort of the rays of `packets` by key, below `N` - 1. Lanes with the last key hold no ray and are
    /// left out.
    #[inline(always)]
    fn sort<const N: usize>(&mut self, packets: usize) {
        let mut starts = [0_u32; N];
        let keys = &self.keys[..packets];
        for keys in keys {
            for &key in keys {
                starts[usize::from(key) % (N - 1) + 1] += 1;
            }
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        self.count = starts[N - 2] as usize;
        let mut ray = 0;
        for keys in keys {
            for &key in keys {
                let start = &mut starts[usize::from(key) % (N - 1)];
                self.order[*start as usize % RAYS] = ray;
                *start += 1;
                ray = ray.wrapping_add(1);
            }
        }
    }

    /// The sorted rays, packet times eight plus lane; neighbours within a cell stay neighbours.
    #[inline(always)]
    pub fn rays(&self) -> &[u16] {
        &self.order[..self.count]
    }
}

/// The sum of the directions of all live rays.
#[inline(always)]
fn sum_of_live<'a, S: Simd>(simd: S, rays: impl Iterator<Item = &'a RayPacket>) -> [f32; 3] {
    let zero = simd.splat(0.0);
    let mut sum = Vec3Eight::<S>::new(zero, zero, zero);
    for rays in rays {
        let live = simd.load(&rays.t_max).gt(zero);
        let none = Vec3Lanes::new(zero, zero, zero);
        sum = sum + Vec3Lanes::select(live, simd.load3(&rays.direction), none);
    }
    [sum.x.sum(), sum.y.sum(), sum.z.sum()]
}

/// The cells of eight places along one side, of those that begin at `lower`.
#[inline(always)]
fn cells<S: Simd>(places: S::V8, lower: f32, scale: f32) -> [i32; LANES] {
    let cell = (places - places.all(lower)) * scale;
    cell.max(cell.all(0.0)).min(cell.all((CELLS - 1) as f32)).trunc()
}

/// Whether the rays of a packet go through more than one face.
#[inline(always)]
fn is_mixed<S: Simd>(simd: S, rays: &RayPacket) -> bool {
    let faces = (squares(simd, rays) * 0.25).trunc();
    faces != [faces[0]; LANES]
}

/// The squares of a cube map that eight rays go through.
#[inline(always)]
fn squares<S: Simd>(simd: S, rays: &RayPacket) -> S::V8 {
    let d = simd.load3(&rays.direction);
    let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
    let (by_x, by_y) = (x.ge(y.max(z)), y.ge(z));
    /// One of three by the face's axis.
    macro_rules! pick {
        ($x:expr, $y:expr, $z:expr) => {
            S::V8::select(by_x, $x, S::V8::select(by_y, $y, $z))
        };
    }
    let face = pick!(simd.splat(0.0), simd.splat(8.0), simd.splat(16.0));
    let face = face + below(pick!(d.x, d.y, d.z)) * 4.0;
    let a = below(pick!(d.y, d.z, d.x));
    let b = below(pick!(d.z, d.x, d.y));
    // In range even if a direction is NaN.
    (face + a + b + b).min(simd.splat((SQUARES - 1) as f32))
}

/// 1 where a number is negative, else 0.
#[inline(always)]
fn below<V: Lanes>(v: V) -> V {
    V::select(v.lt(v.all(0.0)), v.all(1.0), v.all(0.0))
}

#[cfg(test)]
mod tests;
