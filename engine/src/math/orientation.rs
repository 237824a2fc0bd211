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

/// More than the rounding of 24 products of three and of their sum, as a fraction of the sum of their magnitudes.
const ROUNDING: f64 = 32.0 / (1_u64 << 53) as f64;

/// Returns a number with the sign of the determinant of four rows: of four points, the side of the plane through three on
/// which the fourth is. Exact unless products of three numbers underflow or overflow.
pub(crate) fn sign(rows: [Row; 4]) -> f64 {
    let (mut sum, mut magnitude) = (0.0, 0.0);
    for_each_product(&rows, |[a, b, c]| {
        let product = a * b * c;
        sum += product;
        magnitude += product.abs();
    });
    if sum.abs() > magnitude * ROUNDING {
        return sum;
    }
    let mut exact = Expansion::default();
    for_each_product(&rows, |[a, b, c]| {
        // The rounding error of a product of two is itself representable.
        let ab = a * b;
        for factor in [ab, a.mul_add(b, -ab)] {
            let product = factor * c;
            exact.add(product);
            exact.add(factor.mul_add(c, -product));
        }
    });
    exact.sign()
}

/// Calls `add` with the factors of each of the 24 products.
fn for_each_product(rows: &[Row; 4], mut add: impl FnMut([f64; 3])) {
    for [i, j, k, l] in EVEN {
        add(three(
            [rows[0][i], rows[1][j], rows[2][k], rows[3][l]],
            [i, j, k, l],
        ));
        let [a, b, c] = three([rows[1][i], rows[0][j], rows[2][k], rows[3][l]], [i, j, k, l]);
        add([-a, b, c]);
    }
}

/// Four factors as three: that of the last column is 1 or 0, and goes with another.
fn three(factors: [f64; 4], columns: [usize; 4]) -> [f64; 3] {
    let last = columns.iter().position(|&column| column == 3).unwrap_or(3);
    let [a, b, c] = match last {
        0 => [factors[1], factors[2], factors[3]],
        1 => [factors[0], factors[2], factors[3]],
        2 => [factors[0], factors[1], factors[3]],
        _ => [factors[0], factors[1], factors[2]],
    };
    [a * factors[last], b, c]
}
