//! Tests of `benchmark`.

use super::*;

#[test]
fn frames_become_figures() {
    let start = Instant::now();
    let mut benchmark = Benchmark::new(Duration::from_secs(1), start);
    for i in 0..=200_u32 {
        let picture = Picture {
            full: i % 4 != 0,
            rays: 1_000_000,
            elapsed: Duration::from_millis(5),
            ..Picture::default()
        };
        let now = start + Duration::from_millis(10) * i;
        benchmark.shown(&picture, now);
        assert_eq!(benchmark.is_over(now), i >= 150);
        assert_eq!(benchmark.report().is_some(), i > 50);
    }
    let report = benchmark.report().unwrap();
    assert!((report.fps - 100.0).abs() < 1e-6, "{report:?}");
    assert!((report.frame_ms_p50 - 10.0).abs() < 1e-6 && (report.frame_ms_p99 - 10.0).abs() < 1e-6);
    assert!((report.mrays_per_s - 200.0).abs() < 1e-6);
    assert!((report.full_quality_share - 0.75).abs() < 0.01);
}
