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

/// Of samples that show one colour, and of samples that hit nothing.
#[test]
fn half_covered_pixels_keep_their_level() {
    for samples in [2, 3, 4, 7, 16, 49, 256] {
        for covered in 1..samples {
            for level in 0..=255_u8 {
                let color = f32::from(level) / 255.0;
                let sum = |c: f32| (0..covered).fold(0.0, |sum: f32, _| sum + c) / samples as f32;
                let mut film = Film::<[f32; 4]>::black(1, 1);
                film.pixels_mut()[0] = [sum(color), 0.0, 0.0, sum(1.0)];
                let bytes = film.to_bytes(Transfer::Linear);
                assert_eq!(bytes[0], level, "{covered} of {samples}");
            }
        }
    }
    let bytes = |pixel| {
        let mut film = Film::<[f32; 4]>::black(1, 1);
        film.pixels_mut()[0] = pixel;
        film.to_bytes(Transfer::Linear)
    };
    assert_eq!(bytes([0.5, 0.2, 0.0, 0.0]), [127, 51, 0, 0]);
    assert_eq!(bytes([50.9999 / 255.0, 0.2, 0.0, 1.0]), [50, 51, 0, 255]);
    assert_eq!(bytes([25.4999 / 255.0, 0.9, -1.0, 0.5]), [50, 255, 0, 127]);
    assert_eq!(bytes([f32::NAN, 1e30, 0.0, 0.5])[1], 255);
}
