//! Queries against one primitive after the other, on meshes full of shared edges, equal triangles and needles.

mod cameras;
mod crossings;
mod exact;
mod instanced;
mod meshes;
mod needles;
mod placed_points;
mod points;
mod starts;

use glam::{DVec3, Vec3};
use octray::{
    Geometry, Hit, Level, QueryError, Ray, Rays,
    query::{Points, Sphere, sinks::in_order, unit::UnitRay},
    reference::brute,
};

struct Random(fastrand::Rng);

impl Random {
    fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }
    fn signed(&mut self) -> f32 {
        self.0.f32() * 2.0 - 1.0
    }
    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
}

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// A closed surface: the grid of a cube's faces, drawn to a torus or left as it is; vertices at one position are stored
/// several times.
fn cube(side: usize, shape: impl Fn(Vec3) -> Vec3) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for axis in 0..3 {
        for sign in [-1.0_f32, 1.0] {
            for i in 0..side {
                for j in 0..side {
                    let corner = |i: usize, j: usize| {
                        let mut at = Vec3::ZERO;
                        at[axis] = sign;
                        at[(axis + 1) % 3] = 2.0 * i as f32 / side as f32 - 1.0;
                        at[(axis + 2) % 3] = 2.0 * j as f32 / side as f32 - 1.0;
                        shape(at).to_array()
                    };
                    let base = positions.len() as u32;
                    positions.extend([
                        corner(i, j),
                        corner(i + 1, j),
                        corner(i + 1, j + 1),
                        corner(i, j + 1),
                    ]);
                    let mut two = [[base, base + 1, base + 2], [base, base + 2, base + 3]];
                    if sign < 0.0 {
                        for triangle in &mut two {
                            triangle.swap(1, 2);
                        }
                    }
                    triangles.extend(two);
                }
            }
        }
    }
    (positions, triangles)
}

/// Rays at random, at vertices and edges, along the axes, from outside and inside, of any length, and some that are invalid.
fn rays(random: &mut Random, positions: &[[f32; 3]], count: usize) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let origin = match i % 4 {
                0 => random.vector() * 3.0,
                1 => random.vector() * 0.5,
                2 => (random.vector() * 4.0).round() * 0.5,
                _ => Vec3::new(3.0, 0.25, -0.5),
            };
            let vertex = |random: &mut Random| Vec3::from(positions[random.0.usize(..positions.len())]);
            let (a, b) = (vertex(random), vertex(random));
            let direction = match i % 5 {
                0 => a - origin,
                1 => a.midpoint(b) - origin,
                2 => Vec3::AXES[i / 5 % 3] * [1.0, -1.0][i / 15 % 2],
                _ => random.vector(),
            };
            let scale = [1.0, 1.0, 0.037, 250.0, 1e-20, 1e12][i % 6];
            let mut ray = Ray::new(origin, direction * scale);
            if i % 3 == 0 {
                ray.t_min = random.0.f32() * 2.0 / scale;
            }
            if i % 7 == 0 {
                ray.t_max = random.0.f32() * 5.0 / scale;
            }
            match i % 41 {
                0 => ray.direction.x = f32::NAN,
                1 => ray.origin.y = f32::INFINITY,
                2 => ray.direction = Vec3::ZERO,
                3 => ray.t_min = f32::NAN,
                4 => ray.t_max = -1.0,
                5 => ray.t_min = f32::INFINITY,
                _ => {}
            }
            ray
        })
        .collect()
}

/// All hits of a ray, one triangle after the other.
fn all_hits(geometry: &Geometry, ray: &Ray) -> Vec<Hit> {
    let unit = UnitRay::new(ray, geometry.middle());
    let mut hits = brute::all_hits(geometry.scene(), &unit.ray);
    for hit in &mut hits {
        hit.t = (f64::from(hit.t) / unit.length) as f32;
    }
    hits.retain(|hit| hit.t > ray.t_min.max(0.0) && hit.t < ray.t_max);
    hits.sort_by(in_order);
    hits
}

fn meshes() -> Vec<Mesh> {
    let ball = cube(5, |at| at.normalize() * 1.3);
    let mut doubled = cube(3, |at| at);
    let again = doubled.1.clone();
    (0..3).for_each(|_| doubled.1.extend(&again));
    // A triangle without an area.
    doubled.1.push([0, 0, 1]);
    vec![cube(4, |at| at), ball, doubled]
}

