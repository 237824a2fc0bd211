use super::*;

const DIRECTIONS: [DVec3; 6] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::NEG_X,
    DVec3::NEG_Y,
    DVec3::NEG_Z,
];

#[test]
fn turns_are_rotations_from_axis_to_axis() {
    for from in DIRECTIONS.map(Axis::nearest) {
        for to in DIRECTIONS.map(Axis::nearest) {
            let turn = from.turn_to(to);
            assert_eq!(turn * from.vector(), to.vector());
            assert_eq!(turn.determinant(), 1.0);
            assert_eq!(turn * turn.transpose(), DMat3::IDENTITY);
            assert_eq!(turn * from.side(0), to.side(0));
        }
    }
}

#[test]
fn up_cycles_through_all_axes() {
    for (first, expected) in [
        (DVec3::Y, ["z", "x", "-y", "-z", "-x"]),
        (DVec3::Z, ["y", "x", "-z", "-y", "-x"]),
        (DVec3::X, ["y", "z", "-x", "-y", "-z"]),
        (DVec3::NEG_Y, ["z", "x", "y", "-z", "-x"]),
    ] {
        let first = Axis::nearest(first);
        let names: Vec<&str> = first.next(first).map(Axis::name).collect();
        assert_eq!(names, expected);
        // One by one, all the way round.
        let mut axis = first;
        for name in expected.into_iter().chain([first.name()]) {
            axis = axis.next(first).next().unwrap();
            assert_eq!(axis.name(), name);
        }
    }
}

#[test]
fn the_nearest_axis_has_the_sign_of_the_direction() {
    assert_eq!(Axis::nearest(DVec3::new(0.1, -0.9, 0.2)).name(), "-y");
    assert_eq!(Axis::nearest(DVec3::new(0.1, 0.3, 0.4)).vector(), DVec3::Z);
}

#[test]
fn sides_look_from_around_above_and_below() {
    for up in DIRECTIONS {
        let axis = Axis::nearest(up);
        let heights: Vec<f64> = (0..6).map(|side| axis.side(side).dot(up)).collect();
        assert_eq!(heights[..4], [0.0; 4]);
        assert!(heights[4] > 0.999 && heights[5] < -0.999);
        // Seen from above, front, right, back and left follow each other anticlockwise.
        for side in 0..4 {
            let cross = axis.side(side).cross(axis.side((side + 1) % 4));
            assert_eq!(cross, up);
        }
    }
}
