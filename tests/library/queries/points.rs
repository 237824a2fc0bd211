//! Closest points to many points.

use super::*;
use octray::query::nearest::on_triangle;
use std::sync::atomic::AtomicBool;

#[test]
fn closest_points_are_those_of_all_triangles() {
    let mut random = Random::new(34);
    for (positions, triangles) in meshes() {
        let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
        let points: Vec<[f64; 3]> = (0..1500)
            .map(|i| {
                let scale = [1.0, 3.0, 1e6, 1e30][i % 4];
                let at = random.vector() * scale;
                let at = if i % 3 == 0 { at.round() } else { at };
                at.as_dvec3().to_array()
            })
            .collect();
        let mut closest = vec![None; points.len()];
        geometry.closest_points(&points, &mut closest);
        for (&point, closest) in points.iter().zip(&closest) {
            let point = DVec3::from_array(point);
            let (mut best, mut id) = (f64::INFINITY, u32::MAX);
            for i in (0..triangles.len()).filter(|&i| geometry.scene().has_area(i)) {
                let at = on_triangle(point, geometry.scene().triangle(i).map(Vec3::as_dvec3));
                let squared = (at - point).length_squared();
                if squared < best {
                    (best, id) = (squared, i as u32);
                }
            }
            let closest = closest.unwrap();
            assert_eq!(
                (closest.distance, closest.primitive.0),
                (best.sqrt(), id),
                "{point}"
            );
            assert!(((closest.point - point).length() - closest.distance).abs() <= 1e-12 * closest.distance);
        }
        assert!(geometry.closest_point(DVec3::NAN).is_none());
    }
}

/// Points of needles are as near as rounding of their coordinates lets them be.
#[test]
fn closest_points_of_needles() {
    let mut random = Random::new(46);
    let mut worst: f64 = 0.0;
    for _ in 0..20_000 {
        let (a, along, aside) = (random.vector(), random.vector(), random.vector());
        let width = 10.0_f32.powf(-2.0 - 4.0 * random.0.f32());
        let corners = [a, a + along, a + along * (random.0.f32() * 1.5) + aside * width];
        let [u, v] = [random.0.f64() * 0.5, random.0.f64() * 0.5];
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        let point = a * (1.0 - u - v) + b * u + c * v;
        worst = worst.max(on_triangle(point, [a, b, c]).distance(point));
    }
    assert!(worst < 2e-9, "{worst}");
}

#[test]
fn many_closest_points_are_those_of_one_by_one() {
    let mut random = Random::new(35);
    for (positions, triangles) in meshes() {
        let far: Vec<[f64; 3]> = positions
            .iter()
            .map(|&at| (DVec3::from(Vec3::from(at)) + 1e6).to_array())
            .collect();
        let geometry = Geometry::from_triangles(&far, &triangles).unwrap();
        // Near, on vertices, many at one place, far, and not finite.
        let points: Vec<[f64; 3]> = (0..9000)
            .map(|i| match i % 5 {
                0 => far[random.0.usize(..far.len())],
                1 => [1e6, 1e6 + 1e-7, 1e6],
                2 if i % 50 == 2 => [f64::NAN, 0.0, 0.0],
                3 => (random.vector().as_dvec3() * 1e9).to_array(),
                _ => (random.vector().as_dvec3() * 1.5 + 1e6).to_array(),
            })
            .collect();
        let mut closest = vec![None; points.len()];
        geometry.closest_points(&points, &mut closest);
        for (&point, closest) in points.iter().zip(closest) {
            assert_eq!(closest, geometry.closest_point(point), "{point:?}");
        }
    }
}

#[test]
fn cancelled_calls_leave_answers_as_they_are() {
    let geometry = Geometry::from_triangles(
        &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0_f32]],
        &[[0, 1, 2]],
    );
    let points = vec![[0.1_f64; 3]; 40_000];
    for (cancelled, found) in [(true, 0), (false, points.len())] {
        let mut closest = vec![None; points.len()];
        geometry.as_ref().unwrap().closest_points_until(
            (&points).into(),
            &mut closest,
            &AtomicBool::new(cancelled),
        );
        assert_eq!(closest.iter().flatten().count(), found);
    }
}
