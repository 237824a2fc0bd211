//! Exact signs of determinants, by sums without rounding.

use super::expansion::Expansion;
use glam::Vec3;

/// A point (last number 1) or a direction (0).
pub(crate) type Row = [f64; 4];

pub(crate) fn point(p: Vec3) -> Row {
    [f64::from(p.x), f64::from(p.y), f64::from(p.z), 1.0]
}

/// The even permutations of four columns. With the first two rows exchanged they are the odd ones.
const EVEN: [[usize; 4]; 12] = [
    [0, 1, 2, 3],
    [0, 2, 3, 1],
    [0, 3, 1, 2],
    [1, 0, 3, 2],
    [1, 2, 0, 3],
    [1, 3, 2, 0],
    [2, 0, 1, 3],
    [2, 1, 3, 0],
    [2, 3, 0, 1],
    [3, 0, 2, 1],
    [3, 1, 0, 2],
    [3, 2, 1, 0],
];

/// More than the rounding of 24 products and their sum, as a fraction of the sum of their magnitudes.
const ROUNDING: f64 = 32.0 / (1_u64 << 53) as f64;

/// Returns a number with the sign of the determinant of four rows of `f32` numbers: of four points, the side of the plane
/// through three on which the fourth is.
pub(crate) fn sign(rows: [Row; 4]) -> f64 {
    let (mut sum, mut magnitude) = (0.0, 0.0);
    for_each_product(&rows, |x, y| {
        sum += x * y;
        magnitude += (x * y).abs();
    });
    if sum.abs() > magnitude * ROUNDING {
        return sum;
    }
    let mut exact = Expansion::default();
    for_each_product(&rows, |x, y| {
        let product = x * y;
        exact.add(product);
        // The rounding error of the product is itself representable.
        exact.add(x.mul_add(y, -product));
    });
    exact.sign()
}

/// Calls `add` with two factors of each of the 24 products. The first factor is exact: a product of two `f32` numbers.
fn for_each_product(rows: &[Row; 4], mut add: impl FnMut(f64, f64)) {
    for [i, j, k, l] in EVEN {
        let factors = [rows[0][i], rows[1][j], rows[2][k], rows[3][l]];
        let (x, y) = halves(factors, [i, j, k, l]);
        add(x, y);
        let factors = [rows[1][i], rows[0][j], rows[2][k], rows[3][l]];
        let (x, y) = halves(factors, [i, j, k, l]);
        add(-x, y);
    }
}

/// Four factors as two. That of the last column is 1 or 0, and goes with two others.
fn halves(factors: [f64; 4], columns: [usize; 4]) -> (f64, f64) {
    let last = columns.iter().position(|&column| column == 3).unwrap_or(3);
    let [a, b, c] = match last {
        0 => [factors[1], factors[2], factors[3]],
        1 => [factors[0], factors[2], factors[3]],
        2 => [factors[0], factors[1], factors[3]],
        _ => [factors[0], factors[1], factors[2]],
    };
    (a * b * factors[last], c)
}
