//! Geometries of meshes, and of vertices as they were kept.

use super::{Random, cube};
use glam::{DVec3, Vec3};
use octray::{
    query::{Geometry, Points, QueryError, Ray},
    ray::Hit,
    scene::TriangleMesh,
};

#[test]
fn what_was_kept_answers_to_the_bit() {
    let mut random = Random::new(5);
    let (positions, triangles) = cube(4, |at| at);
    let offsets = [
        DVec3::ZERO,
        DVec3::new(4.1e5, -5.2e6, 0.3),
        DVec3::splat(1.55),
        DVec3::splat(-1e3),
    ];
    for offset in offsets {
        let at = |&at: &[f32; 3]| (Vec3::from(at).as_dvec3() * 0.37 + offset).to_array();
        let exact: Vec<[f64; 3]> = positions.iter().map(at).collect();
        let single: Vec<[f32; 3]> = exact.iter().map(|at| at.map(|x| x as f32)).collect();
        for points in [Points::from(&exact), Points::from(&single)] {
            let geometry = Geometry::from_triangles(points, &triangles).unwrap();
            let (relative, middle) = geometry.vertices();
            let again = Geometry::from_relative(&relative, middle, geometry.triangles()).unwrap();
            assert_eq!(
                (again.vertices(), again.bounds()),
                (geometry.vertices(), geometry.bounds())
            );
            for _ in 0..200 {
                let origin = offset + random.vector().as_dvec3();
                let ray = Ray::new(origin.as_vec3(), random.vector());
                assert_eq!(again.all_hits(&ray, None), geometry.all_hits(&ray, None));
                assert_eq!(again.closest_point(origin), geometry.closest_point(origin));
                assert_eq!(again.contains(origin), geometry.contains(origin));
                if let Some(hit) = geometry.closest_hit(&ray) {
                    let surface =
                        |of: &Geometry| of.surface(ray.origin.as_dvec3(), ray.direction.as_dvec3(), &hit);
                    assert_eq!(surface(&again), surface(&geometry));
                }
            }
        }
    }
}

#[test]
fn meshes_become_geometries() {
    let mut mesh = TriangleMesh {
        x: vec![0.0, 1.0, 0.0],
        y: vec![0.0, 0.0, 1.0],
        z: vec![0.5; 3],
        triangles: vec![[0, 1, 2]],
        ..TriangleMesh::default()
    };
    let geometry = Geometry::from_mesh(&mesh).unwrap();
    let expected = "Geometry { vertices: 3, triangles: 1, spheres: 0, .. }";
    assert_eq!(format!("{geometry:?}"), expected);
    let ray = Ray::new([0.2, 0.2, 2.0], [0.0, 0.0, -1.0]);
    assert_eq!(geometry.closest_hit(&ray).unwrap_or_default().t, 1.5);
    assert!(!Hit::default().is_hit());
    mesh.z.pop();
    let error = Geometry::from_mesh(&mesh).unwrap_err();
    assert!(
        matches!(
            error,
            QueryError::Length {
                found: 2,
                expected: 3,
                ..
            }
        ),
        "{error}"
    );
}
