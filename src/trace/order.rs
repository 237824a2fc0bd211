//! Rays in order of their directions, so that bundles hold rays that go the same way (Boulos et al., *Adaptive Ray Packet
//! Reordering*, 2008).
//!
//! Mirrors reflect neighbouring rays to neighbouring places; leaves and folds of curtains do not, and there the rays of a
//! bundle have little in common. A counting sort of a few thousand rays by where they go through a cube map took the
//! mirror rays of the interior from 8.4 to 9.9 Mrays/s, sorting included (11.3 without); where packets agree, or the
//! rays are scattered all the same, it is left out. (Tried: whole packets by the direction of one of their rays, which
//! moves no rays: no gain. Finer squares, or order by origin: slower. Rays that enter a subtree few a packet put together
//! into full packets for it: -4 to +2 %.)
//!
//! Rays from a light to what neighbouring pixels show are neighbours only where that is one surface. Through a thicket of
//! thin things a bundle of them spreads over all that the whole group spreads over; sorted by place, each has its own part.
//! (Zen 5, AVX-512, shadow rays of a picture of 1024 x 1024, sorting included: pipes of thin triangles +80 %, hair +120 %,
//! a denser one +75 %, a million triangles anywhere +35 %, two million smaller ones +40 %, or +85 % where they then go one by
//! one, beams +11 %, spheres +10 %, cow to blobs -1 to +1 %. Whole packets by their first rays: no gain. Told by the
//! effort alone: figure and blobs -4 to -10 %, for they are sorted in vain where a silhouette has cost much. Tried in turn,
//! group by group, and what costs less kept: the same, for groups differ more than that. Bundles given up that leave many
//! rays to go on one by one, in place of those that visit many leaves: hair -20 %.)

use crate::{
    ray::RayPacket,
    simd::{F32x8, LANES, ge, gt, lt, max, max_lane, min, min_lane, splat, truncate},
};

/// So many packets are sorted together. (Mirror rays of the interior, without the time for sorting: 9.7 Mrays/s with 64,
/// 10.5 with 128, 11 with 256, 11.3 with 512.)
pub(super) const PACKETS: usize = 512;
const RAYS: usize = PACKETS * LANES;

/// A cube map's faces, and 2 x 2 squares of each.
const SQUARES: usize = 6 * 4;

/// Where one packet in this many has rays through more than one face, sorting pays.
const MIXED: usize = 4;
/// Of so many packets one is looked at to find that out.
const ASKED: usize = 8;

/// Cells along either side of the square that rays from one point are sorted in.
const CELLS: usize = 32;

/// A ray that goes through a subtree on its own costs about as much as so many packets at a leaf.
const ALONE: usize = 8;

/// Above so many tenths of a packet at a leaf, for each ray, sorting may pay. (Cow, figure and interior have 0.5 to 1.1
/// tenths on average, and lose 35 to 62 % where they are sorted all the same; terrain 6, spheres 7, a million blobs 9, pipes
/// of thin triangles 158, hair 370. Zen 5, AVX-512.)
const HIGH_X10: usize = 5;

/// What bundles of rays from one point have cost.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    rays: usize,
    /// Packets that came by leaves, summed over the leaves.
    packets: usize,
    /// Rays that went on one by one, summed over the subtrees that they went through.
    alone: usize,
}

impl Effort {
    /// A bundle more.
    #[inline(always)]
    pub fn add(&mut self, rays: usize, packets: usize, alone: usize) {
        self.rays += rays;
        self.packets += packets;
        self.alone += alone;
    }

    /// Whether it is so much that sorting the next rays might make it less.
    pub fn is_high(&self) -> bool {
        10 * (self.packets + ALONE * self.alone) > HIGH_X10 * self.rays
    }
}

/// Rays of a packet are spread where the square around the places that they go to is larger than so many times their share
/// of the square around all. (On a smooth surface it is at most about twice its share, and less where that is long.)
const SPREAD: f32 = 2.5;

/// Where one packet in this many is spread, sorting rays from one point pays.
const SPREAD_ONE_IN: usize = 5;

/// Fewer packets are not sorted by place: they are half a bundle, and sorting costs as much as that of many.
const FEWEST: usize = 32;

/// Memory for sorting.
#[derive(Debug, Default)]
pub(super) struct Sorted {
    /// Where each ray belongs.
    keys: Box<[[u16; LANES]]>,
    order: Box<[u16]>,
    count: usize,
}

