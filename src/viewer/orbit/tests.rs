use super::*;
use crate::{scene::Lens, viewer::pose::half_height};
use glam::Vec3;

/// A cube of that side around the origin.
fn cube(side: f32) -> Aabb {
    Aabb {
        lower: Vec3::splat(-0.5 * side),
        upper: Vec3::splat(0.5 * side),
    }
}

fn view(number: u32) -> Orbit {
    Orbit::new(Pose::classic_view(number).unwrap(), cube(2.0)).unwrap()
}

/// Parallel rays, a view of this height.
fn parallel(height: f64) -> Orbit {
    let pose = Pose {
        projection: Projection::Orthographic { height },
        ..view(1).pose()
    };
    Orbit::new(pose, cube(2.0)).unwrap()
}

fn spherical(orbit: &Orbit) -> [f64; 3] {
    let v = orbit.pose().eye - orbit.pose().target;
    let degrees = |radians: f64| radians.to_degrees();
    [
        degrees(v.y.atan2(v.x)),
        degrees((v.z / v.length()).asin()),
        v.length(),
    ]
}

fn assert_near(a: [f64; 3], b: [f64; 3]) {
    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
}

#[test]
fn it_begins_exactly_where_it_was_put() {
    for number in 1..=6 {
        assert_eq!(Some(view(number).camera()), Camera::classic_view(number));
    }
}

#[test]
fn a_pixel_is_a_quarter_of_a_degree() {
    for number in 1..=5 {
        let mut orbit = view(number);
        let before = spherical(&orbit);
        orbit.turn(8.0, 0.0);
        orbit.turn(0.0, -12.0);
        assert_near(spherical(&orbit), [before[0] - 2.0, before[1] - 3.0, before[2]]);
    }
}

#[test]
fn elevation_is_held() {
    let mut orbit = view(1);
    let before = spherical(&orbit);
    orbit.turn(0.0, 1e5);
    assert_near(spherical(&orbit), [before[0], 89.99, before[2]]);
    orbit.turn(0.0, -1e6);
    assert_near(spherical(&orbit), [before[0], -89.99, before[2]]);
    // And it comes back from there.
    orbit.turn(0.0, 4.0);
    assert_near(spherical(&orbit), [before[0], -88.99, before[2]]);
}

#[test]
fn a_notch_has_the_same_factor_at_any_distance() {
    // scenes/evening.scn: 7 units from the target, on water of 4000 x 4000.
    for (side, distances) in [
        (3.0, [0.001, 1.0, 1000.0]),
        (4000.0, [0.1, 7.0, 1e5]),
        (0.01, [1e-6, 0.1, 5.0]),
    ] {
        for distance in distances {
            for factor in [1.1, 1.0 / 1.1] {
                let mut orbit = view(1);
                orbit.set_bounds(cube(side));
                orbit.go_to(Pose {
                    eye: DVec3::new(distance, 0.0, 0.5),
                    ..orbit.pose()
                });
                orbit.approach(factor);
                let found = spherical(&orbit)[2] / distance;
                assert!((found - factor).abs() < 1e-9, "{side} {distance}: {found}");
            }
        }
    }
}

#[test]
fn distances_end_where_coordinates_do() {
    let mut orbit = view(1);
    let diagonal = 12.0_f64.sqrt();
    for (factor, limit) in [(0.9, 1e-6), (1.1, 1e3)] {
        for _ in 0..500 {
            orbit.approach(factor);
        }
        let ratio = spherical(&orbit)[2] / (limit * diagonal);
        assert!((0.9..=1.12).contains(&ratio), "{ratio}");
    }
    // From beyond the limits it comes back step by step.
    let before = spherical(&orbit)[2];
    orbit.set_bounds(cube(1e-3));
    orbit.approach(1.1);
    assert_eq!(spherical(&orbit)[2], before);
    orbit.approach(0.9);
    assert!((spherical(&orbit)[2] / before - 0.9).abs() < 1e-9);
}

#[test]
fn the_wheel_scales_an_orthographic_view_and_keeps_the_share_in_focus() {
    let mut orbit = parallel(4.0);
    let before = orbit.pose();
    orbit.approach(0.5);
    let after = Pose {
        projection: Projection::Orthographic { height: 2.0 },
        ..before
    };
    assert_eq!(orbit.pose(), after);
    orbit.approach(1e-9);
    orbit.turn(8.0, 4.0);
    assert_eq!(orbit.pose().projection, after.projection);
    // A perspective camera moves, and what is in focus with it.
    let lens = |focus| Lens { aperture: 0.1, focus };
    for (focus, near) in [(None, None), (Some(6.0), Some(3.0))] {
        let mut orbit = view(2);
        orbit.go_to(Pose {
            lens: lens(focus),
            ..orbit.pose()
        });
        orbit.turn(8.0, 4.0);
        orbit.fly(1.0, 1.0, 1.0);
        assert_eq!(orbit.pose().lens, lens(focus));
        orbit.approach(0.5);
        assert_eq!(orbit.pose().lens, lens(near));
        orbit.frame(here(LONG), 1.0);
        assert_eq!(orbit.pose().lens, lens(None));
    }
}

