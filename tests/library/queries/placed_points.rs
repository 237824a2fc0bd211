//! Closest points of placed geometries against all triangles: to the bit with the stored placements, and nearly with the given
//! ones.

use super::{
    Random, cube,
    instanced::{Rows, all_of, geometries, geometry, matrix, placed},
    meshes,
};
use crate::long::rounds;
use glam::{DVec3, Vec3};
use octray::{
    Geometry, InstanceId, InstancedGeometry, Level, PrimitiveId,
    query::{InstancedClosestPoint, Sphere, nearest::on_triangle},
    scene::Transform,
};

/// Turned, mirrored, stretched by very different factors and sheared, in a scene of about this size.
fn sheared(random: &mut Random, i: usize, size: f64) -> Transform {
    let factors = match i % 4 {
        0 => DVec3::splat(0.4),
        1 => DVec3::new(0.2, -0.5, 0.8),
        2 => DVec3::new(-1.0, -0.002, -0.3),
        _ => DVec3::new(1.0, 1e-3, 1e-3),
    };
    let shear = f64::from(random.signed());
    let sheared = Transform::from_rows([
        [1.0, shear, 0.0, 0.0],
        [0.0, 1.0, if i.is_multiple_of(3) { 3.0 * shear } else { 0.0 }, 0.0],
        [0.0, 0.0, 1.0, 0.0],
    ]);
    let turned = sheared
        .then_scale(factors * size)
        .then_rotate(random.vector().as_dvec3(), f64::from(random.signed()) * 180.0);
    match i % 6 {
        // Along the axes, and some of them in the same place.
        0 => Transform::IDENTITY.then_scale(DVec3::splat(size)),
        1 => turned,
        _ => turned.then_translate(random.vector().as_dvec3() * (1.5 * size)),
    }
}

/// Everywhere, on a grid, on surfaces, far away, and not finite.
fn points(random: &mut Random, scene: &InstancedGeometry, count: usize, size: f64) -> Vec<[f64; 3]> {
    let stored = scene.scene();
    let point = |i: usize| {
        let at = random.vector().as_dvec3();
        let far = scene.middle();
        let near = match i % 8 {
            0 => at * size,
            1 => (at * 3.0).round() * (0.5 * size),
            2 => at * (1e6 * size),
            3 => at * 1e30,
            4 if i % 64 == 4 => at * f64::NAN,
            4 if i % 64 == 12 => at / 0.0,
            4 if i % 64 == 20 => at * 1e39,
            _ => {
                let instance = &stored.instances()[random.0.usize(..stored.instances().len())];
                let triangles = &stored.prototypes()[instance.prototype().0 as usize].triangles;
                let triangle = stored.triangle(random.0.u32(triangles.clone()) as usize);
                let [u, v] = [
                    random.0.f64() * 0.5,
                    if i.is_multiple_of(3) {
                        0.0
                    } else {
                        random.0.f64() * 0.5
                    },
                ];
                let [a, b, c] = triangle.map(|corner| instance.placement().point_in_f64(corner.as_dvec3()));
                a + (b - a) * u + (c - a) * v
            }
        };
        (near + far).to_array()
    };
    (0..count).map(point).collect()
}

/// The closest point of triangles as they are stored, one after the other.
fn by_brute_force(
    scene: &InstancedGeometry,
    kept: &[usize],
    point: [f64; 3],
) -> Option<InstancedClosestPoint> {
    let (stored, from) = (scene.scene(), DVec3::from(point) - scene.middle());
    let (mut best, mut least) = (None, f64::INFINITY);
    if !from.as_vec3().is_finite() {
        return None;
    }
    for (instance, &given) in stored.instances().iter().zip(kept) {
        let placement = instance.placement();
        let triangles = &stored.prototypes()[instance.prototype().0 as usize].triangles;
        for (local, id) in (0..).zip(triangles.clone()) {
            if !stored.has_area(id as usize) {
                continue;
            }
            let corners = stored.triangle(id as usize);
            let corners = corners.map(|corner| placement.point_in_f64(corner.as_dvec3()));
            let at = on_triangle(from, corners);
            let squared = (at - from).length_squared();
            if squared < least {
                least = squared;
                best = Some(InstancedClosestPoint {
                    point: at + scene.middle(),
                    distance: squared.sqrt(),
                    primitive: PrimitiveId(local),
                    instance: InstanceId(given as u32),
                });
            }
        }
    }
    best
}

