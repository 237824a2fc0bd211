//! Random numbers and gradient noise, the same on every machine.

use glam::DVec3;
use oorandom::Rand64;
use std::f64::consts::TAU;

/// A stream of random numbers: PCG (O'Neill 2014) with 128 bits of state, by `oorandom`, whose output is fixed.
pub(super) struct Random(Rand64);

impl Random {
    pub(super) fn new(seed: u64) -> Self {
        Self(Rand64::new(u128::from(seed)))
    }

    /// Returns a number, uniform in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0.rand_float()
    }

    /// Returns a number, uniform in [low, high).
    pub(super) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a direction, uniform over the unit sphere.
    pub(super) fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sin, cos) = libm::sincos(TAU * self.unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// Gradient noise (Perlin, *Improving Noise*, 2002), with a hash of the lattice point instead of a permutation table, so
/// that it does not repeat.
pub(super) struct Noise {
    seed: u64,
}

impl Noise {
    pub(super) fn new(seed: u64) -> Self {
        Self { seed: mix(seed) }
    }

    /// Returns the noise at `p`: about -1 to 1, 0 at lattice points, features of about one unit.
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

    /// Returns fractal noise: each octave has twice the frequency and half the amplitude of the one before.
    pub(super) fn fractal(&self, p: DVec3, octaves: u32) -> f64 {
        self.octaves(p, octaves, |n| n)
    }

    /// Returns ridged fractal noise: 0 in the valleys, 1 to 2 on the ridges.
    pub(super) fn ridged(&self, p: DVec3, octaves: u32) -> f64 {
        self.octaves(p, octaves, |n| (1.0 - n.abs()) * (1.0 - n.abs()))
    }

    fn octaves(&self, p: DVec3, octaves: u32, shape: impl Fn(f64) -> f64) -> f64 {
        let (mut sum, mut height, mut p) = (0.0, 1.0, p);
        for _ in 0..octaves {
            sum += height * shape(self.at(p));
            height *= 0.5;
            // Not exactly 2, and shifted, so that the zeros at lattice points do not coincide.
            p = p * 2.03 + DVec3::new(17.3, 5.1, 11.7);
        }
        sum
    }

    /// Returns one of the twelve directions to the edges of a cube.
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

/// Returns 0 below `from`, 1 above `to`, and a smooth step between.
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
