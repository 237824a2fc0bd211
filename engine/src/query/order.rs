//! Sorts rays with a shared origin by direction if neighbours in the array are not neighbours in space, as in the rows of a
//! picture. The tracer itself sorts other rays.

use crate::{
    lanes::{F32x8, LANES, Vec3x8},
    ray::{HitPacket, RayPacket},
    simd::{EightLanes, LaneMask, Lanes, Level, Simd, Vec3Eight, at_level},
};
use glam::Vec3;

/// Packets that are traced together at most: their rays should be neighbours.
const BUNDLE: usize = 32;

/// Fewer packets are not worth it.
// Tuned: see docs/lab-notes.md#varied-constants
const LEAST: usize = 4 * BUNDLE;

/// Rays are sorted if bundles are longer than squares of as many rays by this factor.
// Tuned: see docs/lab-notes.md#order-of-query-rays
const TOLERATED: f32 = 3.0;

/// Rays are sorted if neighbours are farther apart than this fraction of the extent of all.
// Tuned: see docs/lab-notes.md#varied-constants
const UNORDERED: f32 = 0.125;

/// Bits of a sorting key for each of two axes. Rays of one cell keep their order.
const BITS: u32 = 6;

/// Cells along an axis.
const STEPS: f32 = (1 << BITS) as f32;

/// Keys: cells ahead, then those behind.
const KEYS: usize = 2 << (2 * BITS);

/// One in this many packets is sampled for the axes.
// Tuned: see docs/lab-notes.md#varied-constants
const STRIDE: usize = 16;

/// Rays in another order, and where they belong.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// The key of each ray.
    keys: Vec<u16>,
    /// The place of each ray that was sorted.
    places: Vec<u32>,
    pub packets: Vec<RayPacket>,
    pub hits: Vec<HitPacket>,
}

/// A plane that directions are projected to, with its first axis along them, so that rows stay rows whatever their
/// direction.
struct Plane {
    forward: Vec3,
    axes: [Vec3; 2],
    lower: [f32; 2],
    /// The same along both axes.
    scale: f32,
}

impl Plane {
    fn of(packets: &[RayPacket]) -> Self {
        let samples = || {
            packets
                .iter()
                .step_by(STRIDE)
                .map(|packet| packet.direction.lane(0))
        };
        let farthest = |from: Vec3| {
            samples().fold(from, |far, d| {
                if d.distance_squared(from) > far.distance_squared(from) {
                    d
                } else {
                    far
                }
            })
        };
        let first = farthest(packets[0].direction.lane(0));
        let along = (farthest(first) - first).normalize_or(Vec3::X);
        let middle: Vec3 = samples().sum();
        let forward = middle
            .reject_from(along)
            .normalize_or(along.any_orthonormal_vector());
        let mut plane = Self {
            forward,
            axes: [along, forward.cross(along)],
            lower: [f32::INFINITY; 2],
            scale: 0.0,
        };
        let mut upper = [f32::NEG_INFINITY; 2];
        for d in samples() {
            for (axis, at) in plane.projected(d).into_iter().enumerate() {
                plane.lower[axis] = plane.lower[axis].min(at);
                upper[axis] = upper[axis].max(at);
            }
        }
        let size = (upper[0] - plane.lower[0]).max(upper[1] - plane.lower[1]);
        plane.scale = (STEPS - 1.0) / size.max(f32::MIN_POSITIVE);
        plane
    }

    fn projected(&self, d: Vec3) -> [f32; 2] {
        self.axes.map(|axis| axis.dot(d))
    }

    /// The places of directions along a Z-order curve, first those ahead.
    #[inline(always)]
    fn keys<S: Simd>(&self, simd: S, directions: &Vec3x8) -> [u16; LANES] {
        let d: Vec3Eight<S> = simd.load3(directions);
        let (zero, last) = (simd.splat(0.0), simd.splat(STEPS - 1.0));
        let mut steps = [[0.0; LANES]; 2];
        for (axis, steps) in steps.iter_mut().enumerate() {
            let at = d.dot_about(simd.splat3(self.axes[axis])) - simd.splat(self.lower[axis]);
            // NaN becomes 0, what is beyond the samples the nearest step.
            *steps = (at * self.scale).max(zero).min(last).to8().to_array();
        }
        let behind = d.dot_about(simd.splat3(self.forward)).lt(zero).bits();
        let mut keys = [0; LANES];
        for (lane, key) in keys.iter_mut().enumerate() {
            let [x, y] = [steps[0][lane] as i32 as u16, steps[1][lane] as i32 as u16];
            *key = spread(x) | spread(y) << 1 | ((behind >> lane & 1) as u16) << (2 * BITS);
        }
        keys
    }
}