#[test]
fn closest_points_are_those_of_all_placed_triangles() {
    let mut random = Random::new(61);
    // Without the spheres.
    let meshes = &geometries()[..4];
    for (size, far, count) in [
        (1.0, 0.0, 1),
        (1.0, 0.0, 30),
        (1e-7, 0.0, 20),
        (1e-20, 0.0, 20),
        (1e6, 0.0, 20),
        (1.0, 3e6, 20),
        (1e3, -4e8, 20),
    ] {
        let instances: Vec<(usize, Transform)> = (0..count)
            .map(|i| {
                let transform = sheared(&mut random, i, size);
                (random.0.usize(..4), transform.then_translate(DVec3::splat(far)))
            })
            .chain([(
                0,
                Transform::IDENTITY
                    .then_scale(DVec3::splat(size))
                    .then_translate(DVec3::splat(far)),
            )])
            .collect();
        let scene = all_of(meshes, &instances);
        let kept: Vec<usize> = (0..instances.len())
            .filter(|&i| meshes[instances[i].0].bounds().is_some())
            .collect();
        let points = points(&mut random, &scene, rounds(150, 600), size);
        let mut closest = vec![None; points.len()];
        scene.closest_points(&points, &mut closest);
        for (&point, &found) in points.iter().zip(&closest) {
            assert_eq!(
                found,
                by_brute_force(&scene, &kept, point),
                "{size} {far}: {point:?}"
            );
            assert_eq!(scene.closest_point(point), found);
        }
        assert!(closest.iter().flatten().count() * 15 > points.len() * 14);
        for level in Level::all() {
            let scene = all_of(meshes, &instances).at_level(level);
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            let mut again = vec![None; points.len()];
            pool.install(|| scene.closest_points(&points, &mut again));
            assert!(again == closest, "{level}");
        }
    }
}

#[test]
fn closest_points_are_those_of_triangles_that_are_placed_in_f64() {
    let mut random = Random::new(62);
    let meshes = meshes();
    let stored: Vec<Geometry> = meshes.iter().map(geometry).collect();
    for round in 0..9 {
        let far = [0.0, 2e6, -7e8][round % 3];
        let matrices: Vec<Rows> = (0..6).map(|_| matrix(&mut random, far)).collect();
        let instances: Vec<(usize, Transform)> = (matrices.iter().enumerate())
            .map(|(i, rows)| (i % 3, Transform::from_rows(*rows)))
            .collect();
        let scene = all_of(&stored, &instances);
        for i in 0..rounds(60, 200) {
            let point = random.vector().as_dvec3() * [2.0, 4.0, 1e3][i % 3] + far;
            let found = scene.closest_point(point).unwrap();
            let triangle = |instance: usize, id: usize| {
                let (positions, triangles) = &meshes[instances[instance].0];
                triangles[id].map(|corner| placed(&matrices[instance], positions[corner as usize]))
            };
            let mut nearest = f64::INFINITY;
            for (instance, (mesh, _)) in instances.iter().enumerate() {
                for id in 0..meshes[*mesh].1.len() {
                    nearest = nearest.min(on_triangle(point, triangle(instance, id)).distance(point));
                }
            }
            assert!(
                (found.distance - nearest).abs() < 2e-6,
                "{far}: {} {nearest}",
                found.distance
            );
            let own = triangle(found.instance.0 as usize, found.primitive.0 as usize);
            assert!((on_triangle(point, own).distance(point) - nearest).abs() < 2e-6);
            assert!((found.point.distance(point) - found.distance).abs() < 1e-6);
        }
    }
}

#[test]
fn many_closest_points_of_instances_are_those_of_one_by_one() {
    let mut random = Random::new(63);
    let meshes = geometries();
    let instances: Vec<(usize, Transform)> = (0..200)
        .map(|i| (random.0.usize(..5), sheared(&mut random, i, 0.3)))
        .collect();
    let scene = all_of(&meshes, &instances);
    let points = points(&mut random, &scene, rounds(2000, 20_000), 1.0);
    let mut closest = vec![None; points.len()];
    scene.closest_points(&points, &mut closest);
    for (&point, closest) in points.iter().zip(closest) {
        assert_eq!(closest, scene.closest_point(point), "{point:?}");
    }
}

#[test]
fn moved_instances_have_the_closest_points_of_a_new_scene() {
    let mut random = Random::new(64);
    let meshes = geometries();
    let mut place = || -> Vec<Transform> { (0..40).map(|i| sheared(&mut random, i, 1.0)).collect() };
    let of = |transforms: &[Transform]| {
        let instances: Vec<_> = (0..)
            .zip(transforms)
            .map(|(i, &transform)| (i % 5, transform))
            .collect();
        all_of(&meshes, &instances)
    };
    let (first, second) = (place(), place());
    let (scene, new) = (of(&first).moved(&second).unwrap(), of(&second));
    for point in points(&mut random, &new, 500, 1.0) {
        assert_eq!(scene.closest_point(point), new.closest_point(point));
    }
}

