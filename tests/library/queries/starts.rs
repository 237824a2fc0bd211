use glam::{DVec3, Vec3};
use octray::{Geometry, Hit, Rays, query::starts::starts_on, ray::PrimitiveId};

/// A grid of squares, and rays from points on its planes and elsewhere: the counter notices each that starts on one,
/// whichever kernel traces it.
#[test]
fn rays_that_start_on_triangles_are_noticed() {
    let mut random = fastrand::Rng::with_seed(5);
    let side = 12;
    let mut positions = Vec::new();
    for i in 0..side * side {
        let (x, y) = ((i % side) as f32, (i / side) as f32);
        positions.push([x, y, x * 0.5 + (i % 5) as f32 * y]);
    }
    let mut triangles = Vec::new();
    for i in (0..side * (side - 1)).filter(|i| i % side < side - 1) {
        let [a, b, c, d] = [i, i + 1, i + side, i + side + 1].map(|i| i as u32);
        triangles.extend([[a, b, c], [b, d, c], [a, b, c]]);
    }
    let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
    let mut all = 0;
    for round in 0..24 {
        let mut vector = || [0; 3].map(|_| random.f32() * 2.0 - 1.0);
        let directions: Vec<[f32; 3]> = (0..1 << (round % 12)).map(|_| vector()).collect();
        let origins: Vec<[f32; 3]> = (0..directions.len())
            .map(|i| {
                let corners = triangles[random.usize(0..triangles.len())].map(|v| positions[v as usize]);
                let [p, q] = [0, round % 3].map(|k| Vec3::from(corners[k]));
                let aside = if i % 4 == 0 { Vec3::Z * 0.1 } else { Vec3::ZERO };
                (p * 0.5 + q * 0.5 + aside).to_array()
            })
            .collect();
        let rays = Rays::from_arrays(&origins, &directions).unwrap();
        let expected: Vec<(usize, PrimitiveId)> = (0..origins.len())
            .flat_map(|i| {
                let (origin, direction) = (origins[i].into(), Vec3::from(directions[i]).as_dvec3());
                let (triangles, geometry) = (0..triangles.len(), &geometry);
                triangles
                    .filter(move |&id| {
                        starts_on(
                            origin,
                            direction,
                            geometry
                                .triangle(id)
                                .map(|corner| (corner - geometry.middle()).as_vec3()),
                        )
                    })
                    .map(move |id| (i, PrimitiveId(id as u32)))
            })
            .collect();
        let mut hits = vec![Hit::default(); origins.len()];
        let ((), starts) =
            geometry.with_starts(rays, false, || geometry.worker().closest_hits(rays, &mut hits));
        assert_eq!(starts, expected);
        if origins.len() <= 256 {
            let (_, starts) = geometry.with_starts(rays, false, || geometry.all_hits_each(rays, None));
            assert_eq!(starts, expected);
        }
        let mut blocked = vec![false; origins.len()];
        let trace = || geometry.worker().occluded_each(rays, &mut blocked);
        let ((), starts) = geometry.with_starts(rays, false, trace);
        for (ray, _) in starts {
            blocked[ray] = true;
        }
        for &(ray, _) in &expected {
            assert!(blocked[ray]);
        }
        all += expected.len();
    }
    assert!(all > 4_000, "{all}");
}

/// Directions whose rounding to unit length leaves the plane of the triangle that they lie in, or falls into it.
#[test]
fn starts_are_those_of_the_given_directions() {
    let positions = [[0.0, 0.0, 0.0], [4.0, -4.0, 0.0], [4.0, 0.0, -4.0_f64]];
    let geometry = Geometry::from_triangles(&positions, &[[0, 1, 2]]).unwrap();
    let directions = [
        [1.0, -1.0, 0.0],
        [1.0, 1.0, -2.0],
        [1.0, 2.0, -3.0],
        [3.0, -1.0, -2.0],
        [1.0, -0.999_999_999, 0.0],
        [1e-300, -1e-300, 1e-309],
        [1e300, -1e300, 1e285],
    ];
    let rays = Rays::from_arrays(&[[2.0, -1.0, -1.0_f64]], &directions).unwrap();
    let mut hits = [Hit::default(); 7];
    for once in [false, true] {
        let ((), starts) =
            geometry.with_starts(rays, once, || geometry.worker().closest_hits(rays, &mut hits));
        assert_eq!(starts, [4, 5, 6].map(|ray| (ray, PrimitiveId(0))));
    }
    assert!(starts_on(Vec3::X, DVec3::Z, [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y]));
}
