//! Rays in order of their directions, so that bundles hold rays that go the same way (Boulos et al., *Adaptive Ray Packet
//! Reordering*, 2008).
//!
//! Mirrors reflect neighbouring rays to neighbouring places; leaves and folds of curtains do not, and there the rays of a
//! bundle have little in common. A counting sort of a few thousand rays by where they go through a cube map took the
//! mirror rays of the interior from 8.4 to 9.9 Mrays/s, sorting included (11.3 without); where packets agree, or the
//! rays are scattered all the same, it is left out. (Tried: whole packets by the direction of one of their rays, which
//! moves no rays: no gain. Finer squares, or order by origin: slower. Rays that enter a subtree few a packet put together
//! into full packets for it: -4 to +2 %.)

use crate::{
    ray::RayPacket,
    simd::{F32x8, LANES, ge, gt, lt, max, min, splat, truncate},
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

/// Memory for sorting.
#[derive(Debug, Default)]
pub(super) struct Sorted {
    squares: Box<[[u8; LANES]]>,
    order: Box<[u16]>,
    count: usize,
}

impl Sorted {
    pub fn new() -> Self {
        Self {
            squares: Box::new([[0; LANES]; PACKETS]),
            order: Box::new([0; RAYS]),
            count: 0,
        }
    }

    /// Sorts up to [`PACKETS`] packets; `false` if that would not pay.
    #[inline(never)]
    pub fn by_direction(&mut self, rays: &[RayPacket]) -> bool {
        let asked = rays.iter().step_by(ASKED);
        let mixed = asked.clone().filter(|rays| is_mixed(rays)).count();
        if mixed * MIXED < asked.len() {
            return false;
        }
        // Where a square's rays begin; those without a ray come last, and are left out.
        let mut starts = [0_u32; SQUARES + 2];
        for (squares, rays) in self.squares.iter_mut().zip(rays) {
            let live8 = gt(rays.t_max, splat(0.0));
            let squares8 = truncate(live8.select(squares8(rays), splat(SQUARES as f32)));
            for (square, of) in squares.iter_mut().zip(squares8) {
                *square = of as u8;
                starts[of as usize % (SQUARES + 1) + 1] += 1;
            }
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        self.count = starts[SQUARES] as usize;
        for (packet, squares) in self.squares.iter().take(rays.len()).enumerate() {
            for (lane, &square) in squares.iter().enumerate() {
                let start = &mut starts[usize::from(square)];
                self.order[*start as usize % RAYS] = (packet * LANES + lane) as u16;
                *start += 1;
            }
        }
        true
    }

    /// Packet times eight plus lane of the rays there are, those of a square together, neighbours as neighbours.
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

    #[test]
    fn rays_that_agree_stay_where_they_are() {
        assert!(!Sorted::new().by_direction(&packets(&[[Vec3::X; LANES], [Vec3::Y; LANES]])));
    }
}