/// Spheres: turned, they are the same; stretched, they are ellipsoids, like a fine mesh of one.
#[test]
fn closest_points_of_spheres() {
    let mut random = Random::new(65);
    let (center, radius) = (Vec3::new(0.5, -1.0, 0.25), 0.75);
    let sphere = Sphere {
        center: center.as_dvec3().to_array(),
        radius,
    };
    let nothing: &[[f32; 3]] = &[];
    let sphere = Geometry::new(nothing, &[], &[sphere]).unwrap();
    let (positions, triangles) = cube(60, |at| at.normalize() * radius + center);
    let ball = Geometry::from_triangles(&positions, &triangles).unwrap();
    for i in 0..40 {
        let transform = sheared(&mut random, i, 1.0);
        let [exact, fine] =
            [&sphere, &ball].map(|mesh| InstancedGeometry::new(&[mesh], &[(0, transform)]).unwrap());
        for _ in 0..40 {
            let point = random.vector().as_dvec3() * 4.0;
            let found = exact.closest_point(point).unwrap();
            assert_eq!((found.instance, found.primitive), (InstanceId(0), PrimitiveId(0)));
            assert!((found.point.distance(point) - found.distance).abs() < 1e-12);
            let near = fine.closest_point(point).unwrap();
            assert!(
                (found.distance - near.distance).abs() < 3e-3,
                "{i}: {} {}",
                found.distance,
                near.distance
            );
        }
    }
    // Alone, where they are: those of the geometry.
    let scene = InstancedGeometry::new(&[&sphere], &[(0, Transform::IDENTITY)]).unwrap();
    for _ in 0..200 {
        let point = random.vector().as_dvec3() * 3.0;
        let (one, other) = (
            sphere.closest_point(point).unwrap(),
            scene.closest_point(point).unwrap(),
        );
        assert!((one.distance - other.distance).abs() < 1e-6 && one.point.distance(other.point) < 1e-5);
    }
    // In the middle all points are as near.
    let found = scene.closest_point(center.as_dvec3()).unwrap();
    assert!((found.distance - f64::from(radius)).abs() < 1e-6);
}

#[test]
fn equally_near_points_are_those_of_the_first_instance() {
    let (positions, triangles) = cube(1, |at| at);
    let cube = Geometry::from_triangles(&positions, &triangles).unwrap();
    let nothing = geometry(&(Vec::new(), Vec::new()));
    let at = |x: f64| Transform::IDENTITY.then_translate(DVec3::X * x);
    let instances = [
        (1, at(0.0)),
        (0, at(4.0)),
        (0, at(-4.0)),
        (0, at(4.0)),
        (0, at(-4.0)),
    ];
    let scene = InstancedGeometry::new(&[&cube, &nothing], &instances).unwrap();
    for (x, instance, distance) in [(0.0, 1, 3.0), (-0.5, 2, 2.5), (4.5, 1, 0.5), (-9.0, 2, 4.0)] {
        let found = scene.closest_point([x, 0.1, 0.2]).unwrap();
        assert_eq!((found.instance, found.distance), (InstanceId(instance), distance));
    }
    // At a corner, of its triangles the lowest.
    let found = scene.closest_point([8.0, 3.0, 3.0]).unwrap();
    assert_eq!(found.point, DVec3::new(5.0, 1.0, 1.0));
    let touching = |id: &usize| {
        triangles[*id]
            .iter()
            .any(|&corner| positions[corner as usize] == [1.0; 3])
    };
    assert_eq!(
        found.primitive.0 as usize,
        (0..triangles.len()).find(touching).unwrap()
    );
}

#[test]
fn nothing_is_near_where_nothing_is() {
    let nothing = geometry(&(Vec::new(), Vec::new()));
    let flat = geometry(&(vec![[0.0; 3], [1.0, 0.0, 0.0]], vec![[0, 1, 1]]));
    let here = Transform::IDENTITY;
    for instances in [&[][..], &[(0, here)], &[(1, here), (0, here)]] {
        let scene = InstancedGeometry::new(&[&nothing, &flat], instances).unwrap();
        let mut closest = [None; 2];
        scene.closest_points(&[[0.0_f32, 1.0, 2.0], [f32::NAN; 3]], &mut closest);
        assert_eq!(closest, [None; 2]);
        assert_eq!(scene.closest_point(DVec3::ZERO), None);
        scene.closest_points(&[] as &[[f64; 3]], &mut []);
    }
}
