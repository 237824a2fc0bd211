//! Points of the two-dimensional Sobol' sequence, scrambled by hashes: Burley, *Practical Hash-based Owen Scrambling*,
//! JCGT 2020.
//!
//! Every pair of dimensions (the place in the pixel, the point on a light, a direction) has a sequence of its own, padded
//! as there: the first points of any of them fill the square evenly, and those of different pairs are independent.

/// Hashes 32 bits bijectively, by two rounds of multiply and xorshift.
#[inline(always)]
pub(crate) fn hash(mut bits: u32) -> u32 {
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
pub(crate) fn unit(bits: u32) -> f32 {
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

/// Returns point `index`, in the unit square, of a pixel's sequence number `pair`.
#[inline(always)]
pub(crate) fn point(pixel: u32, pair: u32, index: u32) -> [f32; 2] {
    let seed = hash(pixel ^ hash(pair));
    let index = scrambled(index.reverse_bits(), seed);
    let (first, other) = (hash(seed ^ 0x5bd1_e995), hash(seed ^ 0x9e37_79b9));
    [
        unit(scrambled(index, first)),
        unit(scrambled(second(index), other)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_second_dimension_is_pascals_triangle() {
        for index in (0..1000).chain([u32::MAX, 1 << 31, 0xdead_beef]) {
            // Column i of the generator matrix is row i of the triangle modulo 2: 1, 11, 101, 1111, ...
            let (mut column, mut point) = (1_u32, 0);
            for i in 0..32 {
                point ^= if index >> i & 1 == 1 { column } else { 0 };
                column ^= column << 1;
            }
            assert_eq!(second(index), point, "{index}");
        }
    }

    #[test]
    fn the_first_points_of_each_pair_fill_the_square() {
        for (pixel, pair) in [(0, 0), (0, 1), (77, 5), (u32::MAX, 3)] {
            let points: Vec<_> = (0..64).map(|i| point(pixel, pair, i)).collect();
            for (columns, rows) in [(64, 1), (16, 4), (8, 8), (2, 32), (1, 64)] {
                let cell = |p: &[f32; 2]| ((p[0] * columns as f32) as u32, (p[1] * rows as f32) as u32);
                let cells: BTreeSet<_> = points.iter().map(cell).collect();
                assert_eq!(cells.len(), 64, "{columns} x {rows}");
            }
        }
    }

    #[test]
    fn pairs_are_independent() {
        // The mean of the products of coordinates of two pairs, over pixels: that of independent ones is 1/4.
        let products = (0..20_000).map(|pixel| {
            let [a, _] = point(hash(pixel), 1, 0);
            let [b, _] = point(hash(pixel), 2, 0);
            f64::from(a * b)
        });
        let mean = products.sum::<f64>() / 20_000.0;
        assert!((mean - 0.25).abs() < 0.006, "{mean}");
    }
}
