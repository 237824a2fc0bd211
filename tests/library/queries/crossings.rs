//! Crossings of closed meshes: their number is even, whatever the ray passes through.

use super::*;

#[test]
fn crossings_of_closed_meshes_are_even() {
    let mut random = Random::new(13);
    for (positions, triangles) in meshes() {
        let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
        let rays = rays(&mut random, &positions, 4000);
        let crossings = geometry.crossings_each(&rays);
        for (i, ray) in rays.iter().enumerate() {
            let starts_outside = ray.origin.abs().max_element() > 1.31;
            let is_whole = ray.t_min == 0.0 && ray.t_max == f32::INFINITY;
            if starts_outside && is_whole {
                assert_eq!(crossings.of_ray(i).len() % 2, 0, "{ray:?}");
            }
            assert_eq!(crossings.of_ray(i), geometry.crossings(ray));
        }
    }
}

/// Edges on the ray's own line, two solids one behind the other.
#[test]
fn crossings_along_edges_are_even() {
    let positions = [
        [5.0_f32, 0.0, -1.0],
        [5.0, 0.0, 1.0],
        [6.0, -1.0, 0.5],
        [6.0, 1.0, 0.5],
        [2.0, 0.0, 0.0],
        [3.0, 0.0, 0.0],
        [2.5, 1.0, 0.0],
        [2.5, 0.0, 1.0],
    ];
    let solid = |i: u32| {
        [
            [i, i + 1, i + 2],
            [i, i + 3, i + 1],
            [i, i + 2, i + 3],
            [i + 1, i + 3, i + 2],
        ]
    };
    let triangles = [solid(0), solid(4)].concat();
    let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
    let along = Ray::new([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    assert_eq!(geometry.crossings(&along).len() % 2, 0);
    assert_eq!(
        geometry
            .crossings(&Ray::new([5.5, 0.0, 0.0], [1.0, 0.0, 0.0]))
            .len(),
        1
    );
}

/// From so far that the smallest turn of the line would leave boxes near 0.
#[test]
fn crossings_from_far_away_are_even() {
    let at = 1e-6_f32;
    let (low, high) = ([-1.0_f32, -1.0, 0.0], [1.0_f32, 1.0, 1.0]);
    let positions = [
        low,
        [at, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [at, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
        [-1.0, -1.0, 1.0],
        [1.0, -1.0, 1.0],
        high,
        [-1.0, 1.0, 1.0],
    ];
    let triangles = [
        [0, 4, 1],
        [0, 5, 4],
        [1, 3, 2],
        [1, 4, 3],
        [6, 7, 8],
        [6, 8, 9],
        [0, 1, 6],
        [1, 2, 7],
        [1, 7, 6],
        [3, 4, 8],
        [4, 5, 9],
        [4, 9, 8],
        [2, 3, 8],
        [2, 8, 7],
        [5, 0, 6],
        [5, 6, 9],
    ];
    let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
    geometry.check_closed().unwrap();
    for distance in [1.0, 1e3, 1e5, 1e7] {
        for x in [0.0, at, -at, 1e-7] {
            let ray = Ray::new([x, 0.3, -distance], [0.0, 0.0, 1.0]);
            assert_eq!(geometry.crossings(&ray).len(), 2, "{distance} {x}");
        }
    }
}

/// Closed solids with slivers along diagonals, and rays that start in the slivers' boxes.
#[test]
fn slivers_do_not_change_parity() {
    let mut random = Random::new(77);
    for round in 0..300 {
        let mut thin = || random.vector() * 1e-7;
        let (a, b) = (Vec3::ZERO + thin(), Vec3::ONE + thin());
        let middle = Vec3::splat(0.5) + thin();
        let (left, right) = (Vec3::new(1.0, 0.0, 0.4), Vec3::new(0.0, 1.0, 0.6));
        let positions = [a, b, middle, left, right].map(|corner| corner.to_array());
        // Both sides of the sliver a, b, middle.
        let triangles = [
            [0, 1, 3],
            [0, 4, 1],
            [0, 3, 2],
            [3, 1, 2],
            [0, 2, 4],
            [2, 1, 4],
            [0, 1, 2],
            [0, 2, 1],
        ];
        let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
        if geometry.check_closed().is_err() || (0..8).any(|i| !geometry.scene().has_area(i)) {
            continue;
        }
        // Forward and backward together, a whole line.
        let from = (random.vector() + 1.0) * 0.5;
        let to = a.lerp(b, 0.2 + 0.002 * round as f32);
        let crossings = |way: Vec3| geometry.crossings(&Ray::new(from, way)).len();
        assert_eq!((crossings(to - from) + crossings(from - to)) % 2, 0, "{round}");
    }
}