#[test]
fn every_query_of_rays_finds_what_one_triangle_after_the_other_tells() {
    let mut random = Random::new(5);
    for (positions, triangles) in meshes() {
        let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
        let rays = rays(&mut random, &positions, 1500);
        let mut closest = vec![Hit::miss(0.0); rays.len()];
        let mut occluded = vec![false; rays.len()];
        geometry.closest_hits(&rays, &mut closest);
        geometry.occluded_each(&rays, &mut occluded);
        let all = geometry.all_hits_each(&rays, None);
        let two = geometry.all_hits_each(&rays, Some(2));
        let mut found = 0;
        for (i, ray) in rays.iter().enumerate() {
            let expected = all_hits(&geometry, ray);
            found += expected.len();
            assert_eq!(all.of_ray(i), expected, "{ray:?}");
            assert_eq!(two.of_ray(i), &expected[..expected.len().min(2)], "{ray:?}");
            assert_eq!(geometry.all_hits(ray, Some(3)), expected[..expected.len().min(3)]);
            assert!(geometry.all_hits(ray, Some(0)).is_empty());
            assert_eq!(occluded[i], !expected.is_empty(), "{ray:?}");
            assert_eq!(geometry.occluded(ray), occluded[i]);
            let first = closest[i].is_hit().then_some(closest[i]);
            assert_eq!(geometry.closest_hit(ray), first, "{ray:?}");
            assert_eq!(
                first.map(|hit| hit.t),
                expected.first().map(|hit| hit.t),
                "{ray:?}"
            );
            assert!(first.is_none_or(|hit| expected.contains(&hit)));
        }
        assert!(found > 600, "{found}");
    }
}

#[test]
fn arrays_and_slices_shared_origins_and_levels_give_the_same_hits() {
    let mut random = Random::new(8);
    let (positions, triangles) = cube(6, |at| at.normalize());
    let origin = Vec3::new(0.3, -2.0, 0.7);
    let rays: Vec<Ray> = (0..20_000)
        .map(|_| Ray::new(origin, random.vector() * 0.6 - origin))
        .collect();
    let directions: Vec<[f64; 3]> = rays
        .iter()
        .map(|ray| ray.direction.as_dvec3().to_array())
        .collect();
    let one = [origin.to_array()];
    let each = vec![origin.to_array(); rays.len()];
    let mut expected = vec![Hit::miss(0.0); rays.len()];
    let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
    geometry.closest_hits(&rays, &mut expected);
    let count = expected.iter().filter(|hit| hit.is_hit()).count();
    assert!(count > 10_000 && count < rays.len());
    for level in Level::all() {
        let geometry = Geometry::from_triangles(&positions, &triangles)
            .unwrap()
            .at_level(level);
        let mut hits = vec![Hit::miss(0.0); rays.len()];
        let shared = Rays::from_arrays(&one, &directions).unwrap();
        geometry.closest_hits(shared, &mut hits);
        assert!(hits == expected, "{level}");
        let separate = Rays::from_arrays(&each, &directions).unwrap();
        geometry.worker().closest_hits(separate, &mut hits);
        assert!(hits == expected, "{level}");
        for (ray, hit) in rays.iter().zip(&expected).take(1000) {
            assert_eq!(geometry.closest_hit(ray), hit.is_hit().then_some(*hit));
        }
    }
    assert!(matches!(
        Rays::from_arrays(&each[..7], &directions),
        Err(QueryError::Length { found: 7, .. })
    ));
}

#[test]
fn inside_is_told_of_any_point() {
    let mut random = Random::new(21);
    for (scale, offset) in [(1.0, DVec3::ZERO), (1e-3, DVec3::new(4e5, 5e6, 100.0))] {
        let (positions, triangles) = cube(8, |at| at);
        let positions: Vec<[f64; 3]> = positions
            .iter()
            .map(|&at| (Vec3::from(at).as_dvec3() * scale + offset).to_array())
            .collect();
        let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
        let points: Vec<[f64; 3]> = (0..4000)
            .map(|i| {
                let at = random.vector() * 1.4;
                let at = if i % 2 == 0 {
                    (at * 4.0).round() * 0.249
                } else {
                    at
                };
                (at.as_dvec3() * scale + offset).to_array()
            })
            .collect();
        let mut inside = vec![false; points.len()];
        geometry.contains_each(&points, &mut inside).unwrap();
        let mut distances = vec![0.0; points.len()];
        geometry.signed_distances(&points, &mut distances).unwrap();
        for ((point, inside), distance) in points.iter().zip(inside).zip(distances) {
            let at = (DVec3::from_array(*point) - offset) / scale;
            let depth = 1.0 - at.abs().max_element();
            if depth.abs() > 1e-5 {
                assert_eq!(inside, depth > 0.0, "{at}");
                assert!(
                    distance.is_sign_positive() == inside
                        && (!inside || (distance / scale - depth).abs() < 1e-4)
                );
            }
        }
    }
}

