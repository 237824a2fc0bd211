use super::*;

#[test]
fn means_are_those_of_many_points() {
    for (at, width) in [
        (0.3, 0.2),
        (0.9, 0.5),
        (-0.1, 0.7),
        (-7.3, 3.1),
        (1e6 + 0.2, 1.3),
        (5.5, 40.3),
    ] {
        const COUNT: u32 = 100_000;
        let sum: f64 = (0..COUNT)
            .map(|i| at + width * ((f64::from(i) + 0.5) / f64::from(COUNT) - 0.5))
            .map(|at| mean(at, 0.0))
            .sum();
        let found = mean(at, width);
        assert!(
            (found - sum / f64::from(COUNT)).abs() < 1e-4,
            "{at} {width}: {found}"
        );
    }
    for (at, width) in [
        (f64::NAN, 1.0),
        (0.5, f64::NAN),
        (0.5, f64::INFINITY),
        (f64::INFINITY, 0.0),
    ] {
        assert_eq!(mean(at, width), 0.0);
    }
}

const CHECKER: Checker = Checker {
    colors: [[1.0, 0.5, 0.0], [0.0, 0.5, 1.0]],
    size: 0.25,
};

#[test]
fn cells_alternate_along_every_axis() {
    for i in -3..4_i32 {
        for axis in 0..3 {
            let mut point = DVec3::new(0.1, 0.05, 0.2);
            point[axis] += 0.25 * f64::from(i);
            let color = CHECKER.color(point, Vec3::Z, Vec3::new(0.0, 0.6, -0.8), 0.0);
            assert_eq!(
                color,
                CHECKER.colors[usize::from(i.rem_euclid(2) == 1)],
                "{i} {axis}"
            );
        }
    }
}

/// On a face between two layers rounding changes nothing, from either side.
#[test]
fn faces_between_cells_show_one_of_them() {
    for normal in [Vec3::Z, Vec3::NEG_Z] {
        for z in [0.75 - 1e-8, 0.75, 0.75 + 1e-8] {
            let color = CHECKER.color(DVec3::new(0.1, 0.1, z), normal, -normal, 1e-9);
            assert_eq!(color, CHECKER.colors[1]);
        }
    }
}

#[test]
fn far_away_there_is_the_mean() {
    let grazing = Vec3::new(1.0, 0.0, -1e-4).normalize();
    for (direction, width) in [(grazing, 0.01), (Vec3::X, 0.01), (Vec3::NEG_Z, 100.0)] {
        let color = CHECKER.color(DVec3::new(3.1, 0.125, 0.0), Vec3::Z, direction, width);
        assert!(color.iter().all(|c| (c - 0.5).abs() < 0.01), "{color:?}");
    }
}
