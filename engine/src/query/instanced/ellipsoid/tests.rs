use super::*;
use glam::DMat3;

struct Random(fastrand::Rng);

impl Random {
    fn vector(&mut self) -> DVec3 {
        DVec3::from([(); 3].map(|()| self.0.f64() * 2.0 - 1.0))
    }
}

#[test]
fn no_other_point_of_an_ellipsoid_is_nearer() {
    let mut random = Random(fastrand::Rng::with_seed(1));
    for round in 0..600 {
        let stretch = [
            DVec3::ONE,
            DVec3::new(1.0, 0.3, 2.0),
            DVec3::new(2.0, 2.0, 0.01),
            DVec3::new(1e-3, 1.0, 1e-3),
        ][round % 4];
        let turned = DMat3::from_axis_angle(random.vector().normalize(), random.0.f64() * 6.0);
        let sheared = DMat3::from_cols(DVec3::X, random.vector() + DVec3::Y * 2.0, DVec3::Z);
        let size = [1.0, 1e-20, 1e12][round % 3];
        let mut matrix = turned * DMat3::from_diagonal(stretch) * size;
        if round % 5 > 1 {
            matrix *= sheared;
        }
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let center = random.vector() * size;
        let from = match round % 7 {
            0 => DVec3::ZERO,
            // In a plane of symmetry, on an axis, on the ellipsoid, far away.
            1 => matrix * DVec3::new(0.3, -0.2, 0.0),
            2 => matrix * DVec3::new(0.0, 1e-9, 0.0),
            3 => matrix * random.vector().normalize(),
            4 => random.vector() * size * 1e9,
            _ => random.vector() * size * 3.0,
        };
        let found = on_ellipsoid(center + from, center, axes);
        let unit = matrix.inverse() * (found - center);
        assert!((unit.length() - 1.0).abs() < 1e-9, "{round}: {unit}");
        let distance = found.distance(center + from);
        let mut nearest = f64::INFINITY;
        for i in 0..4000 {
            let on_sphere = if i % 2 == 0 {
                random.vector().normalize()
            } else {
                (unit + random.vector() * 10.0_f64.powi(-i % 8)).normalize()
            };
            nearest = nearest.min((center + matrix * on_sphere).distance(center + from));
        }
        let rounding = 1e-12 * (size + from.length());
        assert!(distance <= nearest + rounding, "{round}: {distance} {nearest}");
    }
}
