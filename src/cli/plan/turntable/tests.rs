use super::*;
use crate::scene::{Lens, Projection};
use glam::DVec3;

#[test]
fn a_quarter_turn_goes_counterclockwise() {
    let view = View {
        eye: DVec3::new(3.0, 0.0, 2.0),
        target: DVec3::new(1.0, 0.0, 0.0),
        up: DVec3::new(0.0, 0.0, 4.0),
        projection: Projection::DEFAULT,
        lens: Lens::PINHOLE,
    };
    assert_eq!(turned(&view, Turn { number: 1, count: 4 }), view);
    let second = turned(&view, Turn { number: 2, count: 4 });
    assert!(
        (second.eye - DVec3::new(1.0, 2.0, 2.0)).length() < 1e-12,
        "{second:?}"
    );
    assert_eq!((second.target, second.up), (view.target, view.up));
}

#[test]
fn a_sphere_is_seen_from_all_sides() {
    let eye = DVec3::new(1.0, 2.0, 4.0);
    let (up, target) = (DVec3::new(0.0, 0.0, 2.0), DVec3::new(1.0, 2.0, 2.0));
    let view = View {
        eye,
        target,
        up,
        projection: Projection::DEFAULT,
        lens: Lens::PINHOLE,
    };
    for count in [1, 2, 3, 100, 10_000] {
        let views = (1..=count).map(|number| Orbit::Sphere.view(&view, Turn { number, count }));
        let mut sum = DVec3::ZERO;
        for view in views {
            let arm = view.eye - view.target;
            assert!((arm.length() - 2.0).abs() < 1e-9);
            assert!(arm.cross(up).length() > 0.0 && view.up == up);
            sum += arm / f64::from(count);
        }
        assert!(
            count < 3 || sum.length() < 0.5 / f64::from(count).sqrt(),
            "{count}: {sum}"
        );
    }
}

#[test]
fn the_distance_stays() {
    let mut random = fastrand::Rng::new();
    for _ in 0..256 {
        let [x, y] = [(); 2].map(|()| 18.0 * random.f64() - 9.0);
        let eye = DVec3::new(x, y, 1.0 + 8.0 * random.f64());
        let number = random.u32(1..=24);
        let view = View {
            eye,
            target: DVec3::ZERO,
            up: DVec3::new(0.3, -0.2, 1.0),
            projection: Projection::DEFAULT,
            lens: Lens::PINHOLE,
        };
        let turned = turned(&view, Turn { number, count: 24 }).eye;
        assert!((turned.length() - eye.length()).abs() < 1e-9, "{eye}, {number}");
        assert!(
            (turned.dot(view.up) - eye.dot(view.up)).abs() < 1e-9,
            "{eye}, {number}"
        );
    }
}