/// The bits of a number below 2^8, one apart.
#[inline(always)]
fn spread(bits: u16) -> u16 {
    let bits = (bits | bits << 4) & 0x0f0f;
    let bits = (bits | bits << 2) & 0x3333;
    (bits | bits << 1) & 0x5555
}

/// The extent of directions, by two lanes of each packet; and the mean distance of neighbours.
fn extent(packets: &[RayPacket]) -> (f32, f32) {
    let (mut lower, mut upper) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let mut steps = 0.0;
    for (i, packet) in packets.iter().enumerate() {
        let lane = i % (LANES - 1);
        let (a, b) = (packet.direction.lane(lane), packet.direction.lane(lane + 1));
        (lower, upper) = (lower.min(a).min(b), upper.max(a).max(b));
        steps += (b - a).length();
    }
    ((upper - lower).length(), steps / packets.len() as f32)
}

/// Whether neighbours in the array are far apart in space, or bundles are much longer than wide.
fn is_scattered(packets: &[RayPacket]) -> bool {
    if packets.len() < LEAST {
        return false;
    }
    let (whole, step) = extent(packets);
    let bundles = packets.chunks_exact(BUNDLE);
    let count = bundles.len() as f32;
    let mean = bundles.map(|bundle| extent(bundle).0).sum::<f32>() / count;
    let diagonal = ((2 * BUNDLE * LANES) as f32).sqrt() * step;
    mean > TOLERATED * diagonal || step > UNORDERED * whole
}

impl Order {
    /// Sorts packets of rays into its own; `false` if their order is good.
    pub(super) fn sort(&mut self, level: Level, packets: &[RayPacket]) -> bool {
        if !is_scattered(packets) {
            return false;
        }
        let plane = Plane::of(packets);
        self.keys.clear();
        let mut counts = [0_u32; KEYS];
        at_level!(level, |simd| {
            for packet in packets {
                let keys = plane.keys(simd, &packet.direction);
                self.keys.extend_from_slice(&keys);
                for key in keys {
                    counts[usize::from(key) % KEYS] += 1;
                }
            }
        });
        let mut sum = 0;
        for count in &mut counts {
            (*count, sum) = (sum, sum + *count);
        }
        self.places.resize(self.keys.len(), 0);
        for (i, &key) in self.keys.iter().enumerate() {
            let to = &mut counts[usize::from(key) % KEYS];
            self.places[*to as usize] = i as u32;
            *to += 1;
        }
        self.packets.clear();
        self.packets.extend_from_slice(packets);
        for (to, eight) in self.packets.iter_mut().zip(self.places.as_chunks::<LANES>().0) {
            for (lane, &place) in eight.iter().enumerate() {
                let (from, from_lane) = (place as usize / LANES, place as usize % LANES);
                let [x, y, z] = packets[from].direction.lane(from_lane).to_array();
                to.direction.x.as_mut_array()[lane] = x;
                to.direction.y.as_mut_array()[lane] = y;
                to.direction.z.as_mut_array()[lane] = z;
                to.t_max.as_mut_array()[lane] = packets[from].t_max.as_array()[from_lane];
            }
        }
        self.hits.resize(packets.len(), HitPacket::miss(F32x8::ZERO));
        true
    }

    /// Puts the hits of its packets where the rays were.
    pub(super) fn put_back(&self, hits: &mut [HitPacket]) {
        for (from, eight) in self.hits.iter().zip(self.places.as_chunks::<LANES>().0) {
            for (lane, &place) in eight.iter().enumerate() {
                hits[place as usize / LANES].set_hit(place as usize % LANES, &from.hit(lane));
            }
        }
    }

    /// Puts the instances of its packets' hits where the rays were; there may be none.
    pub(super) fn put_back_instances(&self, found: &[[u32; LANES]], to: &mut Vec<[u32; LANES]>) {
        to.resize(found.len(), [0; LANES]);
        for (from, eight) in found.iter().zip(self.places.as_chunks::<LANES>().0) {
            for (&instance, &place) in from.iter().zip(eight) {
                to[place as usize / LANES][place as usize % LANES] = instance;
            }
        }
    }
}

#[cfg(test)]
mod tests;
