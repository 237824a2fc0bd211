//! Fused multiply-add where the CPU has none: the same bits, by `f64`.
//!
//! The product of two `f32` is exact in `f64`. Its sum with the third number is rounded to odd, so that rounding it again
//! to `f32` gives the correctly rounded result: Boldo and Melquiond, *Emulation of a FMA and correctly
//! rounded sums: proved algorithms using rounding to odd*, IEEE Transactions on Computers 57(4) 2008.

/// Whether every CPU of this build has fused multiply-add, so that the compiler uses it.
pub const IS_COMPILED_IN: bool = cfg!(any(
    target_feature = "fma",
    all(target_arch = "aarch64", target_feature = "neon")
));

/// Returns `a * b + c`, rounded once.
#[inline(always)]
#[must_use]
pub fn mul_add(a: f32, b: f32, c: f32) -> f32 {
    if IS_COMPILED_IN {
        a.mul_add(b, c)
    } else {
        emulated_apart(a, b, c)
    }
}

/// Not inlined, because it is several times the code of a call and used throughout the scalar reference.
#[inline(never)]
fn emulated_apart(a: f32, b: f32, c: f32) -> f32 {
    emulated(a, b, c)
}

/// [`mul_add`] by `f64`.
#[inline(always)]
pub fn emulated(a: f32, b: f32, c: f32) -> f32 {
    let (product, c) = (f64::from(a) * f64::from(b), f64::from(c));
    let sum = product + c;
    // The rounding error of the sum (Knuth); NaN, which is ignored, if the sum is not finite.
    let part = sum - product;
    let error = (product - (sum - part)) + (c - part);
    let is_inexact = u64::from(error.abs() > 0.0);
    // Towards 0 where it was rounded away from it, then to the odd one of its two neighbours.
    let is_beyond = ((sum.to_bits() ^ error.to_bits()) >> 63) & is_inexact;
    f64::from_bits((sum.to_bits() - is_beyond) | is_inexact) as f32
}

#[cfg(test)]
mod tests {
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
}