/// Where a ray goes as seen from a point: a place in the square that an octahedron folds out to, with one of its corners in
/// the middle (Cigolle et al., *A Survey of Efficient Representations for Independent Unit Vectors*, 2014).
#[derive(Clone, Copy, Debug)]
struct Octahedron {
    axis: usize,
    sign: f32,
}

impl Octahedron {
    /// With that corner in the middle which is nearest to `direction`.
    fn toward(direction: [f32; 3]) -> Self {
        let largest = (0..3).max_by(|&i, &j| direction[i].abs().total_cmp(&direction[j].abs()));
        let axis = largest.unwrap_or(0);
        let sign = 1.0_f32.copysign(direction[axis]);
        Self { axis, sign }
    }

    /// Eight places, coordinates from -1 to 1.
    #[inline(always)]
    fn places8(self, rays: &RayPacket) -> [F32x8; 2] {
        let d = [rays.direction.x, rays.direction.y, rays.direction.z];
        let (a, b) = (d[(self.axis + 1) % 3], d[(self.axis + 2) % 3]);
        let along = d[self.axis] * splat(self.sign);
        let one = splat(1.0);
        let scale = one / (a.abs() + b.abs() + along.abs());
        let (a, b) = (a * scale, b * scale);
        let signed = |size: F32x8, of: F32x8| lt(of, splat(0.0)).select(-size, size);
        let is_behind = lt(along, splat(0.0));
        [
            is_behind.select(signed(one - b.abs(), a), a),
            is_behind.select(signed(one - a.abs(), b), b),
        ]
    }
}

/// The bits of a number below [`CELLS`], each with a 0 above it.
const fn apart(mut number: usize) -> u16 {
    let (mut bits, mut place) = (0, 0);
    while number != 0 {
        bits |= ((number & 1) << place) as u16;
        number >>= 1;
        place += 2;
    }
    bits
}

