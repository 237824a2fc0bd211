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
mod tests;
