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
    for from in UpAxis::ALL {
        for to in UpAxis::ALL {
            let turn = turn(from, to);
            assert_eq!(turn * from.vector(), to.vector());
            assert_eq!(turn.determinant(), 1.0);
            assert_eq!(turn * turn.transpose(), DMat3::IDENTITY);
            assert_eq!(turn * from.front(), to.front());
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
        let first = nearest(first);
        // All the way round.
        let mut axis = first;
        for name in expected.into_iter().chain([first.name()]) {
            axis = next(axis, first);
            assert_eq!(axis.name(), name);
        }
    }
}

#[test]
fn the_nearest_axis_has_the_sign_of_the_direction() {
    assert_eq!(nearest(DVec3::new(0.1, -0.9, 0.2)).name(), "-y");
    assert_eq!(nearest(DVec3::new(0.1, 0.3, 0.4)).vector(), DVec3::Z);
}

#[test]
fn sides_look_from_around_above_and_below() {
    for (direction, axis) in DIRECTIONS.into_iter().zip(UpAxis::ALL) {
        assert_eq!(nearest(direction), axis);
        // `--from front` and the key 1 show the same.
        assert_eq!([side(axis, 0), side(axis, 1)], [axis.front(), axis.right()]);
        let heights: Vec<f64> = (0..6).map(|i| side(axis, i).dot(direction)).collect();
        assert_eq!(heights[..4], [0.0; 4]);
        assert!(heights[4] > 0.999 && heights[5] < -0.999);
        // Seen from above, front, right, back and left follow each other anticlockwise.
        for i in 0..4 {
            let cross = side(axis, i).cross(side(axis, (i + 1) % 4));
            assert_eq!(cross, direction);
        }
    }
}