#[test]
fn flight_keeps_the_direction() {
    let mut orbit = view(2);
    let before = orbit.pose();
    orbit.fly(0.0, 0.0, 0.5);
    let after = orbit.pose();
    let step = after.eye - before.eye;
    assert!(step.normalize().dot(before.frame()[2]) > 1.0 - 1e-12);
    assert!((after.target - before.target - step).length() < 1e-12);
    orbit.fly(1.0, 0.0, 0.0);
    assert!((orbit.pose().eye - after.eye).dot(after.frame()[2]).abs() < 1e-12);
}

/// Whether all corners of a box are in the picture, and how much of its half side they fill.
fn filled(orbit: &Orbit, bounds: Aabb, aspect: f64) -> f64 {
    let pose = orbit.pose();
    let [right, up, forward] = pose.frame();
    let half_height = match pose.projection {
        Projection::Perspective { fov_degrees } => half_height(fov_degrees),
        Projection::Orthographic { height } => height / 2.0,
    };
    let is_parallel = matches!(pose.projection, Projection::Orthographic { .. });
    (0..8_u32).fold(0.0, |most, corner| {
        let pick = |axis: usize| {
            let ends = [bounds.lower[axis], bounds.upper[axis]];
            f64::from(ends[(corner >> axis & 1) as usize])
        };
        let v = DVec3::new(pick(0), pick(1), pick(2)) - pose.eye;
        let depth = v.dot(forward);
        assert!(depth > 0.0);
        let half_height = if is_parallel {
            half_height
        } else {
            depth * half_height
        };
        let upwards = v.dot(up).abs() / half_height;
        most.max(upwards).max(v.dot(right).abs() / (half_height * aspect))
    })
}

const LONG: Aabb = Aabb {
    lower: Vec3::new(10.0, 20.0, 30.0),
    upper: Vec3::new(14.0, 21.0, 31.0),
};

/// Bounds relative to 0.
fn here(bounds: Aabb) -> (Aabb, DVec3) {
    (bounds, DVec3::ZERO)
}

#[test]
fn bounds_far_away_are_framed_there() {
    let far = DVec3::new(500_000.0, 4e6, 300.0);
    let [near, away] = [DVec3::ZERO, far].map(|offset| {
        let mut orbit = view(3);
        orbit.frame((LONG, offset), 2.0);
        orbit.pose()
    });
    assert!((away.eye - near.eye - far).length() < 1e-8);
    assert!((away.target - near.target - far).length() < 1e-8);
}

#[test]
fn framing_sees_all_and_keeps_the_direction() {
    for aspect in [1.0, 0.3, 2.0] {
        let mut orbit = view(3);
        let forward = orbit.pose().frame()[2];
        orbit.frame(here(LONG), aspect);
        assert!(orbit.pose().frame()[2].dot(forward) > 1.0 - 1e-12);
        assert!((0.8..1.0).contains(&filled(&orbit, LONG, aspect)));
    }
    // An orthographic camera stays one.
    let mut orbit = parallel(4.0);
    orbit.frame(here(LONG), 2.0);
    assert!((0.9..1.0).contains(&filled(&orbit, LONG, 2.0)));
    let mut orbit = view(3);
    orbit.frame(here(Aabb::EMPTY), 1.0);
    assert_eq!(orbit.pose(), view(3).pose());
}

#[test]
fn six_sides_show_the_whole_mesh() {
    let flat = Aabb {
        lower: Vec3::new(-1.0, -1.0, 0.0),
        upper: Vec3::new(1.0, 1.0, 0.0),
    };
    for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Y] {
        let up = axis::nearest(direction);
        for (side, bounds) in (0..6).flat_map(|side| [LONG, flat, cube(1e-4), cube(1e6)].map(|b| (side, b))) {
            for aspect in [1.0, 0.3, 2.0] {
                let mut orbit = view(3);
                orbit.frame_side(here(bounds), aspect, side, up);
                assert!((0.7..1.0).contains(&filled(&orbit, bounds, aspect)));
                let away = (orbit.pose().eye - orbit.pose().target).normalize();
                assert!((away - axis::side(up, side)).length() < 1e-9);
                assert_eq!(orbit.pose().up, direction);
                // It is a view that drags can go on from.
                orbit.turn(8.0, 4.0);
                assert!(orbit.pose().camera().is_ok());
            }
        }
    }
}

#[test]
fn turning_up_turns_the_camera_with_the_mesh() {
    let (y, z) = (UpAxis::Y, UpAxis::Z);
    let mut orbit = view(1);
    orbit.frame_side(here(LONG), 1.0, 0, y);
    let before = orbit.pose();
    let center = before.target;
    orbit.go_to(before.rotated(axis::turn(y, z)));
    let after = orbit.pose();
    assert_eq!((after.up, after.target), (DVec3::Z, center));
    // The front of a mesh that stands on z looks towards -y.
    let direction = (after.eye - center).normalize();
    assert!((direction - DVec3::NEG_Y).length() < 1e-12);
    assert!((after.rotated(axis::turn(z, y)).eye - before.eye).length() < 1e-9);
}

#[test]
fn another_up_is_kept() {
    let pose = Pose {
        eye: DVec3::new(0.0, 1.0, 5.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
        projection: Projection::DEFAULT,
        lens: Lens::PINHOLE,
    };
    let mut orbit = Orbit::new(pose, cube(2.0)).unwrap();
    orbit.turn(40.0, 0.0);
    let eye = orbit.pose().eye;
    assert!((eye.y - 1.0).abs() < 1e-12 && eye.x < -0.1);
    orbit.turn(0.0, 1e9);
    assert!(orbit.pose().eye.y > 5.0);
}
