//! Tests of `fused`.

use super::emulated;

/// A number of any magnitude and kind, with few or many bits, often near a power of two.
fn number(random: &mut fastrand::Rng) -> f32 {
    let bits = random.u32(..);
    match random.u32(..8) {
        // Few bits in front, or all but a few at the end.
        0 => f32::from_bits(bits & 0xffc0_0000),
        1 => f32::from_bits(bits | 0x003f_fff0),
        // Subnormal, or nearly.
        2 => f32::from_bits(bits & 0x80ff_ffff),
        // From 2^-20 to 2^20.
        3 | 4 => f32::from_bits((bits & 0x807f_ffff) | (107 + random.u32(..40)) << 23),
        5 => [
            0.0,
            -0.0,
            1.0,
            f32::MAX,
            f32::MIN_POSITIVE,
            f32::INFINITY,
            f32::NAN,
            1e-45,
        ][random.usize(..8)],
        _ => f32::from_bits(bits),
    }
}

/// Any sum, one that nearly cancels, or one at half of the product's last place.
fn triple(random: &mut fastrand::Rng) -> [f32; 3] {
    let (a, b) = (number(random), number(random));
    let product = a * b;
    let near = f32::from_bits(product.to_bits().wrapping_add(random.u32(..5)).wrapping_sub(2));
    let scale = 2_f32.powi(random.i32(-30..30));
    let c = match random.u32(..4) {
        0 => -near,
        1 => near * scale,
        2 => -near * scale,
        _ => number(random),
    };
    [a, b, c]
}

/// Ten million triples; a billion with `OCTRAY_LONG`.
#[test]
fn emulated_sums_are_those_of_the_processor() {
    let rounds = if std::env::var_os("OCTRAY_LONG").is_some() {
        1000
    } else {
        10
    };
    for seed in 0..rounds {
        let mut random = fastrand::Rng::with_seed(seed);
        for _ in 0..1_000_000 {
            let [a, b, c] = triple(&mut random);
            let (expected, found) = (a.mul_add(b, c), emulated(a, b, c));
            assert!(
                expected.to_bits() == found.to_bits() || expected.is_nan() && found.is_nan(),
                "{a:e} * {b:e} + {c:e}: {found:e}, not {expected:e}"
            );
        }
    }
}
