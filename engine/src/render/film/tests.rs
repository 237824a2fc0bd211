//! Tests of `film`.

use super::*;
use crate::{lanes::F32x8, simd::Portable};

#[test]
fn bytes_of_lanes_are_bytes_of_scalars() {
    let hundredths = (-150..350).map(|i| i as f32 / 100.0);
    let exact = (0..=255).map(|i| i as f32 / 255.0);
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, 1e-40, 1e9];
    for c in hundredths.chain(exact).chain(odd) {
        let rgb = [c, 1.0 - c, c * 0.5];
        let [r, g, b] = rgb.map(|c| Portable.splat(c));
        let lanes = <[u8; 3]>::from_lanes(Portable, [r, g, b, Portable.splat(1.0)]);
        assert_eq!(lanes, [<[u8; 3]>::from_linear(rgb, 1.0); LANES], "{rgb:?}");
    }
}

#[test]
fn lanes_become_pixels_in_their_order() {
    let byte = |i: usize| (i as f32 + 0.5) / 255.0;
    let channel = |c: usize| {
        let numbers = std::array::from_fn(|lane| byte(3 * lane + c));
        Portable.load(&F32x8::new(numbers))
    };
    let rgba = [channel(0), channel(1), channel(2), channel(0)];
    let lanes = <[u8; 3]>::from_lanes(Portable, rgba);
    let bytes: Vec<u8> = (0..3 * LANES as u8).collect();
    assert_eq!(lanes.as_flattened(), bytes);
}
