//! Needles: triangles whose planes and areas rounding takes.

use super::*;

/// Pyramids with a needle in their base, whose plane `f32` does not know, and rays through it from near it: whichever side
/// they start on, an odd number of crossings from inside, and a hit where there is a crossing.
#[test]
fn needles_are_met_from_either_side() {
    let mut random = Random::new(47);
    let (mut inside, mut met) = (0, 0);
    for round in 0..3000 {
        let [i, j] = [random.vector(), random.vector()].map(Vec3::normalize);
        if i.dot(j).abs() > 0.5 {
            continue;
        }
        let k = i.cross(j).normalize();
        let place = |x: f32, y: f32, z: f32| i * x + j * y + k * z;
        let width = 10.0_f32.powf(-4.0 - 2.5 * random.0.f32());
        let (a, b) = (place(-1.0, -1.0, 0.0), place(1.0, 1.0, 0.0));
        let c = a.lerp(b, 0.3 + 0.4 * random.0.f32()) + (j - i) * width;
        let (p, q, apex) = (place(1.0, -1.0, 0.0), place(-1.0, 1.0, 0.0), place(0.0, 0.0, 1.0));
        let positions = [a, b, c, p, q, apex].map(|corner| corner.to_array());
        let base = [[0, 3, 1], [0, 1, 2], [0, 2, 4], [2, 1, 4]];
        let sides = [[3, 0, 5], [1, 3, 5], [4, 1, 5], [0, 4, 5]];
        let geometry = Geometry::from_triangles(&positions, &[base, sides].concat()).unwrap();
        for _ in 0..8 {
            let [u, v] = [0.2 + random.0.f32() * 0.3, random.0.f32() * 0.3];
            let at = a + (b - a) * u + (c - a) * v;
            let toward = k * if random.0.bool() { 1.0 } else { -1.0 } + random.vector() * 0.2;
            let origin = at - toward * 10.0_f32.powf(-3.0 + 2.0 * random.0.f32());
            let ray = Ray::new(origin, at - origin);
            let crossings = geometry.crossings(&ray).len();
            let is_inside = geometry.contains(origin.as_dvec3()).unwrap();
            let is_odd = crossings % 2 == 1;
            let case = || format!("{round}: {positions:?} {ray:?} {crossings}");
            assert_eq!(is_odd, origin.dot(k) > 0.0, "{}", case());
            assert_eq!(is_odd, is_inside, "{}", case());
            let hit = geometry.closest_hit(&ray);
            assert!(crossings == 0 || hit.is_some(), "{}", case());
            assert_eq!(geometry.occluded(&ray), hit.is_some(), "{}", case());
            inside += usize::from(is_inside);
            met += usize::from(hit.is_some());
        }
    }
    assert!(inside > 5000 && met > 10_000, "{inside} {met}");
}

/// Needles whose area is lost to rounding even in `f64`: they count where exact signs do.
#[test]
fn areas_that_rounding_takes_are_areas() {
    let (p, q) = (2.0_f32.powi(-40), 2.0_f32.powi(-40) * (1.0 + f32::EPSILON));
    for a in [[p, q, 0.0], [q, p, 0.0]] {
        let rest = [
            [1.0, 1.0, 0.0],
            [0.5, 0.5, 0.0],
            [1.0, -1.0, 0.0],
            [-1.0, 1.0, 0.0],
            [0.0, 0.0, -3.0],
        ];
        let positions = [&[a][..], &rest].concat();
        let top = [[0, 3, 1], [0, 1, 2], [0, 2, 4], [2, 1, 4]];
        let sides = [[3, 0, 5], [1, 3, 5], [4, 1, 5], [0, 4, 5]];
        let geometry = Geometry::from_triangles(&positions, &[top, sides].concat()).unwrap();
        assert!((0..8).all(|i| geometry.scene().has_area(i)));
        for i in 0..9 {
            let aside = Vec3::new(i as f32 % 3.0 - 1.0, (i / 3) as f32 - 1.0, 0.0) * 0.5;
            let origin = Vec3::new(0.5, 0.5, 1.0) + aside;
            let ray = Ray::new(origin, Vec3::new(0.0, 0.0, -1.0) - aside);
            let crossings = geometry.crossings(&ray);
            assert_eq!(crossings.len() % 2, 0, "{a:?} {ray:?} {crossings:?}");
        }
        assert!(geometry.contains([0.3, 0.2, -0.5]).unwrap());
    }
    let collinear = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.25, 0.25, 0.25]];
    let geometry = Geometry::from_triangles(&collinear, &[[0, 1, 2]]).unwrap();
    assert!(!geometry.scene().has_area(0));
}