/// [`apart`], looked up.
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

    /// Sorts up to [`PACKETS`] packets of rays with their own origins by the square that they go through; `false` if that
    /// would not pay.
    #[inline(never)]
    pub fn by_direction(&mut self, rays: &[RayPacket]) -> bool {
        let asked = rays.iter().step_by(ASKED);
        let mixed = asked.clone().filter(|rays| is_mixed(rays)).count();
        if mixed * MIXED < asked.len() {
            return false;
        }
        for (keys, rays) in self.keys.iter_mut().zip(rays) {
            let live8 = gt(rays.t_max, splat(0.0));
            let squares8 = truncate(live8.select(squares8(rays), splat(SQUARES as f32)));
            for (key, square) in keys.iter_mut().zip(squares8) {
                *key = square as u16;
            }
        }
        self.sort::<{ SQUARES + 2 }>(rays.len());
        true
    }

    /// Sorts up to [`PACKETS`] packets of rays from one point by the cell that they go through, cells in Z order (Morton,
    /// *A Computer Oriented Geodetic Data Base*, 1966); `false` if that would not pay. The cells cover the square around
    /// most of the places that rays go to; what goes elsewhere belongs to the cells at the side.
    #[inline(never)]
    pub fn by_place(&mut self, rays: &[RayPacket]) -> bool {
        if rays.len() < FEWEST {
            return false;
        }
        let asked = rays.iter().step_by(ASKED);
        let mut sum = [splat(0.0); 3];
        for rays in asked.clone() {
            let live8 = gt(rays.t_max, splat(0.0));
            let d = &rays.direction;
            for (sum, d) in sum.iter_mut().zip([d.x, d.y, d.z]) {
                *sum += live8.select(d, splat(0.0));
            }
        }
        let octahedron = Octahedron::toward(sum.map(F32x8::reduce_add));
        let (mut lower, mut upper) = ([1.0_f32; 2], [-1.0_f32; 2]);
        let mut sizes = [0.0_f32; PACKETS / ASKED];
        for (size, rays) in sizes.iter_mut().zip(asked) {
            let live8 = gt(rays.t_max, splat(0.0));
            let places8 = octahedron.places8(rays);
            for i in 0..2 {
                let least = min_lane(live8.select(places8[i], splat(1.0)));
                let most = max_lane(live8.select(places8[i], splat(-1.0)));
                (lower[i], upper[i]) = (lower[i].min(least), upper[i].max(most));
                *size = size.max(most - least);
            }
        }
        let size = (upper[0] - lower[0])
            .max(upper[1] - lower[1])
            .max(f32::MIN_POSITIVE);
        let share = SPREAD / rays.len() as f32 * size * size;
        let spread = sizes.iter().filter(|&&of| of * of > share).count();
        if spread * SPREAD_ONE_IN < rays.len().div_ceil(ASKED) {
            return false;
        }
        let scale = splat(CELLS as f32 / size);
        let last = splat((CELLS - 1) as f32);
        for (keys, rays) in self.keys.iter_mut().zip(rays) {
            let live = gt(rays.t_max, splat(0.0)).bits();
            let [a, b] = octahedron.places8(rays);
            let cell = |place8: F32x8, lower: f32| {
                truncate(min(max((place8 - splat(lower)) * scale, splat(0.0)), last))
            };
            let (a, b) = (cell(a, lower[0]), cell(b, lower[1]));
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

    /// A counting sort of the rays of `packets` by their keys, which are below `N` - 1. Those with the last of these keys
    /// are none, and left out.
    #[inline(always)]
    fn sort<const N: usize>(&mut self, packets: usize) {
        let mut starts = [0_u32; N];
        let keys = &self.keys[..packets];
        for &key in keys.as_flattened() {
            starts[usize::from(key) % (N - 1) + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        self.count = starts[N - 2] as usize;
        for (&key, ray) in keys.as_flattened().iter().zip(0..) {
            let start = &mut starts[usize::from(key) % (N - 1)];
            self.order[*start as usize % RAYS] = ray;
            *start += 1;
        }
    }

    /// Packet times eight plus lane of the rays there are, those of a square or cell together, neighbours as neighbours.
    pub fn rays(&self) -> &[u16] {
        &self.order[..self.count]
    }
}

/// Whether the rays of a packet go through more than one face.
fn is_mixed(rays: &RayPacket) -> bool {
    let face8 = truncate(squares8(rays) * splat(0.25));
    face8 != [face8[0]; LANES]
}

/// The squares of a cube map that eight rays go through.
#[inline(always)]
fn squares8(rays: &RayPacket) -> F32x8 {
    let d = &rays.direction;
    let (x, y, z) = (d.x.abs(), d.y.abs(), d.z.abs());
    let by_x = ge(x, max(y, z));
    let by_y = ge(y, z);
    let pick = |a: F32x8, b: F32x8, c: F32x8| by_x.select(a, by_y.select(b, c));
    let one = splat(1.0);
    let below = |v: F32x8| lt(v, splat(0.0)).select(one, splat(0.0));
    let face = pick(splat(0.0), splat(8.0), splat(16.0)) + splat(4.0) * below(pick(d.x, d.y, d.z));
    let a = below(pick(d.y, d.z, d.x));
    let b = below(pick(d.z, d.x, d.y));
    // In range even where a direction is not a number.
    min(face + a + b + b, splat((SQUARES - 1) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Vec3x8;
    use glam::Vec3;

    fn packets(directions: &[[Vec3; LANES]]) -> Vec<RayPacket> {
        let packet = |d: &[Vec3; LANES]| RayPacket {
            direction: Vec3x8::from_lanes(*d),
            t_max: splat(1.0),
        };
        directions.iter().map(packet).collect()
    }

    #[test]
    fn rays_of_one_square_come_together_in_the_order_they_had() {
        let (x, z) = (Vec3::X, -Vec3::Z);
        let mut rays = packets(&[[x, z, x, z, x, z, x, z], [z; LANES], [Vec3::NAN; LANES]]);
        rays[1].t_max = splat(0.0);
        let mut sorted = Sorted::new();
        assert!(sorted.by_direction(&rays));
        let mut order = sorted.rays().to_vec();
        assert_eq!(order[..4], [0, 2, 4, 6]);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23]);
    }

    /// Packets of rays toward a square, as wide as one in `parts` of it.
    fn toward(parts: usize, from: Vec3, u: Vec3, v: Vec3) -> Vec<RayPacket> {
        let mut random = fastrand::Rng::with_seed(1);
        let directions: Vec<[Vec3; LANES]> = (0..PACKETS)
            .map(|_| {
                let corner = [random.usize(..parts) as f32, random.usize(..parts) as f32];
                [(); LANES].map(|()| {
                    let [x, y] = corner.map(|corner| (corner + random.f32()) / parts as f32);
                    from + u * x + v * y
                })
            })
            .collect();
        packets(&directions)
    }

    #[test]
    fn rays_of_one_cell_come_together_where_packets_spread() {
        let (u, v) = (Vec3::X * 0.01, Vec3::Y * 0.01);
        let way = Vec3::new(0.1, -0.2, -1.0);
        assert!(!Sorted::new().by_place(&toward(20, way, u, v)));
        assert!(!Sorted::new().by_place(&toward(2, way, u, v)[..FEWEST - 1]));
        assert!(Sorted::new().by_place(&toward(2, way, u, v)[..FEWEST]));
        let mut rays = toward(2, way, u, v);
        rays[1].t_max = splat(0.0);
        rays[2].t_max = F32x8::from([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
        let mut sorted = Sorted::new();
        assert!(sorted.by_place(&rays));
        // The sides of 64 packets: squares have 16 in all, rows would have 65, and unsorted rays 128.
        let mut sides = 0.0;
        for packet in sorted.rays().chunks(RAYS / 64) {
            let place = |&ray: &u16| {
                let ray = usize::from(ray);
                rays[ray / LANES].direction.lane(ray % LANES)
            };
            let lower = packet.iter().map(place).reduce(Vec3::min).unwrap();
            let upper = packet.iter().map(place).reduce(Vec3::max).unwrap();
            sides += (upper - lower).element_sum() / 0.01;
        }
        assert!(sides < 30.0, "{sides}");
        let mut all = sorted.rays().to_vec();
        all.sort_unstable();
        let live = |&ray: &u16| {
            let ray = usize::from(ray);
            rays[ray / LANES].t_max.as_array()[ray % LANES] > 0.0
        };
        let expected: Vec<u16> = (0..RAYS as u16).filter(live).collect();
        assert_eq!(all, expected);
    }

    #[test]
    fn rays_every_way_from_a_point_are_all_there() {
        let mut rays = toward(1, Vec3::NEG_ONE, Vec3::X * 2.0, Vec3::Y * 2.0);
        for (rays, flip) in rays.iter_mut().zip([1.0, -1.0].into_iter().cycle()) {
            rays.direction.z *= splat(flip);
        }
        rays[0].direction.x = splat(f32::NAN);
        rays[1].direction = Vec3x8::splat(Vec3::ZERO);
        let mut sorted = Sorted::new();
        assert!(sorted.by_place(&rays));
        let mut all = sorted.rays().to_vec();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..RAYS as u16));
    }

    #[test]
    fn an_octahedron_folds_out_to_a_square() {
        let octahedron = Octahedron::toward([0.1, -0.9, 0.3]);
        let places = |v: Vec3| {
            let [a, b] = octahedron.places8(&packets(&[[v; LANES]])[0]);
            [a.as_array()[0], b.as_array()[0]]
        };
        assert_eq!(places(Vec3::NEG_Y), [0.0, 0.0]);
        assert_eq!(places(Vec3::Z), [1.0, 0.0]);
        assert_eq!(places(Vec3::NEG_X), [0.0, -1.0]);
        assert_eq!(places(Vec3::Y).map(f32::abs), [1.0, 1.0]);
        // The fold is no jump.
        let [before, behind] = [-1e-4, 1e-4].map(|y| places(Vec3::new(0.6, y, 0.8)));
        for (p, q) in before.into_iter().zip(behind) {
            assert!((p - q).abs() < 1e-3, "{before:?} {behind:?}");
        }
    }

    #[test]
    fn effort_counts_for_each_ray() {
        let high = |rays: usize, packets, alone| {
            let mut effort = Effort::default();
            effort.add(rays / 2, packets, 0);
            effort.add(rays / 2, 0, alone);
            effort.is_high()
        };
        assert!(!Effort::default().is_high());
        assert!(!high(1000, 500, 0));
        assert!(high(1000, 501, 0));
        assert!(!high(1000, 20, 60));
        assert!(high(1000, 20, 61));
    }

    #[test]
    fn rays_that_agree_stay_where_they_are() {
        assert!(!Sorted::new().by_direction(&packets(&[[Vec3::X; LANES], [Vec3::Y; LANES]])));
    }
}
