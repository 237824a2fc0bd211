//! Points of the two-dimensional Sobol' sequence, scrambled by hashes: Burley, *Practical Hash-based Owen Scrambling*,
//! JCGT 2020.
//!
//! Each pair of dimensions (a point on a light, a direction) has its own sequence, independent of the others (padding).
//! A pixel takes consecutive points, from an index given by its position on a Z-order curve through the picture (Ahmed and
//! Wonka, *Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels*, 2020). So
//! the points of a pixel fill the square evenly, and so do those of a block of pixels together: errors of neighbours
//! cancel, and noise is fine-grained.

/// Hashes 32 bits bijectively, by two rounds of multiply and xorshift.
#[inline(always)]
#[doc(hidden)]
pub fn hash(mut bits: u32) -> u32 {
    bits = (bits ^ bits >> 16).wrapping_mul(0x7feb_352d);
    bits = (bits ^ bits >> 15).wrapping_mul(0x846c_a68b);
    bits ^ bits >> 16
}

/// Returns the seed of a pixel, by its absolute column and row.
#[inline(always)]
pub(crate) fn seed_of([x, y]: [u32; 2]) -> u32 {
    hash(x.wrapping_add(hash(y.wrapping_add(0x9e37_79b9))))
}

/// Maps 32 bits to [0, 1).
#[inline(always)]
#[doc(hidden)]
pub fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// Returns the second dimension of point `index`, bit-reversed. (The first is the index itself.)
///
/// Bit j is the sum, modulo 2, of the bits of `index` whose binomial coefficient over j is odd: those whose number has
/// all bits of j (Lucas). One step sums over one bit of that number.
#[inline(always)]
pub(crate) fn second(index: u32) -> u32 {
    let mut point = index;
    point ^= point >> 1 & 0x5555_5555;
    point ^= point >> 2 & 0x3333_3333;
    point ^= point >> 4 & 0x0f0f_0f0f;
    point ^= point >> 8 & 0x00ff_00ff;
    point ^ point >> 16
}

/// Owen-scrambles a bit-reversed point: a hash of the preceding bits flips each bit (Laine and Karras 2011, constants by
/// Burley).
#[inline(always)]
pub(crate) fn scrambled(mut reversed: u32, seed: u32) -> u32 {
    reversed = reversed.wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        reversed ^= reversed.wrapping_mul(factor);
    }
    reversed.reverse_bits()
}

/// Returns the index of a pixel's first point, by its absolute column and row and the points per pixel.
#[inline(always)]
pub(crate) fn first_point([x, y]: [u32; 2], count: u32) -> u32 {
    (spread(x) | spread(y) << 1).wrapping_mul(count)
}

/// Spreads the lower sixteen bits, with a 0 between them. (Further columns and rows repeat the noise of the first.)
#[inline(always)]
fn spread(bits: u32) -> u32 {
    let bits = bits & 0xffff;
    let bits = (bits | bits << 8) & 0x00ff_00ff;
    let bits = (bits | bits << 4) & 0x0f0f_0f0f;
    let bits = (bits | bits << 2) & 0x3333_3333;
    (bits | bits << 1) & 0x5555_5555
}

/// Returns a point of the sequence of a pair of dimensions, in the unit square.
#[inline(always)]
pub(crate) fn point(pair: u32, index: u32) -> [f32; 2] {
    let seed = hash(pair ^ 0x9e37_79b9);
    let index = scrambled(index.reverse_bits(), seed);
    let (first, other) = (hash(seed ^ 0x5bd1_e995), hash(seed ^ 0x85eb_ca6b));
    [
        unit(scrambled(index, first)),
        unit(scrambled(second(index), other)),
    ]
}

#[cfg(test)]
mod tests;
