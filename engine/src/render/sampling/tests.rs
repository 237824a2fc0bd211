use super::*;

fn offsets(pattern: Pattern, filter: Filter, samples_per_axis: u32) -> SampleOffsets {
    SampleOffsets {
        pattern,
        filter,
        samples_per_axis,
        blackman_harris: inverse_blackman_harris(),
    }
}

fn points(offsets: &SampleOffsets, pixel: [u32; 2]) -> Vec<[f32; 2]> {
    let n = offsets.samples_per_axis;
    (0..n * n).map(|i| offsets.point(pixel, [i % n, i / n])).collect()
}

/// Counts the cells of a grid of `columns` x `rows` that contain points.
fn cells(points: &[[f32; 2]], columns: usize, rows: usize) -> usize {
    let cell = |p: &[f32; 2]| ((p[0] * columns as f32) as usize, (p[1] * rows as f32) as usize);
    points
        .iter()
        .map(cell)
        .collect::<std::collections::BTreeSet<_>>()
        .len()
}

#[test]
fn patterns_are_stratified() {
    for pixel in [[0, 0], [1, 0], [0, 1], [4095, 77]] {
        for pattern in [Pattern::Grid, Pattern::Stratified, Pattern::Sobol] {
            let points = points(&offsets(pattern, Filter::Box, 4), pixel);
            assert!(points.as_flattened().iter().all(|c| (0.0..1.0).contains(c)));
            assert_eq!(cells(&points, 4, 4), 16, "{pattern:?}");
            if pattern == Pattern::Sobol {
                for (columns, rows) in [(16, 1), (8, 2), (2, 8), (1, 16)] {
                    assert_eq!(cells(&points, columns, rows), 16, "{columns}x{rows}");
                }
            }
        }
    }
}

#[test]
fn every_pixel_has_different_points() {
    for pattern in [Pattern::Stratified, Pattern::Sobol] {
        let offsets = offsets(pattern, Filter::Box, 2);
        let mut seen: Vec<_> = (0..64)
            .flat_map(|i| points(&offsets, [i % 8, i / 8]))
            .map(|point| point.map(f32::to_bits))
            .collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 256, "{pattern:?}");
    }
}

#[test]
fn filters_have_their_variance() {
    // Variances in pixels: 1/12 for a box of width 1, 1/6 for a tent of radius 1.
    for (filter, reach, variance) in [
        (Filter::Box, 0.5, 1.0 / 12.0),
        (Filter::Tent, 1.0, 1.0 / 6.0),
        (Filter::BlackmanHarris, REACH, blackman_harris_variance()),
    ] {
        let offsets = offsets(Pattern::Grid, filter, 1);
        const COUNT: u32 = 10_000;
        let at = (0..COUNT).map(|i| (f64::from(i) + 0.5) / f64::from(COUNT));
        let warped: Vec<f64> = at.map(|at| f64::from(offsets.warp(at as f32)) * 0.5).collect();
        let mean = warped.iter().sum::<f64>() / f64::from(COUNT);
        let square = warped.iter().map(|o| o * o).sum::<f64>() / f64::from(COUNT);
        assert!(mean.abs() < 1e-4, "{filter:?}: {mean}");
        assert!(
            (square - variance).abs() < 2e-3,
            "{filter:?}: {square}, {variance}"
        );
        assert!(warped.iter().all(|o| o.abs() <= reach));
        assert!(warped.is_sorted());
    }
}

fn blackman_harris_variance() -> f64 {
    const COUNT: u32 = 10_000;
    (0..COUNT)
        .map(|i| {
            let [low, high] = [i, i + 1].map(|i| f64::from(i) / f64::from(COUNT));
            let offset = (low + high - 1.0) * REACH;
            offset * offset * (blackman_harris_integral(high) - blackman_harris_integral(low))
        })
        .sum()
}
