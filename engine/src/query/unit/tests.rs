//! Tests of `unit`.

use super::*;
use glam::Vec3;

/// Any length and end, the extremes too: what is nearer than an end is reported as nearer, what is not is not.
#[test]
fn ends_are_exact() {
    let mut random = fastrand::Rng::with_seed(3);
    for _ in 0..200_000 {
        let length = f64::from(f32::from_bits(random.u32(0x0080_0000..0x7f80_0000)));
        let t = match random.u32(0..20) {
            0 => f32::MAX,
            1 => f32::INFINITY,
            _ => f32::from_bits(random.u32(0..=0x7f80_0000)),
        };
        // Lengths of unit vectors, and middles that are almost distances.
        let length = match random.u32(0..4) {
            0 => 1.0 + f64::from(random.i32(-100..100)) * f64::EPSILON,
            1 => f64::from(f32::from_bits(random.u32(0x3f80_0000..0x4000_0000))),
            _ => length,
        };
        let (start, end) = (start_of(t, length), end_of(t, length));
        let is_open = t.is_infinite() && length >= 0.5;
        assert!(
            t == 0.0 || is_open || end == searched_end(t, length),
            "{t:e} {length:e}"
        );
        assert!(end == 0.0 || reported(end, length) >= t || end == T_MAX);
        assert!(end == 0.0 || reported(end.next_down(), length) < t || is_open);
        if t > 0.0 && t < T_MAX {
            assert!(reported(start, length) <= t, "{t:e} {length:e}");
            assert!(start.next_up() == T_MAX || reported(start.next_up(), length) > t);
        }
    }
}

#[test]
fn directions_of_any_length_are_made_unit_vectors() {
    for scale in [1e-300, 1e-160, 1e-30, 0.1, 1.0, 3.0, 1e30, 1e160, 1e300] {
        let unit = UnitRay::of(
            DVec3::ZERO,
            DVec3::new(3.0, 0.0, -4.0) * scale,
            [0.0, f32::INFINITY],
        );
        assert!((unit.ray.direction - Vec3::new(0.6, 0.0, -0.8)).length() < 1e-6);
        assert!((unit.length / (5.0 * scale) - 1.0).abs() < 1e-12);
    }
    for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert!(!UnitRay::of(DVec3::ZERO, direction, [0.0, 1.0]).ray.is_valid());
    }
}