#[test]
fn what_is_not_closed_has_no_inside() {
    let (positions, mut triangles) = cube(2, |at| at);
    triangles.pop();
    let geometry = Geometry::from_triangles(&positions, &triangles).unwrap();
    assert!(matches!(
        geometry.contains(DVec3::ZERO),
        Err(QueryError::NotClosed { .. })
    ));
    let ball = Sphere {
        center: [0.0; 3],
        radius: 1.0,
    };
    let geometry = Geometry::new(Points::F32(&[]), &[], &[ball]).unwrap();
    assert_eq!(geometry.signed_distance(DVec3::ZERO), Err(QueryError::HasSpheres));
    let nothing = Geometry::from_triangles(Points::F32(&[]), &[]).unwrap();
    assert_eq!(nothing.contains(DVec3::ZERO), Ok(false));
    let also = Geometry::from_triangles(Points::F64(&[]), &[]).unwrap();
    assert_eq!(also.vertices().1, DVec3::ZERO);
    assert_eq!(nothing.signed_distance(DVec3::ZERO), Ok(f64::NEG_INFINITY));
    let (positions, triangles) = cube(1, |at| at);
    let far = Geometry::from_triangles(&positions, &triangles).unwrap();
    assert!(far.signed_distance(DVec3::splat(1e39)).unwrap().is_nan());
    let collapsed = far.refitted(&vec![[5.0_f32; 3]; positions.len()]).unwrap();
    assert_eq!(collapsed.signed_distance(DVec3::ZERO), Ok(f64::NEG_INFINITY));
    assert!(collapsed.signed_distance(DVec3::NAN).unwrap().is_nan());
    for offset in [DVec3::NAN, DVec3::new(0.0, f64::INFINITY, 0.0)] {
        let refused = Geometry::from_relative(&positions, offset, &triangles);
        assert!(matches!(refused, Err(QueryError::Middle { .. })));
    }
    assert!(nothing.bounds().is_none() && nothing.closest_point(DVec3::ZERO).is_none());
    assert!(nothing.closest_hit(&Ray::new(Vec3::ZERO, Vec3::X)).is_none());
}

#[test]
fn moved_vertices_are_hit_where_they_are() {
    let mut random = Random::new(55);
    let (positions, triangles) = cube(5, |at| at.normalize());
    let mut geometry = Geometry::new(
        &positions,
        &triangles,
        &[Sphere {
            center: [0.0, 0.0, 2.0],
            radius: 0.5,
        }],
    )
    .unwrap();
    for round in 0..4 {
        let moved: Vec<[f32; 3]> = positions
            .iter()
            .map(|&at| {
                let at = Vec3::from(at) + random.vector() * 0.1;
                // At last all triangles lose their areas.
                if round == 3 { [0.0; 3] } else { at.to_array() }
            })
            .collect();
        geometry.refit(&moved).unwrap();
        let new = Geometry::new(
            &moved,
            &triangles,
            &[Sphere {
                center: [0.0, 0.0, 2.0],
                radius: 0.5,
            }],
        )
        .unwrap();
        let rays = rays(&mut random, &moved, 2000);
        let (mut hits, mut expected) = (vec![Hit::miss(0.0); 2000], vec![Hit::miss(1.0); 2000]);
        geometry.closest_hits(&rays, &mut hits);
        new.closest_hits(&rays, &mut expected);
        assert!(hits == expected);
        assert_eq!(geometry.bounds(), new.bounds());
    }
    assert!(matches!(
        geometry.refit(&positions[1..]),
        Err(QueryError::Length { .. })
    ));
    let mut bad = positions.clone();
    bad[7][2] = f32::NAN;
    assert!(matches!(
        geometry.refit(&bad),
        Err(QueryError::Coordinate { index: 7, .. })
    ));
}

#[test]
fn a_geometry_that_is_moved_away_is_kept_as_a_new_one() {
    let (positions, triangles) = cube(3, |at| at);
    let ball = Sphere {
        center: [1e6, 1e6, 1e6],
        radius: 0.01,
    };
    for spheres in [&[][..], &[ball][..]] {
        let mut geometry = Geometry::new(&positions, &triangles, spheres).unwrap();
        for (scale, offset) in [(0.01, 1e6), (1.0, 1e10), (1.0, 0.3), (1.0, -3.0)] {
            let moved: Vec<[f64; 3]> = positions
                .iter()
                .map(|&at| (Vec3::from(at).as_dvec3() * scale + offset).to_array())
                .collect();
            let new = Geometry::new(&moved, &triangles, spheres);
            let copy = geometry.refitted(&moved);
            let Ok(new) = new else {
                assert!(copy.is_err() && geometry.refit(&moved).is_err());
                continue;
            };
            geometry.refit(&moved).unwrap();
            for geometry in [&geometry, &copy.unwrap()] {
                assert_eq!(geometry.vertices(), new.vertices());
                assert_eq!(geometry.bounds(), new.bounds());
                for (from, to) in [(moved[3], moved[40]), (ball.center, moved[7])] {
                    let ray = Ray::new(DVec3::from(from).as_vec3() - 5.0, DVec3::from(to).as_vec3());
                    assert_eq!(geometry.closest_hit(&ray), new.closest_hit(&ray));
                }
                assert_eq!(
                    geometry.closest_point(ball.center),
                    new.closest_point(ball.center)
                );
            }
        }
    }
}

