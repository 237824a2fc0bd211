//! Tests of `order`.

use super::*;
use crate::lanes::Vec3x8;

/// Pixels in an order, as packets.
fn packets(pixel: impl Fn(usize) -> [usize; 2]) -> Vec<RayPacket> {
    let direction = |i: usize| {
        let [x, y] = pixel(i);
        Vec3::new(x as f32 * 0.001 - 0.5, 1.0, y as f32 * 0.001 - 0.5).normalize()
    };
    (0..16_000 / LANES)
        .map(|i| RayPacket {
            direction: Vec3x8::from_lanes(std::array::from_fn(|lane| direction(i * LANES + lane))),
            t_max: F32x8::new(std::array::from_fn(|lane| (i * LANES + lane) as f32)),
        })
        .collect()
}

#[test]
fn rows_and_random_rays_are_sorted_and_put_back() {
    let rows = packets(|i| [i % 1000, i / 1000]);
    let random = packets(|i| [i * 7919 % 1000, i * 104_729 % 1009]);
    let tiles = packets(|i| [i / 256 * 16 + i % 16, i / 16 % 16]);
    let mut order = Order::default();
    assert!(!order.sort(Level::current(), &tiles) && !order.sort(Level::current(), &rows[..LEAST - 1]));
    for packets in [rows, random] {
        assert!(order.sort(Level::current(), &packets));
        assert!(!Order::default().sort(Level::current(), &order.packets));
        for (hits, packet) in order.hits.iter_mut().zip(&order.packets) {
            *hits = HitPacket::miss(packet.t_max);
        }
        let mut hits = vec![HitPacket::miss(F32x8::ZERO); packets.len()];
        order.put_back(&mut hits);
        for (hits, packet) in hits.iter().zip(&packets) {
            assert_eq!(hits.t.to_array(), packet.t_max.to_array());
        }
    }
}
