//! Tests of `z_order`.

use super::*;

#[test]
fn cells_follow_the_curve() {
    let corners: Vec<DVec3> = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
        .collect();
    let points: Vec<DVec3> = corners.iter().rev().copied().collect();
    let mut visited = Vec::new();
    in_z_order(8, |i| points[i], |i| visited.push(points[i]));
    assert_eq!(visited, corners);
    assert_eq!(spread(1023), 0x0924_9249);
}

#[test]
fn each_point_is_visited_once() {
    let odd = [f64::NAN, f64::INFINITY, f64::MAX, f64::MIN, 0.0, 1.0];
    for count in 0..odd.len() {
        let mut visited = Vec::new();
        in_z_order(count, |i| DVec3::splat(odd[i]), |i| visited.push(i));
        visited.sort_unstable();
        assert_eq!(visited, (0..count).collect::<Vec<_>>());
    }
}
