use crate::scene::distortion::{Distortion, Inverse};

#[test]
fn slopes_of_distorted_directions_are_derivatives() {
    let brown = Distortion::Perspective {
        radial: [0.1, -0.02, 0.0, 0.0],
        divisor: [0.05, 0.0, 0.0],
        tangential: [0.01, -0.02],
    };
    let fisheye = Distortion::Fisheye {
        radial: [0.05, -0.01, 0.0, 0.0],
    };
    for (distortion, point) in [
        (brown, [0.3, -0.2]),
        (brown, [0.0; 2]),
        (fisheye, [-0.4, 1.9]),
        (fisheye, [0.0; 2]),
    ] {
        let inverse = Inverse::new(distortion).unwrap();
        let seen = |[x, y]: [f64; 2]| {
            let [direction] = inverse.directions(&[[x], [y]]);
            if distortion == brown {
                direction / direction.z
            } else {
                direction
            }
        };
        let ([x, y], step) = (point, 1e-5);
        let [found_x, found_y] = inverse.slopes(seen(point));
        let by_x = (seen([x + step, y]) - seen([x - step, y])) / (2.0 * step);
        let by_y = (seen([x, y + step]) - seen([x, y - step])) / (2.0 * step);
        let error = (found_x - by_x).length().max((found_y - by_y).length());
        assert!(error < 1e-8, "{distortion:?} {point:?}: {error}");
    }
}
