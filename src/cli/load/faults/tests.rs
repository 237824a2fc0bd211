//! Tests of `faults`.

use super::*;
use glam::Vec3;

#[test]
fn only_coarse_coordinates_are_warned_of() {
    for (center, radius, step) in [
        ([448_262.0, 5_411_933.0, 275.0], 1.0, Some("steps of 0.5,")),
        ([0.0, -100_000.0, 0.0], 10.0, Some("steps of 0.0078125,")),
        ([100_000.0, 0.0, 0.0], 100.0, None),
        ([0.0; 3], 1e-6, None),
    ] {
        let center = Vec3::from(center);
        let bounds = Aabb {
            lower: center - radius,
            upper: center + radius,
        };
        let warning = coarse(Path::new("a.ply"), &bounds);
        assert_eq!(warning.is_some(), step.is_some(), "{warning:?}");
        assert!(step.is_none_or(|step| warning.is_some_and(|warning| warning.contains(step))));
    }
}
