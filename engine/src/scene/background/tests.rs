//! Tests of `background`.

use super::*;

#[test]
fn one_colour_is_exact_in_every_direction() {
    let background = Background::constant([1.0, 0.3, 0.0]);
    for direction in [Vec3::Z, -Vec3::Z, Vec3::new(0.6, 0.0, 0.8)] {
        assert_eq!(background.color(direction), [1.0, 0.3, 0.0]);
    }
}

#[test]
fn a_gradient_runs_from_below_to_above() {
    let background = Background {
        bottom: [0.0, 1.0, 0.25],
        top: [1.0, 0.0, 0.75],
    };
    assert_eq!(background.color(-Vec3::Z), [0.0, 1.0, 0.25]);
    assert_eq!(background.color(Vec3::X), [0.5, 0.5, 0.5]);
    assert_eq!(background.color(Vec3::Z), [1.0, 0.0, 0.75]);
}
