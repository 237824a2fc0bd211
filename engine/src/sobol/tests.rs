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
fn blocks_of_pixels_fill_the_square() {
    for pair in [0, 1, 77, u32::MAX] {
        for [x, y] in [[0, 0], [4, 8], [1020, 512]] {
            for side in [1, 2, 4] {
                let pixels = (y..y + side).flat_map(|y| (x..x + side).map(move |x| [x, y]));
                let points = pixels.flat_map(|pixel| {
                    let first = first_point(pixel, 4);
                    (0..4).map(move |i| point(pair, first + i))
                });
                let points: Vec<_> = points.collect();
                let count = 4 * side * side;
                for columns in [1, 2, count / 2, count] {
                    let rows = count / columns;
                    let cell = |[x, y]: &[f32; 2]| ((x * columns as f32) as u32, (y * rows as f32) as u32);
                    let cells: BTreeSet<_> = points.iter().map(cell).collect();
                    assert_eq!(cells.len(), count as usize, "{columns} x {rows}");
                }
            }
        }
    }
}

#[test]
fn pixels_have_points_of_their_own() {
    let pixels = (0..64).flat_map(|y| (0..64).map(move |x| [x, y]));
    let mut firsts: Vec<u32> = pixels.map(|pixel| first_point(pixel, 5)).collect();
    firsts.sort_unstable();
    assert!(firsts.into_iter().eq((0..64 * 64).map(|i| i * 5)));
}

#[test]
fn pairs_are_independent() {
    // The mean of the products of coordinates of two pairs: that of independent ones is 1/4.
    for [a, b] in [[0, 1], [1, 2], [3, 7]] {
        let products = (0..20_000).map(|i| f64::from(point(a, i)[0] * point(b, i)[0]));
        let mean = products.sum::<f64>() / 20_000.0;
        assert!((mean - 0.25).abs() < 0.006, "{mean}");
    }
}
