//! Tests of `transfer`.

use super::*;

#[test]
fn the_table_is_a_search() {
    let curve = srgb_curve();
    let check = |c: f32| {
        let expected = curve.steps.partition_point(|&step| step <= c);
        assert_eq!(usize::from(curve.encode(c)), expected, "{c:e}");
    };
    for &step in &curve.steps[..255] {
        [step.next_down(), step, step.next_up()]
            .into_iter()
            .for_each(check);
    }
    for i in 0..=INTERVALS as u32 {
        let lowest = f32::from_bits(LOWEST.to_bits() + (i << SHIFT));
        [lowest.next_down(), lowest, lowest.next_up()]
            .into_iter()
            .for_each(check);
    }
    // At most one step in an interval.
    let intervals = curve.bytes.windows(2);
    assert!(intervals.map(|pair| pair[1] - pair[0]).all(|steps| steps <= 1));
    [f32::NEG_INFINITY, -0.0, 0.0, 1e-40, 2.0, f32::MAX]
        .into_iter()
        .for_each(check);
}

#[test]
fn srgb_is_the_standards_curve() {
    let encode = |c: f32| Transfer::Srgb.encode([c; 3])[0];
    for (linear, byte) in [
        (-1.0, 0),
        (0.0, 0),
        (0.5, 188),
        (0.215_861, 128),
        (1.0, 255),
        (9.0, 255),
        (f32::NAN, 0),
    ] {
        assert_eq!(encode(linear), byte, "{linear}");
    }
    for byte in 0..=255 {
        assert_eq!(encode(decode(f64::from(byte) / 255.0) as f32), byte);
    }
    assert_eq!(Transfer::Linear.encode([0.5; 3]), [127; 3]);
}
