use super::*;
use crate::simd::{EightLanes, Portable};
use glam::Vec3;

/// The draws of the first points of a sequence, eight at a time.
fn draws(count: u32) -> impl Iterator<Item = [<Portable as Simd>::V8; 2]> {
    (0..count / LANES as u32).map(|packet| {
        let points = [0, 1, 2, 3, 4, 5, 6, 7].map(|lane| sobol::point(2, packet * 8 + lane));
        [0, 1].map(|i| Portable.load(&F32x8::new(points.map(|point| point[i]))))
    })
}

fn lanes(v: Vec3Eight<Portable>) -> [Vec3; LANES] {
    let v = v.to8();
    std::array::from_fn(|lane| v.lane(lane))
}

#[test]
fn discs_are_filled_evenly() {
    let mut rings = [0; 8];
    let mut sectors = [0; 8];
    for point in draws(1 << 14) {
        let [x, y] = disc(Portable, point).map(|c| c.to8().to_array());
        for lane in 0..LANES {
            let [x, y] = [f64::from(x[lane]), f64::from(y[lane])];
            let squared = x * x + y * y;
            assert!(squared < 1.000_001, "{x} {y}");
            rings[((squared * 8.0) as usize).min(7)] += 1;
            let turn = y.atan2(x) / std::f64::consts::TAU + 0.5;
            sectors[((turn * 8.0) as usize).min(7)] += 1;
        }
    }
    for count in rings.into_iter().chain(sectors) {
        assert!((2030..=2066).contains(&count), "{rings:?} {sectors:?}");
    }
    let middle = disc(Portable, [Portable.splat(0.5); 2]);
    assert_eq!(middle.map(|c| c.to8().to_array()), [[0.0; 8]; 2]);
}

#[test]
fn scattered_directions_go_by_the_cosine() {
    for normal in [
        Vec3::Z,
        Vec3::NEG_Z,
        Vec3::new(0.6, -0.8, 0.0),
        Vec3::new(0.0, 1e-9, -1.0),
    ] {
        let n = Portable.splat3(normal);
        let (mut sum, mut along) = (Vec3::ZERO, 0.0);
        for direction in draws(1 << 12).flat_map(|point| lanes(scattered(Portable, n, n, point))) {
            assert!((direction.length() - 1.0).abs() < 1e-6 && direction.dot(normal) >= 0.0);
            sum += direction;
            along += direction.dot(normal).powi(2);
        }
        // The mean cosine is 2/3, the mean of its square 1/2.
        let mean = sum / 4096.0;
        assert!(mean.distance(normal * (2.0 / 3.0)) < 1e-3, "{normal}: {mean}");
        assert!((along / 4096.0 - 0.5).abs() < 1e-3, "{normal}: {along}");
    }
}

#[test]
fn scattered_directions_stay_above_the_surface() {
    let (normal, geometric) = (Vec3::new(0.8, 0.0, 0.6), Vec3::Z);
    let (n, g) = (Portable.splat3(normal), Portable.splat3(geometric));
    for direction in draws(1 << 10).flat_map(|point| lanes(scattered(Portable, n, g, point))) {
        assert!(direction.z >= 0.0 && (direction.length() - 1.0).abs() < 1e-6);
    }
}

/// The mean over the solid angle of a sphere is half of one plus the cosine of the half angle, along the axis.
#[test]
fn cones_hold_the_sphere() {
    for (to_center, radius) in [
        (Vec3::new(3.0, -4.0, 12.0), 5.0_f32),
        (Vec3::new(0.0, 0.0, -1e6), 1.0),
        (Vec3::new(-2e-4, 1e-4, 2e-4), 1e-4),
    ] {
        let half_angle = (radius / to_center.length()).asin();
        let mut sum = Vec3::ZERO;
        for point in draws(1 << 12) {
            let cone = cone(Portable, Portable.splat3(to_center), radius, point);
            let distance = cone.distance.to8().to_array();
            for (direction, distance) in lanes(cone.direction).into_iter().zip(distance) {
                assert!((direction.length() - 1.0).abs() < 1e-6);
                assert!(direction.angle_between(to_center) < half_angle * 1.001 + 1e-3);
                let off = (direction * distance).distance(to_center) / radius - 1.0;
                assert!(
                    off.abs() < 2e-2 * to_center.length() / radius * 1e-3 + 2e-3,
                    "{off}"
                );
                sum += direction;
            }
        }
        let expected = to_center.normalize() * (0.5 + 0.5 * half_angle.cos());
        assert!((sum / 4096.0).distance(expected) < 2e-3, "{to_center}");
    }
}

#[test]
fn inside_a_light_nothing_is_between() {
    for point in draws(64) {
        let cone = cone(Portable, Portable.splat3(Vec3::new(0.1, 0.2, 0.0)), 1.0, point);
        assert!(cone.distance.to8().to_array().iter().all(|&t| t <= 0.0));
    }
}
