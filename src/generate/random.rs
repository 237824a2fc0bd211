//! Random numbers and noise, the same on every machine.

use glam::DVec3;
use oorandom::Rand64;
use std::f64::consts::TAU;

/// A stream of random numbers: PCG (O'Neill 2014) with 128 bits of state, by `oorandom`, whose output is fixed.
pub(super) struct Random(Rand64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(Rand64::new(u128::from(seed)))
    }

    /// Evenly in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0.rand_float()
    }

    /// Evenly in [low, high).
    pub(super) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Evenly over the unit sphere.
    pub(super) fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sin, cos) = libm::sincos(TAU * self.unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// Gradient noise (Perlin 2002, "Improving Noise"). Differs: a hash of the lattice point instead of a
/// permutation table, so that it does not repeat.
pub(super) struct Noise {
    seed: u64,
}

impl Noise {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed: mix(seed) }
    }

    /// Smooth, about -1 to 1, 0 at whole coordinates; features about one unit across.
    pub(super) fn at(&self, p: DVec3) -> f64 {
        let cell = p.floor();
        let f = p - cell;
        let [u, v, w] = [f.x, f.y, f.z].map(fade);
        let corner = |i: f64, j: f64, k: f64| {
            let offset = DVec3::new(i, j, k);
            self.gradient(cell + offset).dot(f - offset)
        };
        let edge = |j: f64, k: f64| lerp(u, corner(0.0, j, k), corner(1.0, j, k));
        let face = |k: f64| lerp(v, edge(0.0, k), edge(1.0, k));
        lerp(w, face(0.0), face(1.0))
    }

    /// Octaves of [`Noise::at`], each twice as fine and half as high as the one before.
    pub(super) fn fractal(&self, p: DVec3, octaves: u32) -> f64 {
        self.octaves(p, octaves, |n| n)
    }

    /// Octaves of creases: 0 in the valleys, 1 to 2 on the ridges.
    pub(super) fn ridged(&self, p: DVec3, octaves: u32) -> f64 {
        self.octaves(p, octaves, |n| (1.0 - n.abs()) * (1.0 - n.abs()))
    }

    fn octaves(&self, p: DVec3, octaves: u32, shape: impl Fn(f64) -> f64) -> f64 {
        let (mut sum, mut height, mut p) = (0.0, 1.0, p);
        for _ in 0..octaves {
            sum += height * shape(self.at(p));
            height *= 0.5;
            // Not exactly 2, and shifted, so that the zeros at whole coordinates do not fall together.
            p = p * 2.03 + DVec3::new(17.3, 5.1, 11.7);
        }
        sum
    }

    /// One of the twelve directions to the middles of a cube's edges.
    fn gradient(&self, cell: DVec3) -> DVec3 {
        let [x, y, z] = [cell.x, cell.y, cell.z].map(|c| (c as i64).cast_unsigned());
        let hash = mix(mix(mix(self.seed ^ x) ^ y) ^ z);
        let sign = |bit: u64| if hash >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let (a, b) = (sign(0), sign(1));
        match (hash >> 2) % 3 {
            0 => DVec3::new(a, b, 0.0),
            1 => DVec3::new(a, 0.0, b),
            _ => DVec3::new(0.0, a, b),
        }
    }
}

/// The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

pub(super) fn lerp(t: f64, a: f64, b: f64) -> f64 {
    a + t * (b - a)
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
