//! The order of rays with one origin: sorted by direction where neighbours in the array are not neighbours in space, as in
//! the rows of a picture. The tracer sorts other rays by itself.

use crate::{
    lanes::{F32x8, LANES},
    ray::{HitPacket, RayPacket},
};

/// Packets that are traced together at most: their rays should be neighbours.
const BUNDLE: usize = 32;

/// Fewer packets are not worth it.
const LEAST: usize = 4 * BUNDLE;

/// Rays are sorted if the boxes of bundles have so many times the extent of squares that share the whole area.
// Tuned: see docs/lab-notes.md#order-of-query-rays
const TOLERATED: f32 = 2.0;

/// Steps of a sorting key along an axis: a power of two, finer than the pixels of large pictures.
const STEPS: f32 = 32768.0;

/// Rays in another order, and where they belong.
#[derive(Debug, Default)]
pub(super) struct Order {
    /// Key, then place, of each ray.
    keyed: Vec<u64>,
    pub packets: Vec<RayPacket>,
    pub hits: Vec<HitPacket>,
}

/// A direction on the unfolded octahedron, from -1 to 1 (Meyer, Süßmuth, Sußner, Stamminger and Greiner, *On
/// Floating-Point Normal Vectors*, 2010).
fn unfolded([x, y, z]: [f32; 3]) -> [f32; 2] {
    let sum = x.abs() + y.abs() + z.abs();
    let (x, y) = (x / sum, y / sum);
    if z >= 0.0 {
        [x, y]
    } else {
        [(1.0 - y.abs()).copysign(x), (1.0 - x.abs()).copysign(y)]
    }
}

fn direction(packet: &RayPacket, lane: usize) -> [f32; 3] {
    let d = &packet.direction;
    [d.x.as_array()[lane], d.y.as_array()[lane], d.z.as_array()[lane]]
}

/// The bits of a number below 2^16, one apart.
fn spread(bits: u32) -> u32 {
    let bits = (bits | bits << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// The place of a direction along a Z-order curve.
fn key(direction: [f32; 3]) -> u32 {
    let [x, y] = unfolded(direction);
    // NaN becomes 0.
    let step = |part: f32| ((part + 1.0) * (STEPS - 1.0) * 0.5) as u32;
    spread(step(x)) | spread(step(y)) << 1
}

/// A box of directions, by one lane of each packet.
#[derive(Clone, Copy)]
struct Extent {
    lower: [f32; 2],
    upper: [f32; 2],
}

impl Extent {
    const NONE: Self = Self {
        lower: [f32::INFINITY; 2],
        upper: [f32::NEG_INFINITY; 2],
    };

    fn add(&mut self, [x, y]: [f32; 2]) {
        self.lower = [self.lower[0].min(x), self.lower[1].min(y)];
        self.upper = [self.upper[0].max(x), self.upper[1].max(y)];
    }

    fn size(&self) -> [f32; 2] {
        [self.upper[0] - self.lower[0], self.upper[1] - self.lower[1]]
    }
}

/// Whether bundles are longer or wider than they need be.
fn is_scattered(packets: &[RayPacket]) -> bool {
    if packets.len() < LEAST {
        return false;
    }
    let (mut all, mut sum, mut bundles) = (Extent::NONE, 0.0, 0.0);
    for bundle in packets.chunks_exact(BUNDLE) {
        let mut extent = Extent::NONE;
        for (i, packet) in bundle.iter().enumerate() {
            let at = unfolded(direction(packet, i % LANES));
            extent.add(at);
            all.add(at);
        }
        let [width, height] = extent.size();
        sum += width + height;
        bundles += 1.0;
    }
    let [width, height] = all.size();
    let square = (width * height / bundles).sqrt();
    sum / bundles > 2.0 * TOLERATED * square
}

impl Order {
    /// Sorts packets of rays into its own; `false` if they are good as they come.
    pub(super) fn sort(&mut self, packets: &[RayPacket]) -> bool {
        if !is_scattered(packets) {
            return false;
        }
        self.keyed.clear();
        for (i, packet) in packets.iter().enumerate() {
            for lane in 0..LANES {
                let key = key(direction(packet, lane));
                self.keyed.push(u64::from(key) << 32 | (i * LANES + lane) as u64);
            }
        }
        self.keyed.sort_unstable();
        self.packets.clear();
        self.packets.extend_from_slice(packets);
        for (to, eight) in self.packets.iter_mut().zip(self.keyed.as_chunks::<LANES>().0) {
            for (lane, &keyed) in eight.iter().enumerate() {
                let (from, from_lane) = place(keyed);
                let [x, y, z] = direction(&packets[from], from_lane);
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
        for (from, eight) in self.hits.iter().zip(self.keyed.as_chunks::<LANES>().0) {
            for (lane, &keyed) in eight.iter().enumerate() {
                let (to, to_lane) = place(keyed);
                hits[to].set_hit(to_lane, &from.hit(lane));
            }
        }
    }
}

/// Packet and lane of a ray.
fn place(keyed: u64) -> (usize, usize) {
    let i = keyed as u32 as usize;
    (i / LANES, i % LANES)
}