/// Needles of all widths, down to those whose areas are rounding, from the side and along their axis: never farther than
/// the nearest of their edges, and at each level the same.
#[test]
fn closest_points_of_needles_are_on_them() {
    let mut random = Random::new(31);
    for round in 0..4000 {
        let width = 10.0_f32.powi(-3 - round % 18);
        let (tip, noise) = (random.vector(), random.vector() * 1e-7);
        let corners = match round % 3 {
            0 => [random.vector() * width, tip, tip * 0.5],
            1 => [tip, tip + random.vector() * width, tip + random.vector() * width],
            _ => [
                Vec3::X,
                Vec3::X * (1.0 - 1e-7) + noise * width,
                Vec3::X + random.vector() * width,
            ],
        };
        let positions = corners.map(|corner| corner.to_array());
        let geometry = Geometry::from_triangles(&positions, &[[0, 1, 2]]).unwrap();
        let far = random.vector() * 10.0_f32.powi(round % 5 - 2);
        for point in [DVec3::ZERO, far.as_dvec3(), far.as_dvec3() + 2.0 * tip.as_dvec3()] {
            let Some(found) = geometry.closest_point(point) else {
                continue;
            };
            let mut edges = f64::INFINITY;
            for [a, b] in [[0, 1], [1, 2], [2, 0]].map(|edge| edge.map(|i| corners[i].as_dvec3())) {
                let part = (point - a).dot(b - a) / (b - a).length_squared();
                let part = if part.is_finite() {
                    part.clamp(0.0, 1.0)
                } else {
                    0.0
                };
                edges = edges.min((a + (b - a) * part - point).length());
            }
            assert!(
                found.distance <= edges * (1.0 + 1e-12) + 1e-15,
                "{corners:?} {point} {found:?} {edges}"
            );
            for level in Level::all() {
                let geometry = Geometry::from_triangles(&positions, &[[0, 1, 2]])
                    .unwrap()
                    .at_level(level);
                assert_eq!(geometry.closest_point(point), Some(found));
            }
        }
    }
}

/// A ray that starts in the plane of a triangle and stays there misses it, and hits what stands at its edge, where it
/// stands.
#[test]
fn rays_in_the_plane_of_a_triangle_miss_it() {
    let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut random = Random::new(51);
    for axis in 0..3 {
        let turned = |p: [f32; 3]| [p[(3 - axis) % 3], p[(4 - axis) % 3], p[(5 - axis) % 3]];
        let geometry = Geometry::from_triangles(&flat.map(turned), &[[0, 1, 2], [0, 2, 3]]).unwrap();
        for _ in 0..200 {
            let [x, y] = [random.signed() * 2.0, random.signed() * 2.0];
            let ray = Ray::new(turned([x, y, 0.0]), turned([0.5 - x, 0.5 - y, 0.0]));
            assert_eq!(geometry.closest_hit(&ray), None, "{ray:?}");
            assert!(
                geometry.all_hits(&ray, None).is_empty() && !geometry.occluded(&ray),
                "{ray:?}"
            );
        }
    }
    let (positions, triangles) = cube(3, |at| at);
    let cube = Geometry::from_triangles(&positions, &triangles).unwrap();
    for y in [-1.0, -0.4, 0.1, 1.0] {
        let hit = cube
            .closest_hit(&Ray::new([-4.0, y, 1.0], [1.0, 0.0, 0.0]))
            .unwrap();
        assert_eq!(hit.t, 3.0, "{y}");
    }
}