/// Directions so long that t underflows: hits at 0 do not count, and a limit keeps the order.
#[test]
fn limits_keep_the_order_where_t_is_rounded() {
    let corners = |z: f32| [[-1.0_f32, -1.0, z], [1.0, -1.0, z], [0.0, 1.0, z]];
    let positions = [corners(1.0), corners(1.000_000_1)].concat();
    let geometry = Geometry::from_triangles(&positions, &[[3, 4, 5], [0, 1, 2]]).unwrap();
    for length in [1e46, 3e44, 0.1, 1e-30] {
        let directions = [[0.0, 0.0, length]];
        let origins = [[0.0, 0.0, -1.0]];
        let rays = Rays::from_arrays(&origins, &directions).unwrap();
        let all = geometry.all_hits_each(rays, None);
        for limit in 1..3 {
            let some = geometry.all_hits_each(rays, Some(limit));
            assert_eq!(some.hits, all.hits[..limit.min(all.hits.len())], "{length}");
        }
        assert!(all.hits.iter().all(|hit| hit.t > 0.0));
        let mut occluded = [false];
        geometry.occluded_each(rays, &mut occluded);
        assert_eq!(occluded[0], !all.hits.is_empty());
    }
}

#[test]
fn spheres_are_hit_on_both_sides() {
    let ball = Sphere {
        center: [10.0, 0.0, 0.0],
        radius: 2.0,
    };
    let geometry = Geometry::new(Points::F32(&[]), &[], &[ball]).unwrap();
    let mut ray = Ray::new([0.0; 3], [2.0, 0.0, 0.0]);
    let ts = |ray: &Ray| {
        geometry
            .all_hits(ray, None)
            .iter()
            .map(|hit| hit.t)
            .collect::<Vec<_>>()
    };
    assert_eq!(ts(&ray), [4.0, 6.0]);
    ray.t_min = 4.5;
    assert_eq!(ts(&ray), [6.0]);
    assert_eq!(geometry.closest_hit(&ray).map(|hit| hit.t), Some(6.0));
    assert_eq!(
        geometry
            .closest_point(DVec3::ZERO)
            .map(|closest| closest.distance),
        Some(8.0)
    );
}

#[test]
fn wrong_arrays_are_refused() {
    let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let refused = |positions: &[[f32; 3]], triangles: &[[u32; 3]]| {
        Geometry::from_triangles(positions, triangles)
            .err()
            .map(|error| error.to_string())
    };
    assert_eq!(refused(&positions, &[[0, 1, 2]]), None);
    assert_eq!(
        refused(&positions, &[[0, 1, 2], [0, 1, 3]]).unwrap(),
        "triangle 1 has vertex index 3, but there are only 3 vertices"
    );
    let mut bad = positions;
    bad[1][2] = f32::NAN;
    assert_eq!(
        refused(&bad, &[[0, 1, 2]]).unwrap(),
        "vertex 1 has the coordinate NaN, expected a finite number"
    );
    bad[1][2] = 2e9;
    assert!(refused(&bad, &[[0, 1, 2]]).unwrap().contains("above 1e9"));
    let far = [[1e300_f64, 0.0, 0.0]; 3];
    let at_0 = Geometry::from_triangles(&far, &[]).expect("relative to their middle they are at 0");
    let (vertices, middle) = at_0.vertices();
    let again = Geometry::from_relative(&vertices, middle, &[]).expect("what was kept is taken again");
    assert_eq!(again.vertices(), (vertices, middle));
    let far = [[1e300_f64, 0.0, 0.0], [0.0; 3]];
    assert!(matches!(
        Geometry::from_triangles(&far, &[]),
        Err(QueryError::Coordinate { index: 0, .. })
    ));
    let ball = Sphere {
        center: [0.0; 3],
        radius: -1.0,
    };
    assert!(matches!(
        Geometry::new(&positions, &[], &[ball]),
        Err(QueryError::Radius { sphere: 0, .. })
    ));
}
